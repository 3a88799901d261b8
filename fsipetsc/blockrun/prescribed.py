"""What conditions prescribe at an instant for the particles of a rank: motion, temperatures, all
unknowns.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.asked import Asked, data, datum
from fsipetsc.blocks.conditions import moves, steady
from fsipetsc.blocks.particles import Particle
from fsipetsc.blocks.values import names_of
from fsipetsc.scheme.particles import Data

Array = NDArray[Any]
#: conditions of a particle that have data
NAMES = "wall", "slip", "clamp", "warm_gas", "warm_solid", "given_gas", "given_solid"
#: those by which the gas's grid moves
WALLS = "wall", "slip", "given_gas"


class Prescribed:
    """Data of conditions. Functions of the case are asked for all particles of a condition at once.

    law: of the gas. instant: says a time [s] in which little happens, for differences in time.
    data: the arrays of the last instant. moving: particles on walls that move, by which the grid
    goes along. timed: data depend on time.
    """

    def __init__(
        self,
        problem: Any,
        particles: Sequence[Particle],
        law: Any,
        instant: Callable[[], float],
        asked: Asked,
    ) -> None:
        self._law, self._instant, self._asked = law, instant, asked
        self._d = d = problem.dimension
        n = len(particles)
        vectors = (np.zeros((n, d)) for _ in range(5))
        several = np.zeros((n, d + 2)), np.zeros((n, 2 * d))
        self.data = Data(*vectors, np.zeros(n), np.zeros(n), *several)
        first = [p.members[0] for p in particles]
        places = [problem.places(k, np.array([node]))[0] for k, node in first]
        self._x = np.array(places).reshape(n, d)
        self._displaced = np.zeros_like(self._x)
        self._groups = {name: _grouped(particles, name) for name in NAMES}
        found = [c for group in self._groups.values() for c, _ in group]
        self.timed = not all(steady(condition) for condition in found)
        self._by_differences = any(moves(c) or _velocity(c) for c in found)
        walls = [who for name in WALLS for c, who in self._groups[name] if moves(c)]
        self.moving = np.unique(np.concatenate([np.empty(0, np.int64), *walls]))

    def at(self, t: float) -> Data:
        """Data at time t [s]; the same arrays each time. InputError the first time."""
        return self._asked("particles", self._when(t), lambda: self._fill(t))

    def displacement(self, t: float) -> Array:
        """(moving particles, d) displacement of those on walls that move at time t [s]."""
        self.at(t)
        return self._displaced[self.moving]

    def _when(self, t: float) -> Any:
        """What the data depend on."""
        if not self.timed:
            return None
        return (t, self._instant()) if self._by_differences else t

    def _fill(self, t: float) -> Data:
        out, x = self.data, self._x
        walls = self._groups["slip"] + self._groups["wall"]
        walls.sort(key=lambda group: moves(group[0]))  # the last one holds
        for condition, who in walls:
            self._move_wall(condition, who, t)
        for condition, who in self._groups["clamp"]:
            place, out.clamp_velocity[who], out.clamp_rate[who] = self._motion(condition, x[who], t)
            out.clamp[who] = place - x[who]
        for condition, who in self._groups["warm_gas"]:
            out.T[who] = datum(condition, "T", x[who], t)
        for condition, who in self._groups["warm_solid"]:
            out.T_solid[who] = datum(condition, "T", x[who], t)
        for condition, who in self._groups["given_gas"]:
            self._give_gas(condition, who, t)
            if moves(condition):
                self._move_wall(condition, who, t)
        for condition, who in self._groups["given_solid"]:
            values = data(condition, "values", x[who], t, names_of("solid", "values", self._d))
            v, T, place = np.split(values, [self._d, self._d + 1], axis=1)
            out.solid[who] = np.concatenate([place - x[who], v], axis=1)
            out.T_solid[who] = T[:, 0]
        return out

    def _move_wall(self, condition: Any, who: Array, t: float) -> None:
        x, out = self._x[who], self.data
        place, out.wall[who], out.wall_rate[who] = self._motion(condition, x, t)
        self._displaced[who] = place - x

    def _motion(self, condition: Any, X: Array, t: float) -> tuple[Array, Array, Array]:
        """(place, velocity, acceleration), (n, d) each; by central differences where they are not
        given. Without a place it is X.
        """
        s, d = self._instant(), self._d

        def x(t: float) -> Array:
            return data(condition, "x", X, t, "xyz"[:d])

        def velocity(t: float) -> Array:
            return data(condition, "velocity", X, t, "uvw"[:d])

        place = x(t) if moves(condition) else X
        if _velocity(condition):
            return place, velocity(t), (velocity(t + s) - velocity(t - s)) / (2 * s)
        if not moves(condition):
            return place, np.zeros_like(X), np.zeros_like(X)
        after, before = x(t + s), x(t - s)
        return place, (after - before) / (2 * s), (after - 2 * place + before) / (s * s)

    def _give_gas(self, condition: Any, who: Array, t: float) -> None:
        values = data(condition, "values", self._x[who], t, names_of("fluid", "values", self._d))
        rho, *u, T = values.T
        energy = rho * (self._law.internal_energy(rho, T) + 0.5 * sum(c * c for c in u))
        self.data.gas[who] = np.stack([rho, *(rho * c for c in u), energy], axis=-1)


def _velocity(condition: Any) -> Any:
    return getattr(condition, "velocity", None)


def _grouped(particles: Sequence[Particle], name: str) -> list[tuple[Any, Array]]:
    """Conditions and the particles they hold."""
    found: dict[int, tuple[Any, list[int]]] = {}
    for p, particle in enumerate(particles):
        condition = getattr(particle, name)
        if condition is not None:
            found.setdefault(id(condition), (condition, []))[1].append(p)
    return [(condition, np.array(who)) for condition, who in found.values()]
