"""A rank's parts of gas and of solid blocks: records for procedures, grids, what is saved."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.blocks.conditions import Centre
from fsipetsc.blocks.grid import grid_of
from fsipetsc.blocks.metrics import solid_metrics
from fsipetsc.checks import Array, block_values
from fsipetsc.equations.tensors import add_unit
from fsipetsc.equations.vectors import dot
from fsipetsc.errors import InputError
from fsipetsc.kernels.loops import zeros
from fsipetsc.materials.own import check_inverses, check_transport, knows_entropy
from fsipetsc.operators.slopes import Stencil
from fsipetsc.parallel.block_layout import GATHER_TAG, Part
from fsipetsc.parallel.exchange import RowExchange
from fsipetsc.scheme import gas_terms as of_gas
from fsipetsc.scheme import solid_procedures as of_solid
from fsipetsc.scheme.dissipation import AT_SHOCKS, GasDamping, SolidDamping, sigma_of
from fsipetsc.scheme.face_terms import normals
from fsipetsc.scheme.gas_sweep import GasSweep, gas_kernels
from fsipetsc.scheme.gas_terms import CONSERVED, add_force, convection_of
from fsipetsc.scheme.monitor import MONITORED, ROOM_COLUMNS
from fsipetsc.scheme.part import images, rates
from fsipetsc.scheme.solid_sweep import SolidSweep, solid_kernels
from fsipetsc.stepping.block_part import BlockPart

#: procedures of parts, and of those whose grid moves
OF_GAS = rates, of_gas.monitor, of_gas.find_volumes
OF_MOVING_GAS = of_gas.follow, of_gas.move, of_gas.turn
OF_SOLID = of_solid.store, rates, of_solid.monitor, of_solid.measure, of_solid.stressed


class GasPart(BlockPart):
    """One part of a gas block. metrics: (d d + d, N), a^k, velocity of the grid, and of axes A."""

    def __init__(self, part: Part, about: SimpleNamespace) -> None:
        super().__init__(part, about)
        opt, order = about.opt, self.order
        material, self.around = self.block.material, self.problem.symmetry > 0
        self.viscous = bool(material.mu or material.kappa)
        sigma, shock = sigma_of(opt["fsi_dissipation"], self.problem.joined), opt["fsi_shock"]
        self._check_law(opt["fsi_convection"], sigma)
        self.form = convection_of(opt["fsi_convection"], self.laws)
        damps = sigma > 0.0 or shock > 0.0
        of = order // 2, part.bands, self.block.cells, sigma, shock, self.form.raises
        damping = GasDamping(*of) if damps else None
        self.add_sources(add_force, of_gas.supply)
        self.added = damps or self.forced or self.forcing is not None
        self.reads_ghosted = self.reads_ghosted or damps
        #: J of the reference map, over which that of the solution is saved and monitored
        self.reference, self.J = np.zeros((2, self.owned.size))
        self.places = self.X.copy()
        self._follow()
        stencil = Stencil(order // 2, max(band.reach for band in self.bands))
        given = self.form, self.viscous, self.moves, stencil, shock > 0.0
        made = self.kernels_of(gas_kernels, *given)
        self.volume = GasSweep(self.laws, self.d, made, self.bands, self.patch, damping)
        potential = self.volume.potential
        potential[:] = -dot(self.laws.force, self.X)[: potential.size]
        self.terms = (of_gas.add_ends,) * self.moves + self.terms
        self.room = np.zeros((MONITORED + len(vars(self.columns)), ROOM_COLUMNS))
        kinds, self.masses = self.problem.kinds[self.k].items(), self.H
        faces = [face for face, what in kinds if not isinstance(what, Centre)]
        self.ends = SimpleNamespace(**self.nodes_of(faces)[0])
        grid = type(self.grid)
        moving = (*OF_MOVING_GAS, grid.swing) if self.moves else (grid.move,)
        of_grid = {"self": self.grid, "known": self.known, "X": self.X, "places": self.places}
        self._record((*moving, images, normals, *OF_GAS, grid.edge, grid.find_places), of_grid)

    def _check_law(self, convection: str, sigma: float) -> None:
        law, owner = self.block.material.gas_law, f"the law of the gas '{self.block.name}'"
        if isinstance(law, CONSERVED):
            return
        if convection == "entropy":
            found = "is not that of a perfect or stiffened gas, whose entropy this conserves"
            raise InputError(f"-fsi_convection entropy: {owner} {found}: expected auto, divergence")
        if sigma > 0.0 and not knows_entropy(law):
            lacks = f"{owner} has no formula entropy(rho, T), which -fsi_dissipation needs"
            raise InputError(f"{lacks}; it is 1 where blocks are joined; -1: no dissipation")

    def _follow(self) -> None:
        """Let the grid follow solids and walls that move."""
        of, layout = self.at_particles, self.about.layout
        faces = sorted(set(zip(of.axis.tolist(), of.index.tolist(), strict=True)))
        blocks = self.problem.blocks
        leading = [
            particle.members
            for particle in self.about.particles
            if particle.moves or any(blocks[b].kind == "solid" for b, _ in particle.members)
        ]
        nodes = np.array([n for members in leading for b, n in members if b == self.k], np.int64)
        self.moves, about = nodes.size > 0, (self.k, self.order, self.ghosted, nodes, faces)
        self.grid = grid_of(self.problem, *about)
        self.metrics = self.grid.metrics
        share = layout.shares[self.k]  # all its ranks get what the owners of nodes have
        wanted = dict.fromkeys(share.ranks, np.ones(nodes.size, bool))
        known = share.owners(nodes), wanted, np.zeros((nodes.size, 2 * self.d))
        self.gather = RowExchange(layout.comm, GATHER_TAG + self.k, *known)
        self.known, self.follower_rows = self.gather.table, self.gather.rows
        _, own, particle = self.about.system.own(self.k)
        self.follows = particle[np.searchsorted(own, nodes[self.follower_rows])]

    def initial(self, q: Array) -> None:
        """Fill q (M, d + 3) with the case's data, with J = 1."""
        rho, *u, T = block_values(self.block, "initial", self.X[:, self.owned], 0.0)
        check_inverses(self.laws.law, rho, T, f"the law of the gas '{self.block.name}'")
        check_transport(self.laws.transport, T, f"the transport of the gas '{self.block.name}'")
        U = self.laws.densities(self.laws.state(rho, tuple(u), T))
        for c, values in enumerate((1.0, *U)):
            q[:, c] = values

    def steepest(self, q: Array) -> tuple[float, ...]:
        """The largest change of p between neighbours, over their larger bulk modulus; X there."""
        at, change, stride = self.owned, np.zeros(self.owned.size), 1
        with np.errstate(all="ignore"):  # a state may be unphysical
            w = self.laws.primitive(tuple(q.T))
            p, K = w[1], self.laws.law.bulk_modulus(w[0], w[2])
        for size in self.patch.ghosted[: self.d]:
            beside = np.where(at // stride % size < size - 1, at + stride, at)
            apart = np.abs(p[beside] - p[at]) / np.maximum(K[beside], K[at])
            change, stride = np.maximum(change, apart), stride * size
        most = change.argmax()
        return change[most], *self.X[:, at[most]]

    def fields(self, q: Array) -> Array:
        """(M, 2d + 4), saved of owned nodes: rho, u, T, p, J over that of the reference map, x."""
        w, J = self.laws.primitive(tuple(q[self.owned].T)), q[self.owned, 0] / self.reference
        self.does["find_places"]()
        x = self.places[:, self.owned]
        return np.stack([w[0], *self.laws.velocity(w), w[2], w[1], J, *x], axis=-1)


class SolidPart(BlockPart):
    """One part of a solid block. squares: (M,) of wave numbers that bound steps, over m0 [m/kg]."""

    def __init__(self, part: Part, about: SimpleNamespace) -> None:
        super().__init__(part, about)
        d, block, order, shock = self.d, self.block, self.order, about.opt["fsi_shock"]
        self.metrics = solid_metrics(self.problem, part.k, order, part.ghosted)
        self.inertia = self.metrics[d * d] * self.laws.m0
        self.inverses = 1.0 / np.array([self.metrics[d * d], self.inertia])
        self.reference = self.metrics[d * d, self.owned]
        self.masses = self.H * self.inertia[self.owned]
        sizes = (self.metrics[: d * d, self.owned].reshape(d, d, -1) ** 2).sum(axis=1)
        self.squares = (sizes.T * self.per_h**2).sum(axis=1) / self.reference**2
        if self.problem.symmetry:
            self.squares += self.laws.curvature(self.metrics[-1, self.owned])
        self.squares /= self.laws.m0
        self.F = zeros((self.laws.strains(d), part.numbers.size))
        self.prestress = None
        if block.prestress is not None:
            self.prestress = np.array(block_values(block, "prestress", self.X, 0.0))
        sigma = sigma_of(about.opt["fsi_dissipation"], self.problem.joined) / 4.0 ** (order // 2)
        terms = (order // 2, sigma, -sigma * (shock > 0.0)), (1, 0.0, AT_SHOCKS * shock)
        of = part.bands, block.cells, self.laws
        dissipation = [SolidDamping(q, *of, a, b) for q, a, b in terms if a > 0.0 or b > 0.0]
        self.terms = *dissipation, *self.terms
        self.add_sources(of_solid.book_force, of_solid.supply)
        self.added = bool(dissipation) or self.forcing is not None
        record, (rows, nodes, _) = about.system.record, about.system.own(self.k)
        at = self.patch.ghosted_rows(self.rows(nodes))
        record.weight[rows] *= self.inertia[at]
        wanted = slice(None) if record.stores else slice(0)
        self.rows_of_stored, self.stored_at = rows[wanted], at[wanted]
        self.reads_ghosted |= bool(dissipation) or self.stored_at.size > 0
        ends = []  # in one dimension
        for number in range(len(self.problem.interfaces) if d == 1 else 0):
            for k, *face in self.problem.interface_faces(number):
                nodes = self.block.face_nodes(*face) if k == self.k else np.zeros(0, int)
                ends += [(number, row) for row in self.rows_among(nodes)]
        self.interfaces = np.array(ends, np.int64).reshape(-1, 2)
        kernels = self.kernels_of(solid_kernels, order, self.prestress is not None)
        self.volume = SolidSweep(self.laws, d, kernels, self.bands, self.patch)
        self.room = np.zeros((MONITORED + len(vars(self.columns)), self.patch.own[0]))
        self._record((images, normals, *OF_SOLID), {})

    def initial(self, q: Array) -> None:
        d, X = self.d, self.X[:, self.owned]
        values = block_values(self.block, "initial", X, 0.0)
        v, T, x = values[:d], values[d], values[d + 1 :]
        for c in range(d):
            q[:, c], q[:, d + c] = x[c] - X[c], v[c]
        solid = self.laws
        q[:, 2 * d] = solid.alpha * T + 0.5 * sum(c * c for c in v)
        if not solid.coupled:
            F, stored = self._strain_of_case(), 0.0
            if self.prestress is not None:  # S : (F - 1)
                S = tuple(self.prestress[:, self.owned])
                stored = dot(S, add_unit(-1.0, tuple(F))) / solid.m0
            q[:, 2 * d] += solid.energy(F) / solid.m0 + stored

    def _strain_of_case(self) -> tuple[Array, ...]:
        """F of the owned nodes from the case's places, which it knows in halos as well."""
        q, X = np.zeros((self.X.shape[1], 2 * self.d + 1)), self.X.copy()
        if self.problem.centred(self.k):  # what is odd in r has images of the other sign
            X[-1] = abs(X[-1])
        places = block_values(self.block, "initial", X, 0.0)[self.d + 1 :]
        for c in range(self.d):
            q[:, c] = (places[c] - X[c]) * np.where(X[c] == self.X[c], 1.0, -1.0)
        self.measure(q)
        return tuple(self.F)

    def measure(self, q: Array) -> None:
        """Find F (d d, M), with hoops (2, M), of the owned nodes; q: (N, 2d + 1)."""
        own = np.ascontiguousarray(q[self.owned].T)
        self.does["measure"](own.reshape(-1), np.ascontiguousarray(q.T).reshape(-1))

    def stressed(self, q: Array, rows: Any) -> tuple[Array, Array, Array, Array]:
        """T, p, Cauchy stress (d, d, n), that of hoops (1 or 0, n), of rows, by the last F."""
        d, around = self.d, self.problem.symmetry > 0
        found = np.empty((2 + d * d + around, self.owned.size))
        self.does["stressed"](np.ascontiguousarray(q.T).reshape(-1), found.reshape(-1))
        (T, p), stress, hoops = np.split(found[:, rows], [2, 2 + d * d])
        return T, p, stress.reshape(d, d, -1) - self.p_ref * np.eye(d)[..., None], hoops

    def fields(self, q: Array) -> Array:
        """(M, …) what is saved of the owned nodes: v, T, Cauchy stress, x; in one dimension its
        part sigma, and p after x; then sigma_theta of hoops.
        """
        self.measure(q)
        d, nodes = self.d, self.owned
        T, p, stress, hoops = self.stressed(q, slice(None))
        v, x = q[nodes, d : 2 * d].T, self.X[:, nodes] + q[nodes, :d].T
        if d > 1:
            return np.stack([*v, T, *stress[np.triu_indices(d)], *x, *hoops], axis=-1)
        return np.stack([*v, T, stress[0, 0] + p, *x, p, *(hoops + p)], axis=-1)
