"""A rank's part of a solid block: metrics, rates, what is saved of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.face_terms import FaceTerms, face_of, ranges_of
from fsipetsc.blockrun.gas_part import MOMENTUM
from fsipetsc.blocks.metrics import solid_metrics
from fsipetsc.blocks.values import prestress_of
from fsipetsc.equations.tensors import add_unit, determinant
from fsipetsc.operators.loops import dot
from fsipetsc.operators.narrow import STIFFNESS_OF_WIDE
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.parallel.block_layout import BlockLayout, Part
from fsipetsc.scheme import block_look
from fsipetsc.scheme.solid_rates import Work, solid_rates, solid_work

Array = NDArray[Any]


class SolidPart:
    """One part of a solid block.

    metrics: (d d + 1, ghosted nodes), A^k and J0; inertia: J0 m0; prestress: (d d, ghosted nodes),
    or (d d, 0) of a block that has none.
    """

    def __init__(self, layout: BlockLayout, part: Part, order: int, form: Any) -> None:
        self.part, self._problem = part, layout.problem
        self.block = self._problem.blocks[part.k]
        self._d = d = self.block.dimension
        self._like = (0.0,) * d
        self.equations = self.block.material.equations(d)
        ranges = ranges_of(part, self.block.shape)
        self.X = self._problem.positions(part.k, ranges)
        self.metrics = solid_metrics(self._problem, part.k, order, ranges)
        self.inertia = self.metrics[d * d] * self.equations.m0
        self._faces = FaceTerms(self._problem, part, self.inertia, self.X)
        self._interfaces = [
            face_of(self._problem, part, *face)
            for face in self._problem.faces_of(part.k)
            if self._problem.is_interface(part.k, *face)
        ]
        self._owned = part.ghosted_rows(np.arange(part.numbers.size))
        self._per_h = np.array(self.block.cells, float)
        self._F = np.zeros((d * d, part.numbers.size))
        self.prestress = prestress_of(self.block, self.X)
        self._work = self._make_work(OPERATORS[order].rows, ranges[0][0])

    def _make_work(self, rows: int, first: int) -> Work:
        """Memory of rates. rows: of the closures; first: the first ghosted node along axis 0."""
        part, nodes = self.part, self.block.shape[0]
        inside = (0, part.patch.ghosted[0]) if self.block.periodic[0] else (rows - first, nodes - rows - first)
        return solid_work(self.equations, part.bands, inside, part.patch)

    @property
    def timed(self) -> bool:
        """Data of faces or forcing depend on time."""
        return self._faces.timed or self.block.forcing is not None

    def initial(self, t: float, q: Array) -> None:
        """Fill q (M, 2d + 1) with the case's data."""
        d, X = self._d, self.X[:, self._owned]
        values = [np.asarray(v) * np.ones(X.shape[1]) for v in self.block.initial(*X)]
        v, T, x = values[:d], values[d], values[d + 1 :]
        for c in range(d):
            q[:, c], q[:, d + c] = x[c] - X[c], v[c]
        solid = self.equations
        q[:, 2 * d] = solid.alpha * T + 0.5 * sum(c * c for c in v)
        if not solid.coupled:
            F = self._strain_of_case()
            q[:, 2 * d] += solid.law.energy(F) / solid.m0 + self._stored_by_prestress(F)

    def _strain_of_case(self) -> tuple[Array, ...]:
        """F of the owned nodes from the case's places, which it knows in halos as well."""
        q = np.zeros((self.X.shape[1], 2 * self._d + 1))
        places = self.block.initial(*self.X)[self._d + 1 :]
        for c in range(self._d):
            q[:, c] = places[c] - self.X[c]
        return tuple(self._deformation(q))

    def _stored_by_prestress(self, F: Any) -> Any:
        """Energy per mass [J/kg] of the owned nodes with heat 'elastic': S : (F - 1)/m0."""
        if self.equations.coupled or not self.prestress.size:
            return 0.0
        return dot(tuple(self._own_prestress), add_unit(-1.0, tuple(F))) / self.equations.m0

    @property
    def _own_prestress(self) -> Array:
        """(d d, M) of the owned nodes, 0 if there is none."""
        return self.prestress[:, self._owned] if self.prestress.size else np.zeros((self._d**2, 1))

    def _deformation(self, q: Array) -> Array:
        """F (d d, M) of the owned nodes."""
        bands, F = self.part.bands, self._F
        S, w = [band.S for band in bands], [band.weight for band in bands]
        block_look.deformation(self._like, q, self.metrics, *S, *w, self.part.patch, F)
        return F

    def look(self, q: Array) -> tuple[Array, dict[str, float]]:
        """What bounds a step, and integrals of the owned nodes: see fsipetsc.scheme.block_look; q: (N, 2d + 1)."""
        d, weights = self._d, [band.weight for band in self.part.bands]
        seen, sums = np.zeros(block_look.LOOKED), np.zeros(d + 1)
        F, of_block = self._deformation(q), (self.metrics, self._per_h, STIFFNESS_OF_WIDE)
        arguments = *of_block, *weights, self.part.patch, F, seen
        block_look.solid_look(self.equations, self._like, q, *arguments, sums)
        if self.prestress.size and not self.equations.coupled:
            thermal = q.copy()
            thermal[self._owned, 2 * d] -= self._stored_by_prestress(F)
            block_look.solid_look(self.equations, self._like, thermal, *arguments, np.zeros(d + 1))
        return seen, dict(zip([*MOMENTUM[:d], "energy"], sums.tolist(), strict=True))

    def fields(self, q: Array) -> Array:
        """(M, …) what is saved of the owned nodes: v, T, Cauchy stress P F^T / J, x."""
        d = self._d
        F, own = tuple(self._deformation(q)), q[self._owned]
        v = tuple(own[:, d : 2 * d].T)
        T = self.equations.temperature(v, own[:, 2 * d] - self._stored_by_prestress(F), F)
        P, J = self.equations.stress_at(F, T) + self._own_prestress, determinant(F)
        stresses = [
            sum(P[i * d + m] * F[j * d + m] for m in range(d)) / J for i in range(d) for j in range(i, d)
        ]
        x = self.X[:, self._owned] + own[:, :d].T
        return np.stack([*v, T, *stresses, *x], axis=-1)

    def rates(self, t: float, q: Array, rates: Array) -> None:
        """rates (M, 2d + 1) of the volume terms, of faces and of forcing; q: (N, 2d + 1)."""
        arguments = self.equations, self._like, q, self.metrics, self.prestress
        solid_rates(*arguments, rates, self._work)
        self._faces.add(t, None, q, self.metrics, rates)
        self._supply(t, q, rates)
        self._force(t, q, rates)

    def _supply(self, t: float, q: Array, rates: Array) -> None:
        """What interfaces supply from outside: traction and heat per reference area."""
        if self._problem.jumps is None:
            return
        d = self._d
        for face in self._interfaces:
            X, at = self.X[:, face.ghosted], face.ghosted
            *traction, heat = (np.asarray(v) * np.ones(at.size) for v in self._problem.jumps(*X, t))
            area = np.sqrt(sum(self.metrics[face.axis * d + c, at] ** 2 for c in range(d)))
            scale = area * face.per_weight / self.inertia[at]
            for c in range(d):
                rates[face.owned, d + c] += scale * traction[c]
                rates[face.owned, 2 * d] += scale * traction[c] * q[at, d + c]
            rates[face.owned, 2 * d] += scale * heat

    def _force(self, t: float, q: Array, rates: Array) -> None:
        """The case's forcing, right-hand sides of velocity, temperature and place."""
        if self.block.forcing is None:
            return
        d = self._d
        values = self.block.forcing(*self.X[:, self._owned], t)
        for c in range(d):
            rates[:, d + c] += values[c]
            rates[:, c] += values[d + 1 + c]
            rates[:, 2 * d] += q[self._owned, d + c] * values[c]
        rates[:, 2 * d] += self.equations.alpha * values[d]
