"""The oracle of blocks around an axis (kappa = 1) or a centre (kappa = 2), along r, or in (z, r).

SCHEME-BLOCKS.md section 6. The last coordinate is r. The metrics carry the weight r^kappa, so that
sums are over a sector of unit angle or unit solid angle. The code of flat blocks (oracle_volume.py)
is used as it is; new are

    grid   a^k = (b^k_1, r^kappa b^k_2), b^k the metrics of (z, s), s = r^(kappa + 1)/(kappa + 1)
    gas    momentum along r += p S - tau_hoop S, with S = sum_k D_k a^k_2
    solid  force along r -= kappa (J0 R^kappa / R) P_hoop, with the hoop stretch lambda = r / R

A block that goes from -r to r, with an even number of nodes and mirrored states, is the scheme with
a centre: none of its nodes is there, and the weight is |r|^kappa. Pairs around an axis have weights
of their own.
"""

from __future__ import annotations

import numpy as np
from block_oracle import Oracle
from oracle_formulas import cofactor, det, dot, energy_and_stress

from fsipetsc.operators.coefficients import AXIS


def beside_axis(order, _, S, weight):
    """(D, S, weight) of an axis from -r to r with the weights of pairs around r = 0."""
    S, n = S.copy(), len(weight) // 2
    for (i, l), w in AXIS.get(order, {}).items():
        for a, b in ((n + i, n + l), (n - 1 - l, n - 1 - i)):
            S[a, b], S[b, a] = float(w), -float(w)
    return 0.5 * (S - np.diag(S.sum(axis=1))) / weight[:, None], S, weight


class Radial(Oracle):
    """An oracle with a weight r^kappa; see Oracle. kappa = 0: no weight."""

    def __init__(self, problem, kappa):
        self.kappa = kappa
        super().__init__(problem)
        for k, b in enumerate(self.blocks):
            if kappa == 1 and b.X[-1].min() < 0.0 < b.X[-1].max():
                self.axes[k][-1] = beside_axis(problem.order, *self.axes[k][-1])
        for k, (A, J0) in self.solids.items():
            weight = self.weight(self.blocks[k].X)
            self.solids[k] = A * weight, J0 * weight

    def weight(self, x):
        """r^kappa (...); also of complex x, whose real part has the sign."""
        return (np.where(x[-1].real < 0.0, -1.0, 1.0) * x[-1]) ** self.kappa

    def flat(self, x):
        """(z, s) of places."""
        return np.array([*x[:-1], self.weight(x) * x[-1] / (self.kappa + 1.0)])

    def metrics(self, k, x):
        """a[axis, component, ...]."""
        a = super().metrics(k, self.flat(x)).astype(x.dtype)
        a[:, -1] = a[:, -1] * self.weight(x)
        return a

    def grids(self, q, t, given=None):
        """With the rate of a, which is no longer bilinear."""
        step = 1e-30j
        found = super().grids(q, t, given)
        if any(np.iscomplexobj(grid.x) for grid in found):
            return found
        turned = (np.imag(self.metrics(k, g.x + step * g.v)) / 1e-30 for k, g in enumerate(found))
        return [grid._replace(a_t=a_t) for grid, a_t in zip(found, turned)]

    def volume_metrics(self, k, grid):
        """b^k and w = d(z, s)/dt."""
        return (
            super().metrics(k, self.flat(grid.x)),
            np.array([*grid.v[:-1], self.weight(grid.x) * grid.v[-1]]),
        )

    def start(self, k):
        """A volume per logical volume: det D(z, s)."""
        return det(np.swapaxes(self.slopes(k, self.flat(self.blocks[k].X)), 0, 1))

    def random_block(self, k, rng, size=1.0):
        """Volumes are near those of `start`."""
        q = super().random_block(k, rng, size)
        if self.blocks[k].material.kind == "gas":
            q *= self.start(k) / det(np.swapaxes(self.slopes(k, self.blocks[k].X), 0, 1))
        return q

    # gas

    def source(self, k, grid):
        """S."""
        return sum(self.derivative(k, grid.a[j, -1], j) for j in range(self.d))

    def gas_terms(self, k, q, grid, t):
        """With the source p S."""
        R = super().gas_terms(k, q, grid, t)
        rho, u, E = q[1] / q[0], q[2:-1] / q[1], q[-1] / q[0]
        m = self.blocks[k].material
        T = ((E - m.p_inf) / rho - 0.5 * dot(u, u)) / m.cv
        p = rho * m.R * T - m.p_inf
        R[-2] += self.W[k] * p * self.source(k, grid)
        return R

    def _viscous(self, k, J, s, grid):
        """Of momentum and energy; all hoop rates together are e = u_r S / V."""
        m, d, S = self.blocks[k].material, self.d, self.source(k, grid)

        def gradient(f):
            return sum(grid.a[j] * self.derivative(k, f, j) for j in range(d)) / J

        w = gradient(-1.0 / s.T)
        G = np.array([s.T * (gradient(u / s.T) + u * w) for u in s.u])
        e = s.u[-1] * S / J
        mean, one = (np.trace(G) + e) / 3.0, np.eye(d).reshape(d, d, *[1] * d)
        tau = m.mu * (G + np.swapaxes(G, 0, 1) - 2.0 * mean * one)
        hoop, total = 2.0 * m.mu * (e / max(self.kappa, 1) - mean), 0.0
        for j in range(d):
            pull = np.einsum("ij...,j...->i...", tau, grid.a[j])
            heat = m.kappa * s.T**2 * dot(w, grid.a[j])
            total = total + self.boundary_flux_free(k, np.array([*pull, dot(pull, s.u) + heat]), j)
        total[-2] -= self.W[k] * hoop * S
        return total

    # solid

    def stretches(self, k, x):
        """F with its hoop stretches, (3, 3, ...)."""
        X, d, G = self.blocks[k].X, self.d, np.zeros((3, 3, *x.shape[1:]), x.dtype)
        G[:d, :d] = self.deformation(k, x)
        for i in range(d, 3):
            G[i, i] = x[-1] / X[-1] if i < d + self.kappa else 1.0
        return G

    def elastic(self, k, x):
        """(W, P), P (3, 3, ...)."""
        m = self.blocks[k].material
        return energy_and_stress(m, self.stretches(k, x), m.p_ref)

    def solid_terms(self, k, q, grid, t):
        """With the hoop force; what it takes from the motion, the hoops store or gain as heat."""
        b, d, (A, J0) = self.blocks[k], self.d, self.solids[k]
        m, v, M = b.material, q[d:-1], self.W[k] * J0 * b.material.m0
        F, P = self.stretches(k, grid.x), self.elastic(k, grid.x)[1]
        C, T = cofactor(F)[:d, :d], self.temperature(k, q)
        gradient = sum(A[j] * self.derivative(k, T, j) for j in range(d)) / J0
        h = m.kappa / det(F) * np.einsum("ki...,kj...,j...->i...", C, C, gradient)
        force, work, heat = np.zeros_like(v), 0.0, 0.0
        for j in range(d):
            PA = np.einsum("mn...,n...->m...", P[:d, :d], A[j])
            force = force + self.boundary_flux_free(k, PA, j)
            work = work + self.W[k] * dot(PA, self.derivative(k, v, j))
            heat = heat + self.boundary_flux_free(k, dot(h, A[j]), j)
        work = work + dot(v, force)
        force[-1] -= self.kappa * self.W[k] * J0 / b.X[-1] * P[d, d]
        stored = work - dot(v, force) if m.heat == "elastic" else 0.0 * work
        energy = work + heat
        if self.problem.dissipation > 0.0:
            lost, warmed = self._solid_dissipation(k, v, A)
            force, energy = force + lost, energy + dot(v, lost) + warmed
        return M, force, energy, stored
