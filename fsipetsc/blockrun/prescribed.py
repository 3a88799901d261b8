"""What conditions prescribe at an instant for the particles of a rank: motion, temperatures, all unknowns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blocks.particles import Particle
from fsipetsc.scheme.particles import Data

Array = NDArray[Any]


class Prescribed:
    """Data of conditions. Functions of the case are asked for arrays of all particles of a condition at once.

    law: of the gas. instant: says a time [s] in which little happens, for differences in time.
    """

    def __init__(self, problem: Any, particles: Sequence[Particle], law: Any, instant: Callable[[], float]) -> None:
        self._problem, self._law, self._instant = problem, law, instant
        self._d = d = problem.blocks[0].dimension
        count = len(particles)
        self._data = Data(
            *(np.zeros((count, d)) for _ in range(5)), np.zeros(count), np.zeros((count, d + 2)), np.zeros((count, 2 * d + 1))
        )
        self._x = np.array([problem.places(k, np.array([n]))[0] for k, n in (p.members[0] for p in particles)])
        self._x = self._x.reshape(count, d)
        self._at = -np.inf
        self._groups = {
            name: self._grouped(particles, name)
            for name in ("wall", "slip", "clamp", "warm", "given_gas", "given_solid")
        }
        self.timed = any(timed(condition) for group in self._groups.values() for condition, _ in group)
        self._materials = [self._solid_of(p) for p in particles]
        #: displacement of particles on walls that move, by which the grid goes along
        self.moving = np.unique(
            np.concatenate(
                [np.empty(0, np.int64)]
                + [chosen for name in ("wall", "slip", "given_gas") for c, chosen in self._groups[name] if moves(c)]
            )
        )

    @staticmethod
    def _grouped(particles: Sequence[Particle], name: str) -> list[tuple[Any, Array]]:
        """Conditions and the particles they hold."""
        found: dict[int, tuple[Any, list[int]]] = {}
        for p, particle in enumerate(particles):
            condition = getattr(particle, name)
            if condition is not None:
                found.setdefault(id(condition), (condition, []))[1].append(p)
        return [(condition, np.array(chosen)) for condition, chosen in found.values()]

    def _solid_of(self, particle: Particle) -> Any:
        blocks = [self._problem.blocks[k] for k, _ in particle.members]
        return next((b.material for b in blocks if b.kind == "solid"), None)

    def at(self, t: float) -> Data:
        """Data at time t [s]; the same arrays each time. InputError for what a function of the case's returns."""
        if t == self._at or (self._at > -np.inf and not self.timed):
            return self._data
        self._at = t
        data = self._data
        for condition, chosen in self._groups["wall"] + self._groups["slip"]:
            _, data.wall[chosen], data.wall_rate[chosen] = self._motion(condition, self._x[chosen], t)
        for condition, chosen in self._groups["clamp"]:
            place, data.clamp_velocity[chosen], data.clamp_rate[chosen] = self._motion(condition, self._x[chosen], t)
            data.clamp[chosen] = place - self._x[chosen]
        for condition, chosen in self._groups["warm"]:
            data.T[chosen] = value(condition.T, self._x[chosen], t)
        for condition, chosen in self._groups["given_gas"]:
            self._give_gas(condition, chosen, t)
            if moves(condition):
                _, data.wall[chosen], data.wall_rate[chosen] = self._motion(condition, self._x[chosen], t)
        for condition, chosen in self._groups["given_solid"]:
            self._give_solid(condition, chosen, t)
        return data

    def displacement(self, t: float) -> Array:
        """(moving particles, d) displacement of those on walls that move at time t [s]."""
        found = np.zeros_like(self._x)
        for name in ("wall", "slip", "given_gas"):
            for condition, chosen in self._groups[name]:
                if moves(condition):
                    found[chosen] = self._motion(condition, self._x[chosen], t)[0] - self._x[chosen]
        return found[self.moving]

    def _motion(self, condition: Any, X: Array, t: float) -> tuple[Array, Array, Array]:
        """(place, velocity, acceleration), (n, d) each; by central differences where they are not given."""
        if not moves(condition):
            return X, np.zeros_like(X), np.zeros_like(X)
        s = self._instant()
        place = vector(condition.x, X, t)
        if condition.velocity is not None:
            velocity = vector(condition.velocity, X, t)
            rate = (vector(condition.velocity, X, t + s) - vector(condition.velocity, X, t - s)) / (2 * s)
            return place, velocity, rate
        after, before = vector(condition.x, X, t + s), vector(condition.x, X, t - s)
        return place, (after - before) / (2 * s), (after - 2 * place + before) / (s * s)

    def _give_gas(self, condition: Any, chosen: Array, t: float) -> None:
        rho, *u, T = (np.asarray(v) * np.ones(chosen.size) for v in condition.values(*self._x[chosen].T, t))
        energy = rho * (self._law.internal_energy(rho, T) + 0.5 * sum(c * c for c in u))
        self._data.gas[chosen] = np.stack([rho, *(rho * c for c in u), energy], axis=-1)

    def _give_solid(self, condition: Any, chosen: Array, t: float) -> None:
        d, X = self._d, self._x[chosen]
        values = [np.asarray(v) * np.ones(chosen.size) for v in condition.values(*X.T, t)]
        v, T, x = values[:d], values[d], values[d + 1 :]
        alpha = np.array([self._materials[p].alpha for p in chosen])
        energy = alpha * T + 0.5 * sum(c * c for c in v)
        self._data.solid[chosen] = np.stack([*(a - b for a, b in zip(x, X.T, strict=True)), *v, energy], axis=-1)


def moves(condition: Any) -> bool:
    """Whether what a condition holds moves as it says."""
    return getattr(condition, "x", None) is not None


def timed(condition: Any) -> bool:
    """Whether the data of a condition depend on time."""
    return any(callable(getattr(condition, name, None)) for name in ("x", "velocity", "T", "heat_flux", "values", "pressure"))


def value(of: Any, X: Array, t: float) -> Array:
    """(n,) of a number or a function of (*X, t)."""
    found = of(*X.T, t) if callable(of) else of
    return np.asarray(found) * np.ones(len(X))


def vector(of: Any, X: Array, t: float) -> Array:
    """(n, d) of a function of (*X, t)."""
    return np.stack([np.asarray(c) * np.ones(len(X)) for c in of(*X.T, t)], axis=-1)
