"""A rank's part of a gas block: its record for procedures, its moving grid, what is saved."""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.block_part import BlockPart
from fsipetsc.blockrun.face_terms import nodes_of
from fsipetsc.blocks.block import Block
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Centre
from fsipetsc.blocks.grid import grid_of
from fsipetsc.checks import block_values
from fsipetsc.equations.vectors import dot
from fsipetsc.errors import InputError
from fsipetsc.materials.own import check_inverses, knows_entropy
from fsipetsc.operators.bands import differences, sigma_of
from fsipetsc.parallel.block_layout import BlockLayout, Part
from fsipetsc.particles.members import Particle
from fsipetsc.particles.system import ParticleSystem
from fsipetsc.scheme import gas_procedures as does
from fsipetsc.scheme.gas_dissipation import GasDamping
from fsipetsc.scheme.gas_kernels import CONSERVED, convection_of, gas_kernels
from fsipetsc.scheme.gas_sweep import GasSweep
from fsipetsc.scheme.monitor import COLUMNS, MONITORED
from fsipetsc.scheme.normals import normals, turned_faces
from fsipetsc.scheme.part import Nothing, images
from fsipetsc.scheme.sweep import text_of

Array = NDArray[Any]


class GasPart(BlockPart):
    """One part of a gas block. metrics: (d d + d, N), a^k and the velocity of the grid; around an
    axis also A.
    """

    def __init__(self, layout: BlockLayout, part: Part, order: int, form: Any) -> None:
        super().__init__(layout, part, order, form)
        material = self.block.material
        self.equations = material.equations(self._d, self._problem.symmetry)
        self.viscous = bool(material.mu or material.kappa)
        self._sigma = sigma_of(form.dissipation, self._problem.joined)
        self._check_law(form)
        self.convection = convection_of(form.convection, self.equations)
        damps = self._sigma > 0.0 or form.shock > 0.0
        around, forces = self._problem.symmetry > 0, any(self.equations.force)
        self.added = damps or around or forces or self.block.forcing is not None
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
        faces = turned_faces(self.at_particles, self.part.patch)
        k, blocks = self.part.k, self._problem.blocks
        leading = [
            particle.members
            for particle in particles
            if particle.moves or any(blocks[b].kind == "solid" for b, _ in particle.members)
        ]
        nodes = np.array([n for members in leading for b, n in members if b == k], np.int64)
        where, self.moves = self.part.ghosted, nodes.size > 0
        self._grid, self.metrics = grid_of(self._problem, k, self._order, where, nodes, faces)
        self.gather = self._layout.gather(k, nodes, 2 * self._d)
        _, own, particle = system.own(k)
        self._particles = particle[np.searchsorted(own, nodes[self.gather.rows])]
        #: J of the reference map, over which that of the solution is saved and monitored
        self.reference, self._J = np.zeros((2, self.owned.size))
        self._places = self.X.copy()

    def begin(self) -> None:
        """Find the metrics of the grid where nothing has moved, once the code is loaded."""
        self.does["begin_grid"]()
        self.does["find_volumes"]()
        self.reference[:] = self._J

    def _record(self, system: Any, begins: Mapping[str, int]) -> Any:
        number = [block.kind for block in self._problem.blocks[: self.part.k]].count("fluid")
        integrals = does.gas_integrals(self._d)
        sums = begins["mass"] + number, *(begins[name] for name in integrals[1:])
        part, d, bands = self.part, self._d, self.part.bands
        sigma, shock = self._sigma, self._form.shock
        damping: Any = Nothing()
        if sigma > 0.0 or shock > 0.0:
            found = differences(d, self._order, bands, self.block.cells)
            damping = GasDamping(d, self.convection.raises, found, sigma, shock)
        made = gas_kernels(self.equations, d, self.convection, self.viscous, self.moves)
        self.volume = GasSweep(self.equations, d, made, bands, part.patch)
        potential = self.volume.potential
        potential[:] = -dot(self.equations.force, self.X)[: potential.size]
        room = np.zeros(((d + 1) ** 2, self.X.shape[1])) if self.block.material.mu else None
        record = SimpleNamespace(
            **self._common(begins),
            columns=np.array(sums),
            laws=self.equations,
            volume=self.volume,
            form=self.convection,
            forced=any(self.equations.force),
            dissipation=damping,
            around=self._problem.symmetry > 0,
            hoops=room if self._problem.symmetry else None,
            column=number,
            places=self._places,
            room=np.zeros((MONITORED + len(integrals), COLUMNS)),
            masses=self.weights,
            follows=self._particles,
            rows=self.gather.rows,
            known=self.gather.table,
            moves=self.moves,
            ends=self._ends(),
            grid=self._grid,
            reference=self.reference,
            J=self._J,
            sums=np.zeros(len(integrals)),
        )
        moving = (does.follow, does.edge, does.move, does.swing, does.turn) if self.moves else ()
        own = does.rates, does.monitor, does.begin_grid, does.find_places, does.find_volumes
        text = text_of(made, d, self.volume.width, self._order)
        return text, record, (*moving, images, normals, *own)

    def _ends(self) -> SimpleNamespace:
        """The ends of all axes here, which are none along a periodic axis and at a centre."""
        problem, part, found = self._problem, self.part, [np.zeros((4, 0))]
        for (axis, side), what in problem.faces_of(part.k).items():
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
        for c, values in enumerate(self.equations.conserved(1.0, rho, tuple(u), T)):
            q[:, c] = values

    def stretch(self, q: Array) -> None:
        """Let J be that of the grid, at the same density, velocity and temperature."""
        self.does["find_volumes"]()
        q *= (self._J / q[:, 0])[:, None]

    def impose_velocities(self, q: Array, nodes: Array, u: Array) -> None:
        """Impose the velocities u (n, d) on nodes, at the same temperature."""
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
        own, J = self.owned[rows], self.reference[rows]
        q = q[own]
        w = self.equations.primitive(tuple(q.T))
        self.does["find_places"]()
        x = self._places[:, own]
        return np.stack([w[0], *self.equations.velocity(w), w[2], w[1], q[:, 0] / J, *x], axis=-1)


def loose_gases(problem: BlockProblem, convection: str) -> list[Block]:
    """The gases on which a constant force acts node by node with this -fsi_convection."""
    gases = [block for block in problem.blocks if block.kind == "fluid"]
    of_gases = [gas.material.equations(problem.dimension, problem.symmetry) for gas in gases]
    pairs = zip(gases, of_gases, strict=True)
    return [gas for gas, of in pairs if any(of.force) and not convection_of(convection, of).raises]
