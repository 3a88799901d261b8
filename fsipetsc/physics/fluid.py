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

from fsipetsc.operators.kernels import BLOCK, OPTIONS, derivative


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
def fluid_rhs(layer, op, w, f, scratch):
    """Time derivative of (rho, rho u, e) at the owned points, f, from the owned points and halos, w.

    w and f are interlaced, three doubles per point; w begins halo_lo points before the first owned one.
    Points outside the active range do not change. Equation (4.20).
    """
    lo, hi, reach = layer.lo, layer.hi, op.reach
    first = layer.own_lo - layer.halo_lo
    a, b = max(layer.own_lo, lo), min(layer.own_hi, hi + 1)
    f[: 3 * max(0, min(a, layer.own_hi) - layer.own_lo)] = 0.0
    f[3 * max(0, max(b, layer.own_lo) - layer.own_lo) :] = 0.0
    s, mu, gm1, inv_cv = layer.s, layer.mu, layer.gamma - 1.0, 1.0 / layer.cv
    kappa, inv_h = layer.kappa, 1.0 / layer.h
    u, T, ux, Tx, f1, f2, f3 = scratch[0], scratch[1], scratch[2], scratch[3], scratch[4], scratch[5], scratch[6]
    for i0 in range(a, b, BLOCK):
        i1 = min(i0 + BLOCK, b)
        # primitive variables where the double derivative reaches
        p0, p1 = max(lo, i0 - 2 * reach), min(hi + 1, i1 + 2 * reach)
        q = w[3 * (p0 - first) : 3 * (p1 - first)]
        for i in range(p1 - p0):
            r = 1.0 / q[3 * i]
            v = q[3 * i + 1] * r
            u[i] = v
            T[i] = (q[3 * i + 2] * r - 0.5 * v * v) * inv_cv
        # their derivatives, and the fluxes, where one derivative reaches
        d0, d1 = max(lo, i0 - reach), min(hi + 1, i1 + reach)
        derivative(op, u, p0, ux, d0, d0, d1, lo, hi, mu * inv_h)
        derivative(op, T, p0, Tx, d0, d0, d1, lo, hi, kappa * inv_h)
        q = w[3 * (d0 - first) : 3 * (d1 - first)]
        ud, Td = u[d0 - p0 : d1 - p0], T[d0 - p0 : d1 - p0]
        cv_gm1 = gm1 * layer.cv
        for i in range(d1 - d0):
            rho, v = q[3 * i], ud[i]
            tau = cv_gm1 * rho * Td[i] - ux[i]
            f1[i] = rho * (v - s)
            f2[i] = q[3 * i + 1] * (v - s) + tau
            f3[i] = q[3 * i + 2] * (v - s) + v * tau - Tx[i]
        k1, k2, k3 = u, T, ux  # their values are not needed any more
        derivative(op, f1, d0, k1, i0, i0, i1, lo, hi, -inv_h)
        derivative(op, f2, d0, k2, i0, i0, i1, lo, hi, -inv_h)
        derivative(op, f3, d0, k3, i0, i0, i1, lo, hi, -inv_h)
        o = f[3 * (i0 - layer.own_lo) : 3 * (i1 - layer.own_lo)]
        for i in range(i1 - i0):
            o[3 * i] = k1[i]
            o[3 * i + 1] = k2[i]
            o[3 * i + 2] = k3[i]


@njit(**OPTIONS)
def fluid_limits(layer, w, scratch):
    """(largest |u-s| + c, largest 1/rho, number of unphysical points) over the owned active points.

    The first two bound the time step; a point is unphysical where rho > 0 and T > 0 do not both hold.
    """
    first = layer.own_lo - layer.halo_lo
    a, b = max(layer.own_lo, layer.lo), min(layer.own_hi, layer.hi + 1)
    speed, volume, bad = scratch[0], scratch[1], 0
    cc = layer.gamma * (layer.gamma - 1.0)
    fastest, lightest = 0.0, 0.0
    for i0 in range(a, b, BLOCK):
        m = min(i0 + BLOCK, b) - i0
        q = w[3 * (i0 - first) : 3 * (i0 + m - first)]
        for i in range(m):
            r = 1.0 / q[3 * i]
            v = q[3 * i + 1] * r
            c2 = cc * (q[3 * i + 2] * r - 0.5 * v * v)
            volume[i] = r
            speed[i] = abs(v - layer.s) + np.sqrt(c2)
            bad += 0 if (r > 0.0 and c2 > 0.0) else 1
        fastest = max(fastest, largest(speed[:m]))
        lightest = max(lightest, largest(volume[:m]))
    return fastest, lightest, bad


@njit(cache=True, fastmath={"nnan", "nsz"}, nogil=True)
def largest(v):
    """Maximum of a row of numbers without NaNs, as a vectorised reduction."""
    m = v[0]
    for i in range(v.size):
        m = max(m, v[i])
    return m
