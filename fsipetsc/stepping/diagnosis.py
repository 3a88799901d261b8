"""Where and how a state became unphysical, in words."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np


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


class Failure(NamedTuple):
    """What is wrong, in words, and what it is about: a topic of fsipetsc.stepping.advice."""

    words: str
    topic: str


def described(state: Any, seen: Iterable[Seen], t: float, step: int) -> Failure:
    """The first unphysical point of all ranks; if there is none, that with the largest number.
    Collective.
    """
    with np.errstate(all="ignore"):
        seen = list(seen)
        bad = [found for found in map(_first_bad, seen) if found]
        large = [found for found in map(_largest, seen) if found]
    every = state.comm.allgather((min(bad, default=None), max(large, default=None)))
    first, largest = (
        min((b for b, _ in every if b), default=None),
        max((n for _, n in every if n), default=None),
    )
    s = state.problem.unit("s")
    if first is None and largest is None:
        return Failure(f"the time step is not a number at t = {t:.6g}{s}, step {step}", "finite")
    if first is not None:
        k, _, name, value, place = first
        what = f"{name} = {value:.6g}" if np.isfinite(value) else f"{name} is not a finite number"
    else:
        _, k, name, value, place = largest
        what = f"{name} = {value:.6g}, too large to go on with,"
    words = (
        f"{what} in layer '{state.problem.layers[k].name}' at {place}, t = {t:.6g}{s}, step {step}"
    )
    return Failure(words, "finite" if first is None or not np.isfinite(value) else name)


def _first_bad(seen: Seen) -> tuple[int, int, str, float, str] | None:
    """(layer, number of the point, field, value, place) of the first point that is not physical."""
    bad = []
    for name, values in seen.values.items():
        good = (values > 0) & (values < np.inf) if name in seen.positive else np.isfinite(values)
        if not good.all():
            bad.append((int(np.argmin(good)), name))
    if not bad:
        return None
    i, name = min(bad, key=lambda entry: entry[0])
    return seen.layer, int(seen.numbers[i]), name, float(seen.values[name][i]), seen.place(i)


def _largest(seen: Seen) -> tuple[float, int, str, float, str] | None:
    """(size, layer, field, value, place) of the number that is farthest from 0."""
    found = []
    for name, values in seen.values.items():
        if values.size:
            i = int(np.argmax(np.abs(values)))
            found.append((float(abs(values[i])), seen.layer, name, float(values[i]), seen.place(i)))
    return max(found, default=None)
