"""What is looked at after a step: extremes that bound the next one, integrals, and what a frame
saves. Compiled.

Extremes are exact, whoever owns the points; sums over ranks may differ by round-off, and nothing
that is computed on depends on them. Quadrature with the norm of the operator, per cross-section;
the strip between an embedded boundary and its ghost point does not count.

    gas     largest |u-s| + c; least rho, least T, largest T;        sums of rho, rho u, e
    solid   least x_X, least sigma, least T, largest T;              sums of u, u^2, T
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.boundaries import INTERFACE_END, WALL
from fsipetsc.paper.ends import beyond_boundary, gradient_values
from fsipetsc.paper.rates import primitive_rows, solid_rows
from fsipetsc.paper.stencils import INNER, U, lagrange, largest, smallest, total, weight

#: numbers of a layer that are looked at: the extremes, and 1 where a number is not finite
SEEN, SHARES = 5, 6
#: unknowns of a solid, as no literals, and a degree
VELOCITY, PLACE, CUBIC = np.int64(0), np.int64(3), np.int64(3)


@njit(**INNER)
def owned(layer):
    """(first, end) of the active points that this rank owns, end = first if there is none, and the
    rank's first point with its halo."""
    first = max(layer.own_lo, layer.lo)
    return first, max(first, min(layer.own_hi, layer.hi + 1)), layer.own_lo - layer.halo_lo


@njit(**INNER)
def nothing_seen(seen):
    """Of a layer without points of this rank."""
    seen[0], seen[1], seen[2], seen[3], seen[4] = -np.inf, np.inf, np.inf, -np.inf, 0.0


@njit(**INNER)
def speeds_of(gas, s, rho, u, T, speed, a, b):
    """|u-s| + c."""
    for i in range(a, b):
        c = np.sqrt(gas.law.sound_speed_squared(rho[U(i)], T[U(i)]))
        speed[U(i)] = abs(u[U(i)] - s) + c


@njit(**INNER)
def see_gas(op, gas, layer, q, w, seen, sums):
    """Extremes and weighted sums, without h. q: (points with halos, 3); w: scratch."""
    first, end, origin = owned(layer)
    nothing_seen(seen)
    a, b = first - origin, end - origin
    rho, m, e, u, T, speed = w[0], w[1], w[2], w[3], w[4], w[5]
    primitive_rows(gas, q, rho, m, e, u, T, a, b)
    speeds_of(gas, layer.s, rho, u, T, speed, a, b)
    seen[0], seen[1] = largest(speed, a, b), smallest(rho, a, b)
    seen[2], seen[3] = smallest(T, a, b), largest(T, a, b)
    sums[0], sums[1], sums[2] = total(rho, a, b), total(m, a, b), total(e, a, b)
    if not np.isfinite(sums[0] + sums[1] + sums[2] + total(T, a, b) + total(speed, a, b)):
        seen[4] = 1.0
    for r in range(op.rows):
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
def strains_and_squares(per_h, u, x, x_X, square, a, b):
    """Differences of x to the point before, and u^2."""
    for i in range(a, b):
        square[U(i)] = u[U(i)] * u[U(i)]
        x_X[U(i)] = (x[U(i)] - x[U(i - 1)]) * per_h


@njit(**INNER)
def see_solid(op, solid, layer, q, w, seen, sums):
    """Extremes and weighted sums, without h. q: (points with halos, 4); w: scratch."""
    first, end, origin = owned(layer)
    nothing_seen(seen)
    a, b = first - origin, end - origin
    after = max(a, layer.lo + 1 - origin)  # of the points behind the first
    u, sigma, T, x, x_X, square = w[0], w[1], w[2], w[3], w[4], w[5]
    solid_rows(q, u, sigma, T, x, after - 1, b)
    square[U(after - 1)] = u[U(after - 1)] * u[U(after - 1)]
    strains_and_squares(1.0 / layer.h, u, x, x_X, square, after, b)
    seen[0], seen[1] = smallest(x_X, after, b), smallest(sigma, a, b)
    seen[2], seen[3] = smallest(T, a, b), largest(T, a, b)
    sums[0], sums[1], sums[2] = total(u, a, b), total(square, a, b), total(T, a, b)
    if not np.isfinite(sums[0] + sums[1] + sums[2] + total(sigma, a, b) + total(x_X, after, b)):
        seen[4] = 1.0
    for r in range(op.rows):
        for i in (layer.lo + r, layer.hi - r):
            if first <= i < end:
                u, change = q[i - origin, 0], op.norm[r] - 1.0
                sums[0] += change * u
                sums[1] += change * u * u
                sums[2] += change * q[i - origin, 2]


# bounds on the step


@njit(**INNER)
def gas_speeds(gas, seen):
    """(physical, largest |u-s| + c, largest max(mu'/rho, kappa/(rho cv)))."""
    speed, rho, cold, hot = seen[0], seen[1], seen[2], seen[3]
    mu = max(gas.viscosity(cold), gas.viscosity(hot))
    kappa = max(gas.conductivity(cold), gas.conductivity(hot))
    cv = min(gas.law.heat_capacity(rho, cold), gas.law.heat_capacity(rho, hot))
    return (
        seen[4] == 0.0 and rho > 0.0 and cold > 0.0 and speed < np.inf,
        speed,
        max(mu, kappa / cv) / rho,
    )


@njit(**INNER)
def solid_speeds(solid, seen):
    """(physical, largest speed of waves, largest kappa_e/(alpha m0 x_X)), in Lagrangian
    coordinates."""
    shortest, pulled, cold, hot = seen[0], seen[1], seen[2], seen[3]
    stretch, heat = 1.0 / shortest, solid.alpha * solid.m0
    p = solid.pressure(hot, shortest)
    c2 = solid.wave_modulus(hot, p, min(pulled, p), shortest) / solid.m0
    good = seen[4] == 0.0 and shortest > 0.0 and cold > 0.0 and 0.0 <= c2 < np.inf
    return good, np.sqrt(c2), solid.kappa_e * stretch / heat


@njit(**INNER)
def layer_rates(op, speeds, h):
    """(physical, rate of convection, rate of diffusion [1/s])."""
    good, speed, spread = speeds
    return good, speed / h, op.diffusion * spread / (h * h)


@njit(**INNER)
def bound(convection, diffusion):
    """1/dt at Courant number 1, the 4-norm of the largest rates: the smaller of the two steps alone
    is too long."""
    squares = convection * convection, diffusion * diffusion
    return np.sqrt(np.sqrt(squares[0] * squares[0] + squares[1] * squares[1]))


# integrals


@njit(**INNER)
def strip_integral(v, delta):
    """Integral from the ghost point (0) to the boundary (delta) of the cubic through the last four
    points."""
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
def gas_force(gas, layer, q):
    """Force [Pa] of the boundary that this rank owns, -n (rho u^2 + p - mu' u_X), from the cubic
    through four points."""
    force, weights, slopes = 0.0, np.zeros(4), np.zeros(4)
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
            u, T = gas.velocity_and_temperature(rho, m, e)
            flux += weights[k] * (m * u + gas.law.pressure(rho, T))
            if k == 0 and layer.end_kind[side] != WALL:
                u = seen_u
            flux -= mu * slopes[k] * u * step / layer.h
        force -= (2.0 * side - 1.0) * flux
    return force


@njit(**INNER)
def solid_force(op, solid, layer, q):
    """Force [Pa] of the outer ends that this rank owns, n (sigma - p)."""
    force = 0.0
    first, end, origin = owned(layer)
    for side in range(2):
        point, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
        if layer.end_kind[side] == INTERFACE_END or not first <= point < end:
            continue
        i, x_X = point - origin, 0.0
        for j in range(op.n):
            x_X += op.closure[0, j] * q[i + step * j, 3]
        p = solid.pressure(q[i, 2], x_X * step / layer.h)
        force += (2.0 * side - 1.0) * (q[i, 1] - p)
    return force


@njit(**INNER)
def gas_entropy(op, gas, layer, q):
    """This rank's part of the entropy, without h."""
    result = 0.0
    first, end, origin = owned(layer)
    for i in range(first, end):
        result += norm_weight(op, layer, i) * entropy_density(gas, q, i - origin)
    for side in range(2):
        ghost, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
        if layer.end_kind[side] != INTERFACE_END and first <= ghost < end:
            i = ghost - origin
            near = entropy_density(gas, q, i), entropy_density(gas, q, i + step)
            far = entropy_density(gas, q, i + 2 * step), entropy_density(gas, q, i + 3 * step)
            result -= strip_integral(
                (near[0], near[1], far[0], far[1]), beyond_boundary(layer, side)
            )
    return result


@njit(**INNER)
def entropy_density(gas, q, i):
    """rho S."""
    T = gas.velocity_and_temperature(q[i, 0], q[i, 1], q[i, 2])[1]
    return q[i, 0] * gas.law.entropy(q[i, 0], T)


@njit(**INNER)
def slope_at(op, layer, q, i, c, origin):
    """h D of unknown c at the active point i."""
    rows, columns = op.rows, op.columns
    slope, r, last = 0.0, i - layer.lo, layer.hi - i
    if r < rows:
        for k in range(columns):
            slope += op.closure[r, k] * q[layer.lo + k - origin, c]
    elif last < rows:
        for k in range(columns):
            slope -= op.closure[last, k] * q[layer.hi - k - origin, c]
    else:
        for k in range(1, op.p + 1):
            slope += op.interior[k - 1] * (q[i + k - origin, c] - q[i - k - origin, c])
    return slope


@njit(**INNER)
def solid_entropy(op, solid, layer, q):
    """(entropy, rate of heating by stress over T) of this rank's part without h: alpha m0 ln T,
    (sigma - p) u_X / T."""
    entropy, heating, per_h = 0.0, 0.0, 1.0 / layer.h
    first, end, origin = owned(layer)
    for i in range(first, end):
        T, a = q[i - origin, 2], norm_weight(op, layer, i)
        u_X, x_X = (
            per_h * slope_at(op, layer, q, i, VELOCITY, origin),
            per_h * slope_at(op, layer, q, i, PLACE, origin),
        )
        entropy += a * np.log(T)
        heating += a * (q[i - origin, 1] - solid.pressure(T, x_X)) * u_X / T
    return solid.alpha * solid.m0 * entropy, heating


@njit(**INNER)
def norm_sum(op, layer):
    """Sum of the norm weights of the owned points."""
    first, end, _ = owned(layer)
    result = 0.0
    for i in range(first, end):
        result += norm_weight(op, layer, i)
    return result


@njit(**INNER)
def look_at_gas(op, gas, layer, q, w, entropy, seen, shares):
    """Extremes, and this rank's shares: mass [kg/m2], energy [J/m2], momentum, force [Pa], entropy,
    heating (0).

    q: (points with halos, 3); w: scratch; entropy: whether it is wanted.
    """
    for c in range(SHARES):
        shares[c] = 0.0
    if layer.present == 0:
        nothing_seen(seen)
        return
    h, sums = layer.h, np.zeros(3)
    see_gas(op, gas, layer, q, w, seen, sums)
    shares[0], shares[1], shares[2] = h * sums[0], h * sums[2], h * sums[1]
    shares[3] = gas.force * shares[0] + gas_force(gas, layer, q)
    if entropy:
        shares[4] = h * gas_entropy(op, gas, layer, q)


@njit(**INNER)
def look_at_solid(op, solid, layer, q, w, entropy, seen, shares):
    """The same of a solid; heating: the rate at which stress heats it, over T [W/(m2 K)]. q:
    (points with halos, 4)."""
    for c in range(SHARES):
        shares[c] = 0.0
    if layer.present == 0:
        nothing_seen(seen)
        return
    mass, sums = solid.m0 * layer.h, np.zeros(3)
    see_solid(op, solid, layer, q, w, seen, sums)
    shares[1], shares[2] = mass * (0.5 * sums[1] + solid.alpha * sums[2]), mass * sums[0]
    shares[3] = solid.force * mass * norm_sum(op, layer) + solid_force(op, solid, layer, q)
    if entropy:
        shares[4], shares[5] = solid_entropy(op, solid, layer, q)
        shares[4] *= layer.h
        shares[5] *= layer.h


# what is saved


@njit(**INNER)
def gas_fields(gas, layer, q, out):
    """rho, u, T, p and x of the owned points, (owned, 5); NaN where inactive. q: (points with
    halos, 3)."""
    interface = layer.lo if layer.end_kind[0] == INTERFACE_END else layer.hi
    for i in range(layer.own_lo, layer.own_hi):
        k, j = i - layer.own_lo, i - layer.own_lo + layer.halo_lo
        for c in range(5):
            out[k, c] = np.nan
        if layer.lo <= i <= layer.hi:
            rho, (u, T) = q[j, 0], gas.velocity_and_temperature(q[j, 0], q[j, 1], q[j, 2])
            out[k, 0], out[k, 1], out[k, 2], out[k, 3] = rho, u, T, gas.law.pressure(rho, T)
            out[k, 4] = (i - interface) * layer.h + layer.x_interface


@njit(**INNER)
def solid_fields(op, solid, layer, q, out):
    """u, sigma, T, x and p of the owned points, (owned, 5). q: (points with halos, 4)."""
    origin = layer.own_lo - layer.halo_lo
    for i in range(layer.own_lo, layer.own_hi):
        k, j = i - layer.own_lo, i - origin
        for c in range(4):
            out[k, c] = q[j, c]
        out[k, 4] = solid.pressure(q[j, 2], slope_at(op, layer, q, i, PLACE, origin) / layer.h)
