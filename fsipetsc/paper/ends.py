"""The outer ends of layers: of a gas an embedded boundary, which stands between the nodes of a
frame's grid and moves over it; of a solid its end node.

The ghost point is the first point of the grid at or beyond the boundary, delta in [0, 1) cells
outside. n is the outward normal, -1 left, 1 right. Outgoing characteristics keep their values in a
ghost point, with Z = rho c; else the scheme is unstable. docs/open-end.md derives the open end.
"""

import numpy as np

from fsipetsc.boundaries import Dirichlet, Open, Wall, clamped, free
from fsipetsc.equations.gas import of_sound
from fsipetsc.equations.vectors import choose
from fsipetsc.kernels.loops import each, number, pick, stop, when, whole
from fsipetsc.paper.stencils import halo_of_rates
from fsipetsc.scheme.plan import OFF_GRID

#: nodes that a formula may use, ghost point included
NODES = 8
#: least weight of the ghost point in the formula for data; in that for gradients from degree 4 on:
#: with less the viscous stress of the ghost point takes more than the time step gives
LEAST, LEAST_OF_GRADIENTS = 0.25, 0.3
#: order 1 of an open end fades out where viscosity is this fraction of c0 L; q_nn = 0 where alpha
#: is this fraction of a L
LONGEST = 0.25
#: of an insulated wall, by s, for q = s + 1 …: coefficients of eta_q in powers of delta
ETA = np.zeros((4, 3, 4))
ETA[0, 0, :2] = 0.0, 0.5
ETA[1, 0, :3] = 0.0882352941176471, 0.0883801777493091, -0.1766154718669562
ETA[2, 0] = 0.2222164620745679, -0.4850917636042938, 0.1267629370385567, 0.0198481621891904
ETA[3, :, :3] = (1.267, -2.9, 1.178), (-0.888, 1.872, -0.677), (0.193, -0.389, 0.131)
#: with narrow second derivatives
ETA_NARROW = ETA.copy()
ETA_NARROW[2, 0] = 0.2289158450015872, -0.4914033185443774, 0.1207498614024324, 0.0225285974796345


def distance(layer):
    """From the interface to the embedded boundary, in cells."""
    return np.absolute(layer.end_x - layer.frame[1]) / layer.h


def delta_of(layer):
    """How far the ghost point lies outside, in cells."""
    return number(layer.cells) - distance(layer)


def lagrange(delta, degree):
    """Lagrange weights and their derivatives at delta for the nodes 0, 1, ..., degree.

    Node 0 is the ghost point and the boundary lies delta cells inside of it; (4.26) is degree 2.
    """
    weights, slopes = [], []
    for k in range(degree + 1):
        value, denominator, slope = 1.0, 1.0, 0.0
        for m in (m for m in range(degree + 1) if m != k):
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
    is large enough: a constant one spoils the accuracy where the boundary is near the ghost point.
    """
    eta = np.maximum(0.0, least - weights[0])
    s, binomial = g, 1.0
    for k in range(1, degree + 1):
        binomial *= -(degree + 1.0 - k) / k
        s -= (weights[k] + eta * binomial) * v[k]
    return s / (weights[0] + eta)


def insulated_ghost(layer, T, delta):
    """T of the ghost point so that no heat flows through a wall at delta.

    The interpolant of degree s = p has zero slope there (Kreiss et al. 2004); differences of the
    orders s + 1 ... are added, with eta fitted to the error that D makes at its closure.
    """
    p, eta_of = layer.op.p, ETA_NARROW if layer.narrow else ETA
    last = p + 3 if p == 4 else p + 1
    _, slopes = lagrange(delta, p)
    for q in range(p + 1, last + 1):
        eta, binomial = 0.0, 1.0
        for coefficient in eta_of[p - 1, q - p - 1, ::-1]:
            eta = eta * delta + float(coefficient)
        slopes += [0.0] * (q + 1 - len(slopes))
        for k in range(q + 1):
            slopes[k] = slopes[k] + eta * binomial
            binomial *= -(q - k) / (k + 1.0)
    return -sum(slopes[k] * T[k] for k in range(1, last + 1)) / slopes[0]


class GasEnd:
    """An end of a gas. points: (rho, u, T) of the ghost point, and of points inside of it; data:
    what is given there. new: degree of the extrapolation that fills a new point. ghost(): (rho, u,
    T) of the ghost point. gradient(): (u, T) of it for gradients, where they are others.
    """

    new = 2
    gradient = None

    def __init__(self, layer):
        self.gas, self.layer, side = layer.material, layer, layer.side
        self.n, self.data, self.points = 2.0 * side - 1.0, layer.given[side], []
        self.degree, self.delta = layer.ends[side].degree or layer.op.p + 1, delta_of(layer)
        # who owns the next point to come in has these in its halo; no layer has fewer
        for k in range(min(NODES, halo_of_rates(layer.op))):
            rho, m, e = (layer.local[c, layer.ghost + (1 - 2 * side) * k] for c in range(3))
            self.points.append((rho, *self.gas.velocity_and_temperature(rho, m, e)))

    def given(self, c, data, least=LEAST):
        """Number c of the ghost point with which data are met at the boundary."""
        weights, _ = lagrange(self.delta, self.degree)
        values = [point[c] for point in self.points]
        return dirichlet_ghost(data, values, weights, self.degree, least)

    def fill(self, new=False):
        """Give the ghost point its values. new: it has none yet."""
        for_new = [0.0] * NODES, self.new + 1, 1.0  # of the highest difference, which vanishes
        if new:
            self.points[0] = tuple(dirichlet_ghost(0.0, v, *for_new) for v in zip(*self.points))
        rho, u, T = self.ghost()
        self.layer.local[:, self.layer.ghost] = rho, rho * u, self.gas.total_energy(rho, u, T)


class WallEnd(GasEnd):
    """An adiabatic no-slip wall: u = 0, T_X = 0, and p + n Z u keeps its value."""

    def ghost(self):
        law, (rho, u, T) = self.gas.law, self.points[0]
        Z, u_G = rho * np.sqrt(law.sound_speed_squared(rho, T)), self.given(1, 0.0)
        p_G = law.pressure(rho, T) - self.n * Z * (u_G - u)
        T_G = insulated_ghost(self.layer, [point[2] for point in self.points], self.delta)
        return law.density(p_G, T_G), u_G, T_G


class DirichletEnd(GasEnd):
    """Exact (rho, u, T): as many of them as come in along characteristics.

    Inflow faster than sound: all three; inflow: p - n Z u and the entropy rho - p/c^2; outflow:
    p - n Z u; faster than sound: nothing. What viscosity and conduction ask for besides is
    imposed in the gradients.
    """

    new = 3

    def ghost(self):
        law, n, data, (rho, u, T) = self.gas.law, self.n, self.data, self.points[0]
        rho1, u1, T1 = self.points[1]
        rho_D, u_D, T_D = (self.given(c, data[c]) for c in range(3))
        c2 = law.sound_speed_squared(rho1, T1)
        c, outflow = np.sqrt(c2), n * data[1] >= 0.0
        all_in = n * data[1] <= -np.sqrt(law.sound_speed_squared(data[0], data[2]))
        Z, p, p_D = rho1 * c, law.pressure(rho, T), law.pressure(rho_D, T_D)
        w_o, w_i = p + n * Z * u, p_D - n * Z * u_D
        entropy, p_G = np.where(outflow, rho - p / c2, rho_D - p_D / c2), 0.5 * (w_i + w_o)
        rho_G = entropy + p_G / c2
        slow = rho_G, n * (w_o - w_i) / (2.0 * Z), law.temperature_of(rho_G, p_G)
        slow = choose(outflow & (n * u1 >= c), (rho, u, T), slow)
        return choose(all_in, (rho_D, u_D, T_D), slow)

    def gradient(self):
        least = LEAST if self.degree < 4 else LEAST_OF_GRADIENTS
        return tuple(self.given(c, self.data[c], least) for c in (1, 2))


class OpenEnd(GasEnd):
    """Towards gas of p0, T0 and velocity u0: no sound comes in, up to order 0 or 1 in the
    viscosity; on outflow the entropy keeps its value, on inflow it is that of the gas beyond.
    """

    new = 1

    def beyond(self):
        """(rho0, c0, tau, alpha, p_T/cv, b, kappa) of the gas beyond, the part of order 1."""
        gas, law, p0, T0 = self.gas, self.gas.law, self.data[0], self.data[1]
        rho = law.density(p0, T0)
        c, cv, by_heat, tau, capacity = of_sound(law, rho, T0)
        mu, kappa = gas.viscosity(T0), gas.conductivity(T0)
        longest = LONGEST * c * self.layer.h * number(self.layer.cells)
        faded = 1.0 - np.maximum(mu, kappa / cv) / (rho * longest)
        part = self.data[3] * np.maximum(0.0, faded)
        b = 0.5 * (mu - tau * by_heat * kappa)
        return rho, c, tau, kappa / capacity, by_heat, b, kappa, part

    def carried(self, a, alpha, part):
        """How much of q_nn = 0 there is where gas flows out with a, 0 to 1."""
        layer = self.layer
        carrying = np.maximum(a, 0.0) * LONGEST * layer.h * number(layer.cells)
        return part * carrying / (carrying + alpha)

    def ghost(self):
        (p0, T0, u0), n, layer = (self.data[c] for c in range(3)), self.n, self.layer
        law, gamma = self.gas.law, layer.gamma
        rho0, c0, tau, alpha, by_heat, b, kappa, of_1 = self.beyond()
        (rho, u, T), (rho1, u1, T1), (rho2, _, T2) = self.points[:3]
        v1, c2 = n * (u1 - u0), law.sound_speed_squared(rho1, T1)
        p, p1 = law.pressure(rho, T), law.pressure(rho1, T1)
        Z, scale, m = rho1 * np.sqrt(c2), rho0 * c0 * c0 / gamma, 0.5 - 0.5 / gamma
        # Z v (1 + by_v) = simple wave + by_p (p - p0) + known
        by = of_1 / (rho0 * c0 * layer.h)
        by_v, by_p = by * np.maximum(b, 0.0), by * np.maximum(-b, 0.0)
        q_n = (T1 - T2 - tau * (p1 - law.pressure(rho2, T2))) / layer.h
        heat = self.carried(n * u1, alpha, of_1) * by_heat * kappa / (rho0 * c0) * q_n
        known = by_v * rho0 * c0 * v1 - by_p * (p1 - p0) + np.where(kappa > 0.0, heat, 0.0)
        # with p + n Z u, a quadratic equation for y, the pressure of the wave in units of scale
        share, rise, fall = Z / (rho0 * c0 * (1.0 + by_v)), (1.0 + m) / 6.0, (2.0 - m) / 3.0
        w_o = p - p0 + Z * n * (u - u0)
        free, wave = 1.0 + share * by_p, (w_o - share * known) / scale
        half = 0.5 * (free + share - fall * wave)
        y = wave / (half + np.sqrt(half * half + (free * fall + share * rise) * wave))
        sound = scale * y
        u_G = u0 + n * (w_o - sound) / Z
        in_, out = rho0 * (1.0 + y) ** (1.0 / gamma), rho + (p0 + sound - p) / c2
        rho_G = np.where(n * u_G >= 0.0, out, in_)
        slow = rho_G, u_G, law.temperature_of(rho_G, p0 + sound)
        slow = choose(n * u0 <= -c0, (rho0, u0, T0), slow)
        return choose(n * u1 >= np.sqrt(c2), (rho, u, T), slow)

    def gradient(self):
        """Heat and viscous stress are imposed there."""
        gas, law, layer, p0, T0 = self.gas, self.gas.law, self.layer, self.data[0], self.data[1]
        (rho, u, T), (rho1, u1, T1), (rho2, u2, T2) = self.points[:3]
        a = self.n * u
        imposed = (a < 0.0) | (a * a >= law.sound_speed_squared(rho1, T1))
        seen_u = np.where((gas.mu > 0.0) & imposed, 2.0 * u1 - u2, u)
        _, c0, tau, alpha, _, _, _, of_1 = self.beyond()
        p, p1, p2 = law.pressure(rho, T), law.pressure(rho1, T1), law.pressure(rho2, T2)
        q_n = T1 - T2 - tau * (p1 - p2)
        slow, conducted = np.maximum(1.0 + np.minimum(a, 0.0) / c0, 0.0), alpha / layer.h
        step = of_1 * slow * slow * tau * (p - p1) + self.carried(a, alpha, of_1) * q_n
        width = layer.h * number(layer.cells)
        lost = 0.5 * (np.sqrt(a * a + 4.0 * (alpha / width) ** 2) - a)
        at_rest = T0 + tau * (p - p0)
        seen_T = (conducted * (T1 + step) + lost * at_rest) / (conducted + lost)
        return seen_u, np.where(gas.kappa > 0.0, seen_T, T)


#: what a case says of an end of a gas -> its formulas
OF_GAS = {Wall: WallEnd, Open: OpenEnd, Dirichlet: DirichletEnd}


def fill_ghost(layer):
    """Fill the ghost point. All ranks do, those that need it from points in their halos."""
    layer.end(layer).fill()


def move_boundary(layer):
    """Let the ghost point be the first one at or beyond the boundary; OFF_GRID: 1 + the number of
    the layer if no point is left. All ranks of a layer decide alike.

    A point that comes in is extrapolated; where the boundary moves inwards the last interior point
    becomes the ghost point. Where cells are no number, the bounds on the step will tell.
    """
    side, active, outwards = layer.side, layer.active, 2 * layer.side - 1
    cells = distance(layer) - 1e-9
    with when(cells < 1e15):
        below = whole(cells)
        target = below + pick(number(below) < cells, 1, 0)
        size = layer.local.shape[1]
        for _ in each(size):
            stop(layer.cells >= target)
            exhausted = active[side] == (size - 1 if side else 0)
            with when(exhausted):
                layer.steps.results[OFF_GRID] = 1.0 + number(layer.number)
            stop(exhausted)
            active[side] = active[side] + outwards
            layer.end(layer).fill(new=True)
        with when((layer.cells > target) & (target >= layer.least - 1)):
            active[side] = active[1 - side] + outwards * target
            fill_ghost(layer)


def close_solid(layer):
    """Apply the conditions at the outer ends of a solid that this rank owns. An end that absorbs
    lets the characteristic sigma - p - n Z u leave, Z = m0 c.
    """
    solid, q, beta = layer.material, layer.local, [float(v) for v in layer.op.closure[0]]
    for side, end in enumerate(layer.ends):
        if end is None:
            continue
        i, given, heat = layer.active[side], layer.given[side, 0], layer.given[side, 4]
        step, n, d = 1 - 2 * side, 2.0 * side - 1.0, (1.0 - 2.0 * side) / layer.h
        with when((layer.own[0] <= i) & (i < layer.own[1])):
            x_X = sum(d * v * q[3, i + step * j] for j, v in enumerate(beta))
            rest = sum(v * q[2, i + step * j] for j, v in enumerate(beta) if j > 0)
            slope = n * heat * x_X / (solid.kappa_e * d) if end.heated == "heat_flux" else 0.0
            imposed = heat if end.heated == "T" else (slope - rest) / beta[0]
            T = np.where(solid.kappa_e > 0.0, imposed, q[2, i])
            u, sigma, p = q[0, i], q[1, i], solid.pressure(T, x_X)
            q[2, i] = T
            if isinstance(end, clamped):
                q[0, i] = given
            elif isinstance(end, free):
                q[1, i] = given + p
            else:
                Z = np.sqrt(solid.wave_modulus(T, p, given + p, x_X) * solid.m0)
                w_o = sigma - p - given - n * Z * u
                q[0, i], q[1, i] = -n * 0.5 * w_o / Z, given + p + 0.5 * w_o
