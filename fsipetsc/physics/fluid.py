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

from fsipetsc.operators.kernels import BLOCK, OPTIONS, U1, U2, U3, U64, derivative, row
from fsipetsc.physics.emission import emit3


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

    s: the memory, in which the owned points and halos stand from w on, three doubles per point, and the scratch rows
    from ``scratch`` on (see fsipetsc.physics.emission). Other points do not change.
    """
    lo, hi, reach = layer.lo, layer.hi, op.reach
    first = layer.own_lo - layer.halo_lo
    a, b = max(layer.own_lo, lo), min(layer.own_hi, hi + 1)
    velocity, mu, inv_cv, gas = layer.s, layer.mu, 1.0 / layer.cv, (layer.gamma - 1.0) * layer.cv
    kappa, inv_h = layer.kappa, 1.0 / layer.h
    u, T, ux, Tx = scratch + row(0), scratch + row(1), scratch + row(2), scratch + row(3)
    f1, f2, f3 = scratch + row(4), scratch + row(5), scratch + row(6)
    for i0 in range(a, b, BLOCK):
        i1 = min(i0 + BLOCK, b)
        # primitive variables where the double derivative reaches
        p0, p1 = max(lo, i0 - 2 * reach), min(hi + 1, i1 + 2 * reach)
        q, ru, rT = U64(w + 3 * (p0 - first)), U64(u), U64(T)
        for i in range(U64(p1 - p0)):
            r = 1.0 / s[q + U3 * i]
            v = s[q + U3 * i + U1] * r
            s[ru + i] = v
            s[rT + i] = (s[q + U3 * i + U2] * r - 0.5 * v * v) * inv_cv
        # their derivatives, and the fluxes, where one derivative reaches
        d0, d1 = max(lo, i0 - reach), min(hi + 1, i1 + reach)
        derivative(op, s, u, p0, ux, d0, d0, d1, lo, hi, mu * inv_h)
        derivative(op, s, T, p0, Tx, d0, d0, d1, lo, hi, kappa * inv_h)
        q, ru, rT, rux, rTx = U64(w + 3 * (d0 - first)), U64(u + d0 - p0), U64(T + d0 - p0), U64(ux), U64(Tx)
        r1, r2, r3 = U64(f1), U64(f2), U64(f3)
        for i in range(U64(d1 - d0)):
            rho, v = s[q + U3 * i], s[ru + i]
            tau = gas * rho * s[rT + i] - s[rux + i]
            s[r1 + i] = rho * (v - velocity)
            s[r2 + i] = s[q + U3 * i + U1] * (v - velocity) + tau
            s[r3 + i] = s[q + U3 * i + U2] * (v - velocity) + v * tau - s[rTx + i]
        k1, k2, k3 = u, T, ux  # their values are not needed any more
        derivative(op, s, f1, d0, k1, i0, i0, i1, lo, hi, -inv_h)
        derivative(op, s, f2, d0, k2, i0, i0, i1, lo, hi, -inv_h)
        derivative(op, s, f3, d0, k3, i0, i0, i1, lo, hi, -inv_h)
        emit3(s, target, 3 * (i0 - layer.own_lo), k1, k2, k3, i1 - i0)


@njit(**OPTIONS)
def fluid_limits(layer, s, w, scratch):
    """(largest |u-s| + c, largest 1/rho, number of unphysical points) over the owned active points.

    The first two bound the time step; a point is unphysical where rho > 0 and T > 0 do not both hold.
    """
    first = layer.own_lo - layer.halo_lo
    a, b = max(layer.own_lo, layer.lo), min(layer.own_hi, layer.hi + 1)
    speed, volume, bad, velocity = U64(scratch + row(0)), U64(scratch + row(1)), 0, layer.s
    cc = layer.gamma * (layer.gamma - 1.0)
    fastest, lightest = 0.0, 0.0
    for i0 in range(a, b, BLOCK):
        m, q = U64(min(i0 + BLOCK, b) - i0), U64(w + 3 * (i0 - first))
        for i in range(m):
            r = 1.0 / s[q + U3 * i]
            v = s[q + U3 * i + U1] * r
            c2 = cc * (s[q + U3 * i + U2] * r - 0.5 * v * v)
            s[volume + i] = r
            s[speed + i] = abs(v - velocity) + np.sqrt(c2)
            bad += 0 if (r > 0.0 and c2 > 0.0) else 1
        fastest = max(fastest, largest(s, speed, m))
        lightest = max(lightest, largest(s, volume, m))
    return fastest, lightest, bad


@njit(cache=True, fastmath={"nnan", "nsz"}, nogil=True)
def largest(s, v, m):
    """Maximum of s[v:v+m], numbers above zero without NaNs, as a vectorised reduction."""
    result = 0.0
    for i in range(m):
        result = max(result, s[v + i])
    return result
