"""The outer end of a layer of gas: an embedded boundary, which stands between the nodes of a
frame's grid.

It stands at x_w; the ghost point is the first point of the grid at or beyond it, delta in [0, 1)
cells outside. ``nodes`` are lists of rho, u, T at the ghost point (number 0) and inside of it; n is
the outward normal, -1 left, 1 right. A part is a fsipetsc.paper.steps.Part.

Only what a condition gives is overwritten in a ghost point: outgoing characteristics keep their
values, with Z = rho c. (A ghost point with extrapolated density, or with all variables prescribed,
makes the scheme unstable.) docs/open-end.md says why each formula of the open end is as it is, with
measurements.
"""

import numpy as np

from fsipetsc.boundaries import Dirichlet, Open, Wall
from fsipetsc.equations.vectors import choose
from fsipetsc.kernels.loops import number

#: nodes that a formula may use, ghost point included
NODES = 8
#: least weight of the ghost point in the formula for data that are given; in that for gradients
#: from degree 4 on: with less the viscous stress of the ghost point takes more than the time step
#: gives
LEAST, LEAST_OF_GRADIENTS = 0.25, 0.3
#: order 1 of an open end fades out where viscosity is this fraction of c0 L; q_nn = 0 where alpha
#: is this fraction of a L
LONGEST = 0.25
#: degree of the extrapolation that fills a new point
NEW = {Wall: 2, Open: 1, Dirichlet: 3}
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


def distance(layer, side):
    """From the interface to the embedded boundary, in cells, from where the frame is: not by
    (4.25)."""
    return np.absolute(layer.end_x[side] - layer.x_interface) / layer.h


def beyond_boundary(layer, side):
    """delta: how far the ghost point lies outside, in cells."""
    return number(layer.hi - layer.lo) - distance(layer, side)


def depth_of(op):
    """Points inside the ghost point that are taken. Who owns the next point to come in must have
    them in its halo; no layer has fewer (fsipetsc.paper.layout)."""
    return min(NODES, op.halo) - 1


def fetch(part, ghost, side):
    """The nodes of a gas whose ghost point has the number ``ghost`` among its points."""
    step, q, found = 1 - 2 * side, part.local, []
    for k in range(depth_of(part.op) + 1):
        rho, m, e = (q[c, ghost + step * k] for c in range(3))
        found.append((rho, *part.law.velocity_and_temperature(rho, m, e)))
    return [list(values) for values in zip(*found, strict=True)]


def lagrange(delta, degree):
    """Lagrange weights and their derivatives at delta for the nodes 0, 1, ..., degree.

    Node 0 is the ghost point and the boundary lies delta cells inside of it; (4.26) is degree 2,
    with the sign of its third weight corrected so that the weights sum to one.
    """
    weights, slopes = [], []
    for k in range(degree + 1):
        value, denominator, slope = 1.0, 1.0, 0.0
        for m in range(degree + 1):
            if m != k:
                slope = slope * (delta - m) + value
                value *= delta - m
                denominator *= k - m
        weights.append(value / denominator)
        slopes.append(slope / denominator)
    return weights, slopes


def dirichlet_ghost(g, v, weights, degree, least):
    """Value of the ghost point (node 0) so that the interpolant takes the value g at the boundary.

    v[1..degree] are the nodes inside. The q-th difference is added with eta = max(0, least - L_0):
    the formula of Kreiss & Petersson (2006) as in (4.26), but with an eta that vanishes where L_0
    is large enough, because a constant one spoils the accuracy when the boundary is close to the
    ghost point.
    """
    eta = np.maximum(0.0, least - weights[0])
    s, binomial = g, 1.0
    for k in range(1, degree + 1):
        binomial *= -(degree + 1.0 - k) / k
        s -= (weights[k] + eta * binomial) * v[k]
    return s / (weights[0] + eta)


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
        for coefficient in (ETA_NARROW if op.narrow else ETA)[s - 1, q - s - 1, ::-1]:
            eta = eta * delta + float(coefficient)
        slopes += [0.0] * (q + 1 - len(slopes))
        for k in range(q + 1):
            slopes[k] = slopes[k] + eta * binomial
            binomial *= -(q - k) / (k + 1.0)
    return -sum(slopes[k] * T[k] for k in range(1, last + 1)) / slopes[0]


def given_ghost(part, layer, side, values, data, least=LEAST):
    """The ghost point's value with which data are met at the boundary."""
    degree = part.ends.degree[side]
    weights, _ = lagrange(beyond_boundary(layer, side), degree)
    return dirichlet_ghost(data, values, weights, degree, least)


def wall_ghost(part, layer, side, n, nodes):
    """(rho, u, T) at an adiabatic no-slip wall: u = 0, T_X = 0, and p + n Z u keeps its value."""
    gas, (rho, u, T) = part.law, (values[0] for values in nodes)
    Z, delta = rho * np.sqrt(gas.law.sound_speed_squared(rho, T)), beyond_boundary(layer, side)
    u_G = given_ghost(part, layer, side, nodes[1], 0.0)
    p_G = gas.law.pressure(rho, T) - n * Z * (u_G - u)
    T_G = insulated_ghost(part.op, nodes[2], delta)
    return gas.law.density(p_G, T_G), u_G, T_G


def exact_ghost(part, layer, side, n, nodes):
    """Exact (rho, u, T): as many of them as come in along characteristics.

    Inflow faster than sound: all three; inflow: p - n Z u and the entropy rho - p/c^2; outflow:
    p - n Z u; faster than sound: nothing. What viscosity and conduction ask for besides is
    imposed in the gradients.
    """
    gas, data = part.law, layer.end_data[side]
    (rho, u, T), (rho1, u1, T1) = ([values[k] for values in nodes] for k in range(2))
    rho_D = given_ghost(part, layer, side, nodes[0], data[0])
    u_D = given_ghost(part, layer, side, nodes[1], data[1])
    T_D = given_ghost(part, layer, side, nodes[2], data[2])
    c2 = gas.law.sound_speed_squared(rho1, T1)
    c, outflow = np.sqrt(c2), n * data[1] >= 0.0
    all_in = n * data[1] <= -np.sqrt(gas.law.sound_speed_squared(data[0], data[2]))
    Z, p, p_D = rho1 * c, gas.law.pressure(rho, T), gas.law.pressure(rho_D, T_D)
    w_o, w_i = p + n * Z * u, p_D - n * Z * u_D
    entropy, p_G = np.where(outflow, rho - p / c2, rho_D - p_D / c2), 0.5 * (w_i + w_o)
    rho_G = entropy + p_G / c2
    slow = rho_G, n * (w_o - w_i) / (2.0 * Z), gas.law.temperature_of(rho_G, p_G)
    slow = choose(outflow & (n * u1 >= c), (rho, u, T), slow)
    return choose(all_in, (rho_D, u_D, T_D), slow)


def open_ghost(part, layer, side, n, nodes):
    """Towards gas of p0, T0 and velocity u0: no sound comes in, up to order 0 or 1 in the
    viscosity; on outflow the entropy keeps its value, on inflow it is that of the gas beyond.
    """
    gas, (p0, T0, u0) = part.law, (layer.end_data[side, c] for c in range(3))
    rho0, c0, tau, alpha, by_heat, b, kappa, of_1 = gas_beyond(gas, layer, side)
    (rho, u, T), (rho1, u1, T1), (rho2, _, T2) = ([of[k] for of in nodes] for k in range(3))
    v1, c2 = n * (u1 - u0), gas.law.sound_speed_squared(rho1, T1)
    p, p1 = gas.law.pressure(rho, T), gas.law.pressure(rho1, T1)
    Z, scale, m = rho1 * np.sqrt(c2), rho0 * c0 * c0 / gas.gamma, 0.5 - 0.5 / gas.gamma
    # Z v (1 + by_v) = simple wave + by_p (p - p0) + known
    by = of_1 / (rho0 * c0 * layer.h)
    by_v, by_p = by * np.maximum(b, 0.0), by * np.maximum(-b, 0.0)
    q_n = (T1 - T2 - tau * (p1 - gas.law.pressure(rho2, T2))) / layer.h
    heat = carried(layer, n * u1, alpha, of_1) * by_heat * kappa / (rho0 * c0) * q_n
    known = by_v * rho0 * c0 * v1 - by_p * (p1 - p0) + np.where(kappa > 0.0, heat, 0.0)
    # with p + n Z u, a quadratic equation for y, the pressure of the wave in units of scale
    share, rise, fall = Z / (rho0 * c0 * (1.0 + by_v)), (1.0 + m) / 6.0, (2.0 - m) / 3.0
    w_o = p - p0 + Z * n * (u - u0)
    free, wave = 1.0 + share * by_p, (w_o - share * known) / scale
    half = 0.5 * (free + share - fall * wave)
    y = wave / (half + np.sqrt(half * half + (free * fall + share * rise) * wave))
    sound = scale * y
    u_G = u0 + n * (w_o - sound) / Z
    in_, out = rho0 * (1.0 + y) ** (1.0 / gas.gamma), rho + (p0 + sound - p) / c2
    rho_G = np.where(n * u_G >= 0.0, out, in_)
    slow = rho_G, u_G, gas.law.temperature_of(rho_G, p0 + sound)
    slow = choose(n * u0 <= -c0, (rho0, u0, T0), slow)
    return choose(n * u1 >= np.sqrt(c2), (rho, u, T), slow)


def open_gradient(part, layer, side, n, nodes):
    """(u, T) for the gradients at an open end: heat and viscous stress are imposed there."""
    gas = part.law
    (rho, u, T), (rho1, u1, T1), (rho2, u2, T2) = ([of[k] for of in nodes] for k in range(3))
    a, p0, T0 = n * u, layer.end_data[side, 0], layer.end_data[side, 1]
    imposed = (a < 0.0) | (a * a >= gas.law.sound_speed_squared(rho1, T1))
    seen_u = np.where((gas.mu > 0.0) & imposed, 2.0 * u1 - u2, u)
    _, c0, tau, alpha, _, _, _, of_1 = gas_beyond(gas, layer, side)
    p, p1, p2 = gas.law.pressure(rho, T), gas.law.pressure(rho1, T1), gas.law.pressure(rho2, T2)
    q_n = T1 - T2 - tau * (p1 - p2)
    slow, conducted = np.maximum(1.0 + np.minimum(a, 0.0) / c0, 0.0), alpha / layer.h
    step = of_1 * slow * slow * tau * (p - p1) + carried(layer, a, alpha, of_1) * q_n
    width = layer.h * number(layer.hi - layer.lo)
    lost = 0.5 * (np.sqrt(a * a + 4.0 * (alpha / width) ** 2) - a)
    at_rest = T0 + tau * (p - p0)
    seen_T = (conducted * (T1 + step) + lost * at_rest) / (conducted + lost)
    return seen_u, np.where(gas.kappa > 0.0, seen_T, T)


def gas_beyond(gas, layer, side):
    """(rho0, c0, tau, alpha, p_T/cv, b, kappa) of the gas beyond an open end, and how much of order
    1 there is, 0 to 1."""
    p0, T0 = layer.end_data[side, 0], layer.end_data[side, 1]
    rho = gas.law.density(p0, T0)
    c2, cv = gas.law.sound_speed_squared(rho, T0), gas.law.heat_capacity(rho, T0)
    c, by_heat = np.sqrt(c2), gas.law.pressure_by_temperature(rho, T0) / cv
    mu, kappa, tau = gas.viscosity(T0), gas.conductivity(T0), T0 * by_heat / (rho * rho * c2)
    alpha = kappa * gas.law.bulk_modulus(rho, T0) / (cv * rho * rho * c2)
    longest = LONGEST * c * layer.h * number(layer.hi - layer.lo)
    faded = 1.0 - np.maximum(mu, kappa / cv) / (rho * longest)
    part = layer.end_data[side, 3] * np.maximum(0.0, faded)
    return rho, c, tau, alpha, by_heat, 0.5 * (mu - tau * by_heat * kappa), kappa, part


def carried(layer, a, alpha, part):
    """How much of q_nn = 0 there is where gas flows out with a, 0 to 1."""
    carrying = np.maximum(a, 0.0) * LONGEST * layer.h * number(layer.hi - layer.lo)
    return part * carrying / (carrying + alpha)


def given_gradient(part, layer, side, n, nodes):
    """(u, T) for the gradients in viscous stress and conduction at a ghost point that is filled:
    those with which data are met at the boundary.
    """
    _, u, T = nodes
    data = layer.end_data[side]
    least = LEAST if part.ends.degree[side] < 4 else LEAST_OF_GRADIENTS
    seen_u = given_ghost(part, layer, side, u, data[1], least)
    return seen_u, given_ghost(part, layer, side, T, data[2], least)


#: what a case says of an end -> (rho, u, T) of the ghost point
GHOSTS = {Wall: wall_ghost, Open: open_ghost, Dirichlet: exact_ghost}
#: and (u, T) of the ghost point for gradients, where they are others
GRADIENTS = {Open: open_gradient, Dirichlet: given_gradient}
