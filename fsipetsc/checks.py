"""What a case says is checked where it says it, so that the message can name the line."""

from collections.abc import Mapping, Sequence
from datetime import timedelta
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.errors import InputError

#: what functions of a case take, and what they return for several unknowns
Array = NDArray[Any]
Fields = Sequence[Array | float]

#: cells of a layer: the unknowns of a few such layers can still be counted in 32 bits
MOST_CELLS = 50_000_000
POSITIVE, NONNEGATIVE, ANY = "above 0", "not below 0", ""
#: name of a number -> what it must be: "" for any, "above …" or "not below …"
Ranges = Mapping[str, str]


def described(value: Any) -> str:
    """A value in a message: short, and on one line."""
    if callable(value):
        return f"a function ({getattr(value, '__name__', type(value).__name__)})"
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def counted(count: int, word: str) -> str:
    """ "1 step", "2 steps"."""
    return f"{count} {word}{'s' * (count != 1)}"


def duration(seconds: float) -> str:
    """Seconds, as "4.2 s" or "1:02:33"."""
    return f"{seconds:.3g} s" if seconds < 60 else str(timedelta(seconds=int(seconds)))


def number(value: Any, what: str, bound: str = ANY, unit: str = "") -> float:
    """The value as a float; InputError if it is no finite real number or out of bound."""
    expected = f"expected a number{' ' * bool(bound)}{bound}{f' [{unit}]' if unit else ''}"
    found = np.nan
    if np.ndim(value) == 0 and not isinstance(value, (str, bytes, bool, np.bool_, complex)):
        try:
            found = float(value)
        except (TypeError, ValueError, OverflowError):
            pass
    if not isfinite(found):
        raise InputError(f"{what} is {described(value)}: {expected}")
    least = float(bound.split()[-1]) if bound else -np.inf
    if found < least or (found == least and bound.startswith("above")):
        raise InputError(f"{what} is {found:g}: {expected}")
    return found


def numbers(record: Any, owner: str, ranges: Ranges) -> None:
    """Make attributes of a frozen dataclass floats within their ranges. InputError."""
    for name, bound in ranges.items():
        object.__setattr__(record, name, number(getattr(record, name), f"{owner}: {name}", bound))


def check_name(value: Any, what: str) -> None:
    """InputError if a value is no name of a layer or a block."""
    if not isinstance(value, str) or not value.isprintable() or not value.strip() or "|" in value:
        raise InputError(f"{what}: name is {described(value)}: expected a line of text without |")


def check_units(value: Any, what: str) -> None:
    """InputError if a value does not say whether numbers have units."""
    if value not in ("SI", "none", ""):
        raise InputError(f"{what}: units is {described(value)}: expected 'SI' or 'none'")


def extent(X: Any, what: str) -> tuple[float, float]:
    """(left, right), left < right; InputError."""
    if not isinstance(X, (tuple, list, np.ndarray)) or len(X) != 2:
        raise InputError(f"{what}: X is {described(X)}: expected (left, right), two numbers [m]")
    left, right = (number(end, f"{what}: X") for end in X)
    if not left < right:
        expected = "expected (left, right) with left below right"
        raise InputError(f"{what}: X = ({left:g}, {right:g}): {expected}")
    return left, right


def whole(value: Any) -> bool:
    """Whether it is a whole number above 0."""
    return isinstance(value, (int, np.integer)) and value is not True and int(value) > 0


def own_cells(cells: Any, h: Any, ends: tuple[float, float], what: str) -> int | None:
    """Cells of a layer that says their number or size h [m], or neither: None. InputError."""
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


def function(value: Any, what: str, form: str, *, optional: bool = False) -> None:
    """InputError if a value is no function; form: as in "initial(X) -> (rho, u, T)"."""
    if not (callable(value) or (optional and value is None)):
        expected = f"a function {form}{' or None' if optional else ''}"
        raise InputError(f"{what} is {described(value)}: expected {expected}")
