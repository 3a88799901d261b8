"""Data of a case that depend on time, recorded where they can be: then C fills them.

A function of a condition, of forcing or of jumps is tried on symbols, as a law is
(fsipetsc.materials.own). If one cannot be recorded, as one with an ``if`` on t or a table, Python
is asked for all of them, at each stage. Sums and products are rounded one by one, as numpy does it.
What must be above 0 and is not becomes NaN: so the step fails, and Python says why.
"""

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.checks import POSITIVE, Array, block_values, checked, datum, names_of
from fsipetsc.errors import InputError, place_in, reason
from fsipetsc.kernels.loops import each
from fsipetsc.kernels.symbols import Record, Symbol, needed, numbers_of
from fsipetsc.scheme.plan import time_of

#: a function of more operations is left to Python: the compiler takes 2 to 3 s for so many
MOST = 500
#: of places (d symbols, or (d, n)) and the time: numbers and tuples of them, one for each target
Make = Callable[[Any, Any], Sequence[Any]]


class Source(SimpleNamespace):
    """A function of place and time, and where its values go. about: a condition or a text. x:
    (d, n), the places; at: (n,) rows of targets, which differ, or None: 0, 1, ….
    """

    def __init__(self, about: Any, make: Make, x: Array, at: Array | None, *targets: Array) -> None:
        self.about = about if isinstance(about, str) else type(about).__name__
        self.make, self.at, self.targets = make, at, targets
        self.x = tuple(map(np.ascontiguousarray, x))

    def fill(self, t: float) -> None:
        """Fill the targets with data at time t [s], as Python finds them. InputError."""
        if self.x[0].size:
            rows = slice(None) if self.at is None else self.at
            for target, values in zip(self.targets, self.make(np.array(self.x), t), strict=True):
                target[rows] = np.transpose(values)


def timed(sources: Sequence[Source]) -> tuple[list[Source], list[str]]:
    """The sources whose data depend on time, so that C fills them; Python is asked once for the
    others. Also what cannot be recorded, and why.
    """
    found, refused = list[Source](), list[str]()
    for one in sources:
        try:
            record = Record()
            t, x = record.given("t"), tuple(record.given(f"x{c}") for c in range(len(one.x)))
            rows = [row if isinstance(row, tuple) else (row,) for row in one.make(x, t)]
            every = needed([record.constant(number) for row in rows for number in row])
            count = sum(symbol.value is None for symbol in every)
            if count > MOST:
                raise InputError(f"it has {count} operations: expected {MOST} at most")
            if t in set(every):
                found.append(one)
        except (Exception, SystemExit) as error:  # of the user's function
            place = place_in(error)
            refused.append(f"{place}: " * bool(place) + f"{one.about}: {reason(error)}")
    return found, refused


def asked(condition: Any, name: str, x: Any, t: Any, names: Sequence[str] = ()) -> Any:
    """A datum of a condition at places x, of d components, and a time, numbers or symbols: a
    number, or one for each name; `positive` where its ranges say so. InputError.
    """
    of = getattr(condition, name)
    if not isinstance(t, Symbol):
        found = datum(condition, name, np.transpose(x), t, names or None).T
    else:
        found = numbers_of(of(*x, t), len(names)) if callable(of) else of
    if not names:
        return positive(condition, name, found)
    return tuple(positive(condition, *pair) for pair in zip(names, found, strict=True))


def positive(condition: Any, name: str, value: Any) -> Any:
    """A datum, or NaN where it must be above 0 and is not."""
    above = condition.ranges.get(name) == POSITIVE
    return np.where(value > 0.0, value, np.nan) if above else value


def found_by(function: Any, at: Sequence[Any], names: Sequence[str], X: Any, what: str) -> Any:
    """What a function of the case's returns, numbers or symbols, for each name; the last of its
    arguments is the time. X: (d, n) places, or NOWHERE. InputError.
    """
    if isinstance(at[-1], Symbol):
        return numbers_of(function(*at), len(names))
    return checked(function, at, X, names, f"{what} at t = {at[-1]:.6g}")


def forcing_of(block: Any, x: Any, t: Any) -> Any:
    """The forcing of a block, or of a layer of the paper's method: numbers, or symbols."""
    if not isinstance(t, Symbol):
        return block_values(block, "forcing", x, t)
    names = getattr(block, "unknowns", None) or names_of(block.kind, "forcing", len(x))
    return numbers_of(block.forcing(*x, t), len(names))


def set_data(timed, time):
    """Fill data that depend on time."""
    for one in timed:
        t = time[0]
        for i in each(one.x[0].shape[0], vector=True):
            row = i if one.at is None else one.at[i]
            x, begun = tuple(x[i] for x in one.x), len(t.record.items)
            values = one.make(x, t)
            t.record.exact.update(range(begun, len(t.record.items)))
            for array, value in zip(one.targets, values, strict=True):
                array[row] = value


def set_time(part, found):
    """The time of data is at a part of the step."""
    found.time[0] = time_of(part, found.plan.batch)
