"""Rates of solid blocks: against dense matrices, what they conserve, no dependence on cuts."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("numba")

from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.materials.solid_pressure import gruneisen
from fsipetsc.operators.bands import NO_AXIS, Patch, band
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.scheme import solid_work as module
from fsipetsc.scheme.solid_rates import solid_rates
from fsipetsc.scheme.solid_work import solid_work

#: cells of the axes, for each order and dimension
CELLS = {1: (29,), 2: (20, 18), 3: (15, 14, 16)}


def three(values, filler):
    """Numbers of the axes of a patch."""
    return tuple(map(int, values)) + (filler,) * (3 - len(values))


class Block:
    """A solid block on a curved map with a random state, whole: bands, metrics A^k and J0,
    unknowns.

    Arrays (…, nodes): axis 0 is the fastest, as in a DMDA.
    """

    def __init__(self, d, order, periodic=(), seed=0, cells=None, **material):
        rng = np.random.default_rng(seed)
        self.d, self.like = d, (0.0,) * d
        cells = cells or CELLS[d]
        periodic = tuple(periodic) + (False,) * (d - len(periodic))
        self.bands = [band(order, n, p) for n, p in zip(cells, periodic, strict=True)]
        self.shape = tuple(len(b.weight) for b in self.bands)
        self.periodic, self.order = periodic, order
        grids = [np.arange(n) / c for n, c in zip(self.shape, cells, strict=True)]
        xi = [g.ravel() for g in np.meshgrid(*grids[::-1], indexing="ij")][::-1]
        self.xi = xi
        self.D = [self.along(b.matrix(), k) for k, b in enumerate(self.bands)]
        self.weight = np.ones(1)
        for b in self.bands:
            self.weight = np.kron(b.weight, self.weight)
        waves = [sum(np.sin(2 * np.pi * xi[k] + 0.7 * c + k) for k in range(d)) for c in range(d)]
        self.X = [1.5 * xi[c] + 0.3 * xi[(c + 1) % d] * (d > 1) + 0.04 * waves[c] for c in range(d)]
        slope = np.array(
            [[D @ self.periodic_part(c, k) for k, D in enumerate(self.D)] for c in range(d)]
        )
        G = slope + np.array(
            [[np.full(len(xi[0]), self.jump(c, k)) for k in range(d)] for c in range(d)]
        )
        G = np.moveaxis(G, -1, 0)  # G[node, c, k] = D_k X_c
        J0 = np.linalg.det(G)
        A = J0[:, None, None] * np.linalg.inv(G)  # A[node, k, c]
        assert J0.min() > 0
        self.G, self.A, self.J0 = G, A, J0
        self.metrics = np.concatenate([A.reshape(-1, d * d).T, J0[None]])
        self.material = {
            "mu_e": 1.3,
            "lambda_e": 2.1,
            "kappa_e": 0.0,
            "m0": 1.7,
            "alpha": 0.6,
        } | material
        self.solid = ElasticSolid(**self.material).equations(d)
        self.prestress = np.zeros((d * d, 0))
        self.displacement = 0.004 * rng.standard_normal((d, len(J0)))
        self.v, self.T = rng.standard_normal((d, len(J0))), 1.0 + rng.random(len(J0))
        self.set_unknowns()

    def jump(self, c, k):
        """X_c(1) - X_c(0) along a periodic axis k, which is no part of the periodic function."""
        if not self.periodic[k]:
            return 0.0
        return 1.5 * (c == k) + 0.3 * ((c + 1) % self.d == k) * (self.d > 1)

    def periodic_part(self, c, k):
        return self.X[c] - self.jump(c, k) * self.xi[k]

    def along(self, matrix, k):
        """A matrix of one axis as one of all nodes."""
        whole = np.eye(1)
        for m, n in enumerate(self.shape):
            whole = np.kron(matrix if m == k else np.eye(n), whole)
        return whole

    def set_unknowns(self):
        F = tuple(self.strain().reshape(-1, self.d**2).T)
        e = self.solid.total_energy(tuple(self.v), self.T, F) + self.stored(F)
        self.q = np.concatenate([self.displacement, self.v, e[None]]).T.copy()

    def stored(self, F):
        """Energy per mass of the prestress."""
        if self.solid.coupled or not self.prestress.size:
            return 0.0
        unit = np.eye(self.d).ravel()[:, None]
        return (self.prestress * (np.array(F) - unit)).sum(0) / self.solid.m0

    def strain(self):
        """F[node, i, j]."""
        slopes = np.array([[D @ u for D in self.D] for u in self.displacement])  # [i, k, node]
        return np.eye(self.d) + np.einsum("ikn,nkj->nij", slopes, self.A) / self.J0[:, None, None]

    def reference(self):
        """Rates by dense matrices."""
        d, solid, F = self.d, self.solid, self.strain()
        flat = tuple(F.reshape(-1, d * d).T)
        v, e = self.q[:, d : 2 * d].T, self.q[:, 2 * d]
        T = solid.temperature(tuple(v), e - self.stored(flat), flat)
        P = np.array(solid.stress_at(flat, T))
        P = (P + self.prestress if self.prestress.size else P).T.reshape(-1, d, d)
        t = np.einsum("nij,nkj->kin", P, self.A)
        gradient = np.einsum("nkj,kn->jn", self.A, np.array([D @ T for D in self.D])) / self.J0
        inverse = np.linalg.inv(F)
        h = solid.kappa * np.linalg.det(F) * np.einsum("nia,nja,jn->in", inverse, inverse, gradient)
        force, power = np.zeros((d, len(e))), np.zeros(len(e))
        for k, b in enumerate(self.bands):
            loose = self.without_flux(k, b)
            force += np.array([loose @ t[k, i] for i in range(d)])
            heat = np.einsum("nj,jn->n", self.A[:, k], h)
            work = sum((loose @ t[k, i]) * v[i] + t[k, i] * (self.D[k] @ v[i]) for i in range(d))
            power += work + loose @ heat
        mass = self.J0 * solid.m0
        b = np.array(solid.force)[:, None]
        rates = [*v, *(force / mass + b), power / mass + (b * v).sum(0)]
        return np.array(rates).T

    def without_flux(self, k, b):
        """D°_k = - H^-1 D_k^T H, D_k without the flux through the ends."""
        return self.along(-(b.weight[:, None] * b.matrix()).T / b.weight[:, None], k)

    def rates(self):
        """Rates by the kernels, of the whole block; periodic axes have a halo."""
        d, n = self.d, self.shape
        width = 4 * (self.order // 2) + 4
        halo = [width * p for p in self.periodic]
        numbers = np.arange(len(self.J0)).reshape(n[::-1])
        picked = np.pad(numbers, [(h, h) for h in halo[::-1]], mode="wrap").ravel()
        bands = [b.part(-h, m + h) if h else b for b, h, m in zip(self.bands, halo, n, strict=True)]
        ghosted = [m + 2 * h for m, h in zip(n, halo, strict=True)]
        patch = Patch(three(n, 1), three(ghosted, 1), three(halo, 0))
        rows = OPERATORS[self.order].rows
        inside = (0, ghosted[0]) if self.periodic[0] else (rows, n[0] - rows)
        metrics, prestress = self.metrics[:, picked].copy(), self.prestress
        if prestress.size:
            prestress = prestress[:, picked].copy()
        rates, bands = np.zeros((len(self.J0), 2 * d + 1)), [*bands, *[NO_AXIS] * (3 - d)]
        self.of_patch(self.q[picked], metrics, bands, patch, rates, prestress, inside)
        return rates

    def of_patch(self, q, metrics, bands, patch, rates, prestress, inside):
        work = solid_work(self.solid, bands, inside, patch)
        solid_rates(self.solid, self.like, q, metrics, prestress, rates, work)


@pytest.mark.parametrize("heat", ["coupled", "elastic"])
def test_a_prestress_is_part_of_the_stress(heat):
    block = Block(2, 4, (False, True), kappa_e=0.4, heat=heat, force=(0.3, -0.7))
    block.prestress = 0.5 * np.random.default_rng(3).standard_normal((4, len(block.J0)))
    block.set_unknowns()
    found, wanted = block.rates(), block.reference()
    assert np.abs(found - wanted).max() <= 1e-12 * np.abs(wanted).max()


@pytest.mark.parametrize("heat", ["coupled", "elastic"])
def test_where_the_power_of_stresses_goes(heat):
    """P : F_t of each node; it becomes heat ('coupled'), or is W_t and heats nothing
    ('elastic').
    """
    block = Block(2, 4, kappa_e=0.0, heat=heat)
    rates, (v, T), step = block.rates(), (block.v, block.T), 1e-6
    F = block.strain()
    kept = block.displacement
    block.displacement = kept + step * v
    F_t = (block.strain() - F) / step
    block.displacement = kept
    P = np.array(block.solid.stress_at(tuple(F.reshape(-1, 4).T), T)).T.reshape(-1, 2, 2)
    power = (P * F_t).sum((1, 2)) / block.solid.m0
    warmed = rates[:, 4] - (v.T * rates[:, 2:4]).sum(1)  # e_t less that of |v|^2/2
    if heat == "elastic":
        law, flat = block.solid.law, lambda G: tuple(G.reshape(-1, 4).T)
        W_t = (law.energy(flat(F + step * F_t)) - law.energy(flat(F - step * F_t))) / (2 * step)
        assert np.abs(warmed - W_t / block.solid.m0).max() < 1e-7 * np.abs(W_t).max()
    size = np.abs(power).max()
    assert size > 0.1 and np.abs(warmed - power).max() < 1e-8 * size


@pytest.mark.parametrize(
    ("d", "material"), [(2, {"pressing": gruneisen(1.2)}), (3, {"heat": "elastic"})]
)
def test_rates_of_many_tiles_are_those_of_dense_matrices(d, material, monkeypatch):
    monkeypatch.setattr(module, "TILES", ((7, 1), (6, 1), (6, 5)))
    block = Block(d, 2 if d == 3 else 4, (d == 2,), kappa_e=0.4, **material)
    found, wanted = block.rates(), block.reference()
    assert np.abs(found - wanted).max() <= 1e-12 * np.abs(wanted).max()
