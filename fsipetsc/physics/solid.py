"""Elastic (elastic-plastic) solid in Lagrangian coordinates, (3.1) and (4.19).

    u_t         = (sigma - p)_X / m0 + force
    sigma_t     = K / x_X u_X,                                   K = 2 mu_e + lambda_e
    alpha m0 T_t = (sigma - p) u_X + (kappa_e / x_X T_X)_X
    x_t         = u

with p(epsilon, rho) an equation of state in epsilon = alpha T and rho = m0 / x_X; p = 0 is the elastic solid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import BLOCK, OPTIONS, derivative


@dataclass(frozen=True)
class Solid:
    """Linear elastic material, with the pressure p = gruneisen * rho * epsilon where gruneisen > 0.

    K: 2 mu_e + lambda_e [Pa]; kappa_e: heat conductivity [W/(m K)]; m0: density in the reference configuration
    [kg/m3]; alpha: specific heat [J/(kg K)]; force: body force per mass [m/s2]; gruneisen: [-].
    """

    K: float
    kappa_e: float
    m0: float
    alpha: float
    force: float = 0.0
    gruneisen: float = 0.0

    def sound_speed(self, x_X: float = 1.0) -> float:
        """Speed of the elastic waves in Lagrangian coordinates [m/s] (p = 0)."""
        return (self.K / (self.m0 * x_X)) ** 0.5

    def pressure(self, T: np.ndarray, x_X: np.ndarray) -> np.ndarray:
        """p(epsilon, rho) [Pa] with epsilon = alpha T, rho = m0 / x_X."""
        return self.gruneisen * self.m0 * self.alpha * T / x_X


@njit(**OPTIONS)
def solid_rhs(layer, op, w, f, scratch):
    """Time derivative of (u, sigma, T, x) at the owned points, f, from the owned points and halos, w.

    w and f are interlaced, four doubles per point; w begins halo_lo points before the first owned one. Eq. (4.19).
    """
    lo, hi, reach = layer.lo, layer.hi, op.reach
    first = layer.own_lo - layer.halo_lo
    inv_h, K, kappa_e = 1.0 / layer.h, layer.K, layer.kappa_e
    inv_m0, inv_am0, force = 1.0 / layer.m0, 1.0 / (layer.alpha * layer.m0), layer.force
    pe = layer.gruneisen * layer.m0 * layer.alpha
    u, s, T, x = scratch[0], scratch[1], scratch[2], scratch[3]
    ux, xX, flux, k1, k3 = scratch[4], scratch[5], scratch[6], scratch[7], scratch[8]
    for i0 in range(layer.own_lo, layer.own_hi, BLOCK):
        i1 = min(i0 + BLOCK, layer.own_hi)
        p0, p1 = max(lo, i0 - 2 * reach), min(hi + 1, i1 + 2 * reach)
        q = w[4 * (p0 - first) : 4 * (p1 - first)]
        for i in range(p1 - p0):
            u[i] = q[4 * i]
            s[i] = q[4 * i + 1]
            T[i] = q[4 * i + 2]
            x[i] = q[4 * i + 3]
        # strain and heat flux where one more derivative reaches
        d0, d1 = max(lo, i0 - reach), min(hi + 1, i1 + reach)
        derivative(op, x, p0, xX, d0, d0, d1, lo, hi, inv_h)
        derivative(op, T, p0, flux, d0, d0, d1, lo, hi, kappa_e * inv_h)
        for i in range(d1 - d0):
            flux[i] /= xX[i]
        if pe != 0.0:  # s becomes sigma - p
            sd, Td = s[d0 - p0 : d1 - p0], T[d0 - p0 : d1 - p0]
            for i in range(d1 - d0):
                sd[i] -= pe * Td[i] / xX[i]
        derivative(op, u, p0, ux, i0, i0, i1, lo, hi, inv_h)
        derivative(op, s, p0, k1, i0, i0, i1, lo, hi, inv_h * inv_m0)
        derivative(op, flux, d0, k3, i0, i0, i1, lo, hi, inv_h)
        o = f[4 * (i0 - layer.own_lo) : 4 * (i1 - layer.own_lo)]
        ui, si, xi = u[i0 - p0 : i1 - p0], s[i0 - p0 : i1 - p0], xX[i0 - d0 : i1 - d0]
        for i in range(i1 - i0):
            o[4 * i] = k1[i] + force
            o[4 * i + 1] = K * ux[i] / xi[i]
            o[4 * i + 2] = (si[i] * ux[i] + k3[i]) * inv_am0
            o[4 * i + 3] = ui[i]


@njit(**OPTIONS)
def solid_limits(layer, w):
    """(largest squared wave speed, largest 1/x_X, number of unphysical points) over the owned points.

    Speeds are in Lagrangian coordinates, x_X is the difference to the right neighbour. A point is unphysical where
    x_X > 0 and T > 0 do not both hold or its velocity is not a number.
    """
    first = layer.own_lo - layer.halo_lo
    n, bad, smallest, pressure = min(layer.own_hi, layer.hi) - layer.own_lo, 0, np.inf, 0.0
    q = w[4 * (layer.own_lo - first) :]
    for i in range(n):
        dx = q[4 * i + 7] - q[4 * i + 3]
        smallest = min(smallest, dx)
        bad += 0 if (dx > 0.0 and q[4 * i + 2] > 0.0 and q[4 * i] == q[4 * i]) else 1
    if layer.own_hi == layer.hi + 1:
        bad += 0 if (q[4 * n + 2] > 0.0 and q[4 * n] == q[4 * n]) else 1
    if layer.gruneisen > 0.0:  # c^2 = (K + (p - sigma) p_eps / rho) / m0 + p_rho, see after (3.9)
        for i in range(n):
            heat = layer.gruneisen * layer.alpha * q[4 * i + 2]
            pressure = max(pressure, heat * layer.m0 * layer.h / smallest - q[4 * i + 1] + layer.m0 * heat)
    stretch = layer.h / smallest
    return (layer.K + max(0.0, layer.gruneisen) * pressure) / layer.m0 * stretch, stretch, bad
