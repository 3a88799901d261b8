"""Where and how a state became unphysical, in words."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

#: the square of a larger number is none
TOO_LARGE = 1e150


class Seen(NamedTuple):
    """What a rank sees of a layer. numbers: of the points, (n,), as they count over all ranks;
    values: field -> (n,), those first of which others are made; positive: fields that must be
    above 0, the others need only be finite; place(i): of point i.
    """

    layer: int
    numbers: np.ndarray
    values: Mapping[str, np.ndarray]
    positive: frozenset[str]
    place: Callable[[int], str]


def described(state: Any, seen: Iterable[Seen], t: float, step: int) -> str:
    """The first unphysical point of all ranks. Collective."""
    with np.errstate(all="ignore"):
        bad = [found for found in map(_first_bad, seen) if found]
    every = state.comm.allgather(min(bad, default=None))
    first = min((found for found in every if found), default=None)
    when = f"t = {t:.6g}{state.problem.unit('s')}, step {step}"
    if first is None:
        return f"the time step is not a number at {when}"
    k, _, name, value, place = first
    what = f"{name} = {value:.6g}" if np.isfinite(value) else f"{name} is not a finite number"
    if TOO_LARGE <= abs(value) < np.inf:
        what += ", too large to go on with,"
    return f"{what} in layer '{state.problem.layers[k].name}' at {place}, {when}"


def _first_bad(seen: Seen) -> tuple[int, int, str, float, str] | None:
    """(layer, number of the point, field, value, place) of the first point that is not physical, or
    with numbers whose squares are none.
    """
    bad = []
    for name, values in seen.values.items():
        good = np.abs(values) < TOO_LARGE
        if name in seen.positive:
            good &= values > 0
        if not good.all():
            bad.append((int(np.argmin(good)), name))
    if not bad:
        return None
    i, name = min(bad, key=lambda entry: entry[0])
    return seen.layer, int(seen.numbers[i]), name, float(seen.values[name][i]), seen.place(i)
