"""Dissipation of solid blocks: against dense matrices, what it conserves, no dependence on cuts."""

from __future__ import annotations

from math import comb

import numpy as np
import pytest

pytest.importorskip("numba")

from test_solid_rates import Block

from fsipetsc.operators.undivided import differences
from fsipetsc.scheme.solid_dissipation import Damping, room, solid_dissipation

IMPEDANCE, M0, SMALL = 2.3, 1.7, 0.02


class Damped(Block):
    """A block of test_solid_rates, with dissipation alone; q: order of the differences."""

    def __init__(self, d, order, q, a, b, periodic=(), cells=None):
        super().__init__(d, order, periodic, cells=cells)
        self.numbers, self.a, self.b = q, a, b
        self.cells = [n - (not p) for n, p in zip(self.shape, self.periodic, strict=True)]

    def of_patch(self, q, metrics, bands, patch, rates, prestress, inside):
        found = differences(self.d, 2 * self.numbers, bands, self.cells)
        damping = Damping(self.a, self.b, IMPEDANCE, M0, SMALL)
        rates[:] = 0.0
        solid_dissipation(self.like, damping, q, metrics, found, patch, rates, room(self.d, found))

    def alpha(self, k):
        """Of each node along axis k."""
        n, v = self.shape[k], self.q[:, self.d : 2 * self.d].T
        ahead, behind = (self.along(np.roll(np.eye(n), s, axis=1), k) for s in (1, -1))
        rise, fall = v @ ahead.T - v, v - v @ behind.T
        s = (np.abs(rise - fall) / (np.abs(rise) + np.abs(fall) + SMALL)).max(axis=0)
        index = np.indices(self.shape[::-1])[self.d - 1 - k].ravel()
        if not self.periodic[k]:
            s = np.where((index == 0) | (index == n - 1), 0.0, s)
        return np.clip(2.5 * (s - 0.03), 0.0, 1.0)

    def reference(self):
        v, q = self.q[:, self.d : 2 * self.d].T, self.numbers
        force, heat = np.zeros_like(v), np.zeros(v.shape[1])
        for k, band in enumerate(self.bands):
            n = self.shape[k]
            count = n if self.periodic[k] else n - q
            delta, middle, norm = np.zeros((count, n)), np.zeros((count, n)), np.zeros(count)
            alpha_of = np.zeros((q + 1, count, n))
            for i in range(count):
                nodes = [(i + m) % n for m in range(q + 1)]
                for m, node in enumerate(nodes):
                    delta[i, node] += (-1) ** (q - m) * comb(q, m)
                    alpha_of[m, i, node] = 1.0
                middle[i, nodes[q // 2]] += 0.5
                middle[i, nodes[(q + 1) // 2]] += 0.5
                norm[i] = min(1.0, *(band.weight[nodes] * self.cells[k]))
            whole = lambda matrix: self.axis_matrix(matrix, k)  # noqa: B023, E731
            Delta, M, H = whole(delta), whole(middle), self.along(np.diag(1 / band.weight), k)
            A = M @ self.A[:, k]
            alpha = np.max([whole(pick) @ self.alpha(k) for pick in alpha_of], axis=0)
            size = (self.a + self.b * alpha) * self.spread(norm, k)
            F = size * IMPEDANCE * np.linalg.norm(A, axis=1) * (v @ Delta.T)
            force -= F @ Delta @ H.T
            heat += ((F * (v @ Delta.T)).sum(0) @ M) @ H.T
        per_mass = 1.0 / (self.J0 * M0)
        return np.array([*0.0 * v, *force * per_mass, ((v * force).sum(0) + heat) * per_mass]).T

    def axis_matrix(self, matrix, k):
        """A matrix of one axis, (count, n), for all nodes."""
        whole = np.eye(1)
        for m, n in enumerate(self.shape):
            whole = np.kron(matrix if m == k else np.eye(n), whole)
        return whole

    def spread(self, values, k):
        """Numbers along an axis, for all nodes of a grid that is as long as they are there."""
        whole = np.ones(1)
        for m, n in enumerate(self.shape):
            whole = np.kron(values if m == k else np.ones(n), whole)
        return whole


CASES = [
    (1, 4, 2, 0.02, 0.0, ()),
    (1, 2, 1, 0.0, 0.7, ()),
    (1, 6, 3, 0.02, -0.01, (True,)),
    (2, 4, 2, 0.02, -0.01, (True, False)),
    (2, 8, 4, 0.02, -0.01, ()),
    (3, 4, 2, 0.02, -0.01, ()),
]
CELLS = {1: (23,), 2: (18, 17), 3: (13, 12, 14)}


@pytest.mark.parametrize(("d", "order", "q", "a", "b", "periodic"), CASES)
def test_dissipation_is_that_of_dense_matrices(d, order, q, a, b, periodic):
    block = Damped(d, order, q, a, b, periodic, CELLS[d])
    found, wanted = block.rates(), block.reference()
    assert np.abs(found - wanted).max() <= 1e-13 * np.abs(wanted).max()
    assert np.abs(wanted[:, d:]).max() > 1e-2


@pytest.mark.parametrize(("d", "order", "q", "a", "b", "periodic"), CASES[:5])
def test_momentum_and_energy_stay_and_motion_becomes_heat(d, order, q, a, b, periodic):
    block = Damped(d, order, q, a, b, periodic, CELLS[d])
    rates, v = block.rates(), block.q[:, d : 2 * d]
    mass = (block.weight * block.J0 * M0)[:, None]
    lost = (mass * v * rates[:, d : 2 * d]).sum()
    assert lost < 0.0
    assert np.abs((mass * rates[:, d:]).sum(0)).max() < 1e-13 * np.abs(mass * rates[:, d:]).sum()
    warmed = rates[:, -1] - (v * rates[:, d : 2 * d]).sum(1)
    assert warmed.min() >= -1e-12 * warmed.max() and (mass[:, 0] * warmed).sum() == pytest.approx(
        -lost
    )


def test_smooth_motion_is_no_shock():
    block = Damped(2, 4, 1, 0.0, 0.7, (True, True), (40, 40))
    x, y = block.xi
    block.q[:, 2], block.q[:, 3] = 0.01 * np.sin(2 * np.pi * x), 0.01 * np.cos(2 * np.pi * y)
    assert not block.rates()[:, 2:].any()
    block.q[:, 2] = np.sign(x - 0.5)
    assert np.abs(block.rates()[:, 2]).max() > 1.0
