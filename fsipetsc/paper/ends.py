"""The outer ends: embedded boundaries of gases, with their ghost points, and ends of a solid.
Compiled.

An embedded boundary stands at x_w; the ghost point is the first point of the frame's grid at or
beyond it, delta in [0, 1) cells outside. Only what the condition gives is overwritten there:
outgoing characteristics keep their values, with Z = rho c. (A ghost point with extrapolated
density, or with all variables prescribed, makes the scheme unstable.) docs/open-end.md says why
each formula is as it is, with measurements.

``nodes`` (3, NODES) holds (rho, u, T) at the ghost point (column 0) and inside of it; n is the
outward normal, -1 left, 1 right.
"""

import numpy as np

from fsipetsc.operators.loops import njit
from fsipetsc.boundaries import CLAMPED, FREE, GIVEN_FLUX, GIVEN_T, INTERFACE_END, OPEN, WALL
from fsipetsc.paper.stencils import INNER, NEW, OLD

#: nodes that a formula may use, ghost point included
NODES = 8
#: least weight of the ghost point in the formula for data that are given
LEAST = 0.25
#: degree of the extrapolation that fills a new point
NEW_WALL, NEW_OPEN, NEW_DIRICHLET = 2, 1, 3
#: order 1 of an open end fades out where viscosity is this fraction of c0 L; q_nn = 0 where alpha
#: is this fraction of a L
LONGEST = 0.25
#: of an insulated wall, by s, and for q = s + 1, s + 2, s + 3: coefficients of eta_q in powers of
#: delta
ETA = np.zeros((4, 3, 4))
ETA[0, 0, :2] = 0.0, 0.5
ETA[1, 0, :3] = 0.0882352941176471, 0.0883801777493091, -0.1766154718669562
ETA[2, 0] = 0.2222164620745679, -0.4850917636042938, 0.1267629370385567, 0.0198481621891904
ETA[3, :, :3] = (1.267, -2.9, 1.178), (-0.888, 1.872, -0.677), (0.193, -0.389, 0.131)
#: with narrow second derivatives
ETA_NARROW = ETA.copy()
ETA_NARROW[2, 0] = 0.2289158450015872, -0.4914033185443774, 0.1207498614024324, 0.0225285974796345


@njit(**INNER)
def distance(layer, side):
    """From the interface to the embedded boundary, in cells, from where the frame is: not by
    (4.25)."""
    return abs(layer.end_x[side] - layer.x_interface) / layer.h


@njit(**INNER)
def beyond_boundary(layer, side):
    """delta: how far the ghost point lies outside, in cells."""
    return layer.hi - layer.lo - distance(layer, side)


@njit(**INNER)
def depth_of(layer):
    """Points inside the ghost point that are taken. Who owns the next point to come in must have
    them in its halo."""
    return min(min(NODES - 1, layer.halo - 1), layer.hi - layer.lo)


@njit(**INNER)
def fetch(gas, layer, q, ghost, side):
    """The nodes of a gas whose ghost point is q[ghost]."""
    step, nodes = 1 - 2 * side, np.zeros((3, NODES))
    for k in range(depth_of(layer) + 1):
        i = ghost + step * k
        nodes[0, k] = q[i, 0]
        nodes[1, k], nodes[2, k] = gas.velocity_and_temperature(q[i, 0], q[i, 1], q[i, 2])
    return nodes


@njit(**INNER)
def fill_ghost(op, gas, layer, q, side, new):
    """Give the ghost point its values, where a rank has the points that this takes: all who need it
    do.

    q: (points with halos, 3); new: the ghost point has no values yet.
    """
    ghost = (layer.lo if side == 0 else layer.hi) - (layer.own_lo - layer.halo_lo)
    last = ghost + (1 - 2 * side) * depth_of(layer)
    if not (0 <= ghost < len(q) and 0 <= last < len(q)):
        return
    kind, nodes = layer.end_kind[side], fetch(gas, layer, q, ghost, side)
    if new:
        degree = NEW_WALL if kind == WALL else (NEW_OPEN if kind == OPEN else NEW_DIRICHLET)
        for c in range(3):  # without data the highest difference is left, which vanishes
            nodes[c, 0] = dirichlet_ghost(0.0, nodes[c], np.zeros(NODES), degree + 1, 1.0)
    n = 2.0 * side - 1.0
    if kind == WALL:
        rho, u, T = wall(op, gas, layer, side, n, nodes)
    elif kind == OPEN:
        rho, u, T = open_end(gas, layer, side, n, nodes)
    else:
        rho, u, T = given_data(gas, layer, side, n, nodes)
    q[ghost, 0], q[ghost, 1], q[ghost, 2] = rho, rho * u, gas.total_energy(rho, u, T)


@njit(**INNER)
def gradient_values(gas, layer, q, ghost, side):
    """(u, T) for the gradients in viscous stress and conduction at the ghost point q[ghost], which
    is filled."""
    nodes = fetch(gas, layer, q, ghost, side)
    if layer.end_kind[side] == OPEN:
        return open_gradients(gas, layer, side, 2.0 * side - 1.0, nodes)
    degree, data = layer.end_degree[side], layer.end_data[side]
    weights, _ = lagrange(beyond_boundary(layer, side), degree)
    # less, and the viscous stress of the ghost point takes more than the time step gives
    least = LEAST if degree < 4 else 0.3
    u = dirichlet_ghost(data[1], nodes[1], weights, degree, least)
    return u, dirichlet_ghost(data[2], nodes[2], weights, degree, least)


# formulas


@njit(**INNER)
def lagrange(delta, degree):
    """Lagrange weights and their derivatives at delta for the nodes 0, 1, ..., degree.

    Node 0 is the ghost point and the boundary lies delta cells inside of it; (4.26) is degree 2,
    with the sign of its third weight corrected so that the weights sum to one.
    """
    weights, slopes = np.zeros(NODES), np.zeros(NODES)
    for k in range(degree + 1):
        value, denominator, slope = 1.0, 1.0, 0.0
        for m in range(degree + 1):
            if m != k:
                slope = slope * (delta - m) + value
                value *= delta - m
                denominator *= k - m
        weights[k], slopes[k] = value / denominator, slope / denominator
    return weights, slopes


@njit(**INNER)
def dirichlet_ghost(g, v, weights, degree, least):
    """Value of the ghost point (node 0) so that the interpolant takes the value g at the boundary.

    v[1..degree] are the nodes inside. The q-th difference is added with eta = max(0, least - L_0):
    the formula of Kreiss & Petersson (2006) as in (4.26), but with an eta that vanishes where L_0
    is large enough, because a constant one spoils the accuracy when the boundary is close to the
    ghost point.
    """
    eta = max(0.0, least - weights[0])
    s, binomial = g, 1.0
    for k in range(1, degree + 1):
        binomial *= -(degree + 1.0 - k) / k
        s -= (weights[k] + eta * binomial) * v[k]
    return s / (weights[0] + eta)


@njit(**INNER)
def insulated_ghost(op, T, delta):
    """T of the ghost point so that no heat flows through a wall at delta.

    The interpolant of degree s has zero slope there (Kreiss et al. 2004); differences of the orders
    s + 1 ... are added, with eta fitted to the error that D makes at its closure.
    """
    s = op.p
    last = s + 3 if s == 4 else s + 1
    _, slopes = lagrange(delta, s)
    for q in range(s + 1, last + 1):
        eta, binomial = 0.0, 1.0
        for power in range(3, -1, -1):
            eta = eta * delta + (ETA_NARROW if op.narrow else ETA)[s - 1, q - s - 1, power]
        for k in range(q + 1):
            slopes[k] += eta * binomial
            binomial *= -(q - k) / (k + 1.0)
    sum_inside = 0.0
    for k in range(1, last + 1):
        sum_inside += slopes[k] * T[k]
    return -sum_inside / slopes[0]


# wall


@njit(**INNER)
def wall(op, gas, layer, side, n, nodes):
    """Adiabatic no-slip wall: u = 0, T_X = 0, and p + n Z u keeps its value."""
    rho, u, T = nodes[0, 0], nodes[1, 0], nodes[2, 0]
    Z, delta = rho * np.sqrt(gas.law.sound_speed_squared(rho, T)), beyond_boundary(layer, side)
    degree = layer.end_degree[side]
    u_G = dirichlet_ghost(0.0, nodes[1], lagrange(delta, degree)[0], degree, LEAST)
    p_G = gas.law.pressure(rho, T) - n * Z * (u_G - u)
    T_G = insulated_ghost(op, nodes[2], delta)
    return gas.law.density(p_G, T_G), u_G, T_G


# given data


@njit(**INNER)
def given_data(gas, layer, side, n, nodes):
    """Exact (rho, u, T): as many of them as come in along characteristics.

    Inflow faster than sound: all three; inflow: p - n Z u and the entropy rho - p/c^2; outflow: p -
    n Z u; faster than sound: nothing. What viscosity and conduction ask for besides is imposed in
    the gradients.
    """
    degree, data = layer.end_degree[side], layer.end_data[side]
    weights, _ = lagrange(beyond_boundary(layer, side), degree)
    rho, u, T = nodes[0, 0], nodes[1, 0], nodes[2, 0]
    rho_D = dirichlet_ghost(data[0], nodes[0], weights, degree, LEAST)
    u_D = dirichlet_ghost(data[1], nodes[1], weights, degree, LEAST)
    T_D = dirichlet_ghost(data[2], nodes[2], weights, degree, LEAST)
    c2 = gas.law.sound_speed_squared(nodes[0, 1], nodes[2, 1])
    c = np.sqrt(c2)
    if n * data[1] <= -np.sqrt(gas.law.sound_speed_squared(data[0], data[2])):
        return rho_D, u_D, T_D
    if n * data[1] >= 0.0 and n * nodes[1, 1] >= c:
        return rho, u, T
    Z = nodes[0, 1] * c
    p, p_D = gas.law.pressure(rho, T), gas.law.pressure(rho_D, T_D)
    w_o, w_i = p + n * Z * u, p_D - n * Z * u_D
    entropy = rho - p / c2 if n * data[1] >= 0.0 else rho_D - p_D / c2
    p = 0.5 * (w_i + w_o)
    rho = entropy + p / c2
    return rho, n * (w_o - w_i) / (2.0 * Z), gas.law.temperature_of(rho, p)


# open end


@njit(**INNER)
def gas_beyond(gas, layer, side):
    """(rho0, c0, tau, alpha, p_T/cv, b, kappa) of the gas beyond an open end, and how much of order
    1 there is, 0 to 1."""
    p0, T0 = layer.end_data[side, 0], layer.end_data[side, 1]
    rho = gas.law.density(p0, T0)
    c2, cv = gas.law.sound_speed_squared(rho, T0), gas.law.heat_capacity(rho, T0)
    c, by_heat = np.sqrt(c2), gas.law.pressure_by_temperature(rho, T0) / cv
    mu, kappa, tau = gas.viscosity(T0), gas.conductivity(T0), T0 * by_heat / (rho * rho * c2)
    alpha = kappa * gas.law.bulk_modulus(rho, T0) / (cv * rho * rho * c2)
    longest = LONGEST * c * layer.h * (layer.hi - layer.lo)
    part = layer.end_data[side, 3] * max(0.0, 1.0 - max(mu, kappa / cv) / (rho * longest))
    return rho, c, tau, alpha, by_heat, 0.5 * (mu - tau * by_heat * kappa), kappa, part


@njit(**INNER)
def carried(layer, a, alpha, part):
    """How much of q_nn = 0 there is where gas flows out with a, 0 to 1."""
    carrying = max(a, 0.0) * LONGEST * layer.h * (layer.hi - layer.lo)
    return part * carrying / (carrying + alpha)


@njit(**INNER)
def open_end(gas, layer, side, n, nodes):
    """Towards gas of p0, T0 and velocity u0: no sound comes in, up to order 0 or 1 in the
    viscosity; on outflow the entropy keeps its value, on inflow it is that of the gas beyond.
    end_data = (p0, T0, u0, order).
    """
    p0, T0, u0 = layer.end_data[side, 0], layer.end_data[side, 1], layer.end_data[side, 2]
    rho0, c0, tau, alpha, by_heat, b, kappa, part = gas_beyond(gas, layer, side)
    rho, u, T = nodes[0, 0], nodes[1, 0], nodes[2, 0]
    rho1, T1, v1 = nodes[0, 1], nodes[2, 1], n * (nodes[1, 1] - u0)
    c2 = gas.law.sound_speed_squared(rho1, T1)
    if n * nodes[1, 1] >= np.sqrt(c2):
        return rho, u, T
    if n * u0 <= -c0:
        return rho0, u0, T0
    p, p1 = gas.law.pressure(rho, T), gas.law.pressure(rho1, T1)
    Z, scale, m = rho1 * np.sqrt(c2), rho0 * c0 * c0 / gas.gamma, 0.5 - 0.5 / gas.gamma
    # Z v (1 + by_v) = simple wave + by_p (p - p0) + known
    by = part / (rho0 * c0 * layer.h)
    by_v, by_p = by * max(b, 0.0), by * max(-b, 0.0)
    known = by_v * rho0 * c0 * v1 - by_p * (p1 - p0)
    if kappa > 0.0:
        p2 = gas.law.pressure(nodes[0, 2], nodes[2, 2])
        q_n = (T1 - nodes[2, 2] - tau * (p1 - p2)) / layer.h
        known += carried(layer, n * nodes[1, 1], alpha, part) * by_heat * kappa / (rho0 * c0) * q_n
    # with p + n Z u, a quadratic equation for y, the pressure of the wave in units of scale
    share, rise, fall = Z / (rho0 * c0 * (1.0 + by_v)), (1.0 + m) / 6.0, (2.0 - m) / 3.0
    w_o = p - p0 + Z * n * (u - u0)
    free, wave = 1.0 + share * by_p, (w_o - share * known) / scale
    half = 0.5 * (free + share - fall * wave)
    y = wave / (half + np.sqrt(half * half + (free * fall + share * rise) * wave))
    sound = scale * y
    u = u0 + n * (w_o - sound) / Z
    rho = rho + (p0 + sound - p) / c2 if n * u >= 0.0 else rho0 * (1.0 + y) ** (1.0 / gas.gamma)
    return rho, u, gas.law.temperature_of(rho, p0 + sound)


@njit(**INNER)
def open_gradients(gas, layer, side, n, nodes):
    """(u, T) for the gradients at an open end: heat and viscous stress are imposed there."""
    u, T, T1 = nodes[1, 0], nodes[2, 0], nodes[2, 1]
    a, seen_u, seen_T = n * u, u, T
    if gas.mu > 0.0 and (a < 0.0 or a * a >= gas.law.sound_speed_squared(nodes[0, 1], T1)):
        seen_u = 2.0 * nodes[1, 1] - nodes[1, 2]
    if gas.kappa > 0.0:
        _, c0, tau, alpha, _, _, _, part = gas_beyond(gas, layer, side)
        p, p1 = gas.law.pressure(nodes[0, 0], T), gas.law.pressure(nodes[0, 1], T1)
        q_n = T1 - nodes[2, 2] - tau * (p1 - gas.law.pressure(nodes[0, 2], nodes[2, 2]))
        slow, conducted = max(1.0 + min(a, 0.0) / c0, 0.0), alpha / layer.h
        step = part * slow * slow * tau * (p - p1) + carried(layer, a, alpha, part) * q_n
        width = layer.h * (layer.hi - layer.lo)
        lost = 0.5 * (np.sqrt(a * a + 4.0 * (alpha / width) ** 2) - a)
        at_rest = layer.end_data[side, 1] + tau * (p - layer.end_data[side, 0])
        seen_T = (conducted * (T1 + step) + lost * at_rest) / (conducted + lost)
    return seen_u, seen_T


# a boundary that moves over the grid


@njit(**INNER)
def move_boundary(op, gas, layer, q, side):
    """Let the ghost point be the first one at or beyond the boundary; False if no point is left.

    A point that comes in is extrapolated and becomes the ghost point, the old one keeps its value;
    where the boundary moves inwards the last interior point becomes the ghost point. q: (points
    with halos, 3). All ranks of a layer decide alike.
    """
    cells = distance(layer, side)
    if not cells < 1e15:
        return True  # not a number: the bounds on the step will tell
    target = int(np.ceil(cells - 1e-9))
    while layer.hi - layer.lo < target:
        if (layer.lo == 0) if side == 0 else (layer.hi == layer.n - 1):
            return False
        if side == 0:
            layer.lo -= 1
        else:
            layer.hi += 1
        fill_ghost(op, gas, layer, q, side, NEW)
    if layer.hi - layer.lo > target >= layer.least - 1:
        if side == 0:
            layer.lo = layer.hi - target
        else:
            layer.hi = layer.lo + target
        fill_ghost(op, gas, layer, q, side, OLD)
    return True


# solid


@njit(**INNER)
def close_solid(op, solid, layer, q):
    """Apply the conditions at the outer ends of a solid that this rank owns. q: (owned, 4).

    Clamped: end_data = (u,). Free, absorbing: (sigma - p,), the latter of the solid at rest beyond
    the end: the characteristic that leaves, sigma - p - n Z u, Z = m0 c, keeps its value.
    """
    beta = op.closure[0]
    for side in range(2):
        end, step, kind = layer.lo if side == 0 else layer.hi, 1 - 2 * side, layer.end_kind[side]
        if kind == INTERFACE_END or not layer.own_lo <= end < layer.own_hi:
            continue
        i, n, given = end - layer.own_lo, 2.0 * side - 1.0, layer.end_data[side, 0]
        d, x_X, rest = -n / layer.h, 0.0, 0.0
        for j in range(op.n):
            x_X += d * beta[j] * q[i + step * j, 3]
            if j > 0:
                rest += beta[j] * q[i + step * j, 2]
        if solid.kappa_e > 0.0:
            thermal, heat = layer.end_thermal[side], layer.end_heat[side]
            slope = n * heat * x_X / (solid.kappa_e * d) if thermal == GIVEN_FLUX else 0.0
            q[i, 2] = heat if thermal == GIVEN_T else (slope - rest) / beta[0]
        T = q[i, 2]
        p = solid.pressure(T, x_X)
        if kind == CLAMPED:
            q[i, 0] = given
        elif kind == FREE:
            q[i, 1] = given + p
        else:
            Z = np.sqrt(solid.wave_modulus(T, p, given + p, x_X) * solid.m0)
            w_o = q[i, 1] - p - given - n * Z * q[i, 0]
            q[i, 0], q[i, 1] = -n * 0.5 * w_o / Z, given + p + 0.5 * w_o
