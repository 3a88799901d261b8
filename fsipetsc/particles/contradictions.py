"""Conditions that contradict each other where their faces meet, at one particle.

One of them decides: docs/cases.md has a table. Where another one that sticks or clamps, or that
moves, wants a second velocity there, the equations have a singularity: density or stress at that
node grows as 1/h, and no grid converges. That is refused as soon as the velocities differ. Other
contradictions bend a wall at rest, or leave one of two values to a node: a note at the start.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blocks.conditions import moves
from fsipetsc.blocks.maps import place_text
from fsipetsc.blocks.values import datum
from fsipetsc.errors import InputError
from fsipetsc.particles.members import Asked, Particle
from fsipetsc.particles.records import Data

Array = NDArray[Any]
#: parts of the larger one by which velocities differ, as vectors and along a normal, which is that
#: of the reference map; and temperatures
APART, ALONG, WARMER = 1e-3, 0.1, 1e-6
#: of the distance below which places are one: velocities may be differences of places
ROUND_OFF = 1e-4
#: names of what decides on temperatures
WARM = {True: "warm_gas", False: "warm_solid"}
#: what to do where there is a gas, and where there is not
_ADVICE = {
    True: "walls beside one that moves be Slip, have a slip_length",
    False: "faces beside one that moves be Roller",
}
#: a pair of conditions, the place, what is said of it there
Note = tuple[Any, tuple[float, ...], str]


class _Pair(NamedTuple):
    """What decides, by the name that fsipetsc.particles.members.Particle has for it, and another
    condition, at particles ``who``. normals: (who, d) where they hold along a normal alone.
    """

    name: str
    first: Asked
    other: Asked
    who: Array
    normals: Array | None

    @property
    def refused(self) -> bool:
        """Whether two velocities make a singularity."""
        if self.name in WARM.values():
            return False
        given = any(one.condition.all_given for one in (self.first, self.other))
        return not given and (self.other.normal is None or _has_motion(self.other.condition))


class Contradictions:
    """Of the particles here of a problem. x: (particles, d), their places.

    velocity: (condition, whether it is of a gas, places, time [s]) -> what it prescribes, (n, d).
    possible: some velocities would be refused if they were to differ.
    """

    def __init__(
        self,
        problem: Any,
        particles: Sequence[Particle],
        x: Array,
        velocity: Callable[[Any, bool, Array, float], Array],
    ) -> None:
        self._problem, self._x, self._velocity = problem, x, velocity
        found: dict[Any, list[Any]] = {}
        for p, particle in enumerate(particles):
            for name, first, other in self._several(particle):
                normal = first.normal if other.normal is None else other.normal
                key = name, first.face, other.face, normal is None
                found.setdefault(key, []).append((name, first, other, p, normal))
        self._pairs = []
        for listed in found.values():
            names, firsts, others, who, normals = zip(*listed, strict=True)
            along = None if normals[0] is None else np.array(normals)
            self._pairs.append(_Pair(names[0], firsts[0], others[0], np.array(who), along))
        self._refused = [pair for pair in self._pairs if pair.refused]
        self.possible = bool(self._refused)

    def _of_gas(self, asked: Asked) -> bool:
        return asked.face is not None and self._problem.blocks[asked.face[0]].kind == "fluid"

    def _several(self, particle: Particle) -> Iterator[tuple[str, Asked, Asked]]:
        """(name, what decides, another one) of motions, one of which has data, and temperatures."""
        for other in particle.asked:
            gas, condition = self._of_gas(other), other.condition
            mover, warm = particle.mover(gas), WARM[gas]
            for name in (mover, warm):
                decides = getattr(particle, name, None)
                if decides is None or decides is condition:
                    continue
                if name == warm:
                    meant = getattr(condition, "T", None) is not None and "given" not in mover
                else:
                    meant = condition.holds
                    meant &= _has_motion(decides) or _has_motion(condition)
                if meant:
                    yield name, next(o for o in particle.asked if o.condition is decides), other

    def refuse(self, data: Data, t: float, instant: float) -> None:
        """InputError where two conditions want velocities at time t [s] that cannot be."""
        for pair in self._refused:
            for words, _ in self._found(pair, data, t, instant):
                gas = self._of_gas(pair.first) or self._of_gas(pair.other)
                advice = f"let {_ADVICE[gas]}, or move with it"
                raise InputError(f"{words} at t = {t:.6g}: no grid converges there: {advice}")

    def notes(self, data: Data, t: float, instant: float) -> list[Note]:
        """What is to be said of all others."""
        return [
            ((pair.name, pair.first.face, pair.other.face), place, f"{words}: the first one counts")
            for pair in self._pairs
            if not pair.refused
            for words, place in self._found(pair, data, t, instant)
        ]

    def _found(
        self, pair: _Pair, data: Data, t: float, instant: float
    ) -> Iterator[tuple[str, tuple[float, ...]]]:
        """What a pair says differently, at the first place where it does; or nothing."""
        x, other = self._x[pair.who], pair.other.condition
        if pair.name in WARM.values():
            of, unit, part, least = "temperatures", "K", WARMER, 0.0
            mine = (data.T if pair.name == WARM[True] else data.T_solid)[pair.who, None]
            others = datum(other, "T", x, t)[:, None]
        else:
            of, unit, part = "velocities", "m/s", APART if pair.normals is None else ALONG
            least = ROUND_OFF * self._problem.tolerance / instant
            mine = _velocities(data, pair.name, pair.who)
            others = self._velocity(other, self._of_gas(pair.other), x, t)
        size = np.maximum(np.linalg.norm(mine, axis=1), np.linalg.norm(others, axis=1))
        apart = mine - others
        if pair.normals is not None and unit == "m/s":
            apart = (pair.normals * apart).sum(axis=1, keepdims=True)
        bad = np.flatnonzero(np.linalg.norm(apart, axis=1) > part * size + least)
        if bad.size:
            at = min(bad.tolist(), key=lambda p: tuple(x[p]))
            both = " and ".join(self._name(one) for one in (pair.first, pair.other))
            said = " and ".join(_text(values[at]) for values in (mine, others))
            words = f"{both} meet at {place_text(x[at])} with {of} of {said}"
            yield words + self._problem.unit(unit), tuple(x[at].tolist())

    def _name(self, asked: Asked) -> str:
        """Such as "NoSlip of 'gas', axis 0, side 1"."""
        if asked.face is None:
            return "a Hinge"
        k, axis, side = asked.face
        kind, block = type(asked.condition).__name__, self._problem.blocks[k].name
        return f"{kind} of '{block}', axis {axis}, side {side},"


def _has_motion(condition: Any) -> bool:
    """Whether data say how it moves."""
    moving = moves(condition) or getattr(condition, "velocity", None) is not None
    return condition.all_given or moving


def _velocities(data: Data, name: str, who: Array) -> Array:
    """(who, d): the velocities by that condition which decides."""
    d = data.wall.shape[1]
    if name == "given_gas":
        return data.gas[who, 1 : 1 + d] / data.gas[who, :1]
    if name == "given_solid":
        return data.solid[who, d:]
    return (data.clamp_velocity if name == "clamp" else data.wall)[who]


def _text(values: Array) -> str:
    """Numbers, in brackets if there are several."""
    numbers = ", ".join(f"{v:.4g}" for v in values.tolist())
    return numbers if len(values) == 1 else f"({numbers})"
