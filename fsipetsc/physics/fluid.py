"""Compressible Navier–Stokes equations in the rigid frame that moves with the interface, (3.2) and (4.20).

    rho_t     + (rho (u-s))_X                                        = 0
    (rho u)_t + (rho u (u-s) + p - mu' u_X)_X                        = 0,      mu' = 4/3 mu
    e_t       + (e (u-s) + u (p - mu' u_X) - kappa T_X)_X            = 0

with p = (gamma-1)(e - rho u^2/2) = rho R T (R stands for R/M) and s(t) the velocity of the fluid's own interface
point. The viscous and heat fluxes stand inside the outer derivative, so that D is applied twice to u and T.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import BLOCK, OPTIONS, U64, derivative, maximum, minimum, row
from fsipetsc.operators.reductions import largest, smallest
from fsipetsc.physics.emission import emit


@dataclass(frozen=True)
class Fluid:
    """A perfect gas.

    mu: shear viscosity [Pa s]; kappa: heat conductivity [W/(m K)]; gamma: ratio of the specific heats;
    R: gas constant over molar mass [J/(kg K)].
    """

    mu: float
    kappa: float
    gamma: float
    R: float

    @property
    def cv(self) -> float:
        """Specific heat at constant volume [J/(kg K)]."""
        return self.R / (self.gamma - 1)

    def sound_speed(self, T: float | np.ndarray) -> float | np.ndarray:
        """Speed of sound [m/s] at temperature T [K]."""
        return np.sqrt(self.gamma * self.R * T)

    def conserved(self, rho: np.ndarray, u: np.ndarray, T: np.ndarray) -> np.ndarray:
        """(rho, rho u, e) of shape (..., 3) from density, velocity and temperature."""
        return np.stack([rho, rho * u, rho * (self.cv * T + 0.5 * u * u)], axis=-1)

    def primitive(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """rho, u, T, p from the conserved variables q of shape (..., 3)."""
        rho = q[..., 0]
        u = q[..., 1] / rho
        T = (q[..., 2] / rho - 0.5 * u * u) / self.cv
        return rho, u, T, self.R * rho * T


@njit(**OPTIONS)
def fluid_rhs(layer, op, s, w, scratch, target):
    """Time derivative of (rho, rho u, e) at the owned active points, equation (4.20), to where ``target`` says.

    s: the memory, in which the owned points and halos of each unknown stand from w on, ``layer.stride`` apart, and the
    scratch rows from ``scratch`` on (see fsipetsc.physics.emission). Other points do not change.
    """
    lo, hi, reach = layer.lo, layer.hi, op.reach
    first, stride = layer.own_lo - layer.halo_lo, layer.stride
    velocity, mu, kappa, gas = layer.s, layer.mu, layer.kappa, (layer.gamma - 1.0) * layer.cv
    inv_cv, inv_h = 1.0 / layer.cv, 1.0 / layer.h
    u, T, ux, Tx = scratch + row(0), scratch + row(1), scratch + row(2), scratch + row(3)
    f1, f2, f3 = scratch + row(4), scratch + row(5), scratch + row(6)
    for i0 in range(max(layer.own_lo, lo), min(layer.own_hi, hi + 1), BLOCK):
        i1 = min(i0 + BLOCK, min(layer.own_hi, hi + 1))
        # velocity and temperature where the double derivative reaches
        p0, p1 = max(lo, i0 - 2 * reach), min(hi + 1, i1 + 2 * reach)
        d = U64(w + p0 - first)
        m, e, ru, rT = d + U64(stride), d + U64(2 * stride), U64(u), U64(T)
        for i in range(U64(p1 - p0)):
            r = 1.0 / s[d + i]
            v = s[m + i] * r
            s[ru + i] = v
            s[rT + i] = (s[e + i] * r - 0.5 * v * v) * inv_cv
        # their derivatives, and the fluxes, where one derivative reaches
        d0, d1 = max(lo, i0 - reach), min(hi + 1, i1 + reach)
        for q in range(2):  # a loop keeps the compiler from expanding the same code twice
            scale = mu * inv_h if q == 0 else kappa * inv_h
            derivative(op, s, scratch + row(q), p0, scratch + row(2 + q), d0, d0, d1, lo, hi, scale)
        shift, rux, rTx = U64(d0 - p0), U64(ux), U64(Tx)
        d, m, e, ru, rT = d + shift, m + shift, e + shift, ru + shift, rT + shift
        r1, r2, r3 = U64(f1), U64(f2), U64(f3)
        for i in range(U64(d1 - d0)):
            s[rux + i] = gas * s[d + i] * s[rT + i] - s[rux + i]  # pressure less viscous stress
            s[r1 + i] = s[d + i] * (s[ru + i] - velocity)
        for i in range(U64(d1 - d0)):
            s[r2 + i] = s[m + i] * (s[ru + i] - velocity) + s[rux + i]
            s[r3 + i] = s[e + i] * (s[ru + i] - velocity) + s[ru + i] * s[rux + i] - s[rTx + i]
        for unknown in range(3):
            derivative(op, s, scratch + row(4 + unknown), d0, u, i0, i0, i1, lo, hi, -inv_h)
            emit(s, target, unknown, u, i0 - layer.own_lo, i1 - i0)


@njit(**OPTIONS)
def fluid_limits(layer, s, w, scratch):
    """(largest |u-s| + c, smallest rho, smallest T) over the owned active points; not numbers where the state is none.

    The first two bound the time step; the state is unphysical where rho > 0 and T > 0 do not hold.
    """
    first, stride = layer.own_lo - layer.halo_lo, layer.stride
    a, b = max(layer.own_lo, layer.lo), min(layer.own_hi, layer.hi + 1)
    speed, c2, velocity = U64(scratch + row(0)), U64(scratch + row(1)), layer.s
    cc = layer.gamma * (layer.gamma - 1.0)
    fastest, lightest, coldest = 0.0, np.inf, np.inf
    for i0 in range(a, b, BLOCK):
        count, d = U64(min(i0 + BLOCK, b) - i0), U64(w + i0 - first)
        m, e = d + U64(stride), d + U64(2 * stride)
        for i in range(count):
            r = 1.0 / s[d + i]
            v = s[m + i] * r
            s[c2 + i] = cc * (s[e + i] * r - 0.5 * v * v)
            s[speed + i] = abs(v - velocity)
        for i in range(count):
            s[speed + i] += np.sqrt(s[c2 + i])
        fastest = maximum(fastest, largest(s, speed, count))
        lightest = minimum(lightest, smallest(s, d, count))
        coldest = minimum(coldest, smallest(s, c2, count))
    return fastest, lightest, coldest / (cc * layer.cv)
