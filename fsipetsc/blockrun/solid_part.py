"""A rank's part of a solid block: metrics, rates, what is saved of it."""

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.block_part import BlockPart
from fsipetsc.blocks.metrics import solid_metrics
from fsipetsc.checks import block_values
from fsipetsc.equations.tensors import add_unit, apply, cofactor
from fsipetsc.equations.vectors import dot
from fsipetsc.kernels.arrays import zeros
from fsipetsc.operators.bands import differences, sigma_of
from fsipetsc.parallel.block_layout import BlockLayout, Part
from fsipetsc.scheme import solid_procedures as does
from fsipetsc.scheme.monitor import MONITORED
from fsipetsc.scheme.normals import normals
from fsipetsc.scheme.part import Nothing, images
from fsipetsc.scheme.solid_dissipation import AT_SHOCKS, SolidDamping
from fsipetsc.scheme.solid_kernels import solid_kernels
from fsipetsc.scheme.solid_sweep import WIDTH, SolidSweep
from fsipetsc.scheme.sweep import text_of

Array = NDArray[Any]


class SolidPart(BlockPart):
    """One part of a solid block.

    metrics: (d d + 1, ghosted nodes), A^k and J0; inertia: J0 m0; reference: J0 of owned nodes;
    prestress: (d d, ghosted nodes), or (d d, 0) of a block that has none.
    """

    def __init__(self, layout: BlockLayout, part: Part, order: int, form: Any) -> None:
        super().__init__(layout, part, order, form)
        d = self._d
        self.equations = self.block.material.equations(d, self._problem.symmetry)
        self.metrics = solid_metrics(self._problem, part.k, order, part.ghosted)
        self.inertia = self.metrics[d * d] * self.equations.m0
        self.reference = self.metrics[d * d, self.owned]
        strain = self.equations.unstrained((0.0,) * d)
        self.F = zeros((len(strain), part.numbers.size))
        self.prestress = np.zeros((self._d**2, 0))
        if self.block.prestress is not None:
            self.prestress = np.array(block_values(self.block, "prestress", self.X, 0.0))
        self._dissipation = self._damping()
        damps = not isinstance(self._dissipation, Nothing)
        self.added = damps or self.block.forcing is not None
        self.reads_ghosted = self.reads_ghosted or damps or part.signs.size > 0

    def _damping(self) -> Any:
        """What adds the term of all nodes, and after it that of shocks."""
        order, form = self._order, self._form
        sigma = sigma_of(form.dissipation, self._problem.joined) / 4.0 ** (order // 2)
        terms = (2, 0.0, AT_SHOCKS * form.shock), (order, sigma, -sigma * (form.shock > 0.0))
        found: Any = Nothing()
        for order_of_term, a, b in terms:
            if a > 0.0 or b > 0.0:
                apart = differences(self._d, order_of_term, self.part.bands, self.block.cells)
                found = SolidDamping(self.equations, apart, a, b, found)
        return found

    def initial(self, t: float, q: Array) -> None:
        d, X = self._d, self.X[:, self.owned]
        values = block_values(self.block, "initial", X, t)
        v, T, x = values[:d], values[d], values[d + 1 :]
        for c in range(d):
            q[:, c], q[:, d + c] = x[c] - X[c], v[c]
        solid = self.equations
        q[:, 2 * d] = solid.alpha * T + 0.5 * sum(c * c for c in v)
        if not solid.coupled:
            F, stored = self._strain_of_case(), 0.0
            if self.prestress.size:  # S : (F - 1)
                S = tuple(self._prestress_at(self.owned))
                stored = dot(S, add_unit(-1.0, tuple(F))) / solid.m0
            q[:, 2 * d] += solid.energy(F) / solid.m0 + stored

    def _strain_of_case(self) -> tuple[Array, ...]:
        """F of the owned nodes from the case's places, which it knows in halos as well."""
        q, X = np.zeros((self.X.shape[1], 2 * self._d + 1)), self.X.copy()
        if self._problem.centred(self.part.k):  # what is odd in r has images of the other sign
            X[-1] = abs(X[-1])
        places = block_values(self.block, "initial", X, 0.0)[self._d + 1 :]
        for c in range(self._d):
            q[:, c] = (places[c] - X[c]) * np.where(X[c] == self.X[c], 1.0, -1.0)
        self.measure(q)
        return tuple(self.F)

    def _prestress_at(self, at: Array) -> Array:
        """(d d, …) of ghosted nodes, 0 if there is none."""
        return self.prestress[:, at] if self.prestress.size else np.zeros((self._d**2, 1))

    def measure(self, q: Array) -> None:
        """Find F (d d, M), with hoops (2, M), of the owned nodes; q: (N, 2d + 1)."""
        own = np.ascontiguousarray(q[self.owned].T)
        self.does["measure"](own.reshape(-1), np.ascontiguousarray(q.T).reshape(-1))

    @property
    def volume_ratio(self) -> Array:
        """(M,) det F of the owned nodes, by the last F."""
        return self.equations.volume(tuple(self.F))

    def _record(self, system: Any, begins: Mapping[str, int]) -> Any:
        part, d = self.part, self._d
        ends = [
            (number, row, X, self._prestress_at(self.owned[[row]])[0, 0])
            for number, k, row, X in self._layout.interface_ends()
            if k == part.k
        ]
        rows, nodes, _ = system.own(part.k, stores=True)
        self.reads_ghosted = self.reads_ghosted or rows.size > 0
        kernels = solid_kernels(self.equations, d, self._order, self.prestress.size > 0)
        integrals = does.solid_integrals(d)
        columns = [begins[name] for name in (*integrals, "lost_energy") if name in begins]
        record = SimpleNamespace(
            **self._common(begins),
            columns=np.array(columns),
            volume=SolidSweep(self.equations, d, kernels, part.bands, part.patch),
            laws=self.equations,
            dissipation=self._dissipation,
            loses=self._problem.loses(part.k),
            inertia=self.inertia,
            prestress=self.prestress if self.prestress.size else None,
            room=np.zeros((MONITORED + len(integrals), part.patch.own[0])),
            masses=self.weights * self.inertia[self.owned],
            F=self.F,
            sums=np.zeros(len(integrals) + 1),
            interfaces=np.array(ends, float).reshape(-1, 4),
            stored_at=part.patch.ghosted_rows(part.rows(nodes)),
            rows_of_stored=rows,
        )
        own = does.store, does.rates, does.monitor, does.measure, does.stressed
        return text_of(kernels, d, WIDTH, self._order), record, (images, normals, *own)

    def normals(self, rows: Any, axis: int, side: int) -> Array:
        """(n, d) unit normals out of the solid of a face as it is at owned nodes, by the last F."""
        d = self._d
        A = tuple(self.metrics[axis * d : (axis + 1) * d, self.owned[rows]] * (2 * side - 1))
        n = np.array(apply(cofactor(tuple(self.F[: d * d, rows])), A))
        return (n / np.linalg.norm(n, axis=0)).T

    def stressed(self, q: Array, rows: Any) -> tuple[Array, Array, Array, Array]:
        """T, p (n,), Cauchy stress (d, d, n) and that of hoops (1, n), or (0, n) without hoops, of
        owned nodes, by the last F.
        """
        d, around = self._d, self._problem.symmetry > 0
        found = np.empty((2 + d * d + around, self.owned.size))
        self.does["stressed"](np.ascontiguousarray(q.T).reshape(-1), found.reshape(-1))
        (T, p), stress, hoops = np.split(found[:, rows], [2, 2 + d * d])
        return T, p, stress.reshape(d, d, -1) - self.faces.p_ref * np.eye(d)[..., None], hoops

    def fields(self, q: Array, rows: slice = slice(None)) -> Array:
        """(…, …) what is saved of these rows of the owned nodes: v, T, Cauchy stress, x; in one
        dimension its part sigma, and p after x; then sigma_theta of hoops.
        """
        self.measure(q)
        d, nodes = self._d, self.owned[rows]
        T, p, stress, hoops = self.stressed(q, rows)
        v, x = q[nodes, d : 2 * d].T, self.X[:, nodes] + q[nodes, :d].T
        hoops = hoops + p * (d == 1)
        if d > 1:
            return np.stack([*v, T, *stress[np.triu_indices(d)], *x, *hoops], axis=-1)
        return np.stack([*v, T, stress[0, 0] + p, *x, p, *hoops], axis=-1)
