"""A rank's part of a solid block: metrics, rates, what is saved of it."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.block_part import BlockPart
from fsipetsc.blockrun.columns import loses
from fsipetsc.blocks.metrics import solid_metrics
from fsipetsc.blocks.values import block_values, prestress_of
from fsipetsc.equations.tensors import add_unit, apply, cofactor
from fsipetsc.operators.loops import dot
from fsipetsc.operators.undivided import differences, sigma_of
from fsipetsc.parallel.block_layout import BlockLayout, Part
from fsipetsc.scheme.block_monitor import MONITORED
from fsipetsc.scheme.part import Nothing
from fsipetsc.scheme.solid_dissipation import AT_SHOCKS, solid_damping
from fsipetsc.scheme.solid_monitor import solid_monitor
from fsipetsc.scheme.solid_record import SolidRecord
from fsipetsc.scheme.solid_work import solid_work, sums_of

Array = NDArray[Any]


class SolidPart(BlockPart):
    """One part of a solid block.

    metrics: (d d + 1, ghosted nodes), A^k and J0; inertia: J0 m0; prestress: (d d, ghosted nodes),
    or (d d, 0) of a block that has none.
    """

    def __init__(self, layout: BlockLayout, part: Part, order: int, form: Any) -> None:
        super().__init__(layout, part, order)
        d, kappa, material = self._d, self._problem.symmetry, self.block.material
        self.equations = material.radial_equations(kappa, d) if kappa else material.equations(d)
        self.metrics = solid_metrics(self._problem, part.k, order, self._ranges)
        self.inertia = self.metrics[d * d] * self.equations.m0
        self._masses = self.weights * self.inertia[self.owned]
        self._per_h = np.array(self.block.cells, float)
        self._loses = int(loses(self._problem, part.k))
        strain = self.equations.unstrained((0.0,) * d)
        self._F = np.zeros((len(strain), part.numbers.size))
        self.prestress = prestress_of(self.block, self.X)
        self._work = solid_work(self.equations, part.bands, part.patch)
        self._dissipation = self._make_dissipation(order, form)

    @property
    def reference(self) -> Array:
        """(M,) J of the reference map."""
        J: Array = self.metrics[self._d**2, self.owned]
        return J

    def _make_dissipation(self, order: int, form: Any) -> Any:
        """The term of all nodes, and after it that of shocks."""
        found: Any = Nothing()
        sigma = sigma_of(form.dissipation, self._problem.joined) / 4.0 ** (order // 2)
        terms = (2, 0.0, AT_SHOCKS * form.shock), (order, sigma, -sigma * (form.shock > 0.0))
        for order_of_term, a, b in terms:
            if a > 0.0 or b > 0.0:
                apart = differences(self._d, order_of_term, self.part.bands, self.block.cells)
                found = solid_damping(self.equations, apart, a, b, found)
        return found

    def initial(self, t: float, q: Array) -> None:
        """Fill q (M, 2d + 1) with the case's data."""
        d, X = self._d, self.X[:, self.owned]
        values = block_values(self.block, "initial", X, t)
        v, T, x = values[:d], values[d], values[d + 1 :]
        for c in range(d):
            q[:, c], q[:, d + c] = x[c] - X[c], v[c]
        solid = self.equations
        q[:, 2 * d] = solid.alpha * T + 0.5 * sum(c * c for c in v)
        if not solid.coupled:
            F = self._strain_of_case()
            of_law = solid.energy(F) / solid.m0
            q[:, 2 * d] += of_law + self._stored_by_prestress(F, self.owned)

    def _strain_of_case(self) -> tuple[Array, ...]:
        """F of the owned nodes from the case's places, which it knows in halos as well."""
        q, X = np.zeros((self.X.shape[1], 2 * self._d + 1)), self.X.copy()
        if self._problem.centred(self.part.k):  # what is odd in r has images of the other sign
            X[-1] = abs(X[-1])
        places = block_values(self.block, "initial", X, 0.0)[self._d + 1 :]
        for c in range(self._d):
            q[:, c] = (places[c] - X[c]) * np.where(X[c] == self.X[c], 1.0, -1.0)
        return tuple(self._deformation(q))

    def _stored_by_prestress(self, F: Any, at: Array) -> Any:
        """Energy per mass [J/kg] of ghosted nodes with heat 'elastic': S : (F - 1)/m0."""
        if self.equations.coupled or not self.prestress.size:
            return 0.0
        return dot(tuple(self._prestress_at(at)), add_unit(-1.0, tuple(F))) / self.equations.m0

    def _prestress_at(self, at: Array) -> Array:
        """(d d, …) of ghosted nodes, 0 if there is none."""
        return self.prestress[:, at] if self.prestress.size else np.zeros((self._d**2, 1))

    def _deformation(self, q: Array) -> Array:
        """F (d d, M) of the owned nodes, with hoops (2, M)."""
        self.monitor(q)
        return self._F

    def volume_ratio(self, q: Array) -> Array:
        """(M,) det F of the owned nodes."""
        ratio: Array = self.equations.volume(tuple(self._deformation(q)))
        return ratio

    def monitor(self, q: Array) -> tuple[Array, Array]:
        """What bounds a step, and the sums of the owned nodes; q: (N, 2d + 1).

        See fsipetsc.scheme.solid_monitor.
        """
        seen, sums = np.zeros(MONITORED), np.zeros(sums_of(self._d) + 1)
        of_block = self.X, self.metrics, self.prestress, self._per_h
        memory = self._masses, self._work, self._F, self._loses, seen, sums
        solid_monitor(self.equations, (0.0,) * self._d, q, *of_block, *memory)
        return seen, sums

    def record(
        self,
        columns: Array,
        at_particles: Any,
        alone: bool,
        interfaces: list[tuple[int, int, float]],
        stored: tuple[Array, Array],
    ) -> SolidRecord:
        """For compiled code; as that of a gas. interfaces: number, owned row and X of those with an
        end of this part in one dimension. stored: rows and numbers of nodes of members that tell
        what they store.
        """
        part, d = self.part, self._d
        ends = np.zeros((len(interfaces), 4))
        for end, (number, row, X) in zip(ends, interfaces, strict=True):
            end[:] = number, row, X, self._prestress_at(self.owned[[row]])[0, 0]
        return SolidRecord(
            **self._common(at_particles, columns, alone),
            laws=self.equations,
            dissipation=self._dissipation,
            loses=self._loses,
            inertia=self.inertia,
            prestress=self.prestress,
            work=self._work,
            masses=self._masses,
            F=self._F,
            sums=np.zeros(sums_of(d) + 1),
            interfaces=ends,
            stored_at=part.ghosted_rows(part.rows(stored[1])),
            rows_of_stored=stored[0],
        )

    def normal(self, row: int, axis: int, side: int) -> Array:
        """(d,) unit normal out of the solid of a face as it is, at an owned node, by the last F."""
        d = self._d
        if d == 1:
            return np.array([2.0 * side - 1.0])
        A = tuple(self.metrics[axis * d : (axis + 1) * d, self.owned[row]] * (2 * side - 1))
        n = np.array(apply(cofactor(tuple(self._F[:, row])), A))
        return n / np.linalg.norm(n)

    def fields(self, q: Array, rows: slice = slice(None)) -> Array:
        """(…, …) what is saved of these rows of the owned nodes: v, T, Cauchy stress P F^T / J, x;
        in one dimension its part sigma, and p after x; then sigma_theta of hoops.
        """
        d, nodes = self._d, self.owned[rows]
        F, own = tuple(self._deformation(q)[:, rows]), q[nodes]
        v = tuple(own[:, d : 2 * d].T)
        e = own[:, 2 * d] - self._stored_by_prestress(F, nodes)
        T = self.equations.temperature(v, e, F)
        P, J = self.equations.stress_at(F, T), self.equations.volume(F)
        P = P + self._prestress_at(nodes)
        pairs = [(i, j) for i in range(d) for j in range(i, d)]
        stresses = [sum(P[i * d + m] * F[j * d + m] for m in range(d)) / J for i, j in pairs]
        p_ref = self.faces.p_ref
        stresses = [s - p_ref * (i == j) for s, (i, j) in zip(stresses, pairs, strict=True)]
        x = self.X[:, nodes] + own[:, :d].T
        p, around = self.equations.pressure_at(J, T) + 0.0 * T, self._problem.symmetry > 0
        hoops = [self.equations.hoop_stress(F, T) + p * (d == 1)] if around else []
        if d > 1:
            return np.stack([*v, T, *stresses, *x, *hoops], axis=-1)
        return np.stack([*v, T, stresses[0] + p, *x, p, *hoops], axis=-1)
