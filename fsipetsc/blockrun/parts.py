"""A rank's parts of gas and of solid blocks: records for procedures, grids, what is saved."""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.block_part import BlockPart, nodes_of
from fsipetsc.blocks.block import Block
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Centre
from fsipetsc.blocks.grid import grid_of
from fsipetsc.blocks.metrics import solid_metrics
from fsipetsc.checks import block_values
from fsipetsc.equations.tensors import add_unit
from fsipetsc.equations.vectors import dot
from fsipetsc.errors import InputError
from fsipetsc.kernels.arrays import zeros
from fsipetsc.materials.own import check_inverses, knows_entropy
from fsipetsc.parallel.block_layout import GATHER_TAG, BlockLayout, Part
from fsipetsc.parallel.exchange import RowExchange
from fsipetsc.particles.members import Particle
from fsipetsc.particles.system import ParticleSystem
from fsipetsc.scheme import gas_procedures as of_gas
from fsipetsc.scheme import solid_procedures as of_solid
from fsipetsc.scheme.dissipation import AT_SHOCKS, GasDamping, SolidDamping, sigma_of
from fsipetsc.scheme.faces import normals
from fsipetsc.scheme.gas_sweep import GasSweep, gas_kernels
from fsipetsc.scheme.gas_terms import CONSERVED, add_force, add_radial, convection_of
from fsipetsc.scheme.monitor import COLUMNS, MONITORED
from fsipetsc.scheme.part import images, rates
from fsipetsc.scheme.solid_sweep import WIDTH, SolidSweep, solid_kernels
from fsipetsc.scheme.sweep import text_of

Array = NDArray[Any]
#: procedures of parts, and of those whose grid moves
OF_GAS = rates, of_gas.monitor, of_gas.begin_grid, of_gas.find_places, of_gas.find_volumes
OF_MOVING_GAS = of_gas.follow, of_gas.edge, of_gas.move, of_gas.swing, of_gas.turn
OF_SOLID = of_solid.store, rates, of_solid.monitor, of_solid.measure, of_solid.stressed


class GasPart(BlockPart):
    """One part of a gas block. metrics: (d d + d, N), a^k and the velocity of the grid; around an
    axis also A.
    """

    add_force, supply = staticmethod(add_force), staticmethod(of_gas.supply)

    def __init__(self, layout: BlockLayout, part: Part, order: int, form: Any) -> None:
        super().__init__(layout, part, order, form)
        material = self.block.material
        self.equations = material.equations(self._d, self._problem.symmetry)
        self.viscous = bool(material.mu or material.kappa)
        self._sigma = sigma_of(form.dissipation, self._problem.joined)
        self._check_law(form)
        self.convection = convection_of(form.convection, self.equations)
        damps = self._sigma > 0.0 or form.shock > 0.0
        around, pulled = self._problem.symmetry > 0, any(self.equations.force)
        self.added = damps or around or pulled or self.block.forcing is not None
        self.reads_ghosted = self.reads_ghosted or damps or around

    def _check_law(self, form: Any) -> None:
        """InputError if the law of the gas lacks what an option needs."""
        law, owner = self.block.material.gas_law, f"the law of the gas '{self.block.name}'"
        if isinstance(law, CONSERVED):
            return
        if form.convection == "entropy":
            found = "is not that of a perfect or stiffened gas, whose entropy this conserves"
            raise InputError(f"-fsi_convection entropy: {owner} {found}: expected auto, divergence")
        if self._sigma > 0.0 and not knows_entropy(law):
            lacks = f"{owner} has no formula entropy(rho, T), which -fsi_dissipation needs"
            raise InputError(f"{lacks}; it is 1 where blocks are joined; -1: no dissipation")

    def follow(self, particles: Sequence[Particle], system: ParticleSystem) -> None:
        """Let the grid follow the particles that have a solid, or are on walls that move.
        Collective on the block's ranks.
        """
        of = self.at_particles
        faces = sorted(set(zip(of.axis.tolist(), of.index.tolist(), strict=True)))
        k, blocks = self.part.k, self._problem.blocks
        leading = [
            particle.members
            for particle in particles
            if particle.moves or any(blocks[b].kind == "solid" for b, _ in particle.members)
        ]
        nodes = np.array([n for members in leading for b, n in members if b == k], np.int64)
        where, self.moves = self.part.ghosted, nodes.size > 0
        self._grid, self.metrics = grid_of(self._problem, k, self._order, where, nodes, faces)
        share = self._layout.shares[k]  # all its ranks get what the owners of nodes have
        wanted = dict.fromkeys(share.ranks, np.ones(nodes.size, bool))
        known = share.owners(nodes), wanted, 2 * self._d
        self.gather = RowExchange(self._layout.comm, GATHER_TAG + k, *known)
        _, own, particle = system.own(k)
        self._particles = particle[np.searchsorted(own, nodes[self.gather.rows])]
        #: J of the reference map, over which that of the solution is saved and monitored
        self.reference, self._J = np.zeros((2, self.owned.size))
        self._places = self.X.copy()

    def begin(self) -> None:
        """Find the metrics of the grid where nothing has moved, once the code is loaded."""
        self.does["begin_grid"]()
        self.reference[:] = self._J

    def _record(self, system: Any, begins: Mapping[str, int]) -> Any:
        number = [block.kind for block in self._problem.blocks[: self.part.k]].count("fluid")
        begins = {**begins, "mass": begins["mass"] + number}
        part, d, bands = self.part, self._d, self.part.bands
        sigma, shock, around = self._sigma, self._form.shock, self._problem.symmetry > 0
        if sigma > 0.0 or shock > 0.0:
            given = sigma, shock, self.convection.raises
            self.dissipation = (GasDamping(self._order // 2, bands, self.block.cells, *given),)
        self.adds = (of_gas.add_ends,) * self.moves + (add_radial,) * around
        made = gas_kernels(self.equations, d, self.convection, self.viscous, self.moves)
        self.volume = GasSweep(self.equations, d, made, bands, part.patch)
        potential = self.volume.potential
        potential[:] = -dot(self.equations.force, self.X)[: potential.size]
        room = np.zeros(((d + 1) ** 2, self.X.shape[1])) if self.block.material.mu else None
        record = SimpleNamespace(
            **self._common(begins),
            laws=self.equations,
            volume=self.volume,
            form=self.convection,
            around=around,
            hoops=room if around else None,
            column=number,
            places=self._places,
            room=np.zeros((MONITORED + len(begins), COLUMNS)),
            masses=self.weights,
            follows=self._particles,
            rows=self.gather.rows,
            known=self.gather.table,
            moves=self.moves,
            ends=self._ends(),
            grid=self._grid,
            reference=self.reference,
            J=self._J,
        )
        moving = OF_MOVING_GAS if self.moves else ()
        text = text_of(made, d, self.volume.width, self._order)
        return text, record, (*moving, images, normals, *OF_GAS)

    def _ends(self) -> SimpleNamespace:
        """The ends of all axes here, which are none along a periodic axis and at a centre."""
        problem, part, found = self._problem, self.part, [np.zeros((4, 0))]
        for (axis, side), what in problem.kinds[part.k].items():
            if not isinstance(what, Centre):
                at, own, axes, signs, per_weight, *_ = nodes_of(problem, part, axis, side)
                found.append(np.stack([at, own, axes, signs * per_weight]))
        *numbers, factor = np.concatenate(found, axis=1)
        at, own, axes = (n.astype(np.int64) for n in numbers)
        return SimpleNamespace(at=at, own=own, axis=axes, factor=factor)

    def initial(self, t: float, q: Array) -> None:
        """Fill q (M, d + 3) with the case's data, with J = 1."""
        X = self.X[:, self.owned]
        rho, *u, T = block_values(self.block, "initial", X, t)
        check_inverses(self.equations.law, rho, T, f"the law of the gas '{self.block.name}'")
        U = self.equations.densities(self.equations.state(rho, tuple(u), T))
        for c, values in enumerate((1.0, *U)):
            q[:, c] = values

    def begin_at_walls(self, q: Array, nodes: Array, u: Array) -> None:
        """Let J be that of the grid, at the same density, velocity and temperature, and nodes have
        the velocities u (n, d), at the same temperature.
        """
        self.does["find_volumes"]()
        q *= (self._J / q[:, 0])[:, None]
        rows, d = self.part.rows(nodes), self._d
        momentum = q[rows, 1, None] * u
        change = (momentum**2 - q[rows, 2 : 2 + d] ** 2).sum(axis=1) / q[rows, 1]
        q[rows, 2 : 2 + d], q[rows, 2 + d] = momentum, q[rows, 2 + d] + 0.5 * change

    def steepest(self, q: Array) -> tuple[float, ...]:
        """The largest change of the pressure from an owned node to one beside it, over the larger
        bulk modulus, and X there. q: (N, d + 3) of all nodes with a halo.
        """
        at, change, stride = self.owned, np.zeros(self.owned.size), 1
        with np.errstate(all="ignore"):  # corners of halos hold nothing, and are not used
            w = self.equations.primitive(tuple(q.T))
            p, K = w[1], self.equations.law.bulk_modulus(w[0], w[2])
        for size in self.part.patch.ghosted[: self._d]:
            beside = np.where(at // stride % size < size - 1, at + stride, at)
            apart = np.abs(p[beside] - p[at]) / np.maximum(K[beside], K[at])
            change, stride = np.maximum(change, apart), stride * size
        most = change.argmax()
        return change[most], *self.X[:, at[most]]

    def fields(self, q: Array, rows: slice = slice(None)) -> Array:
        """(…, 2d + 4) what is saved of these rows of the owned nodes: rho, u, T, p, J over that of
        the reference map, x.
        """
        own = self.owned[rows]
        w, J = self.equations.primitive(tuple(q[own].T)), q[own, 0] / self.reference[rows]
        self.does["find_places"]()
        x = self._places[:, own]
        return np.stack([w[0], *self.equations.velocity(w), w[2], w[1], J, *x], axis=-1)


def loose_gases(problem: BlockProblem, convection: str) -> list[Block]:
    """The gases on which a constant force acts node by node with this -fsi_convection."""
    gases = [block for block in problem.blocks if block.kind == "fluid"]
    of_gases = [gas.material.equations(problem.dimension, problem.symmetry) for gas in gases]
    pairs = zip(gases, of_gases, strict=True)
    return [gas for gas, of in pairs if any(of.force) and not convection_of(convection, of).raises]


class SolidPart(BlockPart):
    """One part of a solid block.

    metrics: (d d + 1, ghosted nodes), A^k and J0; inertia: J0 m0; reference: J0 of owned nodes;
    prestress: (d d, ghosted nodes), if there is one.
    """

    add_force, supply = staticmethod(of_solid.book_force), staticmethod(of_solid.supply)

    def __init__(self, layout: BlockLayout, part: Part, order: int, form: Any) -> None:
        super().__init__(layout, part, order, form)
        d = self._d
        self.equations = self.block.material.equations(d, self._problem.symmetry)
        self.metrics = solid_metrics(self._problem, part.k, order, part.ghosted)
        self.inertia = self.metrics[d * d] * self.equations.m0
        self.reference = self.metrics[d * d, self.owned]
        strain = self.equations.unstrained((0.0,) * d)
        self.F = zeros((len(strain), part.numbers.size))
        self.prestress = None
        if self.block.prestress is not None:
            self.prestress = np.array(block_values(self.block, "prestress", self.X, 0.0))
        sigma = sigma_of(form.dissipation, self._problem.joined) / 4.0 ** (order // 2)
        of_all = order // 2, sigma, -sigma * (form.shock > 0.0)
        self.dissipation = tuple(
            SolidDamping(q, part.bands, self.block.cells, a, b, self.equations)
            for q, a, b in (of_all, (1, 0.0, AT_SHOCKS * form.shock))
            if a > 0.0 or b > 0.0
        )
        self.added = bool(self.dissipation) or self.block.forcing is not None
        self.reads_ghosted |= bool(self.dissipation) or part.signs.size > 0

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
            if self.prestress is not None:  # S : (F - 1)
                S = tuple(self.prestress[:, self.owned])
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

    def measure(self, q: Array) -> None:
        """Find F (d d, M), with hoops (2, M), of the owned nodes; q: (N, 2d + 1)."""
        own = np.ascontiguousarray(q[self.owned].T)
        self.does["measure"](own.reshape(-1), np.ascontiguousarray(q.T).reshape(-1))

    def _record(self, system: Any, begins: Mapping[str, int]) -> Any:
        part, d, problem = self.part, self._d, self._problem
        ends = []  # in one dimension
        for number, (_, k) in enumerate(problem.interfaces if d == 1 else ()):
            for row in part.rows_among(problem.interface_nodes(number)) if k == part.k else ():
                ends.append((number, row))
        rows, nodes, _ = system.own(part.k, stores=True)
        self.reads_ghosted = self.reads_ghosted or rows.size > 0
        kernels = solid_kernels(self.equations, d, self._order, self.prestress is not None)
        record = SimpleNamespace(
            **self._common(begins),
            volume=SolidSweep(self.equations, d, kernels, part.bands, part.patch),
            laws=self.equations,
            inertia=self.inertia,
            prestress=self.prestress,
            room=np.zeros((MONITORED + len(begins), part.patch.own[0])),
            masses=self.weights * self.inertia[self.owned],
            F=self.F,
            interfaces=np.array(ends, np.int64).reshape(-1, 2),
            stored_at=part.patch.ghosted_rows(part.rows(nodes)),
            rows_of_stored=rows,
        )
        return text_of(kernels, d, WIDTH, self._order), record, (images, normals, *OF_SOLID)

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
