"""A manufactured solution in one, two or three dimensions: gas under a solid, on blocks that move.

The last axis goes across the two, 0 < eta < 1 in the gas and 1 < eta < 2 in the solid; the other
axes, p and q, go along them. With r = 1 in three dimensions and r = 0 else

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
round-off for s = 1e-30. Places are (*X, t), d arrays of one shape and a time.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.cases.common import Opt, gas_of
from fsipetsc.checks import Array
from fsipetsc.equations.elementary import log
from fsipetsc.materials.solid import ElasticSolid

Where = Sequence[Any]

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


class Waves:
    """Fields offset + sum of height cos(phase) cos(phase) ...; each is (offset, products), and each
    product (height, phase, phase, ...). Products become sums by cos a cos b = (cos(a + b) +
    cos(a - b)) / 2.
    """

    def __init__(self, *fields: tuple[float, Sequence[Any]]) -> None:
        heights, phases = [], []
        for n, (_, products) in enumerate(fields):
            for height, first, *others in products:
                sums = [first]
                for other in others:
                    sums = [old + sign * other for old in sums for sign in (1.0, -1.0)]
                phases += sums
                heights += [np.eye(len(fields))[n] * height / len(sums)] * len(sums)
        self.offsets = np.array([offset for offset, _ in fields])
        self.heights, self.phases = np.array(heights).T, np.array(phases)

    def at(self, where: Where) -> Jet:
        """The fields there; imaginary parts are those of a step into the complex plane."""
        *along, eta, t = where
        d, shape = len(where) - 1, np.shape(eta)
        all_four = np.broadcast_arrays(*along, *ELSEWHERE[d - 1 :], eta, t)
        places = np.stack([values.ravel() for values in all_four])
        angle = _sums(self.phases[:, :4], places) + self.phases[:, 4:]
        cosine, sine = np.cos(angle.real), np.sin(angle.real)
        if np.iscomplexobj(angle):
            step = 1j * angle.imag
            cosine, sine = cosine - step * sine, sine + step * cosine
        n, m = self.heights.shape
        k, moving = self.phases[:, AXES[d]].T, self.heights * self.phases[:, 3]
        by_axis = (self.heights[:, None] * k).reshape(n * d, m)
        moving_by_axis = (moving[:, None] * k).reshape(n * d, m)
        return Jet(
            (_sums(self.heights, cosine) + self.offsets[:, None]).reshape(n, *shape),
            -_sums(moving, sine).reshape(n, *shape),
            -_sums(by_axis, sine).reshape(n, d, *shape),
            -_sums(moving_by_axis, cosine).reshape(n, d, *shape),
        )


def _sums(weights: Array, values: Array) -> Array:
    """weights (n, m) times values (m, points); no library with threads of its own."""
    return np.einsum("nm,mp->np", weights, values)


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


def _log(J: Array) -> Array:
    """ln J; the imaginary part is that of a small step."""
    return log(J.real) + 1j * (J.imag / J.real) if np.iscomplexobj(J) else log(J)


def unit(F: Array) -> Array:
    """The unit matrix, as F (d, d, …)."""
    return np.broadcast_to(np.eye(len(F)).reshape(F.shape[:2] + (1,) * (F.ndim - 2)), F.shape)


def stress(solid: ElasticSolid, F: Array) -> Array:
    """First Piola-Kirchhoff stress P (d, d, …) for F (d, d, …), by the name of the law.

    log: mu F + ((2 mu + lam) ln J - mu J) cof F; neo-hookean: mu F + (lam ln J - mu)/J cof F; svk:
    F S, S = lam tr(E) + 2 mu E, E = (F^T F - 1)/2; linear: lam tr(e) + 2 mu e, e = (F + F^T)/2 - 1.
    """
    law, mu, lam, one, J = solid.law, solid.mu_e, solid.lambda_e, unit(F), determinant(F)
    if law == "log":
        return mu * F + ((2.0 * mu + lam) * _log(J) - mu * J) * cofactor(F)
    if law == "neo-hookean":
        return mu * F + (lam * _log(J) - mu) / J * cofactor(F)
    if law == "svk":
        E = 0.5 * (np.einsum("ki...,kj...->ij...", F, F) - one)
        S = lam * np.einsum("kk...->...", E) * one + 2.0 * mu * E
        return np.einsum("ik...,kj...->ij...", F, S)
    e = 0.5 * (F + np.swapaxes(F, 0, 1)) - one
    return lam * np.einsum("kk...->...", e) * one + 2.0 * mu * e


class State(NamedTuple):
    """Conserved quantities U (n, …) per reference volume, their fluxes (d, n, …) along the axes,
    and what else changes them (n, …).
    """

    U: Array
    flux: Array
    source: Array


class Solution:
    """The exact solution in d dimensions, of a gas and a solid without units: viscosity, both
    conductivities and the law of the solid are options.
    """

    def __init__(self, d: int, opt: Opt) -> None:
        self.fluid = gas_of(opt)
        self.body = ElasticSolid(1.0, 2.0, opt["solid_kappa"], 2.0, 1.5, law=opt["solid_law"])

        def rippled(height: float, *phases: Array) -> list[Any]:
            """height cos(phase) cos(phase) ... (1 + .2 r sin 2 pi q)."""
            ripple = [(0.2 * height, *phases, Q - QUARTER)] if d == 3 else []
            return [(height, *phases), *ripple]

        def vector(*parts: list[Any]) -> list[Any]:
            return [(0.0, parts[axis]) for axis in AXES[d]]

        D = vector(
            rippled(0.06, P + TIME - QUARTER, ETA + 2 * TIME),
            [(0.05, Q - TIME - QUARTER, P + 2 * TIME, ETA + TIME - QUARTER)],
            rippled(0.08, P - TIME, 1.5 * ETA + TIME - QUARTER),
        )
        drift = vector(
            [(0.6, P - TIME - QUARTER)],
            [(0.4, Q + TIME - QUARTER)],
            rippled(0.5, P + 2 * TIME),
        )
        T = 1.0, rippled(0.15, P + TIME - QUARTER, 2 * ETA - TIME)
        rho = 1.0, rippled(0.2, P - TIME, 2 * ETA + TIME - QUARTER)
        self.displacement, self.temperature = Waves(*D), Waves(T)
        #: (rho, (u - w) / (eta (1 - eta)), T)
        self.of_gas = Waves(rho, *drift, T)

    # -- the gas

    def grid(self, where: Where) -> tuple[Array, Array, Array]:
        """(x_X, w, w_X) of the gas's grid: derivatives of places, velocity, derivatives of that."""
        eta, end = where[-2], self.displacement.at(interface(where))
        x_X, w_X = eta * end.gradient, eta * end.gradient_rate
        x_X[:, -1], w_X[:, -1] = end.value, end.rate
        return x_X + unit(x_X), eta * end.rate, w_X

    def bubble(self, where: Where) -> tuple[Array, Array]:
        """What the drift of the gas is multiplied with, 0 at the interface, and its gradient."""
        *along, eta, _ = where
        return eta * (1.0 - eta), np.stack([*(0.0 * eta for _ in along), 1.0 - 2.0 * eta])

    def gas(self, where: Where) -> State:
        """J (1, rho, rho u, e) and, along each axis with its metric vector a = det(x_X) grad xi,

            a . (-w, rho (u - w), rho u (u - w) + p - tau, e (u - w) + p u - tau u - kappa grad T)

        with tau = mu (grad u + (grad u)^T - 2/3 div u).
        """
        x_X, w, w_X = self.grid(where)
        fields, (bump, slope) = self.of_gas.at(where), self.bubble(where)
        drift = fields.value[1:-1]
        u, u_X = w + bump * drift, w_X + bump * fields.gradient[1:-1] + drift[:, None] * slope
        rho, T, T_X = fields.value[0], fields.value[-1], fields.gradient[-1]
        a, J = cofactor(x_X), determinant(x_X)
        grad_u = np.einsum("ik...,jk...->ij...", u_X, a) / J
        grad_T = np.einsum("k...,jk...->j...", T_X, a) / J
        one, div = unit(grad_u), np.einsum("kk...->...", grad_u)
        tau = self.fluid.mu * (grad_u + np.swapaxes(grad_u, 0, 1) - 2.0 / 3.0 * div * one)
        e = rho * (self.fluid.cv * T + 0.5 * np.einsum("k...,k...->...", u, u))
        force = rho * self.fluid.R * T * one - tau
        heat = np.einsum("ij...,j...->i...", force, u) - self.fluid.kappa * grad_T
        U = np.stack([np.ones_like(rho), rho, *(rho * u), e])
        # -w is the flux of J, a volume that the grid sweeps over
        others = np.concatenate([-w[None], np.zeros_like(w)[None], force, heat[None]])
        carried = np.concatenate([np.zeros_like(rho)[None], U[1:]])
        flux = carried[:, None] * (u - w)[None] + others
        return State(J * U, np.einsum("nj...,jk...->kn...", flux, a), np.zeros_like(U))

    def exact_gas(self, *where: Any) -> list[Array]:
        """(rho, u_1 … u_d, T) at (*X, t)."""
        fields, w, bump = self.of_gas.at(where).value, self.grid(where)[1], self.bubble(where)[0]
        return [fields[0], *(w + bump * fields[1:-1]), fields[-1]]

    def force_gas(self, *where: Any) -> list[Array]:
        """What drives (rho, rho u_1 … rho u_d, e) per volume at a point of the grid at (*X, t)."""
        return list(lack(self.gas, where)[1:] / determinant(self.grid(where)[0]))

    # -- the solid

    def solid(self, where: Where) -> State:
        """m0 (v, alpha T), fluxes -(P, kappa_e J F^-1 F^-T grad T), and the work P : v_X."""
        m, T, body = self.displacement.at(where), self.temperature.at(where), self.body
        F = m.gradient + unit(m.gradient)
        P, c = stress(body, F), cofactor(F)
        scaled = body.kappa_e / determinant(F) * np.einsum("ij...,j...->i...", c, T.gradient[0])
        heat = np.einsum("ik...,i...->k...", c, scaled)
        work = np.einsum("ik...,ik...->...", P, m.gradient_rate)
        U = body.m0 * np.stack([*m.rate, body.alpha * T.value[0]])
        flux = -np.concatenate([P, heat[None]])
        source = np.concatenate([np.zeros_like(m.rate), work[None]])
        return State(U, np.swapaxes(flux, 0, 1), source)

    def exact_solid(self, *where: Any) -> list[Array]:
        """(v_1 … v_d, T, x_1 … x_d) at (*X, t)."""
        m = self.displacement.at(where)
        return [*m.rate, self.temperature.at(where).value[0], *(np.stack(where[:-1]) + m.value)]

    def force_solid(self, *where: Any) -> list[Array]:
        """What drives (v_1 … v_d, T, x_1 … x_d) at (*X, t)."""
        rates = lack(self.solid, where) / self.body.m0
        return [*rates[:-1], rates[-1] / self.body.alpha, *np.zeros_like(rates[:-1])]

    # -- both

    def supplied(self, *where: Any) -> list[Array]:
        """(g_1 … g_d, g_q) at (*X, t) of the interface: traction and heat per reference area that
        the solid gets beside what the gas gives it.
        """
        where = interface(where)
        return self.jump(where, unit(self.displacement.at(where).gradient)[-1])

    def jump(self, where: Where, normal: Array) -> list[Array]:
        """The same with the normal (d, …) from gas to solid."""
        fluxes = self.gas(where).flux, self.solid(where).flux
        below, above = (np.einsum("k...,kn...->n...", normal, flux) for flux in fluxes)
        u = self.displacement.at(where).rate
        traction = below[2:-1]  # no mass goes through
        heat = below[-1] - np.einsum("k...,k...->...", traction, u)
        return [*(above[:-1] - traction), above[-1] - heat]


def interface(where: Where) -> Where:
    """The place with eta = 1."""
    *along, eta, t = where
    return *along, np.ones(np.shape(eta)), t


def lack(state: Callable[[Where], State], where: Where) -> Array:
    """U_t + sum over the axes of flux_k - source."""

    def rate(k: int) -> State:
        stepped = [value + 1j * TINY if i == k else value for i, value in enumerate(where)]
        return State(*(part.imag / TINY for part in state(stepped)))

    d = len(where) - 1
    return rate(d).U + sum(rate(k).flux[k] for k in range(d)) - state(where).source
