"""Volume terms of the oracle of blocks: grids, metrics, rates of blocks with closed faces.

SCHEME-BLOCKS.md sections 1, 2, 5, 6, 8. Arrays of a block have the shape (components, n_1, ...,
n_d). Rates are extensive: times the weights W of the nodes.

Around an axis (kappa = 1) or a centre (kappa = 2) the last coordinate is r. The metrics carry the
weight r^kappa, so that sums are over a sector of unit angle or unit solid angle:

    grid   a^k = (b^k_1, r^kappa b^k_2), b^k the metrics of (z, s), s = r^(kappa + 1)/(kappa + 1)
    gas    momentum along r += p S - tau_hoop S, with S = sum_k D_k a^k_2; else S is 0
    solid  force along r -= kappa (J0 R^kappa / R) P_hoop, with the hoop stretch lambda = r / R

A block that goes from -r to r, with an even number of nodes and mirrored states, is the scheme with
a centre: none of its nodes is there, and the weight is |r|^kappa.
"""

from __future__ import annotations

from collections import namedtuple
from functools import partial
from itertools import product
from math import comb

import numpy as np
from oracle_formulas import (
    TINY,
    State,
    along,
    axis_of,
    cofactor,
    conserved,
    det,
    dot,
    elastic_energy,
    entropy_of,
    flux,
    gas_state,
    pair_flux,
    rate_of,
    spread,
    stress_of,
    three,
)

#: of a block at one time: places, velocities (d, ...), metrics a[axis, component, ...], their rates
Grid = namedtuple("Grid", "x v a a_t")


class Volume:
    """Blocks of a problem one by one. ``of_node``, (block, node) -> particle, is filled by the
    class on top of it.
    """

    def __init__(self, problem, kappa=0):
        self.problem, self.blocks, self.d = problem, problem.blocks, len(problem.blocks[0].X)
        self.kappa, self.names = kappa, [b.name for b in self.blocks]
        self.axes, self.W, self.periods, self.linear = [], [], [], []
        self.solids, self.of_node = {}, {}
        for k, b in enumerate(self.blocks):
            shape, periods = b.X.shape[1:], b.periods or (None,) * self.d
            around = [False] * (self.d - 1) + [kappa == 1 and b.X[-1].min() < 0.0 < b.X[-1].max()]
            kinds = zip(shape, (p is not None for p in periods), around)
            self.axes.append([axis_of(problem.order, *kind) for kind in kinds])
            weights = np.meshgrid(*(axis.weight for axis in self.axes[k]), indexing="ij")
            self.W.append(np.prod(weights, axis=0))
            vectors = [np.zeros(self.d) if p is None else p for p in periods]
            self.periods.append(np.array(vectors, float))
            xi = np.meshgrid(*(np.arange(n) / n for n in shape), indexing="ij")
            self.linear.append(sum(spread(p, self.d) * x for p, x in zip(self.periods[k], xi)))
            if b.material.kind == "solid":
                G = np.swapaxes(self.slopes(k, b.X), 0, 1)  # G[component, axis] = D_axis X
                A, J0 = np.swapaxes(cofactor(G), 0, 1), det(G)
                self.solids[k] = A * self.weight(b.X), J0 * self.weight(b.X)

    def periodic(self, k, axis):
        return bool(self.blocks[k].periods) and self.blocks[k].periods[axis] is not None

    def derivative(self, k, f, axis):
        return along(self.axes[k][axis].D, f, axis, self.d)

    def boundary_flux_free(self, k, f, axis):
        """H D° f: the derivative without the flux through the ends."""
        return along(self.axes[k][axis].flux_free, f, axis, self.d) * self.W[k]

    # grids and metrics

    def weight(self, x):
        """r^kappa (...); also of complex x, whose real part has the sign."""
        return (np.where(x[-1].real < 0.0, -1.0, 1.0) * x[-1]) ** self.kappa

    def flat(self, x):
        """(z, s) of places."""
        return np.array([*x[:-1], self.weight(x) * x[-1] / (self.kappa + 1.0)])

    def start(self, k):
        """A volume per logical volume."""
        return det(np.swapaxes(self.slopes(k, self.flat(self.blocks[k].X)), 0, 1))

    def slopes(self, k, x):
        """D_axis x for each axis, (d, d, ...), of places x, of which ``linear`` is not periodic."""
        y = x - self.linear[k]
        return np.array(
            [self.derivative(k, y, j) + spread(self.periods[k][j], self.d) for j in range(self.d)]
        )

    def metrics(self, k, x):
        """a[axis, component]: the area vectors of the logical axes."""
        a = self.flat_metrics(k, self.flat(x))
        a[:, -1] *= self.weight(x)
        return a

    def flat_metrics(self, k, x):
        """Those without weight, with sum D_axis a = 0."""
        if self.d == 1:
            return np.ones((1, *x.shape)) + 0.0 * x
        Dx = self.slopes(k, x)
        if self.d == 2:
            return np.array([[Dx[1, 1], -Dx[1, 0]], [-Dx[0, 1], Dx[0, 0]]])
        # a = curl(1/2 (y_m D y_l - y_l D y_m) + y_m D c_l - y_l D c_m) + D c_m x D c_l, x = y + c
        y, c, a = x - self.linear[k], self.periods[k], np.zeros_like(Dx)
        Dy = Dx - c.reshape(3, 3, 1, 1, 1)
        for n in range(3):
            m, l = (n + 1) % 3, (n + 2) % 3
            f = [
                0.5 * (y[m] * Dy[b, l] - y[l] * Dy[b, m]) + y[m] * c[b, l] - y[l] * c[b, m]
                for b in range(3)
            ]
            constant = np.cross(c[:, m], c[:, l])
            for i in range(3):
                j, o = (i + 1) % 3, (i + 2) % 3
                a[i, n] = self.derivative(k, f[o], j) - self.derivative(k, f[j], o) + constant[i]
        return a

    def moved(self, q, t, part):
        """By block the displacement (part 0) or the velocity (1) of its nodes."""
        of_solid = slice(part * self.d, (part + 1) * self.d)
        return [
            q[name][of_solid] if k in self.solids else self._blended(k, q, t, part)
            for k, name in enumerate(self.names)
        ]

    def grids(self, q, t):
        """Of all blocks."""
        found = []
        for k, (D, v) in enumerate(zip(self.moved(q, t, 0), self.moved(q, t, 1))):
            x = self.blocks[k].X + D
            a_t = np.imag(self.metrics(k, x + 1j * TINY * v)) / TINY
            found.append(Grid(x, v, self.metrics(k, x), a_t))
        return found

    def _blended(self, k, q, t, part):
        """Of a gas's grid: of vertices, then of edges, faces and the inside. Where not all nodes
        are moved by something it is the Boolean sum of the boundary.
        """
        X, d = self.blocks[k].X, self.d
        f, index = np.zeros(X.shape, q[self.names[k]].dtype), np.indices(X.shape[1:])
        sides = [(None,) if self.periodic(k, j) else (0, -1, None) for j in range(d)]
        for ends in sorted(product(*sides), key=lambda ends: ends.count(None)):
            slices = (slice(None) if e is None else slice(e, e + 1 or None) for e in ends)
            where = (slice(None), *slices)
            nodes = index[where].reshape(d, -1).T.tolist()
            known = [self._source(k, tuple(node), q, t, part) for node in nodes]
            if all(value is not None for value in known):
                f[where] = np.transpose(known).reshape(f[where].shape)
                continue
            rest = f[where]
            for j in range(d):
                if ends[j] is None and not self.periodic(k, j):
                    xi = np.linspace(0.0, 1.0, X.shape[1 + j]).reshape(-1, *[1] * (d - 1 - j))
                    low, high = rest.take([0], j + 1), rest.take([-1], j + 1)
                    rest = rest - (1.0 - xi) * low - xi * high
            f[where] = f[where] - rest
        return f

    def _source(self, k, node, q, t, part):
        """What moves a node of a gas's grid: a solid at its place, or a wall; or None."""
        p = self.of_node.get((k, node))
        if p is None:
            return None
        if p.solid:
            s, other = p.solid[0]
            return q[self.names[s]][(slice(part * self.d, (part + 1) * self.d), *other)]
        X = self.blocks[k].X[(slice(None), *node)]
        for face in p.outer:
            if motion := getattr(face.condition, "motion", None):
                return rate_of(motion, X, t) if part else motion(X, t) - X
        return None

    # gas

    def volume_flux(self, k, grid):
        """b^k and w = d(z, s)/dt, which make the volume flux g of two nodes."""
        w = np.array([*grid.v[:-1], self.weight(grid.x) * grid.v[-1]])
        return self.flat_metrics(k, self.flat(grid.x)), w

    def volume_rate(self, k, grid):
        """J_t, per node."""
        total, (b, w) = 0.0, self.volume_flux(k, grid)
        for j, a in enumerate(b):
            total = total + dot(a, self.derivative(k, w, j)) + dot(w, self.derivative(k, a, j))
        return total

    def hoop_area(self, k, grid):
        """S: 0 without an axis."""
        return sum(self.derivative(k, grid.a[j, -1], j) for j in range(self.d))

    def gas_terms(self, k, q, grid):
        """Rates of J, J rho, J rho u, J E, (d + 3, ...)."""
        b, d, W, R = self.blocks[k], self.d, self.W[k], np.zeros_like(q)
        m, s = b.material, gas_state(b.material, q)
        R[0] = W * self.volume_rate(k, grid)
        for j in range(d):
            R[1:] += self._convection(k, s, grid, j)
        R[-2] += W * s.p * self.hoop_area(k, grid)
        if m.mu > 0.0 or m.kappa > 0.0:
            R[2:] += self._viscous(k, q[0], s, grid)
        if self.problem.dissipation > 0.0:
            R[1:] += self._gas_dissipation(k, s, grid)
        if m.force:
            f = spread(m.force, d)
            R[2:] += W * q[1] * np.array([*(f + 0.0 * s.u), dot(f, s.u)])
        return R

    def _convection(self, k, s, grid, j):
        """- sum_l S_il F(i, l) along axis j: i along one axis of an array, l along the next."""
        m, d, (b, w) = self.blocks[k].material, self.d, self.volume_flux(k, grid)
        here, there = (lambda f: np.expand_dims(f, j - d)), (lambda f: np.expand_dims(f, j - d - 1))
        left, right = State(*map(here, s)), State(*map(there, s))
        a_l, a_r = here(grid.a[j]), there(grid.a[j])
        g = 0.5 * (dot(here(b[j]), there(w)) + dot(there(b[j]), here(w)))
        if self.problem.form == "entropy":
            F = pair_flux(m, left, right, 0.5 * (a_l + a_r), g)
        else:
            F = 0.5 * (flux(left, a_l, g) + flux(right, a_r, g))
        scaled = self.axes[k][j].S / self.axes[k][j].weight[:, None]
        scaled = scaled.reshape(*scaled.shape, *[1] * (d - j - 1))
        return -(scaled * F).sum(axis=j - d) * self.W[k]

    def _viscous(self, k, J, s, grid):
        """Of momentum and energy; gradients are those of the entropy variables u/T and -1/T, and
        all hoop rates together are e = u_r S / J.
        """
        m, d, S = self.blocks[k].material, self.d, self.hoop_area(k, grid)

        def gradient(f):
            return sum(grid.a[j] * self.derivative(k, f, j) for j in range(d)) / J

        w = gradient(-1.0 / s.T)
        gu = np.array([s.T * (gradient(u / s.T) + u * w) for u in s.u])
        e, one = s.u[-1] * S / J, np.eye(d).reshape(d, d, *[1] * d)
        mean = (np.trace(gu) + e) / 3.0
        tau = m.mu * (gu + np.swapaxes(gu, 0, 1) - 2.0 * mean * one)
        hoop = 2.0 * m.mu * (e / max(self.kappa, 1) - mean)
        heat, total = m.kappa * s.T**2 * w, 0.0
        for j in range(d):
            traction = np.einsum("ij...,j...->i...", tau, grid.a[j])
            power = dot(traction, s.u) + dot(heat, grid.a[j])
            total = total + self.boundary_flux_free(k, np.array([*traction, power]), j)
        total[-2] -= self.W[k] * hoop * S
        return total

    def _differences(self, k, j, q):
        """(Delta_q, means of the middle points, the least norm) along axis j."""
        weight = self.axes[k][j].weight
        n, periodic = len(weight), self.periodic(k, j)
        count, h = (n, 1.0 / n) if periodic else (n - q, 1.0 / (n - 1))
        delta, middle, least = np.zeros((count, n)), np.zeros((count, n)), np.ones(count)
        for i in range(count):
            for o in range(q + 1):
                delta[i, (i + o) % n] += (-1) ** (q - o) * comb(q, o)
                least[i] = min(least[i], weight[(i + o) % n] / h)
            middle[i, (i + q // 2) % n] += 0.5
            middle[i, (i + (q + 1) // 2) % n] += 0.5
        return delta, middle, least.reshape(-1, *[1] * (self.d - 1 - j))

    def _scatter(self, k, j, matrix, F):
        """W / weight_j matrix^T F."""
        return along(matrix.T / self.axes[k][j].weight[:, None], F, j, self.d) * self.W[k]

    def _gas_dissipation(self, k, s, grid):
        """-Delta^T sigma lambda U_w Delta w, w: entropy variables, lambda = |a.(u-v)| + c |a|."""
        m, d, total = self.blocks[k].material, self.d, 0.0
        first = m.gamma * m.cv - 0.5 * dot(s.u, s.u) / s.T - entropy_of(m, s)
        w, q = np.array([first, *(s.u / s.T), -1.0 / s.T]), self.problem.order // 2
        for j in range(d):
            delta, middle, least = self._differences(k, j, q)
            strength = self.problem.dissipation / 4.0**q * least
            dw, a = along(delta, w, j, d), along(middle, grid.a[j], j, d)
            rho, mean = along(middle, s.rho, j, d), along(middle, w, j, d)
            T = -1.0 / mean[-1]
            u, g = mean[1:-1] * T, along(middle, dot(grid.a[j], grid.v), j, d)
            speed = strength * (np.abs(dot(a, u) - g) + np.sqrt(m.gamma * m.R * T * dot(a, a)))
            H = m.cv * T + 0.5 * dot(u, u)
            mass = speed * rho / m.R * (dw[0] + dot(u, dw[1:-1]) + H * dw[-1])
            push = speed * rho * T * (dw[1:-1] + u * dw[-1])
            heat = speed * rho * m.cv * T**2 * dw[-1]
            F = np.array([mass, *(u * mass + push), H * mass + dot(u, push) + heat])
            total = total - self._scatter(k, j, delta, F)
        return total

    # solid

    def deformation(self, k, x):
        """F (3, 3, ...), (1/J0) sum D_axis x (x) A^axis and the hoop stretches."""
        (A, J0), d = self.solids[k], self.d
        F = three(np.einsum("jm...,jn...->mn...", self.slopes(k, x), A) / J0)
        for i in range(d, d + self.kappa):
            F[i, i] = x[-1] / self.blocks[k].X[-1]
        return F

    def elastic(self, k, F):
        """W of F; without p_ref in three dimensions, where it is a force on faces."""
        b, d = self.blocks[k], self.d
        W = elastic_energy(b.material, F, b.material.p_ref if d < 3 else 0.0)
        if b.prestress is not None:
            S, one = np.reshape(b.prestress(b.X), (d, d, *b.X.shape[1:])), three(0.0 * F[:0, :0])
            W = W + (S * (F - one)[:d, :d]).sum(axis=(0, 1))
        return W

    def stored(self, k, q):
        """W / m0, where it is part of the energy."""
        b = self.blocks[k]
        if b.material.heat == "coupled":
            return 0.0 * q[0]
        return self.elastic(k, self.deformation(k, b.X + q[: self.d])) / b.material.m0

    def solid_terms(self, k, q, grid):
        """(mass, force (d, ...), energy, what of it is stored in W)."""
        b, d, (A, J0) = self.blocks[k], self.d, self.solids[k]
        m, v, M = b.material, q[d:-1], self.W[k] * J0 * b.material.m0
        T = (q[-1] - 0.5 * dot(v, v) - self.stored(k, q)) / m.alpha
        F = self.deformation(k, grid.x)
        J, cof = det(F), cofactor(F)
        P = stress_of(partial(self.elastic, k), F) - m.gruneisen * m.m0 * m.alpha * T / J * cof
        gradient = sum(A[j] * self.derivative(k, T, j) for j in range(d)) / J0
        cof = cof[:d, :d]
        conducted = m.kappa / J * np.einsum("ki...,kj...,j...->i...", cof, cof, gradient)
        force, work, heat = 0.0, 0.0, 0.0
        for j in range(d):
            PA = np.einsum("mn...,n...->m...", P[:d, :d], A[j])
            force = force + self.boundary_flux_free(k, PA, j)
            work = work + self.W[k] * dot(PA, self.derivative(k, v, j))
            heat = heat + self.boundary_flux_free(k, dot(conducted, A[j]), j)
        work = work + dot(v, force)
        if self.kappa:  # what hoops take from the motion they store or gain as heat
            force[-1] -= self.kappa * self.W[k] * J0 / b.X[-1] * P[d, d]
        stored = work - dot(v, force) if m.heat == "elastic" else 0.0 * work
        energy = work + heat
        if self.problem.dissipation > 0.0 or self.problem.shock > 0.0:
            lost, warmed = self._solid_dissipation(k, v, A)
            force, energy = force + lost, energy + dot(v, lost) + warmed
        if m.force:
            f = M * spread(m.force, d)
            force, energy = force + f, energy + dot(f, v)
        return M, force, energy, stored

    def _solid_dissipation(self, k, v, A):
        """Force, and the heat of what it takes from the motion, in the middle of a difference:
        everywhere with differences of order q, and at shocks with those of order 1 in their place.
        """
        m, d, force, heat = self.blocks[k].material, self.d, 0.0, 0.0
        q, shock = self.problem.order // 2, self.problem.shock
        usual, fast = self.problem.dissipation / 4.0**q, np.sqrt((2.0 * m.mu_e + m.lambda_e) / m.m0)
        for j in range(d):
            steep = np.moveaxis(self._steepness(v, 0.02 * fast, k, j), j, 0)
            for order, a, b in ((q, usual, -usual * (shock > 0.0)), (1, 0.0, 0.7 * shock)):
                delta, middle, least = self._differences(k, j, order)
                most = np.moveaxis(np.array([steep[row != 0.0].max(axis=0) for row in delta]), 0, j)
                area, dv = along(middle, A[j], j, d), along(delta, v, j, d)
                size = (a + b * most) * least * fast * m.m0 * np.sqrt(dot(area, area))
                force = force - self._scatter(k, j, delta, size * dv)
                heat = heat + self._scatter(k, j, middle, size * dot(dv, dv))
        return force, heat

    def _steepness(self, v, small, k, j):
        """alpha: 0 in smooth motion along axis j, 1 at shocks."""
        v = np.moveaxis(v, 1 + j, 1)
        rise, fall = np.roll(v, -1, axis=1) - v, v - np.roll(v, 1, axis=1)
        s = (np.abs(rise - fall) / (np.abs(rise) + np.abs(fall) + small)).max(axis=0)
        if not self.periodic(k, j):
            s[[0, -1]] = 0.0
        return np.moveaxis(np.clip(2.5 * (s - 0.03), 0.0, 1.0), 0, j)

    def random_block(self, k, rng, size=1.0):
        """Unknowns node by node random; places of a solid by a few per cent of the spacing."""
        b, d = self.blocks[k], self.d
        noise, G = size * rng.uniform(-1.0, 1.0, (2 * d + 2, *b.X.shape[1:])), self.slopes(k, b.X)
        rho, T = 1.0 + 0.2 * noise[1], 1.0 + 0.2 * noise[2 * d]
        if b.material.kind == "gas":
            U = conserved(b.material, rho, 0.5 * noise[2 : 2 + d], T)
            return self.start(k) * (1.0 + 0.2 * noise[0]) * np.array([1.0 + 0.0 * rho, *U])
        spacing = min(np.sqrt(dot(g, g)).min() / n for g, n in zip(G, b.X.shape[1:]))
        q = np.array([*(0.05 * spacing * noise[:d]), *(0.3 * noise[d : 2 * d]), 0.0 * T])
        q[-1] = 0.5 * dot(q[d:-1], q[d:-1]) + self.stored(k, q) + b.material.alpha * T
        return q

    def sums(self, k, q, x):
        """Sums over a block: momentum, energy, angular momentum about 0; of a gas mass, entropy."""
        m, d, W, space = self.blocks[k].material, self.d, self.W[k], tuple(range(-self.d, 0))
        if m.kind == "gas":
            s, M = gas_state(m, q), W * q[1]
            momentum, energy = M * s.u, W * q[-1]
            found = {"mass": M.sum(), "entropy": (M * entropy_of(m, s)).sum()}
        else:
            M = W * self.solids[k][1] * m.m0
            momentum, energy, found = M * q[d:-1], M * q[-1], {}
        if d > 1:
            found["angular"] = np.cross(x, momentum, axis=0).sum(axis=space)
        return {**found, "momentum": momentum.sum(axis=space), "energy": energy.sum()}
