"""What is monitored after a step: extremes that bound the next one, and integrals. Compiled.

Extremes are exact, whoever owns the points; sums over ranks may differ by round-off, and nothing
that is computed on depends on them. Quadrature with the norm of the operator, per cross-section;
the strip between an embedded boundary and its ghost point does not count.

    layer.seen      gas     largest |u-s| + c, -rho, -T, T
                    solid   largest -x_X, -sigma, -T, T;        both: 1 if a number is not finite
    layer.shares    mass [kg/m2], energy [J/m2], momentum [N s/m2]: this rank's
"""

import numpy as np
from numba import njit

from fsipetsc.paper.ends import beyond_boundary
from fsipetsc.paper.rates import outer_side, own_range
from fsipetsc.paper.stencils import INNER, weight

#: numbers of a layer that are seen, and shares
SEEN, SHARES = 5, 3


@njit(**INNER)
def norm_weight(op, A, B, i):
    """Of the active point i."""
    return weight(op, min(i - A, B - i))


@njit(**INNER)
def strip_weight(delta, k):
    """Of the point k in the integral from the ghost point (0) to the boundary (delta) of the cubic
    through the last four points."""
    d2, d3, d4 = delta * delta, delta**3, delta**4
    if k == 0:
        return delta - 11.0 / 12.0 * d2 + d3 / 3.0 - d4 / 24.0
    if k == 1:
        return 1.5 * d2 - 5.0 / 6.0 * d3 + d4 / 8.0
    if k == 2:
        return -0.75 * d2 + 2.0 / 3.0 * d3 - d4 / 8.0
    return d2 / 6.0 - d3 / 6.0 + d4 / 24.0


@njit(**INNER)
def monitor_gas(op, gas, layer, q):
    """Extremes and shares. q: (points with halos, 3)."""
    a, b, A, B = own_range(layer)
    side, finite, shares = outer_side(layer), 0.0, layer.shares
    strip, ghost = beyond_boundary(layer, side), (A if side == 0 else B)
    fastest, thinnest, coldest, hottest = -np.inf, -np.inf, -np.inf, -np.inf
    mass, momentum, energy = 0.0, 0.0, 0.0
    for i in range(a, b):
        rho, m, e = q[i, 0], q[i, 1], q[i, 2]
        u, T = gas.velocity_and_temperature(rho, m, e)
        speed = abs(u - layer.s) + np.sqrt(gas.law.sound_speed_squared(rho, T))
        fastest, thinnest = max(fastest, speed), max(thinnest, -rho)
        coldest, hottest = max(coldest, -T), max(hottest, T)
        finite += rho + m + e + T + speed
        w = norm_weight(op, A, B, i)
        if abs(i - ghost) < 4:
            w -= strip_weight(strip, abs(i - ghost))
        mass += w * rho
        momentum += w * m
        energy += w * e
    seen, h = layer.seen, layer.h
    seen[0], seen[1], seen[2], seen[3] = fastest, thinnest, coldest, hottest
    seen[4] = 0.0 if np.isfinite(finite) else 1.0
    shares[0], shares[1], shares[2] = h * mass, h * energy, h * momentum


@njit(**INNER)
def monitor_solid(op, solid, layer, q):
    """Extremes and shares. q: (points with halos, 4)."""
    a, b, A, B = own_range(layer)
    per_h = 1.0 / layer.h
    shortest, pulled, coldest, hottest = -np.inf, -np.inf, -np.inf, -np.inf
    momentum, kinetic, heat, finite = 0.0, 0.0, 0.0, 0.0
    for i in range(a, b):
        u, sigma, T, w = q[i, 0], q[i, 1], q[i, 2], norm_weight(op, A, B, i)
        if i > A:
            x_X = (q[i, 3] - q[i - 1, 3]) * per_h
            shortest = max(shortest, -x_X)
            finite += x_X
        pulled, coldest, hottest = max(pulled, -sigma), max(coldest, -T), max(hottest, T)
        finite += u + u * u + sigma + T
        momentum += w * u
        kinetic += 0.5 * w * u * u
        heat += w * T
    seen, shares, m0_h = layer.seen, layer.shares, solid.m0 * layer.h
    seen[0], seen[1], seen[2], seen[3] = shortest, pulled, coldest, hottest
    seen[4] = 0.0 if np.isfinite(finite) else 1.0
    shares[1], shares[2] = m0_h * (kinetic + solid.alpha * heat), m0_h * momentum


# bounds on the step, from what all ranks have seen


@njit(**INNER)
def bound_of_gas(op, gas, layer):
    """layer.rates of convection and diffusion [1/s], by the largest |u-s| + c and max(mu'/rho,
    kappa/(rho cv)); whether the layer is physical."""
    seen = layer.seen
    speed, rho, cold, hot = seen[0], -seen[1], -seen[2], seen[3]
    mu = max(gas.viscosity(cold), gas.viscosity(hot))
    kappa = max(gas.conductivity(cold), gas.conductivity(hot))
    cv = min(gas.law.heat_capacity(rho, cold), gas.law.heat_capacity(rho, hot))
    put_rates(op, layer, speed, max(mu, kappa / cv) / rho)
    return seen[4] == 0.0 and rho > 0.0 and cold > 0.0 and speed < np.inf


@njit(**INNER)
def bound_of_solid(op, solid, layer):
    """The same, by the largest speed of waves and kappa_e/(alpha m0 x_X), in Lagrangian
    coordinates."""
    seen = layer.seen
    shortest, pulled, cold, hot = -seen[0], -seen[1], -seen[2], seen[3]
    p = solid.pressure(hot, shortest)
    c2 = solid.wave_modulus(hot, p, min(pulled, p), shortest) / solid.m0
    put_rates(op, layer, np.sqrt(c2), solid.kappa_e / (shortest * solid.alpha * solid.m0))
    return seen[4] == 0.0 and shortest > 0.0 and cold > 0.0 and 0.0 <= c2 < np.inf


@njit(**INNER)
def put_rates(op, layer, speed, diffusivity):
    """layer.rates."""
    layer.rates[0] = speed / layer.h
    layer.rates[1] = op.diffusion * diffusivity / (layer.h * layer.h)
