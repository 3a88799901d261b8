"""A manufactured solution in one, two or three dimensions: gas under a solid, on blocks that move.

The last axis goes across the two, 0 < eta < 1 in the gas and 1 < eta < 2 in the solid; the other
axes, p and q, go along them. All fields are smooth and not linear, viscosity and heat conduction
are at work, and the heat of the solid is coupled. With r = 1 in three dimensions and r = 0 else

    displacement of the solid  D = (.06 sin(2 pi p + t) cos(eta + 2t) (1 + .2 r sin 2 pi q),
                                    .05 sin(2 pi q - t) cos(2 pi p + 2t) sin(eta + t),
                                    .08 cos(2 pi p - t) sin(1.5 eta + t) (1 + .2 r sin 2 pi q))
    grid of the gas            x = X + eta D(p, q, 1, t),  with the velocity w = eta D_t(p, q, 1, t)
    velocity of the gas        u = w + eta (1 - eta) (.6 sin(2 pi p - t),
                                                      .4 sin(2 pi q + t),
                                                      .5 cos(2 pi p + 2t) (1 + .2 r sin 2 pi q))
    temperature of both        T = 1 + .15 sin(2 pi p + t) cos(2 eta - t) (1 + .2 r sin 2 pi q)
    density of the gas         rho = 1 + .2 cos(2 pi p - t) sin(2 eta + t) (1 + .2 r sin 2 pi q)

Two dimensions are the plane q = 0 of it, one dimension is the line p = 1/8, q = 0, each without the
components of vectors that point out of it.

Every field is a sum of waves, so that its derivatives are at hand. The forcing needs derivatives of
the fluxes, too: they are taken by a step into the complex plane, Im f(z + i s)/s, which is exact to
round-off for s = 1e-30.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray
Point = Sequence[Array]

#: axes of the three-dimensional solution that a problem in d dimensions has
AXES = {1: (2,), 2: (0, 2), 3: (0, 1, 2)}
#: (p, q) where a problem does not have these axes
ELSEWHERE = (0.125, 0.0)
#: a step into the complex plane
TINY = 1e-30

# phases: the factors of (p, q, eta, t) in them, and a constant
P, Q = np.array([2.0 * np.pi, 0, 0, 0, 0]), np.array([0, 2.0 * np.pi, 0, 0, 0])
ETA, TIME = np.array([0, 0, 1.0, 0, 0]), np.array([0, 0, 0, 1.0, 0])
#: sin(a) = cos(a - QUARTER)
QUARTER = np.array([0, 0, 0, 0, 0.5 * np.pi])


class Jet(NamedTuple):
    """Fields, with a leading axis for their number, and their rates; gradients, and rates of these,
    with a second axis for the d coordinates.
    """

    value: Array
    rate: Array
    gradient: Array
    gradient_rate: Array


class Place:
    """Points X, d arrays of one shape, and a time t; with a step TINY i in one of them (t: d)."""

    def __init__(
        self, X: Point, t: float, step: int | None = None, seen: dict[Any, Any] | None = None
    ) -> None:
        """seen: what other places with the same X and t have found out about them."""
        self.X, self.t, self.step = tuple(X), t, step
        self.seen = {} if seen is None else seen

    @property
    def d(self) -> int:
        """How many dimensions there are."""
        return len(self.X)

    def stepped(self, step: int) -> Place:
        """The place with a step."""
        return Place(self.X, self.t, step, self.seen)

    @property
    def eta(self) -> Array:
        """The coordinate across the blocks."""
        return self.X[-1] + 1j * TINY if self.step == self.d - 1 else self.X[-1]

    @property
    def interface(self) -> Place:
        """The place with eta = 1."""
        step = None if self.step == self.d - 1 else self.step
        X = (*self.X[:-1], np.ones_like(self.X[-1]))
        return Place(X, self.t, step, self.seen.setdefault("interface", {}))


class Waves:
    """Fields offset + sum of height cos(k_p p + k_q q + k_eta eta + omega t + phi)."""

    def __init__(self, offsets: Array, heights: Array, phases: Array) -> None:
        """Of n fields, m waves: offsets (n,), heights (n, m), phases (m, 5): the k, omega, phi."""
        self.offsets, self.heights, self.phases = offsets, heights, phases

    def at(self, place: Place) -> Jet:
        """The fields there; imaginary parts are those of so small a step, derivatives."""
        n, d, shape = len(self.heights), place.d, np.shape(place.X[-1])
        if self not in place.seen:
            place.seen[self] = self._cos_and_sin(place)
        cosine, sine = place.seen[self]
        k, omega = self.phases[:, AXES[d]].T, self.phases[:, 3]
        still, moving = self.heights, self.heights * omega
        of_cosine = np.concatenate([still, -(moving[:, None] * k).reshape(n * d, -1)])
        of_sine = np.concatenate([-moving, -(still[:, None] * k).reshape(n * d, -1)])
        even, odd = sums(of_cosine, cosine), sums(of_sine, sine)
        if place.step is not None:
            turn = TINY * [*k, omega][place.step]
            even = even - 1j * sums(of_cosine * turn, sine)
            odd = odd + 1j * sums(of_sine * turn, cosine)
        even[:n] += self.offsets[:, None]
        each, by_axis = (n, *shape), (n, d, *shape)
        return Jet(
            even[:n].reshape(each),
            odd[:n].reshape(each),
            odd[n:].reshape(by_axis),
            even[n:].reshape(by_axis),
        )

    def _cos_and_sin(self, place: Place) -> tuple[Array, Array]:
        """(m, points) of all phases at the real place."""
        along = (*place.X[:-1], *ELSEWHERE[place.d - 1 :])
        where = np.broadcast_arrays(along[0], along[1], place.X[-1], place.t, 1.0)
        angle = sums(self.phases, np.stack([values.ravel() for values in where]))
        return np.cos(angle), np.sin(angle)


def sums(weights: Array, values: Array) -> Array:
    """weights (n, m) times values (m, points); no library with threads of its own."""
    return np.einsum("nm,mp->np", weights, values)


def together(fields: Sequence[Waves]) -> Waves:
    """All the fields in one."""
    counts = np.cumsum([0, *(len(each.phases) for each in fields)])
    heights = np.zeros((sum(len(each.heights) for each in fields), counts[-1]))
    row = 0
    for each, a, b in zip(fields, counts[:-1], counts[1:]):
        heights[row : row + len(each.heights), a:b] = each.heights
        row += len(each.heights)
    offsets = np.concatenate([each.offsets for each in fields])
    return Waves(offsets, heights, np.concatenate([each.phases for each in fields]))


def product(height: float, *phases: Array, offset: float = 0.0) -> Waves:
    """offset + height cos(phase) cos(phase) …, by cos a cos b = cos(a + b)/2 + cos(a - b)/2."""
    angles = [phases[0]]
    for phase in phases[1:]:
        angles = [old + sign * phase for old in angles for sign in (1.0, -1.0)]
    heights = np.full((1, len(angles)), height / len(angles))
    return Waves(np.array([offset]), heights, np.array(angles))


def determinant(F: Array) -> Array:
    """Of F (d, d, …)."""
    return np.einsum("k...,k...->...", F[0], cofactor(F)[0])


def cofactor(F: Array) -> Array:
    """det(F) F^-T, of F (d, d, …)."""
    if len(F) == 1:
        return np.ones_like(F)
    if len(F) == 2:
        return np.array([[F[1, 1], -F[1, 0]], [-F[0, 1], F[0, 0]]])
    after, before = [1, 2, 0], [2, 0, 1]
    return F[after][:, after] * F[before][:, before] - F[after][:, before] * F[before][:, after]


def unit(F: Array) -> Array:
    """The unit matrix, as F (d, d, …)."""
    return np.broadcast_to(np.eye(len(F)).reshape(F.shape[:2] + (1,) * (F.ndim - 2)), F.shape)


def stress(law: str, mu: float, lam: float, F: Array) -> Array:
    """First Piola-Kirchhoff stress P (d, d, …) for F (d, d, …), Lamé's constants mu and lam.

    log: mu F + ((2 mu + lam) ln J - mu J) cof F; neo-hookean: mu F + (lam ln J - mu)/J cof F; svk:
    F S, S = lam tr(E) + 2 mu E, E = (F^T F - 1)/2; linear: lam tr(e) + 2 mu e, e = (F + F^T)/2 - 1.
    """
    one, J = unit(F), determinant(F)
    if law == "log":
        return mu * F + ((2.0 * mu + lam) * np.log(J) - mu * J) * cofactor(F)
    if law == "neo-hookean":
        return mu * F + (lam * np.log(J) - mu) / J * cofactor(F)
    if law == "svk":
        E = 0.5 * (np.einsum("ki...,kj...->ij...", F, F) - one)
        S = lam * np.einsum("kk...->...", E) * one + 2.0 * mu * E
        return np.einsum("ik...,kj...->ij...", F, S)
    if law == "linear":
        e = 0.5 * (F + np.swapaxes(F, 0, 1)) - one
        return lam * np.einsum("kk...->...", e) * one + 2.0 * mu * e
    raise ValueError(f"no solid law '{law}'")


class State(NamedTuple):
    """Conserved quantities U (n, …) per reference volume, their fluxes (d, n, …) along the axes,
    and what else changes them (n, …).
    """

    U: Array
    flux: Array
    source: Array


@dataclass(frozen=True)
class Solution:
    """The exact solution in d dimensions.

    Gas: viscosity mu, conductivity kappa, ratio of specific heats gamma, gas constant R. Solid:
    name of its law, Lamé's constants mu_e and lambda_e, conductivity kappa_e, density m0, specific
    heat alpha. All without units.
    """

    d: int
    mu: float
    kappa: float
    kappa_e: float
    law: str
    gamma: float = 1.4
    R: float = 1.0
    mu_e: float = 1.0
    lambda_e: float = 2.0
    m0: float = 2.0
    alpha: float = 1.5

    def rippled(self, height: float, *phases: Array, offset: float = 0.0) -> Waves:
        """offset + height cos(phase) cos(phase) … (1 + .2 r sin 2 pi q)."""
        flat = product(height, *phases, offset=offset)
        if self.d < 3:
            return flat
        ripple = product(0.2 * height, *phases, Q - QUARTER)
        both = np.concatenate([flat.heights, ripple.heights], axis=1)
        return Waves(flat.offsets, both, np.concatenate([flat.phases, ripple.phases]))

    @cached_property
    def displacement(self) -> Waves:
        """D."""
        of_all = (
            self.rippled(0.06, P + TIME - QUARTER, ETA + 2 * TIME),
            product(0.05, Q - TIME - QUARTER, P + 2 * TIME, ETA + TIME - QUARTER),
            self.rippled(0.08, P - TIME, 1.5 * ETA + TIME - QUARTER),
        )
        return together([of_all[axis] for axis in AXES[self.d]])

    @cached_property
    def temperature(self) -> Waves:
        """T."""
        return self.rippled(0.15, P + TIME - QUARTER, 2 * ETA - TIME, offset=1.0)

    @cached_property
    def of_gas(self) -> Waves:
        """(rho, (u - w) / (eta (1 - eta)), T)."""
        density = self.rippled(0.2, P - TIME, 2 * ETA + TIME - QUARTER, offset=1.0)
        of_all = (
            product(0.6, P - TIME - QUARTER),
            product(0.4, Q + TIME - QUARTER),
            self.rippled(0.5, P + 2 * TIME),
        )
        return together([density, *(of_all[axis] for axis in AXES[self.d]), self.temperature])

    @property
    def cv(self) -> float:
        """Specific heat of the gas."""
        return self.R / (self.gamma - 1.0)

    # -- the gas

    def grid(self, place: Place) -> tuple[Array, Array, Array]:
        """(x_X, w, w_X) of the gas's grid: derivatives of places, velocity, derivatives of that."""
        eta, end = place.eta, self.displacement.at(place.interface)
        x_X, w_X = eta * end.gradient, eta * end.gradient_rate
        x_X[:, -1], w_X[:, -1] = end.value, end.rate
        return x_X + unit(x_X), eta * end.rate, w_X

    def gas_velocity(self, place: Place, w: Array, w_X: Array, drift: Jet) -> tuple[Array, Array]:
        """(u, u_X), where w is the velocity of the grid and u = w + eta (1 - eta) drift."""
        eta = place.eta
        bump, slope = eta * (1.0 - eta), 1.0 - 2.0 * eta
        u_X = w_X + bump * drift.gradient
        u_X[:, -1] = u_X[:, -1] + slope * drift.value
        return w + bump * drift.value, u_X

    def gas(self, place: Place) -> State:
        """J (1, rho, rho u, e) and, along each axis with its metric vector a = det(x_X) grad xi,

            a . (-w, rho (u - w), rho u (u - w) + p - tau, e (u - w) + p u - tau u - kappa grad T)

        with tau = mu (grad u + (grad u)^T - 2/3 div u).
        """
        x_X, w, w_X = self.grid(place)
        fields = self.of_gas.at(place)
        u, u_X = self.gas_velocity(place, w, w_X, Jet(*(part[1:-1] for part in fields)))
        rho, T, T_X = fields.value[0], fields.value[-1], fields.gradient[-1]
        a, J = cofactor(x_X), determinant(x_X)
        grad_u = np.einsum("ik...,jk...->ij...", u_X, a) / J
        grad_T = np.einsum("k...,jk...->j...", T_X, a) / J
        one, div = unit(grad_u), np.einsum("kk...->...", grad_u)
        tau = self.mu * (grad_u + np.swapaxes(grad_u, 0, 1) - 2.0 / 3.0 * div * one)
        p = rho * self.R * T
        e = rho * (self.cv * T + 0.5 * np.einsum("k...,k...->...", u, u))
        U = np.stack([np.ones_like(rho), rho, *(rho * u), e])
        force = p * one - tau
        others = np.concatenate(
            [
                -w[None],  # of J, a volume that the grid sweeps over
                np.zeros_like(w)[None],
                force,
                (np.einsum("ij...,j...->i...", force, u) - self.kappa * grad_T)[None],
            ]
        )
        carried = np.concatenate([np.zeros_like(rho)[None], U[1:]])
        flux = carried[:, None] * (u - w)[None] + others
        along = np.einsum("nj...,jk...->kn...", flux, a)
        return State(J * U, along, np.zeros_like(U))

    def exact_gas(self, *where: Any) -> list[Array]:
        """(rho, u_1 … u_d, T) at (*X, t)."""
        place = place_of(where)
        fields, eta = self.of_gas.at(place).value, place.eta
        w = eta * self.displacement.at(place.interface).rate
        return [fields[0], *(w + eta * (1.0 - eta) * fields[1:-1]), fields[-1]]

    def force_gas(self, *where: Any) -> list[Array]:
        """What drives (rho, rho u_1 … rho u_d, e) per volume at a point of the grid at (*X, t)."""
        place = place_of(where)
        return list(lack(self.gas, place)[1:] / determinant(self.grid(place)[0]))

    # -- the solid

    def solid(self, place: Place) -> State:
        """m0 (v, alpha T), fluxes -(P, kappa_e J F^-1 F^-T grad T), and the work P : v_X."""
        m, T = self.displacement.at(place), self.temperature.at(place)
        F = m.gradient + unit(m.gradient)
        P, c = stress(self.law, self.mu_e, self.lambda_e, F), cofactor(F)
        scaled = self.kappa_e / determinant(F) * np.einsum("ij...,j...->i...", c, T.gradient[0])
        heat = np.einsum("ik...,i...->k...", c, scaled)
        work = np.einsum("ik...,ik...->...", P, m.gradient_rate)
        U = self.m0 * np.stack([*m.rate, self.alpha * T.value[0]])
        flux = -np.concatenate([P, heat[None]])
        source = np.concatenate([np.zeros_like(m.rate), work[None]])
        return State(U, np.swapaxes(flux, 0, 1), source)

    def exact_solid(self, *where: Any) -> list[Array]:
        """(v_1 … v_d, T, x_1 … x_d) at (*X, t)."""
        place = place_of(where)
        m = self.displacement.at(place)
        return [*m.rate, self.temperature.at(place).value[0], *(np.stack(place.X) + m.value)]

    def force_solid(self, *where: Any) -> list[Array]:
        """What drives (v_1 … v_d, T, x_1 … x_d) at (*X, t)."""
        rates = lack(self.solid, place_of(where)) / self.m0
        return [*rates[:-1], rates[-1] / self.alpha, *np.zeros_like(rates[:-1])]

    # -- both

    def supplied(self, *where: Any) -> list[Array]:
        """(g_1 … g_d, g_q) at (*X, t) of the interface: traction and heat per reference area that
        the solid gets beside what the gas gives it.
        """
        place = place_of(where).interface
        below, above = self.gas(place).flux[-1], self.solid(place).flux[-1]
        u = self.displacement.at(place).rate
        traction = below[2:-1]  # no mass goes through
        heat = below[-1] - np.einsum("k...,k...->...", traction, u)
        return [*(above[:-1] - traction), above[-1] - heat]


def place_of(where: Sequence[Any]) -> Place:
    """Of (*X, t)."""
    return Place(where[:-1], where[-1])


def lack(state: Callable[[Place], State], place: Place) -> Array:
    """U_t + sum over the axes of flux_k - source."""
    d = place.d
    total = state(place.stepped(d)).U.imag / TINY - state(place).source
    for k in range(d):
        total = total + state(place.stepped(k)).flux[k].imag / TINY
    return total
