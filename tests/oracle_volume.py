"""Volume terms of the oracle of blocks: grids, metrics, rates of blocks with closed faces.

SCHEME-BLOCKS.md sections 1, 2, 5, 8. Arrays of a block have the shape (components, n_1, ..., n_d).
Rates are extensive: times the weights W of the nodes.
"""

from __future__ import annotations

from itertools import product
from math import comb
from typing import NamedTuple

import numpy as np
from oracle_formulas import (
    REST,
    State,
    along,
    cofactor,
    conserved,
    cross,
    det,
    dot,
    energy_and_stress,
    entropy_of,
    flux,
    gas_state,
    pair_flux,
    sbp,
    spread,
)


class Grid(NamedTuple):
    """Of a block at one time: places, velocities (d, ...), metrics a[axis, component, ...], a_t."""

    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    a_t: np.ndarray


class Volume:
    """Blocks of a problem one by one. ``of_node``, (block, node) -> particle, is filled by the
    class on top of it.
    """

    def __init__(self, problem):
        self.problem, self.blocks, self.d = problem, problem.blocks, len(problem.blocks[0].X)
        self.names = [b.name for b in self.blocks]
        self.axes, self.W, self.periods, self.linear = [], [], [], []
        self.solids, self.of_node = {}, {}
        for k, b in enumerate(self.blocks):
            periods = b.periods or (None,) * self.d
            made = [sbp(problem.order, n, p is not None) for n, p in zip(b.X.shape[1:], periods)]
            self.axes.append([self._matrices(*m) for m in made])
            self.W.append(np.array(np.meshgrid(*(m[1] for m in made), indexing="ij")).prod(axis=0))
            vectors = [np.zeros(self.d) if p is None else p for p in periods]
            self.periods.append(np.array(vectors, float))
            xi = np.meshgrid(*(np.arange(n) / n for n in b.X.shape[1:]), indexing="ij")
            self.linear.append(sum(spread(p, self.d) * x for p, x in zip(self.periods[k], xi)))
            if b.material.kind == "solid":
                G = np.swapaxes(self.slopes(k, b.X), 0, 1)  # G[component, axis] = D_axis X
                self.solids[k] = np.swapaxes(cofactor(G), 0, 1), det(G)

    @staticmethod
    def _matrices(D, weight):
        """(D, S, weight): S_il = 2 H D without the diagonal, which holds the boundary terms."""
        S = 2.0 * weight[:, None] * D
        np.fill_diagonal(S, 0.0)
        return D, S, weight

    def periodic(self, k, axis):
        return bool(self.blocks[k].periods) and self.blocks[k].periods[axis] is not None

    def derivative(self, k, f, axis):
        return along(self.axes[k][axis][0], f, axis, self.d)

    def boundary_flux_free(self, k, f, axis):
        """H D° f: the derivative without the flux through the ends."""
        _, S, weight = self.axes[k][axis]
        Q = 0.5 * (S + np.diag(S.sum(axis=1)))
        return along(Q / weight[:, None], f, axis, self.d) * self.W[k]

    # grids and metrics

    def slopes(self, k, x):
        """D_axis x for each axis, (d, d, ...), of places x, of which ``linear`` is not periodic."""
        y = x - self.linear[k]
        return np.array(
            [self.derivative(k, y, j) + spread(self.periods[k][j], self.d) for j in range(self.d)]
        )

    def metrics(self, k, x):
        """a[axis, component]: the area vectors of the logical axes, with sum D_axis a = 0."""
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

    def grids(self, q, t, given=None):
        """Of all blocks. given: {name: (displacement, velocity)} in the place of those that follow
        from the solids.
        """
        found = []
        for k, b in enumerate(self.blocks):
            if given and b.name in given:
                moved, v = given[b.name]
            elif b.material.kind == "solid":
                moved, v = q[b.name][: self.d], q[b.name][self.d : 2 * self.d]
            else:
                moved, v = (self._blended(k, q, t, part) for part in (0, 1))
            x = b.X + moved
            # bilinear in x at most: exact
            a_t = 0.5 * (self.metrics(k, x + v) - self.metrics(k, x - v))
            found.append(Grid(x, v, self.metrics(k, x), a_t))
        return found

    def _blended(self, k, q, t, part):
        """Displacement (part 0) or velocity (1) of a gas's grid: on vertices, then on edges, on
        faces, inside.
        """
        b, d = self.blocks[k], self.d
        n, f = b.X.shape[1:], np.zeros(b.X.shape, q[b.name].dtype)
        closed = [j for j in range(d) if not self.periodic(k, j)]
        for free in range(len(closed) + 1):
            for fixed in product((0, 1, None), repeat=len(closed)):
                if sum(side is None for side in fixed) != free:
                    continue
                where = [slice(None)] * d
                for j, side in zip(closed, fixed):
                    where[j] = {0: slice(0, 1), 1: slice(n[j] - 1, n[j]), None: slice(None)}[side]
                nodes = list(product(*(range(*w.indices(m)) for w, m in zip(where, n))))
                known = [self._source(k, node, q, t, part) for node in nodes]
                piece = f[(slice(None), *where)]
                if all(value is not None for value in known):
                    for node, value in zip(nodes, known):
                        f[(slice(None), *node)] = value
                elif free:
                    rest = piece.copy()
                    for j, side in zip(closed, fixed):
                        if side is None:
                            xi = np.arange(n[j]) / (n[j] - 1)
                            xi = xi.reshape([-1 if i == j else 1 for i in range(d)])
                            low, high = np.take(rest, [0], j + 1), np.take(rest, [-1], j + 1)
                            rest = rest - (1.0 - xi) * low - xi * high
                    piece -= rest
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
            motion = getattr(face.condition, "motion", REST)
            if motion is not REST:
                return motion.velocity(X, t) if part else motion.x(X, t) - X
        return None

    # gas

    def volume_rate(self, k, grid):
        """J_t, per node."""
        total, (b, w) = 0.0, self.volume_metrics(k, grid)
        for j, a in enumerate(b):
            total = total + dot(a, self.derivative(k, w, j))
            total = total + dot(w, self.derivative(k, a, j))
        return total

    def gas_terms(self, k, q, grid, t):
        """Rates of J, J rho, J rho u, J E, (d + 3, ...)."""
        b, d, W, R = self.blocks[k], self.d, self.W[k], np.zeros_like(q)
        m, s = b.material, gas_state(b.material, q)
        R[0] = W * self.volume_rate(k, grid)
        for j in range(d):
            R[1:] += self._convection(k, s, grid, j)
        if m.mu > 0.0 or m.kappa > 0.0:
            R[2:] += self._viscous(k, q[0], s, grid)
        if self.problem.dissipation > 0.0:
            R[1:] += self._gas_dissipation(k, s, grid)
        if m.force:
            f = spread(m.force, d)
            R[2:] += W * q[1] * np.array([*(f + 0.0 * s.u), dot(f, s.u)])
        return R

    def volume_metrics(self, k, grid):
        """Area vectors and velocities that make the volume flux g of two nodes."""
        return grid.a, grid.v

    def _convection(self, k, s, grid, j):
        """- sum_l S_il F(i, l) along axis j: i along one axis of an array, l along the next."""
        m, d, (b, w) = self.blocks[k].material, self.d, self.volume_metrics(k, grid)
        here, there = (lambda f: np.expand_dims(f, j - d)), (lambda f: np.expand_dims(f, j - d - 1))
        left, right = State(*map(here, s)), State(*map(there, s))
        a_l, a_r = here(grid.a[j]), there(grid.a[j])
        g = 0.5 * (dot(here(b[j]), there(w)) + dot(there(b[j]), here(w)))
        if self.problem.form == "entropy":
            F = pair_flux(m, left, right, 0.5 * (a_l + a_r), g)
        else:
            F = 0.5 * (flux(left, a_l, g) + flux(right, a_r, g))
        _, S, weight = self.axes[k][j]
        scaled = (S / weight[:, None]).reshape(*S.shape, *[1] * (d - j - 1))
        return -(scaled * F).sum(axis=j - d) * self.W[k]

    def _viscous(self, k, J, s, grid):
        """Of momentum and energy; gradients are those of the entropy variables u/T and -1/T."""
        m, d = self.blocks[k].material, self.d

        def gradient(f):
            return sum(grid.a[j] * self.derivative(k, f, j) for j in range(d)) / J

        w = gradient(-1.0 / s.T)
        gu = np.array([s.T * (gradient(u / s.T) + u * w) for u in s.u])
        one = np.eye(d).reshape(d, d, *[1] * d)
        tau = m.mu * (gu + np.swapaxes(gu, 0, 1) - 2.0 / 3.0 * np.trace(gu) * one)
        heat, total = m.kappa * s.T**2 * w, 0.0
        for j in range(d):
            traction = np.einsum("ij...,j...->i...", tau, grid.a[j])
            power = dot(traction, s.u) + dot(heat, grid.a[j])
            total = total + self.boundary_flux_free(k, np.array([*traction, power]), j)
        return total

    def _differences(self, k, j, q):
        """(Delta_q, means of the middle points, the least norm) along axis j."""
        weight = self.axes[k][j][2]
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
        return along(matrix.T / self.axes[k][j][2][:, None], F, j, self.d) * self.W[k]

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
        """F = (1/J0) sum D_axis x (x) A^axis."""
        A, J0 = self.solids[k]
        return np.einsum("jm...,jn...->mn...", self.slopes(k, x), A) / J0

    def elastic(self, k, x):
        """(W, P); without p_ref in three dimensions, where it is a force on faces."""
        b, F = self.blocks[k], self.deformation(k, x)
        W, P = energy_and_stress(b.material, F, b.material.p_ref if self.d < 3 else 0.0)
        if b.prestress is not None:
            S = np.reshape(b.prestress(b.X), F.shape)
            one = np.eye(self.d).reshape(self.d, self.d, *[1] * self.d)
            W, P = W + (S * (F - one)).sum(axis=(0, 1)), P + S
        return W, P

    def temperature(self, k, q):
        m, d = self.blocks[k].material, self.d
        W = self.elastic(k, self.blocks[k].X + q[:d])[0] / m.m0 if m.heat == "elastic" else 0.0
        return (q[-1] - 0.5 * dot(q[d:-1], q[d:-1]) - W) / m.alpha

    def solid_terms(self, k, q, grid, t):
        """(mass, force (d, ...), energy, what of it is stored in W)."""
        b, d, (A, J0) = self.blocks[k], self.d, self.solids[k]
        m, v, M = b.material, q[d:-1], self.W[k] * J0 * b.material.m0
        F, P = self.deformation(k, grid.x), self.elastic(k, grid.x)[1]
        T, cof = self.temperature(k, q), cofactor(F)
        P = P - m.gruneisen * m.m0 * m.alpha * T / det(F) * cof
        gradient = sum(A[j] * self.derivative(k, T, j) for j in range(d)) / J0
        conducted = m.kappa / det(F) * np.einsum("ki...,kj...,j...->i...", cof, cof, gradient)
        force, work, heat = 0.0, 0.0, 0.0
        for j in range(d):
            _, S, weight = self.axes[k][j]
            PA, scaled = np.einsum("mn...,n...->m...", P, A[j]), S / weight[:, None]
            force = force + self.boundary_flux_free(k, PA, j)
            pairs = dot(PA, along(scaled, v, j, d)) + dot(along(scaled, PA, j, d), v)
            work = work + 0.5 * self.W[k] * pairs
            heat = heat + self.boundary_flux_free(k, dot(conducted, A[j]), j)
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
        v = np.moveaxis(v, 1 + j, 1).real
        rise, fall = np.roll(v, -1, axis=1) - v, v - np.roll(v, 1, axis=1)
        s = (np.abs(rise - fall) / (np.abs(rise) + np.abs(fall) + small)).max(axis=0)
        if not self.periodic(k, j):
            s[[0, -1]] = 0.0
        return np.moveaxis(np.clip(2.5 * (s - 0.03), 0.0, 1.0), 0, j)

    def random_block(self, k, rng, size=1.0):
        """Unknowns node by node random; places of a solid by a few per cent of the spacing."""
        b, d = self.blocks[k], self.d
        noise, G = size * rng.uniform(-1.0, 1.0, (2 * d + 2, *b.X.shape[1:])), self.slopes(k, b.X)
        if b.material.kind == "gas":
            J, rho, T = det(G) * (1.0 + 0.2 * noise[0]), 1.0 + 0.2 * noise[1], 1.0 + 0.2 * noise[2]
            U = conserved(b.material, rho, 0.5 * noise[3 : 3 + d], T)
            return J * np.array([1.0 + 0.0 * J, *U])
        spacing = min(np.sqrt(dot(g, g)).min() / n for g, n in zip(G, b.X.shape[1:]))
        D, v, T = 0.05 * spacing * noise[:d], 0.3 * noise[d : 2 * d], 1.0 + 0.2 * noise[2 * d]
        W = self.elastic(k, b.X + D)[0] / b.material.m0 if b.material.heat == "elastic" else 0.0
        return np.array([*D, *v, 0.5 * dot(v, v) + W + b.material.alpha * T])

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
            turning = cross(x, momentum) if d == 3 else x[0] * momentum[1] - x[1] * momentum[0]
            found["angular"] = turning.sum(axis=space)
        return {**found, "momentum": momentum.sum(axis=space), "energy": energy.sum()}
