"""The oracle of blocks in one dimension with an axis (kappa = 1) or a centre (kappa = 2).

SCHEME-BLOCKS.md section 6. The metrics carry the weight r^kappa, so that sums are over a sector of
unit angle or unit solid angle. The code of flat blocks (oracle_volume.py) is used as it is; new are

    gas    momentum += p S - tau_hoop S, with S = D r^kappa
    solid  force -= kappa (J0 R^kappa / R) P_hoop, with the hoop stretch lambda = r / R

A block that goes from -r to r, with an even number of nodes and mirrored states, is the scheme with
a centre: none of its nodes is there, and the weight is |r|^kappa.
"""

from __future__ import annotations

import numpy as np
from block_oracle import Oracle
from oracle_formulas import det, dot, energy_and_stress


class Radial(Oracle):
    """An oracle with a weight r^kappa; see Oracle. kappa = 0: no weight."""

    def __init__(self, problem, kappa):
        self.kappa = kappa
        super().__init__(problem)
        for k, (A, J0) in self.solids.items():
            weight = self.metrics(k, self.blocks[k].X)[0, 0]
            self.solids[k] = A * weight, J0 * weight

    def metrics(self, k, x):
        """r^kappa, (1, 1, n); also of complex x, whose real part has the sign."""
        return (np.where(x.real < 0.0, -1.0, 1.0) * x)[None] ** self.kappa

    def volume_flux(self, a_l, v_l, a_r, v_r):
        """g of two nodes: sums of its differences are the rate of `start`."""
        return 0.5 * (dot(a_l, v_l) + dot(a_r, v_r))

    def volume_rate(self, k, grid):
        """J_t, per node."""
        return self.derivative(k, dot(grid.a[0], grid.v), 0)

    def start(self, k):
        """A volume per logical length that belongs to uniform motion: D(r^kappa r)/(kappa+1)."""
        X = self.blocks[k].X
        return self.derivative(k, self.metrics(k, X)[0, 0] * X[0], 0) / (self.kappa + 1.0)

    def random_block(self, k, rng, size=1.0):
        """Volumes are near those of `start`."""
        q = super().random_block(k, rng, size)
        if self.blocks[k].material.kind == "gas":
            q *= self.start(k) / self.slopes(k, self.blocks[k].X)[0, 0]
        return q

    # gas

    def gas_terms(self, k, q, grid, t):
        """With the source p S."""
        R = super().gas_terms(k, q, grid, t)
        rho, u, E = q[1] / q[0], q[2] / q[1], q[3] / q[0]
        m = self.blocks[k].material
        T = ((E - m.p_inf) / rho - 0.5 * u * u) / m.cv
        p = rho * m.R * T - m.p_inf
        R[2] += self.W[k] * p * self.derivative(k, grid.a[0, 0], 0)
        return R

    def _viscous(self, k, J, s, grid):
        """Of momentum and energy; all hoop rates together are e = u S / V."""
        m, a, (u,) = self.blocks[k].material, grid.a[0, 0], s.u
        S = self.derivative(k, a, 0)
        w = a * self.derivative(k, -1.0 / s.T, 0) / J
        along = s.T * (a * self.derivative(k, u / s.T, 0) / J + u * w)
        e = u * S / J
        mean = (along + e) / 3.0
        tau, hoop = 2.0 * m.mu * (along - mean), 2.0 * m.mu * (e / max(self.kappa, 1) - mean)
        heat = m.kappa * s.T**2 * w
        total = self.loose(k, np.array([a * tau, a * (tau * u + heat)]), 0)
        total[0] -= self.W[k] * hoop * S
        return total

    # solid

    def stretches(self, k, x):
        """F with its hoop stretches, (3, 3, n)."""
        X, G = self.blocks[k].X, np.zeros((3, 3, x.shape[1]), x.dtype)
        G[0, 0] = self.slopes(k, x)[0, 0] / self.slopes(k, X)[0, 0]
        for i in (1, 2):
            G[i, i] = x[0] / X[0] if i <= self.kappa else 1.0
        return G

    def elastic(self, k, x):
        """(W, P), P (3, 3, n)."""
        m = self.blocks[k].material
        return energy_and_stress(m, self.stretches(k, x), m.p_ref)

    def solid_terms(self, k, q, grid, t):
        """With the hoop force; what it takes from the motion, the hoops store or gain as heat."""
        b, (A, J0) = self.blocks[k], self.solids[k]
        m, (v,), M, a = b.material, q[1:2], self.W[k] * J0 * b.material.m0, A[0, 0]
        F, P = self.stretches(k, grid.x), self.elastic(k, grid.x)[1]
        _, S, weight = self.axes[k][0]
        PA, D = P[0, 0] * a, S / weight[:, None]
        hoop = self.kappa * self.W[k] * J0 / b.X[0] * P[1, 1]
        force = self.loose(k, PA, 0) - hoop
        work = 0.5 * self.W[k] * (PA * (D @ v) + v * (D @ PA))
        slope = a * self.derivative(k, self.temperature(k, q), 0) / J0
        heat = self.loose(k, m.kappa * det(F) / F[0, 0] ** 2 * slope * a, 0)
        stored = work - v * force if m.heat == "elastic" else 0.0 * work
        energy = work + heat
        if self.problem.dissipation > 0.0:
            (lost,), warmed = self._solid_dissipation(k, q[1:2], A)
            force, energy = force + lost, energy + v * lost + warmed
        return M, force[None], energy, stored
