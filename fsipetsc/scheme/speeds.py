"""How fast sound and heat are in a layer, from its extremes: what bounds the time step. Compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.scheme.extremes_and_sums import GREATEST_T, LEAST_RHO, LEAST_SIGMA, LEAST_STRAIN, LEAST_T, SPEED, SUMS


@njit(**OPTIONS)
def fluid_speeds(law, layer, s, at):
    """(the state is physical, largest speed |u-s| + c, largest max(mu'/rho, kappa/(rho cv))) from the words at s[at:]."""
    speed, rho, T = s[U64(at + SPEED)], s[U64(at + LEAST_RHO)], s[U64(at + LEAST_T)]
    numbers = law.transport.constants(layer)
    cold, hot = law.transport.relative(numbers, T), law.transport.relative(numbers, s[U64(at + GREATEST_T)])
    mu, kappa = layer.mu * max(cold[0], hot[0]), layer.kappa * max(cold[1], hot[1])
    gas = law.gas.constants(layer)
    cv = min(law.gas.heat_capacity(gas, rho, T), law.gas.heat_capacity(gas, rho, s[U64(at + GREATEST_T)]))
    return rho > 0.0 and T > 0.0 and speed < np.inf, speed, max(mu, kappa / cv) / rho


@njit(**OPTIONS)
def solid_speeds(law, layer, s, at):
    """(the state is physical, largest speed of waves, largest kappa_e/(alpha m0 x_X)) from the words at s[at:].

    In Lagrangian coordinates; x_X is the difference between neighbours.
    """
    shortest, coldest = s[U64(at + LEAST_STRAIN)], s[U64(at + LEAST_T)]
    hottest, pulled, stretch = s[U64(at + GREATEST_T)], s[U64(at + LEAST_SIGMA)], 1.0 / shortest
    c, heat = law.pressing.constants(layer), layer.alpha * layer.m0
    p = law.pressing.pressure_in_loops(c, hottest, stretch)
    # a velocity or stress that is not a number shows in the speed
    c2 = law.pressing.wave_modulus(c, layer.K, heat, hottest, p, min(pulled, p), shortest) / layer.m0
    c2 += 0.0 * (s[U64(at + SUMS)] + pulled)
    good = shortest > 0.0 and coldest > 0.0 and 0.0 <= c2 < np.inf
    return good, np.sqrt(c2), layer.kappa_e * stretch / (layer.alpha * layer.m0)
