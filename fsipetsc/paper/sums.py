"""What is looked at after a step: extremes that bound the next one, and integrals. Compiled.

Extremes are exact, whoever owns the points; sums over ranks may differ by round-off, and nothing
that is computed on depends on them. Quadrature with the norm of the operator, per cross-section;
the strip between an embedded boundary and its ghost point does not count.

    layer.seen      gas     largest |u-s| + c, -rho, -T, T
                    solid   largest -x_X, -sigma, -T, T;        both: 1 if a number is not finite
    layer.shares    mass [kg/m2], energy [J/m2], momentum, force on the outer end [Pa], entropy,
                    heating by stress over T [W/(m2 K)]: this rank's
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.boundaries import INTERFACE_END, WALL
from fsipetsc.paper.ends import beyond_boundary, gradient_values
from fsipetsc.paper.rates import outer_side
from fsipetsc.paper.stencils import INNER, PLACE, VELOCITY, derivative_at, lagrange, weight

#: numbers of a layer that are seen, and shares
SEEN, SHARES = 5, 6
#: a degree, as no literal
CUBIC = np.int64(3)


@njit(**INNER)
def owned(layer):
    """(first, end, origin): the active points that this rank owns are first .. end-1, and its
    first one with its halo is ``origin``."""
    first = max(layer.own_lo, layer.lo)
    return first, max(first, min(layer.own_hi, layer.hi + 1)), layer.own_lo - layer.halo_lo


@njit(**INNER)
def forget(layer):
    """Start to look at a layer."""
    for c in range(SEEN):
        layer.seen[c] = -np.inf
    for c in range(SHARES):
        layer.shares[c] = 0.0


@njit(**INNER)
def norm_weight(op, layer, i):
    """Of an active point."""
    return weight(op, min(i - layer.lo, layer.hi - i))


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
def look_at_gas(op, gas, layer, q, entropy):
    """Extremes and shares. q: (points with halos, 3); entropy: whether it is wanted."""
    forget(layer)
    first, end, origin = owned(layer)
    side, finite, shares = outer_side(layer), 0.0, layer.shares
    strip, ghost = beyond_boundary(layer, side), (layer.lo if side == 0 else layer.hi)
    fastest, thinnest, coldest, hottest = -np.inf, -np.inf, -np.inf, -np.inf
    mass, momentum, energy, entropy_of = 0.0, 0.0, 0.0, 0.0
    for i in range(first, end):
        rho, m, e = q[i - origin, 0], q[i - origin, 1], q[i - origin, 2]
        u, T = gas.velocity_and_temperature(rho, m, e)
        speed = abs(u - layer.s) + np.sqrt(gas.law.sound_speed_squared(rho, T))
        fastest, thinnest = max(fastest, speed), max(thinnest, -rho)
        coldest, hottest = max(coldest, -T), max(hottest, T)
        finite += rho + m + e + T + speed
        a = norm_weight(op, layer, i)
        if abs(i - ghost) < 4:
            a -= strip_weight(strip, abs(i - ghost))
        mass += a * rho
        momentum += a * m
        energy += a * e
        if entropy:
            entropy_of += a * rho * gas.law.entropy(rho, T)
    seen, h = layer.seen, layer.h
    seen[0], seen[1], seen[2], seen[3] = fastest, thinnest, coldest, hottest
    seen[4] = 0.0 if np.isfinite(finite) else 1.0
    shares[0], shares[1], shares[2], shares[4] = h * mass, h * energy, h * momentum, h * entropy_of
    shares[3] = gas.force * shares[0]
    if first <= ghost < end:
        shares[3] += boundary_force(gas, layer, q, side, ghost - origin)


@njit(**INNER)
def boundary_force(gas, layer, q, side, ghost):
    """Force [Pa] of the boundary, -n (rho u^2 + p - mu' u_X), from the cubic through four
    points."""
    weights, slopes, step = np.zeros(4), np.zeros(4), 1 - 2 * side
    lagrange(beyond_boundary(layer, side), CUBIC, weights, slopes)
    flux, T_end, u_X = 0.0, 0.0, 0.0
    for k in range(4):
        rho, m, e = q[ghost + k * step, 0], q[ghost + k * step, 1], q[ghost + k * step, 2]
        u, T = gas.velocity_and_temperature(rho, m, e)
        flux += weights[k] * (m * u + gas.law.pressure(rho, T))
        T_end += weights[k] * T
        if k == 0 and layer.end_kind[side] != WALL:
            u = gradient_values(gas, layer, q, ghost, side)[0]
        u_X += slopes[k] * u * step / layer.h
    return step * (flux - gas.viscosity(T_end) * u_X)


@njit(**INNER)
def look_at_solid(op, solid, layer, q, entropy):
    """Extremes and shares. q: (points with halos, 4); entropy: whether it and heating are
    wanted."""
    forget(layer)
    first, end, origin = owned(layer)
    shortest, pulled, coldest, hottest = -np.inf, -np.inf, -np.inf, -np.inf
    mass, momentum, kinetic, heat, entropy_of, heating = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    finite, A, B, per_h = 0.0, layer.lo - origin, layer.hi - origin, 1.0 / layer.h
    for i in range(first - origin, end - origin):
        u, sigma, T, a = q[i, 0], q[i, 1], q[i, 2], norm_weight(op, layer, i + origin)
        if i > A:
            x_X = (q[i, 3] - q[i - 1, 3]) * per_h
            shortest = max(shortest, -x_X)
            finite += x_X
        pulled, coldest, hottest = max(pulled, -sigma), max(coldest, -T), max(hottest, T)
        finite += u + u * u + sigma + T
        mass += a
        momentum += a * u
        kinetic += 0.5 * a * u * u
        heat += a * T
        if entropy:
            x_X = per_h * derivative_at(op, q, PLACE, i, A, B)
            u_X = per_h * derivative_at(op, q, VELOCITY, i, A, B)
            entropy_of += a * np.log(T)
            heating += a * (sigma - solid.pressure(T, x_X)) * u_X / T
        if (i == A and layer.end_kind[0] != INTERFACE_END) or (
            i == B and layer.end_kind[1] != INTERFACE_END
        ):  # n (sigma - p)
            n, x_X = (-1.0 if i == A else 1.0), per_h * derivative_at(op, q, PLACE, i, A, B)
            layer.shares[3] += n * (sigma - solid.pressure(T, x_X))
    seen, shares, m0_h, capacity = layer.seen, layer.shares, solid.m0 * layer.h, solid.alpha
    seen[0], seen[1], seen[2], seen[3] = shortest, pulled, coldest, hottest
    seen[4] = 0.0 if np.isfinite(finite) else 1.0
    shares[1], shares[2] = m0_h * (kinetic + capacity * heat), m0_h * momentum
    shares[3] += solid.force * m0_h * mass
    shares[4], shares[5] = m0_h * capacity * entropy_of, layer.h * heating


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
