"""How many cells a layer has: what it says itself, or what the spacing of all layers makes."""

from typing import Any

import numpy as np

from fsipetsc.checks import POSITIVE, described, number
from fsipetsc.errors import InputError

#: cells of a layer: the unknowns of a few such layers can still be counted in 32 bits
MOST_CELLS = 50_000_000


def whole(value: Any) -> bool:
    """Whether it is a whole number above 0."""
    return isinstance(value, (int, np.integer)) and value is not True and int(value) > 0


def own_cells(cells: Any, h: Any, ends: tuple[float, float], what: str) -> int | None:
    """Cells of a layer that says their number or their size h [m]; None where it says neither.

    InputError for both, for what is neither, and as of cells_of.
    """
    if cells is not None and h is not None:
        raise InputError(f"{what}: cells and h are given: expected one of them")
    if h is not None:
        return cells_of(ends, number(h, f"{what}: h", POSITIVE, "m"), what)
    if cells is not None and not whole(cells):
        raise InputError(f"{what}: cells is {described(cells)}: expected a whole number above 0")
    return None if cells is None else int(cells)


def cells_of(ends: tuple[float, float], h: float, what: str) -> int:
    """Cells of about h [m] between the ends of a layer. InputError for more than MOST_CELLS."""
    width = (ends[1] - ends[0]) / h
    if not width < MOST_CELLS:
        found = f"{what} of length {ends[1] - ends[0]:g} would have {width:.3g} cells"
        raise InputError(f"{found}; {MOST_CELLS} are too many")
    return max(1, round(width))
