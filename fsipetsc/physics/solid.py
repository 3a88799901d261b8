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

from fsipetsc.operators.kernels import BLOCK, OPTIONS, U1, U64, copy, derivative, minimum, row
from fsipetsc.operators.reductions import largest, smallest
from fsipetsc.physics.emission import emit


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

    s: the memory, in which the owned points and halos of each unknown stand from w on, ``layer.stride`` apart, and the
    scratch rows from ``scratch`` on (see fsipetsc.physics.emission).
    """
    lo, hi, reach = layer.lo, layer.hi, op.reach
    first, stride = layer.own_lo - layer.halo_lo, layer.stride
    inv_h, K, kappa_e = 1.0 / layer.h, layer.K, layer.kappa_e
    inv_m0, inv_am0, force = 1.0 / layer.m0, 1.0 / (layer.alpha * layer.m0), layer.force
    pe = layer.gruneisen * layer.m0 * layer.alpha
    u, sigma, T, x = w, w + stride, w + 2 * stride, w + 3 * stride
    xX, flux, net = scratch + row(0), scratch + row(1), scratch + row(2)  # net: sigma - p
    ux, k0, k2 = scratch + row(4), scratch + row(3), scratch + row(5)
    # rates of u, sigma, T, x come to stand in the rows 3, 4, 5, 6
    for i0 in range(layer.own_lo, layer.own_hi, BLOCK):
        i1 = min(i0 + BLOCK, layer.own_hi)
        # strain, stress and heat flux where one more derivative reaches
        d0, d1 = max(lo, i0 - reach), min(hi + 1, i1 + reach)
        count = U64(d1 - d0)
        for q in range(2):  # a loop keeps the compiler from expanding the same code twice
            scale = inv_h if q == 0 else kappa_e * inv_h
            derivative(op, s, x if q == 0 else T, first, scratch + row(q), d0, d0, d1, lo, hi, scale)
        rf, rX, rn, rs, rT = U64(flux), U64(xX), U64(net), U64(sigma + d0 - first), U64(T + d0 - first)
        for i in range(count):
            s[rX + i] = 1.0 / s[rX + i]
            s[rf + i] *= s[rX + i]
        for i in range(count):
            s[rn + i] = s[rs + i] - pe * s[rT + i] * s[rX + i]
        for q in range(3):
            source, begin = (net, d0) if q == 0 else ((u, first) if q == 1 else (flux, d0))
            scale = inv_h * inv_m0 if q == 0 else inv_h
            derivative(op, s, source, begin, scratch + row(3 + q), i0, i0, i1, lo, hi, scale)
        shift, rux, r0, r2 = U64(i0 - d0), U64(ux), U64(k0), U64(k2)
        rX, rn = rX + shift, rn + shift
        for i in range(U64(i1 - i0)):
            s[r0 + i] += force
            s[r2 + i] = (s[rn + i] * s[rux + i] + s[r2 + i]) * inv_am0
        for i in range(U64(i1 - i0)):
            s[rux + i] = K * s[rux + i] * s[rX + i]
        copy(s, u + i0 - first, scratch + row(6), i1 - i0)
        for unknown in range(4):
            emit(s, target, unknown, scratch + row(3 + unknown), i0 - layer.own_lo, i1 - i0)


@njit(**OPTIONS)
def solid_limits(layer, s, w, scratch):
    """(largest squared wave speed, largest 1/x_X, smallest x_X, smallest T) over the owned points.

    Not numbers where the state is none; speeds are in Lagrangian coordinates, x_X is the difference to the right
    neighbour. The state is unphysical where x_X > 0 and T > 0 do not hold.
    """
    first, stride = layer.own_lo - layer.halo_lo, layer.stride
    end, dx, inv_h = min(layer.own_hi, layer.hi), U64(scratch + row(0)), 1.0 / layer.h
    own = U64(w + layer.own_lo - first)
    count, sigma = U64(layer.own_hi - layer.own_lo), own + U64(stride)
    T, x = own + U64(2 * stride), own + U64(3 * stride)
    shortest = np.inf
    for i0 in range(layer.own_lo, end, BLOCK):
        m, at = U64(min(i0 + BLOCK, end) - i0), x + U64(i0 - layer.own_lo)
        for i in range(m):
            s[dx + i] = (s[at + i + U1] - s[at + i]) * inv_h
        shortest = minimum(shortest, smallest(s, dx, m))
    # a velocity or stress that is not a number shows in the speed
    coldest = smallest(s, T, count)
    stiffest = layer.K + 0.0 * (largest(s, own, count) + largest(s, sigma, count))
    stretch = 1.0 / shortest
    c2 = stiffest * stretch / layer.m0
    if layer.gruneisen > 0.0:  # c^2 = (K + (p - sigma) p_eps / rho) / m0 + p_rho, see after (3.9)
        heat = layer.gruneisen * layer.alpha * largest(s, T, count)
        excess = heat * layer.m0 * stretch - smallest(s, sigma, count)
        c2 += (layer.gruneisen * max(excess, 0.0) / layer.m0 + heat) * stretch
    return c2, stretch, shortest, coldest
