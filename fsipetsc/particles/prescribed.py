"""What conditions prescribe at an instant for the particles of a rank: motion, temperatures, all
unknowns.

Where faces meet, one condition decides: docs/cases.md has a table. Where another one that sticks or
clamps, or that moves, wants a second velocity there, the equations have a singularity: density or
stress at that node grows as 1/h, and no grid converges. That is refused.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fsipetsc.checks import names_of, place_text
from fsipetsc.errors import InputError, place_of
from fsipetsc.kernels.symbols import Symbol, derivatives
from fsipetsc.particles.members import Face, Particle
from fsipetsc.scheme.recorded_data import Make, Source, asked, positive

Array = NDArray[Any]
#: part of the larger one by which velocities that meet may differ; part of the velocity of a wall
#: at rest that may point across it; part of the largest velocity by which one may differ from the
#: derivative of the place
APART, ACROSS, WRONG = 1e-3, 0.1, 1e-2
#: parts of a run at which velocities are looked at, no multiples of a period
TIMES = 0.0, 1.0, *(0.7548776662466927 * k % 1.0 for k in range(1, 127))
#: of the distance below which places are one: velocities may be differences of places
ROUND_OFF = 1e-4


class Data(NamedTuple):
    """What conditions prescribe at an instant, for each of n particles in d dimensions."""

    place: Array  #: (n, d) displacement of walls
    wall: Array  #: (n, d) velocity of walls
    wall_rate: Array  #: (n, d) acceleration of walls
    clamp: Array  #: (n, d) displacement of clamps
    clamp_velocity: Array  #: (n, d)
    clamp_rate: Array  #: (n, d)
    T: Array  #: (n,) temperature of gas
    T_solid: Array  #: (n,) temperature of solids
    gas: Array  #: (n, d + 2) all unknowns of a gas: rho, rho u, E
    solid: Array  #: (n, 2d) all of a solid: place less X, and velocity


class Prescribed:
    """Data of conditions at the particles of this rank. Functions of the case are asked for all
    particles of a condition at once.

    particles: all of the problem. here: numbers (n,) of those of this rank. instant: gives a short
    time [s], a step for differences in time. data: those found last. sources: of all conditions,
    also those that no particle here has: so the text of their record is the same on all ranks.
    """

    def __init__(
        self,
        problem: Any,
        particles: Sequence[Particle],
        here: Array,
        instant: Callable[[], float],
    ) -> None:
        self._problem, self._every, self._instant = problem, particles, instant
        self._particles = [particles[p] for p in here]
        self._number = np.full(len(particles), -1)
        self._number[here] = np.arange(here.size)
        n, d = here.size, problem.dimension
        several = np.zeros((n, d + 2)), np.zeros((n, 2 * d))
        self.data = Data(*np.zeros((6, n, d)), *np.zeros((2, n)), *several)
        first = (particle.members[0] for particle in self._particles)
        places = [problem.places(k, np.array([node]))[0] for k, node in first]
        self._x = np.array(places).reshape(n, d)
        self.sources = [
            Source(condition, make, self._x[who].T, who, *targets)
            for condition, every, make, targets in self._sources_of()
            for who in [self._here(every)]
        ]

    def _here(self, every: Array) -> Array:
        """Which particles of this rank are among some of the problem."""
        number = self._number[every]
        return number[number >= 0]

    def _grouped(self, name: str) -> list[tuple[Any, Array]]:
        """(condition, numbers of its particles in the problem), for each one of this name."""
        found: dict[int, tuple[Any, list[int]]] = {}
        for p, particle in enumerate(self._every):
            if name in particle.faces:
                condition = particle.faces[name].met
                found.setdefault(id(condition), (condition, []))[1].append(p)
        return [(condition, np.array(who)) for condition, who in found.values()]

    def _sources_of(self) -> Iterator[tuple[Any, Array, Make, tuple[Array, ...]]]:
        """Where data come from: condition, numbers of its particles in the problem, formula (x, t)
        of numbers or symbols, where these go. What comes later holds.
        """
        out, problem, grouped = self.data, self._problem, self._grouped
        walls = sorted(grouped("slip") + grouped("wall"), key=lambda group: group[0].moves)
        walls += [(c, who) for c, who in grouped("given_gas") if c.moves]
        for groups, targets in (walls, out[:3]), (grouped("clamp"), out[3:6]):
            yield from ((c, who, partial(motion, c, self._instant), targets) for c, who in groups)
        for name, T in (("warm_gas", out.T), ("warm_solid", out.T_solid)):
            groups = [(c, who) for c, who in grouped(name) if not c.all_given]
            yield from ((c, who, partial(temperature, c), (T,)) for c, who in groups)
        for c, who in grouped("given_gas"):
            law_of = np.array([problem.law_at(self._every[p].members) for p in who])
            for law in np.unique(law_of):
                yield c, who[law_of == law], partial(gas_of, c, problem.gas_laws[law]), (out.gas,)
        for c, who in grouped("given_solid"):
            yield c, who, partial(solid_of, c), (out.solid, out.T_solid)

    def refresh(self, t: float) -> None:
        """Data at time t [s]. InputError."""
        for one in self.sources:
            one.fill(t)

    def check_motion(self, t_end: float) -> None:
        """InputError where, at some times in 0 … t_end [s], two conditions want velocities that
        cannot be, that of a wall at rest does not lie in it, or one is not the derivative of the
        place. Perhaps on this rank alone.
        """
        times = [part * t_end for part in TIMES]
        for name in ("wall", "slip", "given_gas", "clamp"):
            for c, who in ((c, self._here(every)) for c, every in self._grouped(name)):
                if not c.velocity or not who.size:
                    continue
                if c.moves and t_end > 0.0:
                    self._check_derivative(c, who, times[2:5])
                elif not c.moves and name == "wall":
                    self._check_along(c, who, times)
        for first, other, who in self._meetings():
            self._compare(first, other, who, times)

    def _least(self) -> float:
        """Round-off of differences in time [m/s]."""
        return float(ROUND_OFF * self._problem.tolerance / self._instant())

    def _velocities(self, condition: Any, who: Any, times: Sequence[float]) -> Array:
        """(times, d, particles)."""
        x = self._x[who].T
        return np.array([motion(condition, self._instant, x, t)[1] for t in times])

    def _check_derivative(self, condition: Any, who: Array, times: Sequence[float]) -> None:
        """InputError where a velocity is not the derivative of x."""
        given, found = (
            self._velocities(c, who, times) for c in (condition, replace(condition, velocity=None))
        )
        apart, largest = np.abs(given - found), max(np.abs(given).max(), np.abs(found).max())
        if apart.max() > WRONG * largest + self._least():
            k, c, p = np.unravel_index(apart.argmax(), apart.shape)
            raise InputError(
                f"{place_of(condition.velocity)}: velocity of {type(condition).__name__} at t = "
                f"{times[k]:.6g}: {'uvw'[c]} = {given[k, c, p]:.6g}, and {'xyz'[c]} changes by "
                f"{found[k, c, p]:.6g} per second: expected the derivative of x, or x alone",
                collective=False,
            )

    def _meetings(self) -> list[tuple[Face, Face, list[int]]]:
        """Where a second condition must have the velocity of that which decides: faces of which one
        moves, and the other one sticks, clamps or moves, too, and their particles.
        """
        found: dict[Any, tuple[Face, Face, list[int]]] = {}
        for p, particle in enumerate(self._particles):
            for other in particle.held:
                first = particle.mover(self._problem.blocks[other.block].kind == "fluid")
                if first is None or first.met == other.met:
                    continue
                sticks = _has_motion(first.met) and not particle.slides(other)
                given = first.met.all_given or other.met.all_given
                if not given and (_has_motion(other.met) or sticks):
                    key = first.name, other.name
                    found.setdefault(key, (first, other, []))[2].append(p)
        return list(found.values())

    def _compare(self, first: Face, other: Face, who: list[int], times: Sequence[float]) -> None:
        """InputError where two conditions want different velocities."""
        wanted = [self._velocities(face.met, who, times) for face in (first, other)]
        size = np.maximum(*(np.linalg.norm(v, axis=1) for v in wanted))
        bad = np.linalg.norm(wanted[0] - wanted[1], axis=1) > APART * size + self._least()
        if bad.any():
            k, p = np.argwhere(bad)[0]
            names = " and ".join(face.said(self._problem) for face in (first, other))
            raise InputError(
                f"{names} meet at {place_text(self._x[who[p]])} with velocities of "
                f"{' and '.join(_text(v[k, :, p]) for v in wanted)}{self._problem.unit('m/s')} at "
                f"t = {times[k]:.6g}: no grid converges there: let faces beside one that moves be "
                "Slip or Roller, have a slip_length, or move with it",
                collective=False,
            )

    def _check_along(self, condition: Any, who: Array, times: Sequence[float]) -> None:
        """InputError where the velocity of a wall at rest does not lie in it."""
        faces = [self._particles[p].faces["wall"] for p in who]
        normals = np.array([self._problem.face_normal(*face[:4])[0] for face in faces])
        for t in times:
            (v,) = self._velocities(condition, who, [t])
            across = np.abs((v * normals.T).sum(axis=0))
            p = int(across.argmax())
            if across[p] > ACROSS * np.abs(v).max():
                raise InputError(
                    f"{place_of(condition.velocity)}: velocity of NoSlip at t = {t:.6g} is "
                    f"{_text(v[:, p])} at {place_text(self._x[who[p]])}, across the wall: expected "
                    "one along it, or x, too",
                    collective=False,
                )


def _less(a: Any, b: Any) -> tuple[Any, ...]:
    """a - b by components."""
    return tuple(map(np.subtract, a, b))


def motion(condition: Any, instant: Callable[[], float], x: Any, t: Any) -> Sequence[Any]:
    """Displacement, velocity and acceleration. What is not given of these are derivatives, of
    symbols exact ones, of numbers by differences in time.
    """
    given, d = condition.velocity is not None, len(x)

    def place(t: Any) -> Any:
        return asked(condition, "x", x, t, "xyz"[:d]) if condition.moves else x

    def velocity(t: Any) -> Any:
        return asked(condition, "velocity", x, t, "uvw"[:d])

    if isinstance(t, Symbol):
        v = velocity(t) if given else derivatives(place(t), t, still=True)
        return _less(place(t), x), v, derivatives(v, t, still=True)
    if given:
        v, rate = _differences(velocity, t, instant(), 1)
        return _less(place(t), x), v, rate
    if not condition.moves:
        return np.zeros((3, *x.shape))
    at, v, rate = _differences(place, t, instant(), 2)
    return _less(at, x), v, rate


def temperature(condition: Any, x: Any, t: Any) -> Sequence[Any]:
    """That of a wall."""
    return (positive(asked(condition, "T", x, t)),)


def gas_of(condition: Any, law: Any, x: Any, t: Any) -> Sequence[Any]:
    """All unknowns of a gas with this law: (rho, rho u, E)."""
    rho, *u, T = asked(condition, "values", x, t, names_of("fluid", "values", len(x)))
    rho, T = positive(rho), positive(T)
    energy = rho * (law.internal_energy(rho, T) + 0.5 * sum(c * c for c in u))
    return ((rho, *(rho * c for c in u), energy),)


def solid_of(condition: Any, x: Any, t: Any) -> Sequence[Any]:
    """All unknowns of a solid: displacement and velocity, temperature."""
    d = len(x)
    values = asked(condition, "values", x, t, names_of("solid", "values", d))
    return (*_less(values[d + 1 :], x), *values[:d]), positive(values[d])


def _differences(of: Callable[[float], Array], t: float, s: float, most: int) -> list[Array]:
    """A function of time and its first derivatives at t >= 0, one or two, of second order, the
    first of two of third. From values at t and at earlier times s apart, at first at later ones:
    never from times before or after the run, where it may not be known, nor from when the run
    ends, which may change at a restart.
    """
    count = most + 2
    before = int(min(count - 1.0, t / s))
    steps = np.arange(count) - before
    weights = np.rint(6.0 * np.linalg.inv(np.vander(steps, increasing=True))) / 6.0
    values = [of(t if j == 0 else max(t + j * s, 0.0)) for j in steps.tolist()]
    found = [values[before]]
    for k, row in enumerate(weights[1 : most + 1].tolist(), start=1):  # k = 1, 2: k! is k
        found.append(sum(k * w * v for w, v in zip(row, values, strict=True)) / s**k)
    return found


def _has_motion(condition: Any) -> bool:
    """Whether data say how it moves."""
    return condition.moves or condition.velocity is not None


def _text(values: Array) -> str:
    """Numbers, in brackets if there are several."""
    numbers = ", ".join(f"{v:.4g}" for v in values.tolist())
    return numbers if len(values) == 1 else f"({numbers})"
