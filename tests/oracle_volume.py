"""Volume terms of the oracle of blocks: rates of single blocks with closed faces.

Source: docs/derivation.md. Rates are extensive: times the weights W of the nodes.

Around an axis or a centre (oracle_grid.py) hoops give and take:

    gas    momentum along r += p S - tau_hoop S, with S = sum_k D_k a^k_2; else S is 0
    solid  force along r -= kappa (J0 R^kappa / R) P_hoop, with the hoop stretch lambda = r / R

A constant force on a gas acts node by node, as in the divergence form. That of the entropy form is
made pair by pair: test_gravity.py has what it keeps."""

from functools import partial
from itertools import product
from math import comb

import numpy as np
import oracle_formulas as formulas
from oracle_formulas import State, along, conserved, det, dot, entropy_of, flux, gas_state, spread
from oracle_grid import Grids


class Volume(Grids):
    """Rates, random states and sums of blocks."""

    def gas_terms(self, k, q, grid):
        """Rates of J, J rho, J rho u, J E, (d + 3, ...)."""
        b, d, W, R = self.blocks[k], self.d, self.W[k], np.zeros_like(q)
        m, s = b.material, gas_state(b.material, q)
        R[0] = W * self.volume_rate(k, grid)
        for j in range(d):
            R[1:] += self._convection(k, s, grid, j) * W
        R[-2] += W * s.p * self.hoop_area(k, grid)
        if m.mu > 0.0 or m.kappa > 0.0:
            R[2:] += self._viscous(k, q[0], s, grid)
        if self.problem.dissipation > 0.0:
            R[1:] += self._gas_dissipation(k, s, grid)
        if m.force:
            assert self.problem.form == "divergence"
            f = spread(m.force, d)
            R[2:] += W * q[1] * np.array([*(f + 0.0 * s.u), dot(f, s.u)])
        return R

    def _convection(self, k, s, grid, j):
        """- sum_l S_il F(i, l) along axis j. The part alpha of a pair's flux, the largest from i
        to l, goes through the links between them, with a Lax-Friedrichs flux on each link."""
        axis, m, d, shock = self.axes[k][j], self.blocks[k].material, self.d, self.problem.shock
        n, periodic, (b, w) = len(axis.weight), self.periodic(k, j), self.volume_flux(k, grid)
        steep = np.moveaxis(self._steep_gas(k, s, j, grid), j, 0)
        front = lambda f: np.moveaxis(f, j - d, 0)  # noqa: E731
        s, a, b, w = State(*map(front, s)), *map(front, (grid.a[j], b[j], w))
        state = [State(*(f[i] for f in s)) for i in range(n)]
        R, A, G = np.zeros((n, d + 2, *s.rho.shape[1:])), np.zeros_like(a), np.zeros_like(s.rho)
        for i, distance in product(range(n), range(1, n // 2 if periodic else n)):
            way = [(i + o) % n for o in range(distance + 1)]
            l = way[-1]
            if axis.S[i, l] == 0.0 or (l < i and not periodic):
                continue
            g = 0.5 * (dot(b[i], w[l]) + dot(b[l], w[i]))
            through_links = axis.S[i, l] * steep[way].max(axis=0)
            F = (axis.S[i, l] - through_links) * self._pair(k, state[i], state[l], a[i], a[l], g)
            R[i], R[l] = R[i] - F, R[l] + F
            A[way[:-1]] += through_links * 0.5 * (a[i] + a[l])
            G[way[:-1]] += through_links * g
        for i in range(n if periodic else n - 1) if shock > 0.0 else ():
            l, sides = (i + 1) % n, (state[i], state[(i + 1) % n])
            speeds = (
                np.abs(dot(A[i], x.u) - G[i]) + np.sqrt(m.gamma * m.R * x.T * dot(A[i], A[i]))
                for x in sides
            )
            here, there = (conserved(m, x.rho, x.u, x.T) for x in sides)
            F = self._pair(k, *sides, A[i], A[i], G[i])
            F = F - 0.5 * shock * np.maximum(*speeds) * (there - here)
            R[i], R[l] = R[i] - F, R[l] + F
        return np.moveaxis(R, 0, j - d) / axis.weight.reshape(-1, *[1] * (d - 1 - j))

    def _pair(self, k, left, right, a_l, a_r, g):
        """The flux of two nodes, in the form of the problem."""
        if self.problem.form == "entropy":
            return formulas.pair_flux(self.blocks[k].material, left, right, 0.5 * (a_l + a_r), g)
        return 0.5 * (flux(left, a_l, g) + flux(right, a_r, g))

    def _viscous(self, k, J, s, grid):
        """Of momentum and energy; gradients are those of the entropy variables u/T and -1/T; the
        hoop rates together are e = u_r S / J."""
        m, d, S = self.blocks[k].material, self.d, self.hoop_area(k, grid)

        def gradient(f):
            return sum(grid.a[j] * self.derivative(k, f, j) for j in range(d)) / J

        w = gradient(-1.0 / s.T)
        gu = np.array([s.T * (gradient(u / s.T) + u * w) for u in s.u])
        e, one = s.u[-1] * S / J, np.eye(d).reshape(d, d, *[1] * d)
        mean = (np.trace(gu) + e) / 3.0
        mu, kappa = m.mu * s.T ** m.powers[0], m.kappa * s.T ** m.powers[1]
        tau = mu * (gu + np.swapaxes(gu, 0, 1) - 2.0 * mean * one)
        hoop = 2.0 * mu * (e / max(self.kappa, 1) - mean)
        heat, total = kappa * s.T**2 * w, 0.0
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
        points = [np.roll(np.eye(n), o, axis=1)[:count] for o in range(q + 1)]
        delta = sum((-1) ** (q - o) * comb(q, o) * point for o, point in enumerate(points))
        middle = 0.5 * (points[q // 2] + points[(q + 1) // 2])
        least = np.min([np.ones(count), *(point @ weight / h for point in points)], axis=0)
        return delta, middle, least.reshape(-1, *[1] * (self.d - 1 - j))

    def _scatter(self, k, j, matrix, F):
        """W / weight_j matrix^T F."""
        return along(matrix.T / self.axes[k][j].weight[:, None], F, j, self.d) * self.W[k]

    def _gas_dissipation(self, k, s, grid):
        """-Delta^T sigma (1 - alpha) lambda U_w Delta w / (1 + eta), w: entropy variables, eta: the
        sum of squares of changes: of rho over rho, u over sqrt(R T), e over sqrt(cv R) T."""
        m, d, total = self.blocks[k].material, self.d, 0.0
        first = m.gamma * m.cv - 0.5 * dot(s.u, s.u) / s.T - entropy_of(m, s)
        w, q = np.array([first, *(s.u / s.T), -1.0 / s.T]), self.problem.order // 2
        for j in range(d):
            delta, middle, least = self._differences(k, j, q)
            wide = 1.0 - self._largest(self._steep_gas(k, s, j, grid), delta, j)
            strength = self.problem.dissipation / 4.0**q * least * wide
            dw, a = along(delta, w, j, d), along(middle, grid.a[j], j, d)
            rho, mean = along(middle, s.rho, j, d), along(middle, w, j, d)
            T = -1.0 / mean[-1]
            u, g = mean[1:-1] * T, along(middle, dot(grid.a[j], grid.v), j, d)
            speed = strength * (np.abs(dot(a, u) - g) + np.sqrt(m.gamma * m.R * T * dot(a, a)))
            H = m.cv * T + 0.5 * dot(u, u)
            mass = (dw[0] + dot(u, dw[1:-1]) + H * dw[-1]) / m.R
            push, heat = T * (dw[1:-1] + u * dw[-1]), m.cv * T**2 * dw[-1]
            eta = mass**2 + dot(push, push) / (m.R * T) + heat**2 / (m.cv * m.R * T**2)
            F = np.array([mass, *(u * mass + push), H * mass + dot(u, push) + heat])
            F = speed * rho * F / (1.0 + eta)
            total = total - self._scatter(k, j, delta, F)
        return total

    # solid

    def deformation(self, k, x):
        """F (3, 3, ...), (1/J0) sum D_axis x (x) A^axis and the hoop stretches."""
        (A, J0), d = self.solids[k], self.d
        F = formulas.three(np.einsum("jm...,jn...->mn...", self.slopes(k, x), A) / J0)
        for i in range(d, d + self.kappa):
            F[i, i] = x[-1] / self.blocks[k].X[-1]
        return F

    def elastic(self, k, F):
        """W of F; without p_ref in three dimensions, where it is a force on faces."""
        b, d = self.blocks[k], self.d
        W = formulas.elastic_energy(b.material, F, b.material.p_ref if d < 3 else 0.0)
        if b.prestress is not None:
            S = np.reshape(b.prestress(b.X), (d, d, *b.X.shape[1:]))
            one = formulas.three(0.0 * F[:0, :0])
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
        J, cof = det(F), formulas.cofactor(F)
        P = formulas.stress_of(partial(self.elastic, k), F)
        P = P - m.gruneisen * m.m0 * m.alpha * T / J * cof
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
            steep = self._steepness(v, k, j, 0.02 * fast)
            for order, a, b in ((q, usual, -usual * (shock > 0.0)), (1, 0.0, 0.7 * shock)):
                delta, middle, least = self._differences(k, j, order)
                most = self._largest(steep, delta, j)
                area, dv = along(middle, A[j], j, d), along(delta, v, j, d)
                size = (a + b * most) * least * fast * m.m0 * np.sqrt(dot(area, area))
                force = force - self._scatter(k, j, delta, size * dv)
                heat = heat + self._scatter(k, j, middle, size * dot(dv, dv))
        return force, heat

    def _steep_gas(self, k, s, j, grid):
        """alpha of a gas along axis j, from its density, its pressure, which counts over p + p_inf,
        and its velocity through the areas of the axis, where it falls, over twice that of sound."""
        m, a = self.blocks[k].material, grid.a[j]
        fast = 2.0 * np.sqrt(m.gamma * m.R * s.T * dot(a, a))
        through = lambda du: np.minimum(dot(a, du), 0.0)[None]  # noqa: E731
        mean = lambda f: 0.25 * (np.roll(f, 1, axis=j) + 2.0 * f + np.roll(f, -1, axis=j))  # noqa: E731
        alphas = [
            self._steepness(s.rho[None], k, j, 0.2 * mean(s.rho)),
            self._steepness(s.p[None], k, j, 0.2 * mean(s.p + m.p_inf)),
            self._steepness(s.u, k, j, fast, through),
        ]
        return np.max(alphas, axis=0) * (self.problem.shock > 0.0)

    def _steepness(self, f, k, j, size, of=lambda df: df):
        """alpha of f: 0 where smooth along axis j, 1 at shocks; of: what counts of a change."""
        norm = lambda df: np.sqrt((df**2).sum(axis=0))  # noqa: E731
        rise, fall = of(np.roll(f, -1, axis=1 + j) - f), of(f - np.roll(f, 1, axis=1 + j))
        s = norm(rise - fall) / (norm(rise) + norm(fall) + size)
        if not self.periodic(k, j):
            np.moveaxis(s, j, 0)[[0, -1]] = 0.0
        return np.clip(2.5 * (s - 0.03), 0.0, 1.0)

    @staticmethod
    def _largest(steep, delta, j):
        """The largest alpha of the nodes of a difference."""
        lines = np.moveaxis(steep, j, 0)
        return np.moveaxis(np.array([lines[row != 0.0].max(axis=0) for row in delta]), 0, j)

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
        """Momentum, energy, angular momentum about the origin; of a gas mass and entropy."""
        m, d, W, space = self.blocks[k].material, self.d, self.W[k], tuple(range(-self.d, 0))
        if m.kind == "gas":
            s, M = gas_state(m, q), W * q[1]
            momentum, energy = M * s.u, W * q[-1]
            found = {"mass": M.sum(), "entropy": (M * entropy_of(m, s)).sum()}
        else:
            M = W * self.solids[k][1] * m.m0
            momentum, energy, found = M * q[d:-1], M * q[-1], {}
        pairs = {1: (), 2: ((0, 1),), 3: ((1, 2), (2, 0), (0, 1))}[d]
        turns = [x[i] * momentum[j] - x[j] * momentum[i] for i, j in pairs]
        if turns:
            found["angular"] = np.array(turns).sum(axis=space)
        return {**found, "momentum": momentum.sum(axis=space), "energy": energy.sum()}
