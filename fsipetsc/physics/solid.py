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

from fsipetsc.operators.kernels import BLOCK, OPTIONS, U1, U2, U3, U4, U7, U64, derivative, row
from fsipetsc.physics.emission import emit4


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
def solid_rhs(layer, op, s, w, scratch, target):
    """Time derivative of (u, sigma, T, x) at the owned points, equation (4.19), to where ``target`` says.

    s: the memory, in which the owned points and halos stand from w on, four doubles per point, and the scratch rows
    from ``scratch`` on (see fsipetsc.physics.emission).
    """
    lo, hi, reach = layer.lo, layer.hi, op.reach
    first = layer.own_lo - layer.halo_lo
    inv_h, K, kappa_e = 1.0 / layer.h, layer.K, layer.kappa_e
    inv_m0, inv_am0, force = 1.0 / layer.m0, 1.0 / (layer.alpha * layer.m0), layer.force
    pe = layer.gruneisen * layer.m0 * layer.alpha
    u, net, T, x = scratch + row(0), scratch + row(1), scratch + row(2), scratch + row(3)  # net: sigma - p
    ux, xX, flux, k1, k3 = scratch + row(4), scratch + row(5), scratch + row(6), scratch + row(7), scratch + row(8)
    for i0 in range(layer.own_lo, layer.own_hi, BLOCK):
        i1 = min(i0 + BLOCK, layer.own_hi)
        p0, p1 = max(lo, i0 - 2 * reach), min(hi + 1, i1 + 2 * reach)
        q, ru, rn, rT, rx = U64(w + 4 * (p0 - first)), U64(u), U64(net), U64(T), U64(x)
        for i in range(U64(p1 - p0)):
            s[ru + i] = s[q + U4 * i]
            s[rn + i] = s[q + U4 * i + U1]
            s[rT + i] = s[q + U4 * i + U2]
            s[rx + i] = s[q + U4 * i + U3]
        # strain and heat flux where one more derivative reaches
        d0, d1 = max(lo, i0 - reach), min(hi + 1, i1 + reach)
        derivative(op, s, x, p0, xX, d0, d0, d1, lo, hi, inv_h)
        derivative(op, s, T, p0, flux, d0, d0, d1, lo, hi, kappa_e * inv_h)
        rf, rX = U64(flux), U64(xX)
        for i in range(U64(d1 - d0)):
            s[rf + i] /= s[rX + i]
        if pe != 0.0:
            rn, rT = U64(net + d0 - p0), U64(T + d0 - p0)
            for i in range(U64(d1 - d0)):
                s[rn + i] -= pe * s[rT + i] / s[rX + i]
        derivative(op, s, u, p0, ux, i0, i0, i1, lo, hi, inv_h)
        derivative(op, s, net, p0, k1, i0, i0, i1, lo, hi, inv_h * inv_m0)
        derivative(op, s, flux, d0, k3, i0, i0, i1, lo, hi, inv_h)
        rn, rX, rux = U64(net + i0 - p0), U64(xX + i0 - d0), U64(ux)
        r1, r3 = U64(k1), U64(k3)
        for i in range(U64(i1 - i0)):
            s[r1 + i] += force
            s[r3 + i] = (s[rn + i] * s[rux + i] + s[r3 + i]) * inv_am0
            s[rux + i] = K * s[rux + i] / s[rX + i]
        emit4(s, target, 4 * (i0 - layer.own_lo), k1, ux, k3, u + i0 - p0, i1 - i0)


@njit(**OPTIONS)
def solid_limits(layer, s, w):
    """(largest squared wave speed, largest 1/x_X, number of unphysical points) over the owned points.

    Speeds are in Lagrangian coordinates, x_X is the difference to the right neighbour. A point is unphysical where
    x_X > 0 and T > 0 do not both hold or its velocity is not a number.
    """
    first = layer.own_lo - layer.halo_lo
    n, bad, smallest, pressure = min(layer.own_hi, layer.hi) - layer.own_lo, 0, np.inf, 0.0
    q = U64(w + 4 * (layer.own_lo - first))
    for i in range(U64(n)):
        dx = s[q + U4 * i + U7] - s[q + U4 * i + U3]
        smallest = min(smallest, dx)
        bad += 0 if (dx > 0.0 and s[q + U4 * i + U2] > 0.0 and s[q + U4 * i] == s[q + U4 * i]) else 1
    if layer.own_hi == layer.hi + 1:
        last = q + U4 * U64(n)
        bad += 0 if (s[last + U2] > 0.0 and s[last] == s[last]) else 1
    if layer.gruneisen > 0.0:  # c^2 = (K + (p - sigma) p_eps / rho) / m0 + p_rho, see after (3.9)
        for i in range(U64(n)):
            heat = layer.gruneisen * layer.alpha * s[q + U4 * i + U2]
            pressure = max(pressure, heat * layer.m0 * layer.h / smallest - s[q + U4 * i + U1] + layer.m0 * heat)
    stretch = layer.h / smallest
    return (layer.K + max(0.0, layer.gruneisen) * pressure) / layer.m0 * stretch, stretch, bad
