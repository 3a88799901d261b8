"""What conditions prescribe at an instant for the particles of a rank: motion, temperatures, all
unknowns.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blame import place_of
from fsipetsc.blocks.conditions import moves
from fsipetsc.blocks.values import datum, names_of
from fsipetsc.errors import InputError
from fsipetsc.particles.contradictions import Contradictions, Note
from fsipetsc.particles.members import Particle
from fsipetsc.particles.records import Data
from fsipetsc.scheme.recorded_data import (
    Make,
    Recorder,
    given_gas,
    given_solid,
    motion,
    temperature,
)

Array = NDArray[Any]
#: conditions of a particle that have data; those by which the gas's grid moves
NAMES = "wall", "slip", "clamp", "warm_gas", "warm_solid", "given_gas", "given_solid"
WALLS = "wall", "slip", "given_gas"
#: Weights of first and second derivatives at one of several equidistant times, of which 0, 1, …
#: are before it. With three the first one is of second order, with four of third, the second one of
#: second order.
FIRST = (
    ((-1.5, 2.0, -0.5), (1.0, -2.0, 1.0)),
    ((-0.5, 0.0, 0.5), (1.0, -2.0, 1.0)),
    ((0.5, -2.0, 1.5), (1.0, -2.0, 1.0)),
)
SECOND = (
    ((-11 / 6, 3.0, -1.5, 1 / 3), (2.0, -5.0, 4.0, -1.0)),
    ((-1 / 3, -0.5, 1.0, -1 / 6), (1.0, -2.0, 1.0, 0.0)),
    ((1 / 6, -1.0, 0.5, 1 / 3), (0.0, 1.0, -2.0, 1.0)),
    ((-1 / 3, 1.5, -3.0, 11 / 6), (-1.0, 4.0, -5.0, 2.0)),
)
#: At so many times a given velocity is held against the place; at how many it must be wrong, and by
#: which part. Steps of differences over the run, the shortest first. AT: times and steps are no
#: multiples of a period.
TIMES, OFTEN, WRONG, AT = 8, 3, 1e-3, 0.7548776662466927
PARTS = 1e-10, 1e-8, 1e-6, 1e-4


class Prescribed:
    """Data of conditions. Functions of the case are asked for all particles of a condition at once.

    instant: gives a short time [s], a step for differences in time.
    every: all particles of the problem, of which ``particles`` are those with the numbers ``here``;
    else they are all. data: the arrays of the last instant. moving: particles on walls that move,
    by which the grid goes along; displaced: (particles, d) by how much. by_differences: some data
    are differences in time. doubtful: conditions may come to contradict each other.
    """

    def __init__(
        self,
        problem: Any,
        particles: Sequence[Particle],
        instant: Callable[[], float],
        every: Sequence[Particle] = (),
        here: Array | None = None,
    ) -> None:
        self._instant, self._d, self._laws = instant, problem.dimension, problem.gas_laws.laws
        self._number = problem.gas_laws.number_at
        self._law_of = np.fromiter((self._number(p.members) for p in particles), np.int64)
        n, d = len(particles), problem.dimension
        several = np.zeros((n, d + 2)), np.zeros((n, 2 * d))
        self.data = Data(*np.zeros((5, n, d)), *np.zeros((2, n)), *several)
        first = [p.members[0] for p in particles]
        places = [problem.places(k, np.array([node]))[0] for k, node in first]
        self._x = np.array(places).reshape(n, d)
        self.displaced = np.zeros_like(self._x)
        self._groups = {name: _grouped(particles, name) for name in NAMES}
        self._every = every or particles
        self._here = np.arange(n) if here is None else here
        found = [c for group in self._groups.values() for c, _ in group]
        self.by_differences = any(moves(c) or getattr(c, "velocity", None) for c in found)
        walls = [who for name in WALLS for c, who in self._groups[name] if moves(c)]
        self.moving = np.unique(np.concatenate([np.empty(0, np.int64), *walls]))
        self._contradictions = Contradictions(problem, particles, self._x, self._velocity)
        self.doubtful = self._contradictions.possible
        self._t = 0.0

    def notes(self) -> list[Note]:
        """Where conditions contradict each other at the last instant, see Contradictions."""
        return self._contradictions.notes(self.data, self._t, self._instant())

    def refresh(self, t: float) -> None:
        """Data at time t [s]. InputError."""
        self._t = t
        out, x, d, groups = self.data, self._x, self._d, self._groups
        for condition, who in _walls(groups):
            place, out.wall[who], out.wall_rate[who] = self._motion(condition, x[who], t)
            self.displaced[who] = place - x[who]
        for condition, who in groups["clamp"]:
            place, out.clamp_velocity[who], out.clamp_rate[who] = self._motion(condition, x[who], t)
            out.clamp[who] = place - x[who]
        for name, T in (("warm_gas", out.T), ("warm_solid", out.T_solid)):
            for condition, who in groups[name]:
                T[who] = datum(condition, "T", x[who], t)
        for condition, who in groups["given_gas"]:
            names = names_of("fluid", "values", d)
            rho, *u, T = datum(condition, "values", x[who], t, names).T
            energy = rho * (self._internal_energy(who, rho, T) + 0.5 * sum(c * c for c in u))
            out.gas[who] = np.stack([rho, *(rho * c for c in u), energy], axis=-1)
        for condition, who in groups["given_solid"]:
            values = datum(condition, "values", x[who], t, names_of("solid", "values", d))
            v, T, place = np.split(values, [d, d + 1], axis=1)
            out.solid[who] = np.concatenate([place - x[who], v], axis=1)
            out.T_solid[who] = T[:, 0]
        self._contradictions.refuse(out, t, self._instant())

    def record_data(self, recorder: Recorder) -> None:
        """Record all that depends on time, of conditions anywhere: all ranks have one text."""
        number = np.full(len(self._every), -1)
        number[self._here] = np.arange(len(self._here))
        groups = {name: _grouped(self._every, name) for name in NAMES}
        out, d = self.data, self._d

        def add(condition: Any, who: Array, make: Make, *targets: Array) -> None:
            own = number[who][number[who] >= 0]
            recorder.add(condition, make, self._x[own].T, own, *targets)

        for condition, who in _walls(groups):
            add(condition, who, motion(condition), self.displaced, out.wall, out.wall_rate)
        for condition, who in groups["clamp"]:
            targets = out.clamp, out.clamp_velocity, out.clamp_rate
            add(condition, who, motion(condition), *targets)
        for name, T in (("warm_gas", out.T), ("warm_solid", out.T_solid)):
            for condition, who in groups[name]:
                add(condition, who, temperature(condition), T)
        for condition, who in groups["given_gas"]:
            law_of = [self._number(self._every[p].members) for p in who]
            for law in np.unique(law_of):
                make = given_gas(condition, self._laws[law])
                add(condition, who[law_of == law], make, out.gas)
        for condition, who in groups["given_solid"]:
            add(condition, who, given_solid(condition, d), out.solid, out.T_solid)

    def _velocity(self, condition: Any, gas: bool, X: Array, t: float) -> Array:
        """(n, d), that of a condition of a gas or a solid, also where another one decides."""
        if condition.all_given:
            names = names_of("fluid" if gas else "solid", "values", self._d)
            return datum(condition, "values", X, t, names)[:, gas : gas + self._d]
        return self._motion(condition, X, t)[1]

    def _internal_energy(self, who: Array, rho: Array, T: Array) -> Array:
        """Per mass, of particles of gas by the law of each."""
        laws, found = self._law_of[who], np.empty_like(rho)
        for number in np.unique(laws):
            at = laws == number
            found[at] = self._laws[number].internal_energy(rho[at], T[at])
        return found

    def _motion(self, condition: Any, X: Array, t: float) -> tuple[Array, Array, Array]:
        """(place, velocity, acceleration), (n, d) each; by differences in time where they are not
        given. Without a place it is X.
        """
        s, d = self._instant(), self._d

        def x(t: float) -> Array:
            return datum(condition, "x", X, t, "xyz"[:d])

        def velocity(t: float) -> Array:
            return datum(condition, "velocity", X, t, "uvw"[:d])

        if getattr(condition, "velocity", None) is not None:
            place = x(t) if moves(condition) else X
            v, rate, _ = _differences(velocity, t, s, FIRST)
            return place, v, rate
        if not moves(condition):
            return X, np.zeros_like(X), np.zeros_like(X)
        return _differences(x, t, s, SECOND)

    def check_motion(self, t_end: float) -> None:
        """InputError where the velocity of a wall is not the derivative of its place at some times
        in 0 … t_end [s]: at OFTEN of them, for one may be that of a kink.
        """
        for name in (*WALLS, "clamp"):
            for condition, who in self._groups[name]:
                if moves(condition) and condition.velocity is not None and t_end > 0.0:
                    times = t_end * (AT * np.arange(1, TIMES + 1) % 1.0)
                    found = [self._contradicted(condition, self._x[who], t, t_end) for t in times]
                    said = list(filter(None, found))
                    if len(said) >= OFTEN:
                        where = place_of(condition.velocity)
                        raise InputError(f"{where}: velocity of {said[0]}", collective=False)

    def _contradicted(self, condition: Any, X: Array, t: float, t_end: float) -> str:
        """What a velocity is and what it should be, in words, if it is another one at time t [s].

        The shortest step of differences counts that round-off allows. How wrong they may be is told
        by a step that is twice as long, and by how much velocities change meanwhile.
        """

        def x(t: float) -> Array:
            return datum(condition, "x", X, t, "xyz"[: self._d])

        def velocity(t: float) -> Array:
            return datum(condition, "velocity", X, t, "uvw"[: self._d])

        given, noise = velocity(t), 16.0 * np.finfo(float).eps
        for part in PARTS:
            s = AT * min(part * t_end, t / 2, (t_end - t) / 2)
            near, far = ((x(t + k * s) - x(t - k * s)) / (2 * k * s) for k in (1, 2))
            size = np.maximum(np.abs(given), np.abs(near)).max()
            round_off = noise * (np.abs(x(t)).max() + t_end * size) / s
            if round_off <= WRONG * size:
                break
        turns = sum(np.abs(velocity(t + k * s) - given) for k in (-2, -1, 1, 2))
        allowed = WRONG * size + round_off + 4.0 * (np.abs(near - far) + turns)
        for i, c in np.argwhere(np.abs(given - near) > allowed)[:1]:
            return (
                f"{type(condition).__name__} at t = {t:.6g}: {'uvw'[c]} = {given[i, c]:.6g}, and "
                f"{'xyz'[c]} changes by {near[i, c]:.6g} per second: expected the derivative of x, "
                "or x alone"
            )
        return ""


def _differences(
    of: Callable[[float], Array], t: float, s: float, weights: Sequence[Any]
) -> tuple[Array, Array, Array]:
    """A function of time, its first and its second derivative at t >= 0, from values at t and at
    earlier times s apart, at first at later ones: never from times before or after the run, where
    it may not be known, nor from when the run ends, which may change at a restart.
    """
    before = int(min(len(weights) - 1.0, t / s))
    first, second = weights[before]
    values = [of(t if j == before else max(t + (j - before) * s, 0.0)) for j in range(len(first))]
    rate = sum(w * value for w, value in zip(first, values, strict=True)) / s
    bend = sum(w * value for w, value in zip(second, values, strict=True)) / (s * s)
    return values[before], rate, bend


def _walls(groups: Mapping[str, Any]) -> list[tuple[Any, Array]]:
    """Conditions that say how walls move, and their particles; the last one of several holds."""
    walls = sorted(groups["slip"] + groups["wall"], key=lambda group: moves(group[0]))
    return walls + [(c, who) for c, who in groups["given_gas"] if moves(c)]


def _grouped(particles: Sequence[Particle], name: str) -> list[tuple[Any, Array]]:
    """(condition, numbers of its particles), for each condition."""
    found: dict[int, tuple[Any, list[int]]] = {}
    for p, particle in enumerate(particles):
        condition = getattr(particle, name)
        if condition is not None:
            found.setdefault(id(condition), (condition, []))[1].append(p)
    return [(condition, np.array(who)) for condition, who in found.values()]
