"""What is looked at after a step: extremes that bound the next one, integrals, and what a frame saves. Compiled.

Extremes are exact, whoever owns the points; sums over ranks may differ by round-off, and nothing that is computed on
depends on them. Quadrature with the norm of the operator, per cross-section; the strip between an embedded boundary and its
ghost point does not count.

    gas     largest |u-s| + c; least rho, least T, largest T;        sums of rho, rho u, e
    solid   least x_X, least sigma, least T, largest T;              sums of u, u^2, T
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.boundaries import INTERFACE_END, WALL
from fsipetsc.paper.ends import beyond_boundary, gradient_values
from fsipetsc.paper.stencils import CALL, INNER, U, lagrange, weight

#: numbers of a layer that are looked at: the extremes, and 1 where a number is not finite
SEEN, SHARES = 5, 6
#: unknowns of a solid, as no literals, and a degree
VELOCITY, PLACE, CUBIC = np.int64(0), np.int64(3), np.int64(3)


@njit(**INNER)
def owned(layer):
    """(first, end) of the active points that this rank owns, and the rank's first point with its halo."""
    return max(layer.own_lo, layer.lo), min(layer.own_hi, layer.hi + 1), layer.own_lo - layer.halo_lo


@njit(**INNER)
def nothing_seen(seen):
    """Of a layer without points of this rank."""
    seen[0], seen[1], seen[2], seen[3], seen[4] = -np.inf, np.inf, np.inf, -np.inf, 0.0


@njit(**INNER)
def see_gas(op, gas, layers, q, seen, sums):
    """Extremes and weighted sums, without h. q: (points with halos, 3)."""
    layer = layers[0]
    first, end, origin = owned(layer)
    nothing_seen(seen)
    speed, light, cold, hot = -np.inf, np.inf, np.inf, -np.inf
    mass, momentum, energy, rest = 0.0, 0.0, 0.0, 0.0
    for i in range(first - origin, end - origin):
        rho, m, e = q[U(i), 0], q[U(i), 1], q[U(i), 2]
        r = 1.0 / rho
        u = m * r
        internal = e * r - 0.5 * u * u
        T = gas.law.temperature_in_loops(rho, internal)
        speed = max(speed, abs(u - layer.s) + np.sqrt(gas.law.sound_speed_squared_of_energy(rho, internal)))
        light, cold, hot = min(light, rho), min(cold, T), max(hot, T)
        mass, momentum, energy = mass + rho, momentum + m, energy + e
        rest += T
    seen[0], seen[1], seen[2], seen[3] = speed, light, cold, hot
    if not (np.isfinite(mass) and np.isfinite(momentum) and np.isfinite(energy) and np.isfinite(rest)):
        seen[4] = 1.0
    sums[0], sums[1], sums[2] = mass, momentum, energy
    for r in range(len(op.norm)):
        for i in (layer.lo + r, layer.hi - r):
            if first <= i < end:
                for c in range(3):
                    sums[c] += (op.norm[r] - 1.0) * q[i - origin, c]
    for side in range(2):
        ghost, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
        if layer.end_kind[side] != INTERFACE_END and first <= ghost < end:
            i, strip = ghost - origin, beyond_boundary(layer, side)
            for c in range(3):
                four = q[i, c], q[i + step, c], q[i + 2 * step, c], q[i + 3 * step, c]
                sums[c] -= strip_integral(four, strip)


@njit(**INNER)
def see_solid(op, solid, layers, q, seen, sums):
    """Extremes and weighted sums, without h. q: (points with halos, 4)."""
    layer = layers[0]
    first, end, origin = owned(layer)
    nothing_seen(seen)
    strain, pulled, cold, hot = np.inf, np.inf, np.inf, -np.inf
    momentum, kinetic, heat, rest, per_h = 0.0, 0.0, 0.0, 0.0, 1.0 / layer.h
    for i in range(first - origin, end - origin):
        u, sigma, T = q[U(i), 0], q[U(i), 1], q[U(i), 2]
        pulled, cold, hot = min(pulled, sigma), min(cold, T), max(hot, T)
        momentum, kinetic, heat, rest = momentum + u, kinetic + u * u, heat + T, rest + sigma
    for i in range(max(first, layer.lo + 1) - origin, end - origin):
        x_X = (q[U(i), 3] - q[U(i - 1), 3]) * per_h
        strain, rest = min(strain, x_X), rest + x_X
    seen[0], seen[1], seen[2], seen[3] = strain, pulled, cold, hot
    if not (np.isfinite(momentum) and np.isfinite(heat) and np.isfinite(rest) and np.isfinite(kinetic)):
        seen[4] = 1.0
    sums[0], sums[1], sums[2] = momentum, kinetic, heat
    for r in range(len(op.norm)):
        for i in (layer.lo + r, layer.hi - r):
            if first <= i < end:
                u, change = q[i - origin, 0], op.norm[r] - 1.0
                sums[0] += change * u
                sums[1] += change * u * u
                sums[2] += change * q[i - origin, 2]


# bounds on the step


@njit(**CALL)
def gas_speeds(gas, seen):
    """(physical, largest |u-s| + c, largest max(mu'/rho, kappa/(rho cv)))."""
    speed, rho, cold, hot = seen[0], seen[1], seen[2], seen[3]
    mu = max(gas.viscosity(cold), gas.viscosity(hot))
    kappa = max(gas.conductivity(cold), gas.conductivity(hot))
    cv = min(gas.law.heat_capacity(rho, cold), gas.law.heat_capacity(rho, hot))
    return seen[4] == 0.0 and rho > 0.0 and cold > 0.0 and speed < np.inf, speed, max(mu, kappa / cv) / rho


@njit(**CALL)
def solid_speeds(solid, seen):
    """(physical, largest speed of waves, largest kappa_e/(alpha m0 x_X)), in Lagrangian coordinates."""
    shortest, pulled, cold, hot = seen[0], seen[1], seen[2], seen[3]
    stretch, heat = 1.0 / shortest, solid.alpha * solid.m0
    p = solid.law.pressure_in_loops(hot, stretch)
    c2 = solid.law.wave_modulus(solid.K, heat, hot, p, min(pulled, p), shortest) / solid.m0
    good = seen[4] == 0.0 and shortest > 0.0 and cold > 0.0 and 0.0 <= c2 < np.inf
    return good, np.sqrt(c2), solid.kappa_e * stretch / heat


@njit(**CALL)
def layer_rates(op, speeds, h):
    """(physical, rate of convection, rate of diffusion [1/s])."""
    good, speed, spread = speeds
    return good, speed / h, op.diffusion * spread / (h * h)


@njit(**CALL)
def bound(convection, diffusion):
    """1/dt at Courant number 1, the 4-norm of the largest rates: the smaller of the two steps alone is too long."""
    squares = convection * convection, diffusion * diffusion
    return np.sqrt(np.sqrt(squares[0] * squares[0] + squares[1] * squares[1]))


# integrals


@njit(**INNER)
def strip_integral(v, delta):
    """Integral from the ghost point (0) to the boundary (delta) of the cubic through the last four points."""
    d2, d3, d4 = delta * delta, delta**3, delta**4
    a0 = delta - 11.0 / 12.0 * d2 + d3 / 3.0 - d4 / 24.0
    a1 = 1.5 * d2 - 5.0 / 6.0 * d3 + d4 / 8.0
    a2 = -0.75 * d2 + 2.0 / 3.0 * d3 - d4 / 8.0
    a3 = d2 / 6.0 - d3 / 6.0 + d4 / 24.0
    return a0 * v[0] + a1 * v[1] + a2 * v[2] + a3 * v[3]


@njit(**INNER)
def norm_weight(op, layer, i):
    """Of an active point."""
    return weight(op, min(i - layer.lo, layer.hi - i))


@njit(**INNER)
def gas_force(gas, layers, q):
    """Force [Pa] of the boundary that this rank owns, -n (rho u^2 + p - mu' u_X), from the cubic through four points."""
    layer, force, weights, slopes = layers[0], 0.0, np.zeros(4), np.zeros(4)
    first, end, origin = owned(layer)
    for side in range(2):
        ghost, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
        if layer.end_kind[side] == INTERFACE_END or not first <= ghost < end:
            continue
        lagrange(beyond_boundary(layer, side), CUBIC, weights, slopes)
        flux, T, seen_u = 0.0, 0.0, 0.0
        if layer.end_kind[side] != WALL:
            seen_u = gradient_values(gas, layer, q, ghost - origin, side)[0]
        for k in range(4):
            i = ghost - origin + k * step
            T += weights[k] * gas.velocity_and_temperature(q[i, 0], q[i, 1], q[i, 2])[1]
        mu = gas.viscosity(T)
        for k in range(4):
            i = ghost - origin + k * step
            rho, m, e = q[i, 0], q[i, 1], q[i, 2]
            u = m / rho
            flux += weights[k] * (m * u + gas.law.pressure_of_energy(rho, e - 0.5 * m * u))
            if k == 0 and layer.end_kind[side] != WALL:
                u = seen_u
            flux -= mu * slopes[k] * u * step / layer.h
        force -= (2.0 * side - 1.0) * flux
    return force


@njit(**INNER)
def solid_force(op, solid, layers, q):
    """Force [Pa] of the outer ends that this rank owns, n (sigma - p)."""
    layer, force = layers[0], 0.0
    first, end, origin = owned(layer)
    for side in range(2):
        point, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
        if layer.end_kind[side] == INTERFACE_END or not first <= point < end:
            continue
        i, x_X = point - origin, 0.0
        for j in range(op.n):
            x_X += op.closure[0, j] * q[i + step * j, 3]
        p = solid.law.pressure(q[i, 2], x_X * step / layer.h)
        force += (2.0 * side - 1.0) * (q[i, 1] - p)
    return force


@njit(**INNER)
def gas_entropy(op, gas, layers, q):
    """This rank's part of the entropy, without h."""
    layer, result = layers[0], 0.0
    first, end, origin = owned(layer)
    for i in range(first, end):
        result += norm_weight(op, layer, i) * entropy_density(gas, q, i - origin)
    for side in range(2):
        ghost, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
        if layer.end_kind[side] != INTERFACE_END and first <= ghost < end:
            i = ghost - origin
            near = entropy_density(gas, q, i), entropy_density(gas, q, i + step)
            far = entropy_density(gas, q, i + 2 * step), entropy_density(gas, q, i + 3 * step)
            result -= strip_integral((near[0], near[1], far[0], far[1]), beyond_boundary(layer, side))
    return result


@njit(**INNER)
def entropy_density(gas, q, i):
    """rho S."""
    T = gas.velocity_and_temperature(q[i, 0], q[i, 1], q[i, 2])[1]
    return q[i, 0] * gas.law.entropy(q[i, 0], T)


@njit(**INNER)
def slope_at(op, layer, q, i, c, origin):
    """h D of unknown c at the active point i."""
    rows, columns = op.closure.shape
    total, r, last = 0.0, i - layer.lo, layer.hi - i
    if r < rows:
        for k in range(columns):
            total += op.closure[r, k] * q[layer.lo + k - origin, c]
    elif last < rows:
        for k in range(columns):
            total -= op.closure[last, k] * q[layer.hi - k - origin, c]
    else:
        for k in range(1, op.p + 1):
            total += op.interior[k - 1] * (q[i + k - origin, c] - q[i - k - origin, c])
    return total


@njit(**INNER)
def solid_entropy(op, solid, layers, q):
    """(entropy, rate of heating by stress over T) of this rank's part without h: alpha m0 ln T, (sigma - p) u_X / T."""
    layer, entropy, heating, per_h = layers[0], 0.0, 0.0, 1.0 / layers[0].h
    first, end, origin = owned(layer)
    for i in range(first, end):
        T, a = q[i - origin, 2], norm_weight(op, layer, i)
        u_X, x_X = per_h * slope_at(op, layer, q, i, VELOCITY, origin), per_h * slope_at(op, layer, q, i, PLACE, origin)
        entropy += a * np.log(T)
        heating += a * (q[i - origin, 1] - solid.law.pressure(T, x_X)) * u_X / T
    return solid.alpha * solid.m0 * entropy, heating


@njit(**INNER)
def norm_sum(op, layers):
    """Sum of the norm weights of the owned points."""
    first, end, _ = owned(layers[0])
    total = 0.0
    for i in range(first, end):
        total += norm_weight(op, layers[0], i)
    return total


@njit(**CALL)
def look_at_gas(op, gas, layers, q, entropy, seen, shares):
    """Extremes, and this rank's shares: mass [kg/m2], energy [J/m2], momentum, force [Pa], entropy, heating (0).

    q: (points with halos, 3); entropy: whether it is wanted.
    """
    for c in range(SHARES):
        shares[c] = 0.0
    if layers[0].present == 0:
        nothing_seen(seen)
        return
    h, sums = layers[0].h, np.zeros(3)
    see_gas(op, gas, layers, q, seen, sums)
    shares[0], shares[1], shares[2] = h * sums[0], h * sums[2], h * sums[1]
    shares[3] = gas.force * shares[0] + gas_force(gas, layers, q)
    if entropy:
        shares[4] = h * gas_entropy(op, gas, layers, q)


@njit(**CALL)
def look_at_solid(op, solid, layers, q, entropy, seen, shares):
    """The same of a solid; heating: the rate at which stress heats it, over T [W/(m2 K)]. q: (points with halos, 4)."""
    for c in range(SHARES):
        shares[c] = 0.0
    if layers[0].present == 0:
        nothing_seen(seen)
        return
    mass, sums = solid.m0 * layers[0].h, np.zeros(3)
    see_solid(op, solid, layers, q, seen, sums)
    shares[1], shares[2] = mass * (0.5 * sums[1] + solid.alpha * sums[2]), mass * sums[0]
    shares[3] = solid.force * mass * norm_sum(op, layers) + solid_force(op, solid, layers, q)
    if entropy:
        shares[4], shares[5] = solid_entropy(op, solid, layers, q)
        shares[4] *= layers[0].h
        shares[5] *= layers[0].h


# what is saved


@njit(**CALL)
def gas_fields(gas, layers, q, out):
    """rho, u, T, p and x of the owned points, (owned, 5); NaN where inactive. q: (points with halos, 3)."""
    layer = layers[0]
    interface = layer.lo if layer.end_kind[0] == INTERFACE_END else layer.hi
    for i in range(layer.own_lo, layer.own_hi):
        k, j = i - layer.own_lo, i - layer.own_lo + layer.halo_lo
        for c in range(5):
            out[k, c] = np.nan
        if layer.lo <= i <= layer.hi:
            rho, (u, T) = q[j, 0], gas.velocity_and_temperature(q[j, 0], q[j, 1], q[j, 2])
            out[k, 0], out[k, 1], out[k, 2], out[k, 3] = rho, u, T, gas.law.pressure(rho, T)
            out[k, 4] = (i - interface) * layer.h + layer.x_interface


@njit(**CALL)
def solid_fields(op, solid, layers, q, out):
    """u, sigma, T, x and p of the owned points, (owned, 5). q: (points with halos, 4)."""
    layer, origin = layers[0], layers[0].own_lo - layers[0].halo_lo
    for i in range(layer.own_lo, layer.own_hi):
        k, j = i - layer.own_lo, i - origin
        for c in range(4):
            out[k, c] = q[j, c]
        out[k, 4] = solid.law.pressure(q[j, 2], slope_at(op, layer, q, i, PLACE, origin) / layer.h)
