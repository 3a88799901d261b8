"""What conditions prescribe at an instant for a rank's particles: motion, temperatures, unknowns.

Where faces meet, one condition decides: docs/cases.md has a table. Where another one that sticks or
clamps, or that moves, wants a second velocity there, the equations have a singularity: density or
stress at that node grows as 1/h, and no grid converges. That is refused.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.checks import Array, names_of, place_text
from fsipetsc.equations.vectors import sub
from fsipetsc.errors import InputError, place_of
from fsipetsc.kernels.symbols import Symbol, derivatives
from fsipetsc.particles.members import Face, Particle
from fsipetsc.scheme.recorded_data import Make, Source, asked

Instant = Callable[[], float]
#: part of the larger one by which velocities that meet may differ; part of the velocity of a wall
#: at rest that may point across it; part of the largest velocity by which one may differ from the
#: derivative of the place
APART, ACROSS, WRONG = 1e-3, 0.1, 1e-2
#: parts of a run at which velocities are looked at, no multiples of a period
TIMES = 0.0, 1.0, *(0.7548776662466927 * k % 1.0 for k in range(1, 127))
#: what is said of velocities that meet
NO_GRID = "no grid converges there: let faces beside one that moves be Slip or Roller, "
NO_GRID += "have a slip_length, or move with it"
#: of the distance below which places are one: velocities may be differences of places
ROUND_OFF = 1e-4


class Data(NamedTuple):
    """What conditions prescribe at an instant, for each of n particles in d dimensions."""

    place: Array  #: (n, d) displacement of walls
    wall: Array  #: (n, d) velocity of walls
    wall_rate: Array  #: (n, d) acceleration of walls
    clamp: Array  #: (n, d) displacement of clamps, and of solids that are given
    clamp_velocity: Array  #: (n, d)
    clamp_rate: Array  #: (n, d)
    T: Array  #: (n,) temperature of gas
    T_solid: Array  #: (n,) temperature of solids
    gas: Array  #: (n, d + 2) all unknowns of a gas: rho, rho u, E


class Prescribed:
    """Data of conditions at the particles of this rank. Functions of the case are asked for all
    particles of a condition at once.

    particles: all of the problem. here: numbers (n,) of those of this rank. instant: gives a short
    time [s], a step for differences in time. data: those found last. sources: of all conditions,
    also those that no particle here has: so the text of their record is the same on all ranks.
    """

    def __init__(
        self, problem: Any, particles: Sequence[Particle], here: Array, instant: Instant
    ) -> None:
        self._problem, self._every, self._instant = problem, particles, instant
        self._particles = [particles[p] for p in here]
        self._row = {p: [row] for row, p in enumerate(here.tolist())}
        n, d = here.size, problem.dimension
        self.data = Data(*np.zeros((6, n, d)), *np.zeros((2, n)), np.zeros((n, d + 2)))
        self._x, first = np.zeros((n, d)), np.array([one.members[0] for one in self._particles])
        for k in {k for k, _ in first.tolist()}:
            there = first[:, 0] == k
            self._x[there] = problem.places(k, first[there, 1])
        self.sources = [*self._sources()]

    def _grouped(self, name: str) -> list[tuple[Any, Array, Any]]:
        """For each condition of this name, and each law of a gas there: the condition, which
        particles of this rank have it, the number of the law.
        """
        found: dict[tuple[int, int], tuple[Any, list[int], int]] = {}
        for p, particle in enumerate(self._every):
            if name in particle.faces:
                condition, law = particle.faces[name].met, self._problem.law_at(particle.members)
                group = found.setdefault((id(condition), law), (condition, [], law))
                group[1].extend(self._row.get(p, []))
        return [(condition, np.array(who, np.int64), law) for condition, who, law in found.values()]

    def _sources(self) -> Iterator[Source]:
        """Where data come from. What comes later holds."""
        out, laws, grouped = self.data, self._problem.gas_laws, self._grouped

        def source(c: Any, who: Array, make: Make, *targets: Array) -> Source:
            return Source(c, make, self._x[who].T, who, *targets)

        walls = sorted(grouped("slip") + grouped("wall"), key=lambda group: group[0].moves)
        walls += [group for group in grouped("given_gas") if group[0].moves]
        for groups, targets in (walls, out[:3]), (grouped("clamp"), out[3:6]):
            for c, who, _ in groups:
                yield source(c, who, partial(motion, c, self._instant), *targets)
        for name, T in (("warm_gas", out.T), ("warm_solid", out.T_solid)):
            for c, who, _ in grouped(name):
                if not c.all_given:
                    yield source(c, who, lambda x, t, c=c: (asked(c, "T", x, t),), T)
        for c, who, law in grouped("given_gas"):
            yield source(c, who, partial(gas_of, c, laws[law]), out.gas)
        for c, who, _ in grouped("given_solid"):
            yield source(c, who, partial(solid_of, c), out.clamp, out.clamp_velocity, out.T_solid)

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
            for c, who, _ in self._grouped(name):
                if not c.velocity or not who.size:
                    continue
                about = f"{place_of(c.velocity)}: velocity of {type(c).__name__}"
                if c.moves and t_end > 0.0:
                    both, some = (c, replace(c, velocity=None)), times[2:5]
                    v, rate = (self._velocities(one, who, some) for one in both)
                    most = WRONG * max(np.abs(v).max(), np.abs(rate).max())
                    wanted = "that of x", "expected the derivative of x, or x alone"
                    self._agree(v, rate, most, who, some, about, *wanted)
                elif not c.moves and name == "wall":
                    faces = [self._particles[p].faces["wall"] for p in who]
                    n = np.array([self._problem.face_normal(*face[:4])[0] for face in faces]).T
                    wanted = "across the wall, and along it", "expected that, or x, too"
                    v = self._velocities(c, who, times)
                    along = v - (v * n).sum(axis=1, keepdims=True) * n
                    most = ACROSS * np.abs(v).max(axis=1).max(axis=1, keepdims=True)
                    self._agree(v, along, most, who, times, about, *wanted)
        for faces, who in self._meetings():
            both = [self._velocities(face.met, who, times) for face in faces]
            most = APART * np.maximum(*(np.linalg.norm(v, axis=1) for v in both))
            one, other = (face.said(self._problem) for face in faces)
            names = f"the velocity of {one}", f"that of {other} which meets it there,"
            self._agree(*both, most, who, times, *names, NO_GRID)

    def _velocities(self, condition: Any, who: Any, times: Sequence[float]) -> Array:
        """(times, d, particles)."""
        return np.array([motion(condition, self._instant, self._x[who].T, t)[1] for t in times])

    def _agree(self, v: Array, other: Array, most: Any, who: Any, times: Any, *words: str) -> None:
        """InputError where two velocities differ by more than ``most``; words: to say so."""
        most = most + ROUND_OFF * self._problem.tolerance / self._instant()
        for k, p in np.argwhere(np.linalg.norm(v - other, axis=1) > most)[:1]:
            one, two = (_text(u[k, :, p]) + self._problem.unit("m/s") for u in (v, other))
            at = f"at t = {times[k]:.6g} is {one} at {place_text(self._x[who[p]])}"
            about, beside, wanted = words
            raise InputError(f"{about} {at}, {beside} {two}: {wanted}", collective=False)

    def _meetings(self) -> Iterable[tuple[tuple[Face, Face], list[int]]]:
        """Where a second condition must have the velocity of that which decides: faces of which one
        moves, and the other one sticks, clamps or moves, too, and their particles.
        """
        found: dict[Any, tuple[tuple[Face, Face], list[int]]] = {}
        for p, particle in enumerate(self._particles):
            for other in particle.held:
                first = particle.mover(self._problem.blocks[other.block].kind == "fluid")
                if first is None or first.met == other.met:
                    continue
                one, two = (c.moves or c.velocity is not None for c in (first.met, other.met))
                given = first.met.all_given or other.met.all_given
                if not given and (two or (one and not particle.slides(other))):
                    found.setdefault((first.name, other.name), ((first, other), []))[1].append(p)
        return found.values()


def motion(condition: Any, instant: Instant, x: Any, t: Any) -> Sequence[Any]:
    """Displacement, velocity and acceleration. What is not given of these are derivatives, of
    symbols exact ones, of numbers by differences in time.
    """
    given, moves, d = condition.velocity is not None, condition.moves, len(x)

    def place(t: Any) -> Any:
        return asked(condition, "x", x, t, "xyz"[:d]) if moves else x

    def velocity(t: Any) -> Any:
        return asked(condition, "velocity", x, t, "uvw"[:d])

    if not (given or moves):
        return ((0.0,) * d,) * 3 if isinstance(t, Symbol) else np.zeros((3, *x.shape))
    of, most = (velocity, 1) if given else (place, 2)
    if isinstance(t, Symbol):
        found = [of(t)]
        for _ in range(most):
            found.append(derivatives(found[-1], t, still=True))
    else:
        found = _differences(of, t, instant(), most)
    return sub(place(t) if given else found[0], x), *found[-2:]


def gas_of(condition: Any, law: Any, x: Any, t: Any) -> Sequence[Any]:
    """All unknowns of a gas with this law: (rho, rho u, E)."""
    rho, *u, T = asked(condition, "values", x, t, names_of("fluid", "values", len(x)))
    energy = rho * (law.internal_energy(rho, T) + 0.5 * sum(c * c for c in u))
    return ((rho, *(rho * c for c in u), energy),)


def solid_of(condition: Any, x: Any, t: Any) -> Sequence[Any]:
    """All unknowns of a solid: displacement and velocity, temperature."""
    d = len(x)
    values = asked(condition, "values", x, t, names_of("solid", "values", d))
    return sub(values[d + 1 :], x), values[:d], values[d]


def _differences(of: Callable[[float], Any], t: float, s: float, most: int) -> list[Array]:
    """A function of time and its first derivatives at t >= 0, one or two, of second order, the
    first of two of third. From values at t and at earlier times s apart, at first at later ones:
    never from times before or after the run, where it may not be known, nor from when the run
    ends, which may change at a restart.
    """
    count = most + 2
    before = int(min(count - 1.0, t / s))
    steps = np.arange(count) - before
    weights = np.rint(6.0 * np.linalg.inv(np.vander(steps, increasing=True))) / 6.0
    values = [np.array(of(t if j == 0 else max(t + j * s, 0.0))) for j in steps.tolist()]
    found = [values[before]]
    for k, row in enumerate(weights[1 : most + 1].tolist(), start=1):  # k = 1, 2: k! is k
        found.append(sum(k * w * v for w, v in zip(row, values, strict=True)) / s**k)
    return found


def _text(values: Array) -> str:
    """Numbers, in brackets if there are several."""
    numbers = ", ".join(f"{v:.4g}" for v in values.tolist())
    return numbers if len(values) == 1 else f"({numbers})"
