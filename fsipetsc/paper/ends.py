"""The outer ends: embedded boundaries of gases, with their ghost points, and ends of a solid.

An embedded boundary stands at x_w; the ghost point is the first point of the frame's grid at or
beyond it, delta in [0, 1) cells outside. Only what the condition gives is overwritten there:
outgoing characteristics keep their values, with Z = rho c. (A ghost point with extrapolated
density, or with all variables prescribed, makes the scheme unstable.) docs/open-end.md says why
each formula is as it is, with measurements.

``nodes`` are lists of rho, u, T at the ghost point (number 0) and inside of it; n is the outward
normal, -1 left, 1 right. A part is a fsipetsc.paper.steps.Part.
"""

from dataclasses import dataclass

import numpy as np

from fsipetsc.boundaries import Boundary, Open, Wall, clamped, free
from fsipetsc.equations.vectors import choose
from fsipetsc.kernels.loops import each, named, number, pick, stop, when, whole
from fsipetsc.problem import Problem
from fsipetsc.scheme.plan import EXHAUSTED

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


@dataclass(frozen=True)
class Ends:
    """What a case says of the ends of a layer, left and right: facts of a procedure.

    kind: the class of what stands there, None at an interface. degree: of the formulas of an
    embedded boundary. heated: "T" or "heat_flux" where that is given, else "".
    """

    kind: tuple[type[Boundary] | None, ...]
    degree: tuple[int, ...]
    heated: tuple[str, ...]


def ends_of(problem: Problem, k: int, order: int) -> Ends:
    """The ends of layer k, with the operator of this interior order."""
    found = [problem.end(k, side) for side in (0, 1)]
    return Ends(
        tuple(None if end is None else type(end) for end in found),
        tuple(0 if end is None else end.degree or order // 2 + 1 for end in found),
        tuple("" if end is None else end.heated for end in found),
    )


def outer_side(ends: Ends) -> int:
    """Where the embedded boundary of a gas stands: 0 left, 1 right."""
    return 1 if ends.kind[0] is None else 0


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
        rho, m, e = (q[ghost + step * k, c] for c in range(3))
        found.append((rho, *part.law.velocity_and_temperature(rho, m, e)))
    return [list(values) for values in zip(*found, strict=True)]


def fill_ghost(part, side, new=False):
    """Give the ghost point its values, where a rank has the points that this takes: all who need it
    do. new: it has no values yet.
    """
    layer, n = part.layers[0], part.local.shape[0]
    ghost = named((layer.hi if side else layer.lo) - (layer.own_lo - layer.halo_lo))
    last = ghost + (1 - 2 * side) * depth_of(part.op)
    with when((0 <= ghost) & (ghost < n) & (0 <= last) & (last < n)):
        rho, u, T = ghost_values(part, layer, ghost, side, new)
        q, energy = part.local, part.law.total_energy(rho, u, T)
        q[ghost, 0], q[ghost, 1], q[ghost, 2] = rho, rho * u, energy


def ghost_values(part, layer, ghost, side, new):
    """(rho, u, T) of the ghost point."""
    kind, nodes, n = part.ends.kind[side], fetch(part, ghost, side), 2.0 * side - 1.0
    if new:
        degree = {Wall: NEW_WALL, Open: NEW_OPEN}.get(kind, NEW_DIRICHLET)
        for values in nodes:  # without data the highest difference is left, which vanishes
            values[0] = dirichlet_ghost(0.0, values, [0.0] * NODES, degree + 1, 1.0)
    formula = {Wall: wall, Open: open_end}.get(kind, given_data)
    return formula(part, layer, side, n, nodes)


def gradient_values(part, ghost, side):
    """(u, T) for the gradients in viscous stress and conduction at a ghost point that is filled."""
    layer, (rho, u, T) = part.layers[0], fetch(part, ghost, side)
    if part.ends.kind[side] is Open:
        return open_gradients(part.law, layer, side, 2.0 * side - 1.0, (rho, u, T))
    degree, data = part.ends.degree[side], layer.end_data[side]
    weights, _ = lagrange(beyond_boundary(layer, side), degree)
    # less, and the viscous stress of the ghost point takes more than the time step gives
    least = LEAST if degree < 4 else 0.3
    seen_u = dirichlet_ghost(data[1], u, weights, degree, least)
    return seen_u, dirichlet_ghost(data[2], T, weights, degree, least)


# formulas


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


# wall


def wall(part, layer, side, n, nodes):
    """Adiabatic no-slip wall: u = 0, T_X = 0, and p + n Z u keeps its value."""
    gas, (rho, u, T) = part.law, (values[0] for values in nodes)
    Z, delta = rho * np.sqrt(gas.law.sound_speed_squared(rho, T)), beyond_boundary(layer, side)
    degree = part.ends.degree[side]
    u_G = dirichlet_ghost(0.0, nodes[1], lagrange(delta, degree)[0], degree, LEAST)
    p_G = gas.law.pressure(rho, T) - n * Z * (u_G - u)
    T_G = insulated_ghost(part.op, nodes[2], delta)
    return gas.law.density(p_G, T_G), u_G, T_G


# given data


def given_data(part, layer, side, n, nodes):
    """Exact (rho, u, T): as many of them as come in along characteristics.

    Inflow faster than sound: all three; inflow: p - n Z u and the entropy rho - p/c^2; outflow: p -
    n Z u; faster than sound: nothing. What viscosity and conduction ask for besides is imposed in
    the gradients.
    """
    gas, degree, data = part.law, part.ends.degree[side], layer.end_data[side]
    weights, _ = lagrange(beyond_boundary(layer, side), degree)
    (rho, u, T), (rho1, u1, T1) = ([values[k] for values in nodes] for k in range(2))
    rho_D = dirichlet_ghost(data[0], nodes[0], weights, degree, LEAST)
    u_D = dirichlet_ghost(data[1], nodes[1], weights, degree, LEAST)
    T_D = dirichlet_ghost(data[2], nodes[2], weights, degree, LEAST)
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


# open end


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


def open_end(part, layer, side, n, nodes):
    """Towards gas of p0, T0 and velocity u0: no sound comes in, up to order 0 or 1 in the
    viscosity; on outflow the entropy keeps its value, on inflow it is that of the gas beyond.
    end_data = (p0, T0, u0, order).
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
    return choose(n * u1 >= np.sqrt(c2), (rho, u, T), choose(n * u0 <= -c0, (rho0, u0, T0), slow))


def open_gradients(gas, layer, side, n, nodes):
    """(u, T) for the gradients at an open end: heat and viscous stress are imposed there."""
    (rho, u, T), (rho1, u1, T1), (rho2, u2, T2) = ([of[k] for of in nodes] for k in range(3))
    a, p0, T0 = n * u, layer.end_data[side, 0], layer.end_data[side, 1]
    imposed = (a < 0.0) | (a * a >= gas.law.sound_speed_squared(rho1, T1))
    seen_u = np.where((gas.mu > 0.0) & imposed, 2.0 * u1 - u2, u)
    _, c0, tau, alpha, _, _, _, part = gas_beyond(gas, layer, side)
    p, p1, p2 = gas.law.pressure(rho, T), gas.law.pressure(rho1, T1), gas.law.pressure(rho2, T2)
    q_n = T1 - T2 - tau * (p1 - p2)
    slow, conducted = np.maximum(1.0 + np.minimum(a, 0.0) / c0, 0.0), alpha / layer.h
    step = part * slow * slow * tau * (p - p1) + carried(layer, a, alpha, part) * q_n
    width = layer.h * number(layer.hi - layer.lo)
    lost = 0.5 * (np.sqrt(a * a + 4.0 * (alpha / width) ** 2) - a)
    at_rest = T0 + tau * (p - p0)
    seen_T = (conducted * (T1 + step) + lost * at_rest) / (conducted + lost)
    return seen_u, np.where(gas.kappa > 0.0, seen_T, T)


# a boundary that moves over the grid


def move_boundary(part, side, results):
    """Let the ghost point be the first one at or beyond the boundary; results[EXHAUSTED]: 1 + the
    number of the layer if no point is left.

    A point that comes in is extrapolated and becomes the ghost point, the old one keeps its value;
    where the boundary moves inwards the last interior point becomes the ghost point. All ranks of a
    layer decide alike. Where the cells are not a number, the bounds on the step will tell.
    """
    layer = part.layers[0]
    cells = distance(layer, side) - 1e-9
    with when(cells < 1e15):
        below = whole(cells)
        target = below + pick(number(below) < cells, 1, 0)
        for _ in each(layer.n):
            stop(layer.hi - layer.lo >= target)
            exhausted = layer.hi == layer.n - 1 if side else layer.lo == 0
            with when(exhausted):
                results[EXHAUSTED] = 1.0 + number(layer.number)
            stop(exhausted)
            if side:
                layer.hi = layer.hi + 1
            else:
                layer.lo = layer.lo - 1
            fill_ghost(part, side, new=True)
        with when((layer.hi - layer.lo > target) & (target >= layer.least - 1)):
            if side:
                layer.hi = layer.lo + target
            else:
                layer.lo = layer.hi - target
            fill_ghost(part, side)


# solid


def close_solid(part):
    """Apply the conditions at the outer ends of a solid that this rank owns.

    Clamped: end_data = (u,). Free, absorbing: (sigma - p,), the latter of the solid at rest beyond
    the end: the characteristic that leaves, sigma - p - n Z u, Z = m0 c, keeps its value.
    """
    layer = part.layers[0]
    for side in range(2):
        if part.ends.kind[side] is not None:
            end = layer.hi if side else layer.lo
            with when((layer.own_lo <= end) & (end < layer.own_hi)):
                close_end(part, layer, side, named(end - layer.own_lo))


def close_end(part, layer, side, i):
    """The same of the end that is point i of those that this rank owns."""
    solid, q, kind, heated = part.law, part.owned, part.ends.kind[side], part.ends.heated[side]
    step, n, beta = 1 - 2 * side, 2.0 * side - 1.0, part.op.closure[0]
    given, heat, d = layer.end_data[side, 0], layer.end_heat[side], -n / layer.h
    x_X = sum(d * v * q[i + step * j, 3] for j, v in enumerate(beta))
    rest = sum(v * q[i + step * j, 2] for j, v in enumerate(beta) if j > 0)
    slope = n * heat * x_X / (solid.kappa_e * d) if heated == "heat_flux" else 0.0
    imposed = heat if heated == "T" else (slope - rest) / beta[0]
    T = np.where(solid.kappa_e > 0.0, imposed, q[i, 2])
    u, sigma, p = q[i, 0], q[i, 1], solid.pressure(T, x_X)
    q[i, 2] = T
    if kind is clamped:
        q[i, 0] = given
    elif kind is free:
        q[i, 1] = given + p
    else:
        Z = np.sqrt(solid.wave_modulus(T, p, given + p, x_X) * solid.m0)
        w_o = sigma - p - given - n * Z * u
        q[i, 0], q[i, 1] = -n * 0.5 * w_o / Z, given + p + 0.5 * w_o
