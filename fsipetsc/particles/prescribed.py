"""What conditions prescribe at an instant for the particles of a rank: motion, temperatures, all
unknowns.

Where faces meet, one condition decides: docs/cases.md has a table. Where another one that sticks or
clamps, or that moves, wants a second velocity there, the equations have a singularity: density or
stress at that node grows as 1/h, and no grid converges. That is refused.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blocks.maps import place_text
from fsipetsc.blocks.values import datum, names_of
from fsipetsc.errors import InputError, place_of
from fsipetsc.kernels.symbols import Symbol, derivatives
from fsipetsc.particles.members import Face, Particle
from fsipetsc.scheme.recorded_data import Make, Recorder, asked, positive

Array = NDArray[Any]
#: conditions of a particle that have data; those by which the gas's grid moves
NAMES = "wall", "slip", "clamp", "warm_gas", "warm_solid", "given_gas", "given_solid"
WALLS = "wall", "slip", "given_gas"
#: part of the larger one by which velocities that meet may differ; part of the velocity of a wall
#: at rest that may point across it
APART, ACROSS = 1e-3, 0.1
#: parts of a run at which both are looked at, no multiples of a period
TIMES = 0.0, 1.0, *(0.7548776662466927 * k % 1.0 for k in range(1, 127))
#: parts of a run at which a velocity is held against the place; part of the largest one by which
#: it may differ
BETWEEN, WRONG = (0.7549, 0.5098, 0.2647), 1e-2
#: of the distance below which places are one: velocities may be differences of places
ROUND_OFF = 1e-4


class Data(NamedTuple):
    """What conditions prescribe at an instant, for each of n particles in d dimensions."""

    wall: Array  #: (n, d) velocity of walls
    wall_rate: Array  #: (n, d) acceleration of walls
    clamp: Array  #: (n, d) displacement of clamps
    clamp_velocity: Array  #: (n, d)
    clamp_rate: Array  #: (n, d)
    T: Array  #: (n,) temperature of gas
    T_solid: Array  #: (n,) temperature of solids
    gas: Array  #: (n, d + 2) all unknowns of a gas: rho, rho u, E
    solid: Array  #: (n, 2d) all of a solid: place less X, and velocity


class Met(NamedTuple):
    """A face whose condition says how particles ``who`` move, and another one there whose condition
    wants to say it, too.
    """

    first: Face
    other: Face
    who: list[int]


class Source(NamedTuple):
    """Whose data go to the particles ``who`` of targets, and their formula (x, t): of numbers or of
    symbols.
    """

    condition: Any
    who: Array
    make: Make
    targets: tuple[Array, ...]


class Prescribed:
    """Data of conditions. Functions of the case are asked for all particles of a condition at once.

    particles: all of the problem. here: numbers of those of this rank. instant: gives a short time
    [s], a step for differences in time.

    data: the arrays of the last instant. moving: particles on walls that move, by which the grid
    goes along; displaced: (particles, d) by how much. by_differences: some data are differences in
    time.
    """

    def __init__(
        self,
        problem: Any,
        particles: Sequence[Particle],
        here: Sequence[int],
        instant: Callable[[], float],
    ) -> None:
        self._problem, self._every, self._here = problem, particles, here
        self._instant, self._d = instant, problem.dimension
        own, n, d = [particles[p] for p in here], len(here), problem.dimension
        several = np.zeros((n, d + 2)), np.zeros((n, 2 * d))
        self.data = Data(*np.zeros((5, n, d)), *np.zeros((2, n)), *several)
        first = [p.members[0] for p in own]
        places = [problem.places(k, np.array([node]))[0] for k, node in first]
        self._x = np.array(places).reshape(n, d)
        self.displaced = np.zeros_like(self._x)
        self._sources = self._sources_of(own)
        self.by_differences = any(_has_motion(source.condition) for source in self._sources)
        named = {name: _grouped(own, name) for name in (*WALLS, "clamp")}
        moved = [who for name in WALLS for c, who in named[name] if c.moves]
        self.moving = np.unique(np.concatenate([np.empty(0, np.int64), *moved]))
        every = [group for groups in named.values() for group in groups]
        self._moved = [(c, who) for c, who in every if c.velocity and c.moves]
        sliding = [(c, who) for c, who in named["wall"] if c.velocity and not c.moves]
        normals = [np.array([own[p].wall_normal(problem) for p in who]) for _, who in sliding]
        self._sliding = [(*one, normal) for one, normal in zip(sliding, normals, strict=True)]
        self._met = _met(problem, own)

    def _sources_of(self, particles: Sequence[Particle]) -> list[Source]:
        """Where data of these particles come from; what comes later holds."""
        out, problem = self.data, self._problem
        of_walls = self.displaced, out.wall, out.wall_rate
        of_clamps = out.clamp, out.clamp_velocity, out.clamp_rate
        named = {name: _grouped(particles, name) for name in NAMES}
        walls = sorted(named["slip"] + named["wall"], key=lambda group: group[0].moves)
        walls += [(c, who) for c, who in named["given_gas"] if c.moves]
        found = []
        for groups, targets in (walls, of_walls), (named["clamp"], of_clamps):
            found += [Source(c, w, partial(motion, c, self._instant), targets) for c, w in groups]
        for name, T in (("warm_gas", out.T), ("warm_solid", out.T_solid)):
            found += [Source(c, who, partial(temperature, c), (T,)) for c, who in named[name]]
        for c, who in named["given_gas"]:
            law_of = np.array([problem.law_at(particles[p].members) for p in who])
            for law in np.unique(law_of):
                make = partial(gas_of, c, problem.gas_laws[law])
                found.append(Source(c, who[law_of == law], make, (out.gas,)))
        for c, who in named["given_solid"]:
            found.append(Source(c, who, partial(solid_of, c), (out.solid, out.T_solid)))
        return found

    def refresh(self, t: float) -> None:
        """Data at time t [s]. InputError."""
        for _, who, make, targets in self._sources:
            for target, values in zip(targets, make(self._x[who].T, t), strict=True):
                target[who] = np.transpose(values)

    def record_data(self, recorder: Recorder) -> None:
        """Record all that depends on time, of conditions anywhere: all ranks have one text."""
        number = np.full(len(self._every), -1)
        number[self._here] = np.arange(len(self._here))
        for condition, who, make, targets in self._sources_of(self._every):
            own = number[who][number[who] >= 0]
            recorder.add(condition, make, self._x[own].T, own, *targets)

    def check_motion(self, t_end: float) -> None:
        """InputError where, at some times in 0 … t_end [s], two conditions want velocities that
        cannot be, that of a wall at rest does not lie in it, or one is not the derivative of the
        place. Perhaps on this rank alone.
        """
        for condition, who in self._moved if t_end > 0.0 else ():
            self._check_velocity(condition, who, [part * t_end for part in BETWEEN])
        for t in (part * t_end for part in TIMES):
            for met in self._met:
                self._compare(met, t)
            for condition, who, normals in self._sliding:
                v = datum(condition, "velocity", self._x[who], t, "uvw"[: self._d])
                across = np.abs((v * normals).sum(axis=1))
                worst = int(across.argmax())
                if across[worst] > ACROSS * np.abs(v).max():
                    raise InputError(
                        f"{place_of(condition.velocity)}: velocity of NoSlip at t = {t:.6g} is "
                        f"{_text(v[worst])} at {place_text(self._x[who][worst])}, across the wall: "
                        "expected one along it, or x, too",
                        collective=False,
                    )

    def _check_velocity(self, condition: Any, who: Array, times: Sequence[float]) -> None:
        """InputError where a velocity is not the derivative of x."""
        x, alone = self._x[who].T, replace(condition, velocity=None)
        given, found = (
            np.array([motion(c, self._instant, x, t)[1] for t in times]) for c in (condition, alone)
        )
        apart, largest = np.abs(given - found), max(np.abs(given).max(), np.abs(found).max())
        if apart.max() > WRONG * largest + ROUND_OFF * self._problem.tolerance / self._instant():
            k, c, p = np.unravel_index(apart.argmax(), apart.shape)
            raise InputError(
                f"{place_of(condition.velocity)}: velocity of {type(condition).__name__} at t = "
                f"{times[k]:.6g}: {'uvw'[c]} = {given[k, c, p]:.6g}, and {'xyz'[c]} changes by "
                f"{found[k, c, p]:.6g} per second: expected the derivative of x, or x alone",
                collective=False,
            )

    def _compare(self, met: Met, t: float) -> None:
        """InputError where two conditions want different velocities at time t [s]."""
        x, both = self._x[met.who], (met.first, met.other)
        wanted = [np.transpose(motion(face.met, self._instant, x.T, t)[1]) for face in both]
        size = np.maximum(*(np.linalg.norm(v, axis=1) for v in wanted))
        least = ROUND_OFF * self._problem.tolerance / self._instant()
        bad = np.flatnonzero(np.linalg.norm(wanted[0] - wanted[1], axis=1) > APART * size + least)
        if bad.size:
            at = min(bad.tolist(), key=lambda p: tuple(x[p]))
            names = " and ".join(one.said(self._problem) for one in both)
            raise InputError(
                f"{names} meet at {place_text(x[at])} with velocities of "
                f"{' and '.join(_text(v[at]) for v in wanted)}{self._problem.unit('m/s')} at t = "
                f"{t:.6g}: no grid converges there: let faces beside one that moves be Slip or "
                "Roller, have a slip_length, or move with it",
                collective=False,
            )


def _asked(condition: Any, name: str, x: Any, t: Any, names: Sequence[str] = ()) -> Any:
    """A datum at places x, of d components, and a time: a number, or one for each name. InputError
    or NotRecorded.
    """
    if isinstance(t, Symbol):
        return asked(condition, name, x, t, len(names))
    return datum(condition, name, np.transpose(x), t, names or None).T


def _less(a: Any, b: Any) -> tuple[Any, ...]:
    """a - b by components."""
    return tuple(map(np.subtract, a, b))


def motion(condition: Any, instant: Callable[[], float], x: Any, t: Any) -> Sequence[Any]:
    """Displacement, velocity and acceleration. What is not given of these are derivatives, of
    symbols exact ones, of numbers by differences in time.
    """
    given, d = condition.velocity is not None, len(x)

    def place(t: Any) -> Any:
        return _asked(condition, "x", x, t, "xyz"[:d]) if condition.moves else x

    def velocity(t: Any) -> Any:
        return _asked(condition, "velocity", x, t, "uvw"[:d])

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
    return (positive(_asked(condition, "T", x, t)),)


def gas_of(condition: Any, law: Any, x: Any, t: Any) -> Sequence[Any]:
    """All unknowns of a gas with this law: (rho, rho u, E)."""
    rho, *u, T = _asked(condition, "values", x, t, names_of("fluid", "values", len(x)))
    rho, T = positive(rho), positive(T)
    energy = rho * (law.internal_energy(rho, T) + 0.5 * sum(c * c for c in u))
    return ((rho, *(rho * c for c in u), energy),)


def solid_of(condition: Any, x: Any, t: Any) -> Sequence[Any]:
    """All unknowns of a solid: displacement and velocity, temperature."""
    d = len(x)
    values = _asked(condition, "values", x, t, names_of("solid", "values", d))
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


def _grouped(particles: Sequence[Particle], name: str) -> list[tuple[Any, Array]]:
    """(condition, numbers of its particles), for each condition."""
    found: dict[int, tuple[Any, list[int]]] = {}
    for p, particle in enumerate(particles):
        condition = getattr(particle, name)
        if condition is not None:
            found.setdefault(id(condition), (condition, []))[1].append(p)
    return [(condition, np.array(who)) for condition, who in found.values()]


def _met(problem: Any, particles: Sequence[Particle]) -> list[Met]:
    """Where a second condition must have the velocity of that which decides: pairs of which one
    moves, and the other one sticks, clamps or moves, too.
    """
    found: dict[Any, Met] = {}
    for p, particle in enumerate(particles):
        for other in particle.asked:
            name = particle.mover(problem.blocks[other.block].kind == "fluid")
            decides, met = getattr(particle, name, None), other.met
            if decides is None or decides is met or decides.all_given or met.all_given:
                continue
            if _has_motion(met) or (_has_motion(decides) and not particle.slides(other)):
                first = next(one for one in particle.asked if one.met is decides)
                found.setdefault((first.name, other.name), Met(first, other, [])).who.append(p)
    return list(found.values())


def _has_motion(condition: Any) -> bool:
    """Whether data say how it moves."""
    return condition.moves or condition.velocity is not None


def _text(values: Array) -> str:
    """Numbers, in brackets if there are several."""
    numbers = ", ".join(f"{v:.4g}" for v in values.tolist())
    return numbers if len(values) == 1 else f"({numbers})"
