"""A rank's part of a solid block: metrics, rates, what is saved of it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.asked import Asked, Forced
from fsipetsc.blockrun.face_terms import FaceTerms, ranges_of, strain, weights_of
from fsipetsc.blockrun.gas_part import MOMENTUM
from fsipetsc.blocks.metrics import solid_metrics
from fsipetsc.blocks.values import block_values, prestress_of
from fsipetsc.equations.tensors import add_unit, apply, cofactor, determinant
from fsipetsc.operators.loops import dot
from fsipetsc.operators.narrow import STIFFNESS_OF_WIDE
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.operators.undivided import differences, sigma_of
from fsipetsc.parallel.block_layout import BlockLayout, Part
from fsipetsc.scheme.block_look import LOOKED, look_at_end
from fsipetsc.scheme.line_parts import SolidLine
from fsipetsc.scheme.line_terms import SolidDamping, Undamped
from fsipetsc.scheme.solid_dissipation import AT_SHOCKS, SMALL, Damping, room, solid_dissipation
from fsipetsc.scheme.solid_look import solid_look
from fsipetsc.scheme.solid_rates import solid_rates
from fsipetsc.scheme.solid_work import Work, solid_work

Array = NDArray[Any]


class SolidPart(Forced):
    """One part of a solid block.

    metrics: (d d + 1, ghosted nodes), A^k and J0; inertia: J0 m0; prestress: (d d, ghosted nodes),
    or (d d, 0) of a block that has none.
    """

    def __init__(
        self, layout: BlockLayout, part: Part, order: int, form: Any, asked: Asked
    ) -> None:
        self.part, self._problem = part, layout.problem
        self.block = self._problem.blocks[part.k]
        self._d = d = self.block.dimension
        self._like = (0.0,) * d
        self.equations = self.block.material.equations(d)
        ranges = ranges_of(part, self.block.shape)
        self.X = self._problem.positions(part.k, ranges)
        self.metrics = solid_metrics(self._problem, part.k, order, ranges)
        self.inertia = self.metrics[d * d] * self.equations.m0
        self._asked = asked
        equations, inertia = self.equations, self.inertia
        self.faces = FaceTerms(self._problem, part, order, equations, inertia, self.X, asked)
        self._owned = part.ghosted_rows(np.arange(part.numbers.size))
        self._masses = weights_of(part, self._owned) * self.inertia[self._owned]
        self._per_h = np.array(self.block.cells, float)
        self._F = np.zeros((d * d, part.numbers.size))
        self.prestress = prestress_of(self.block, self.X)
        self._work = self._make_work(OPERATORS[order].rows, ranges[0][0])
        self._dissipation = list(self._make_dissipation(order, form))

    def _make_work(self, rows: int, first: int) -> Work:
        """Memory of rates. rows: of the closures; first: the first ghosted node along axis 0."""
        part, nodes = self.part, self.block.shape[0]
        inside = rows - first, nodes - rows - first
        if self.block.periodic[0]:
            inside = 0, part.patch.ghosted[0]
        return solid_work(self.equations, part.bands, inside, part.patch)

    def _make_dissipation(self, order: int, form: Any) -> Iterator[tuple[Any, ...]]:
        """What solid_dissipation wants of each term: that of all nodes, and that of shocks."""
        d, solid, bands, cells = self._d, self.equations, self.part.bands, self.block.cells
        K = solid.law.wave_modulus(tuple(np.eye(d).ravel().tolist()))
        of_solid = np.sqrt(K * solid.m0), solid.m0, SMALL * np.sqrt(K / solid.m0)
        sigma = sigma_of(form.dissipation, self._problem.joined) / 4.0 ** (order // 2)
        terms = (order, sigma, -sigma * (form.shock > 0.0)), (2, 0.0, AT_SHOCKS * form.shock)
        for order_of_term, a, b in terms:
            if a > 0.0 or b > 0.0:
                found = differences(d, order_of_term, bands, cells)
                yield Damping(a, b, *of_solid), found, room(d, found)

    def initial(self, t: float, q: Array) -> None:
        """Fill q (M, 2d + 1) with the case's data."""
        d, X = self._d, self.X[:, self._owned]
        values = block_values(self.block, "initial", X, t)
        v, T, x = values[:d], values[d], values[d + 1 :]
        for c in range(d):
            q[:, c], q[:, d + c] = x[c] - X[c], v[c]
        solid = self.equations
        q[:, 2 * d] = solid.alpha * T + 0.5 * sum(c * c for c in v)
        if not solid.coupled:
            F = self._strain_of_case()
            q[:, 2 * d] += self._stored(F, self._owned)

    def _strain_of_case(self) -> tuple[Array, ...]:
        """F of the owned nodes from the case's places, which it knows in halos as well."""
        q = np.zeros((self.X.shape[1], 2 * self._d + 1))
        places = block_values(self.block, "initial", self.X, 0.0)[self._d + 1 :]
        for c in range(self._d):
            q[:, c] = places[c] - self.X[c]
        return tuple(self._deformation(q))

    def _stored(self, F: Any, at: Array) -> Any:
        """Energy per mass [J/kg] of ghosted nodes that heat 'elastic' has beside alpha T."""
        of_law = self.equations.law.energy(tuple(F)) / self.equations.m0
        return of_law + self._stored_by_prestress(F, at)

    def _stored_by_prestress(self, F: Any, at: Array) -> Any:
        """Energy per mass [J/kg] of ghosted nodes with heat 'elastic': S : (F - 1)/m0."""
        if self.equations.coupled or not self.prestress.size:
            return 0.0
        return dot(tuple(self._prestress_at(at)), add_unit(-1.0, tuple(F))) / self.equations.m0

    def _prestress_at(self, at: Array) -> Array:
        """(d d, …) of ghosted nodes, 0 if there is none."""
        return self.prestress[:, at] if self.prestress.size else np.zeros((self._d**2, 1))

    def _deformation(self, q: Array) -> Array:
        """F (d d, M) of the owned nodes."""
        self.look(q)
        return self._F

    def volume_ratio(self, q: Array) -> Array:
        """(M,) det F of the owned nodes."""
        ratio: Array = determinant(tuple(self._deformation(q)))
        return ratio

    def look(self, q: Array) -> tuple[Array, dict[str, float]]:
        """What bounds a step, and integrals of the owned nodes; q: (N, 2d + 1).

        See fsipetsc.scheme.block_look.
        """
        d, seen = self._d, np.zeros(LOOKED)
        sums, of_block = np.zeros(d + 1), (self.metrics, self.prestress, self._per_h)
        memory = STIFFNESS_OF_WIDE, self._masses, self._work, self._F, seen, sums
        solid_look(self.equations, self._like, q, *of_block, *memory)
        return seen, dict(zip([*MOMENTUM[:d], "energy"], sums.tolist(), strict=True))

    def line(
        self,
        columns: Array,
        interfaces: list[tuple[int, int, float]],
        stored: tuple[Array, Array],
    ) -> SolidLine:
        """Itself as a record, in one dimension. columns: of its sums in the record of a step.
        interfaces: number, owned row and X of those with an end of this part. stored: rows and
        numbers of nodes of members that tell what they store.
        """
        part, damping = self.part, Undamped()
        for of_term, found, memory in self._dissipation[::-1]:
            damping = SolidDamping(of_term, found, memory, damping)
        ends = np.zeros((len(interfaces), 5))
        for end, (number, row, X) in zip(ends, interfaces, strict=True):
            at = int(self._owned[row])
            end[:] = number, row, at, X, self._prestress_at(np.array([at]))[0, 0]
        return SolidLine(
            self.equations,
            damping,
            *self.faces.line(self.X.shape[1]),
            part.k,
            part.begin,
            part.local if part.has_halo else np.empty((0, part.dof)),
            self.metrics,
            self.inertia,
            self.prestress,
            part.patch,
            self._work,
            self._per_h,
            self._masses,
            self._F,
            forcing=self.supplied(3),
            came=np.zeros(3),
            seen=np.zeros(LOOKED),
            sums=np.zeros(2),
            columns=columns,
            interfaces=ends,
            stored_at=part.ghosted_rows(part.rows(stored[1])),
            rows_of_stored=stored[0],
            S=part.bands[0].S,
            weight=part.bands[0].weight,
            none=np.zeros((1, self.X.shape[1])),
        )

    def normal(self, row: int, axis: int, side: int) -> Array:
        """(d,) unit normal out of the solid of a face as it is, at an owned node, by the last F."""
        d = self._d
        A = tuple(self.metrics[axis * d : (axis + 1) * d, self._owned[row]] * (2 * side - 1))
        n = np.array(apply(cofactor(tuple(self._F[:, row])), A))
        return n / np.linalg.norm(n)

    def fields(self, q: Array, rows: slice = slice(None)) -> Array:
        """(…, …) what is saved of these rows of the owned nodes: v, T, Cauchy stress P F^T / J, x;
        in one dimension its part sigma, and p behind x.
        """
        d, nodes = self._d, self._owned[rows]
        F, own = tuple(self._deformation(q)[:, rows]), q[nodes]
        v = tuple(own[:, d : 2 * d].T)
        e = own[:, 2 * d] - self._stored_by_prestress(F, nodes)
        T = self.equations.temperature(v, e, F)
        P, J = self.equations.stress_at(F, T) + self._prestress_at(nodes), determinant(F)
        pairs = [(i, j) for i in range(d) for j in range(i, d)]
        stresses = [sum(P[i * d + m] * F[j * d + m] for m in range(d)) / J for i, j in pairs]
        p_ref = self.faces.p_ref
        stresses = [s - p_ref * (i == j) for s, (i, j) in zip(stresses, pairs, strict=True)]
        x = self.X[:, nodes] + own[:, :d].T
        if d > 1:
            return np.stack([*v, T, *stresses, *x], axis=-1)
        p = self.equations.pressure_at(J, T) + 0.0 * T
        return np.stack([*v, T, stresses[0] + p, *x, p], axis=-1)

    def at_end(self, q: Array, row: int, found: Array) -> None:
        """Fill found with x - X, v, sigma, T of an owned node in one dimension, by the last F."""
        at = int(self._owned[row])
        S = float(self.prestress[0, at]) if self.prestress.size else 0.0
        look_at_end(self.equations, q, self._F, at, row, S, found)

    def stored(self, q: Array, nodes: Array) -> Array:
        """(n,) energy per mass [J/kg] that is neither kinetic nor heat, of nodes of the block that
        this rank owns.
        """
        if self.equations.coupled:
            return np.zeros(nodes.size)
        at = self.part.ghosted_rows(self.part.rows(nodes))
        F = strain(self.part, at, self.metrics, q)
        return self._stored(F, at)

    def rates(self, t: float, q: Array, rates: Array, gain: Array) -> None:
        """rates (M, 2d + 1) of the volume terms, of faces and of forcing; q: (N, 2d + 1). What
        comes in is added to gain (d + 2,): mass, impulse, energy.
        """
        d = self._d
        solid_rates(self.equations, self._like, q, self.metrics, self.prestress, rates, self._work)
        for damping, found, memory in self._dissipation:
            arguments = self._like, damping, q, self.metrics, found, self.part.patch
            solid_dissipation(*arguments, rates, memory)
        self.faces.add(t, q, self.metrics, rates, gain)
        forcing = self.ask(t)
        if forcing or any(self.equations.force):
            force, v = np.array(self.equations.force), q[self._owned, d : 2 * d]
            gain[1 : 1 + d] += self._masses.sum() * force
            gain[1 + d] += self._masses @ (v @ force)
            if forcing:
                self._force(forcing, v, rates, gain)

    def _force(self, forcing: list[Array], v: Array, rates: Array, gain: Array) -> None:
        """The case's forcing, right-hand sides of velocity, temperature and place."""
        d = self._d
        heat = self.equations.alpha * forcing[d]
        for c in range(d):
            rates[:, d + c] += forcing[c]
            rates[:, c] += forcing[d + 1 + c]
            heat = heat + v[:, c] * forcing[c]
            gain[1 + c] += self._masses @ forcing[c]
        rates[:, 2 * d] += heat
        gain[1 + d] += self._masses @ heat
