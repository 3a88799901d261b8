"""Data of a case that depend on time, recorded where they can be: then C fills them.

A function of a condition, of forcing or of jumps is tried on symbols, as a law is
(fsipetsc.materials.own). One of numpy's functions alone is recorded; of a motion the derivatives in
time follow from the record. If any cannot be recorded, as one with an ``if`` on t or a table,
Python is asked for all of them, at each stage.

What must be above 0 and is not becomes no number: so the step fails, and Python says why.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blame import place_in, reason
from fsipetsc.blocks.conditions import moves
from fsipetsc.blocks.values import names_of
from fsipetsc.kernels.formula import Formula, number_of, numbers_of
from fsipetsc.kernels.procedure import Code
from fsipetsc.kernels.symbols import derivatives
from fsipetsc.kernels.unit import unit
from fsipetsc.scheme.timed import Timed, set_data

Array = NDArray[Any]
#: of places (d symbols) and the time: numbers and tuples of numbers, one for each target
Make = Callable[[Any, Any], Sequence[Any]]


class Recorder:
    """What is recorded of the data of a part of a block, or of particles.

    refused: what cannot be recorded, and why.
    """

    def __init__(self) -> None:
        self._timed, self._about = list[Timed](), list[str]()
        self.refused = list[str]()

    def add(self, about: Any, make: Make, x: Array, at: Array | None, *targets: Array) -> None:
        """Record data of ``about``, a condition or a text, at places x (d, n), which go to rows
        ``at`` of targets. What does not depend on time needs no record: Python is asked once.
        """
        what = about if isinstance(about, str) else type(about).__name__
        try:
            formula = Formula(make, len(x))
        except (Exception, SystemExit) as error:  # of the user's function
            place = place_in(error)
            self.refused.append(f"{place}: " * bool(place) + f"{what}: {reason(error)}")
            return
        if formula.in_time:
            places = tuple(map(np.ascontiguousarray, x))
            self._timed.append(Timed(formula, formula.numbers, places, at, targets))
            self._about.append(what)

    def code(self, now: Array) -> Code | None:
        """The code whose only procedure fills the data; None if nothing depends on time."""
        if not self._timed:
            return None
        code = Code(unit({}, []))
        code.procedure("set_data", set_data, tuple(self._timed), now)
        return code

    def faulty(self) -> str:
        """Whose data are not finite now, or ""."""
        pairs = zip(self._about, self._timed, strict=True)
        bad = (what for what, one in pairs if not all(np.isfinite(a).all() for a in one.targets))
        return next(bad, "")


# what conditions prescribe


def asked(condition: Any, name: str, x: Any, t: Any, count: int = 0) -> Any:
    """Ask a condition for a datum at symbols: a number, or so many of them."""
    of = getattr(condition, name)
    if not callable(of):
        return of
    found = of(*x, t)
    return numbers_of(found, count) if count else number_of(found)


def positive(value: Any) -> Any:
    """Return a number that must be above 0, or NaN where it is not."""
    return np.where(value > 0.0, value, np.nan)


def less(a: Any, b: Any) -> tuple[Any, ...]:
    """Return a - b by components."""
    return tuple(map(np.subtract, a, b))


def motion(condition: Any) -> Make:
    """Return a function that records displacement, velocity and acceleration; those that are not
    given are derivatives in time.
    """

    def make(x: Any, t: Any) -> Sequence[Any]:
        d, place = len(x), x
        if moves(condition):
            place = asked(condition, "x", x, t, d)
        if getattr(condition, "velocity", None) is None:
            velocity = derivatives(place, t, still=True)
        else:
            velocity = asked(condition, "velocity", x, t, d)
        return less(place, x), velocity, derivatives(velocity, t, still=True)

    return make


def temperature(condition: Any) -> Make:
    """Return a function that records the temperature of a wall."""
    return lambda x, t: (positive(asked(condition, "T", x, t)),)


def given_gas(condition: Any, law: Any) -> Make:
    """Return a function that records all unknowns of a gas with this law: (rho, rho u, E)."""

    def make(x: Any, t: Any) -> Sequence[Any]:
        rho, *u, T = asked(condition, "values", x, t, len(x) + 2)
        rho, T = positive(rho), positive(T)
        energy = rho * (law.internal_energy(rho, T) + 0.5 * sum(c * c for c in u))
        return ((rho, *(rho * c for c in u), energy),)

    return make


def given_solid(condition: Any, d: int) -> Make:
    """Return a function that records all unknowns of a solid: displacement and velocity,
    temperature.
    """

    def make(x: Any, t: Any) -> Sequence[Any]:
        values = asked(condition, "values", x, t, len(names_of("solid", "values", d)))
        return (*less(values[d + 1 :], x), *values[:d]), positive(values[d])

    return make
