"""A rank's part of a gas block: its record for compiled code, its moving grid, what is saved."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.asked import Asked, Forced
from fsipetsc.blockrun.face_terms import FaceTerms, ranges_of, weights_of
from fsipetsc.blockrun.particle_system import ParticleSystem
from fsipetsc.blocks.grid import GridMotion
from fsipetsc.blocks.particles import Particle
from fsipetsc.blocks.values import block_values
from fsipetsc.operators.undivided import differences, sigma_of
from fsipetsc.parallel.block_layout import BlockLayout, FaceGather, Part
from fsipetsc.scheme import gas_record
from fsipetsc.scheme.block_look import J_ERROR, LOOKED, room_of, sums_of
from fsipetsc.scheme.gas_dissipation import room
from fsipetsc.scheme.gas_rates import DivergenceForm, EntropyForm, Inviscid, Viscous, scratch
from fsipetsc.scheme.gas_record import Damping, GasRecord, Undamped
from fsipetsc.scheme.normals import add_areas
from fsipetsc.scheme.radial import Radial, Straight

Array = NDArray[Any]


class GasPart(Forced):
    """One part of a gas block. metrics: (d d + d + 1, N), a^k, velocity of the grid, J_t."""

    held = gas_record.HELD

    def __init__(
        self, layout: BlockLayout, part: Part, order: int, form: Any, asked: Asked
    ) -> None:
        self.part, self._layout, self._problem = part, layout, layout.problem
        self.block = self._problem.blocks[part.k]
        self._order, self._form, self._asked = order, form, asked
        self._d = d = self.block.dimension
        self.equations = self.block.material.equations(d, self._problem.symmetry)
        self._ranges = ranges_of(part, self.block.shape)
        self.X = self._problem.positions(part.k, self._ranges)
        self.metrics = np.zeros((d * d + d + 1, self.X.shape[1]))
        self._places = self.X.copy()
        self._owned = part.ghosted_rows(np.arange(part.numbers.size))
        self.faces = FaceTerms(self._problem, part, order, self.X, asked)

    def follow(self, particles: Sequence[Particle], system: ParticleSystem) -> None:
        """Let the grid follow the particles that have a solid, or are on walls that move.

        Collective on the block's ranks.
        """
        k, blocks = self.part.k, self._problem.blocks
        nodes = np.array(
            [
                n
                for particle in particles
                if particle.moves or any(blocks[b].kind == "solid" for b, _ in particle.members)
                for b, n in particle.members
                if b == k
            ],
            np.int64,
        )
        self.grid = GridMotion(self._problem, k, self._order, self._ranges, nodes)
        self.gather = FaceGather(self._layout, k, {"known": nodes}, 2 * self._d)
        own, particle = system.nodes[k]
        self._particles = particle[np.searchsorted(own, self.gather.nodes)]
        self.moves = nodes.size > 0
        self.grid.move(np.zeros((nodes.size, self._d)), self.metrics)
        #: J of the reference map, over which that of the solution is saved and looked at
        self._reference = self.grid.jacobian()[self._owned].copy()

    def record(self, column: int, columns: Array, at_particles: Any, alone: bool) -> GasRecord:
        """For compiled code. column: of its mass in what comes in; columns: of its sums in the
        record of a step. at_particles: its faces at constraints. alone: a rank has all blocks.
        """
        part, d, known = self.part, self._d, self.gather.local
        bands, patch, form, material = part.bands, part.patch, self._form, self.block.material
        like, friction = (0.0,) * d, Viscous() if material.mu or material.kappa else Inviscid()
        convection = DivergenceForm() if form.convection == "divergence" else EntropyForm()
        sigma, shock = sigma_of(form.dissipation, self._problem.joined), form.shock
        damping: Any = Undamped()
        if sigma > 0.0 or shock > 0.0:
            found = differences(d, self._order, bands, self.block.cells)
            damping = Damping(sigma, shock, found, room(d, found))
        return GasRecord(
            like,
            self.equations,
            convection,
            friction,
            damping,
            self._axis(),
            self.faces.record,
            part.k,
            part.begin,
            column,
            part.local if part.has_halo else np.empty((0, part.dof)),
            int(alone and part.has_halo),
            part.signs,
            self.X,
            self._places,
            self.metrics,
            tuple(band.S for band in bands),
            tuple(band.weight for band in bands),
            patch,
            scratch(like, convection, friction, bands, patch),
            np.array(self.block.cells, float),
            room_of(d),
            weights_of(part, self._owned),
            self._particles,
            known,
            known if part.comm.size == 1 else self.gather.whole["known"],
            self.grid.record(),
            at_particles,
            self._reference,
            forcing=self.supplied(d + 2),
            came=np.zeros(d + 2),
            seen=np.zeros(LOOKED),
            sums=np.zeros(sums_of(d)),
            columns=columns,
        )

    def _axis(self) -> Any:
        """What an axis or a centre adds."""
        grid = self.grid.radial
        return Straight() if grid is None else Radial(grid, np.zeros((3, self.X.shape[1])))

    # the grid in three dimensions, which compiled code does not move

    def move(self, known: Array) -> None:
        """a^k from displacements and velocities (m, 2d) of the nodes that it follows."""
        if self.moves and self._d == 3:
            self.grid.move(known[:, : self._d], self.metrics)

    def swing(self, known: Array) -> None:
        """Velocity of the grid and J_t."""
        if self.moves and self._d == 3:
            self.grid.velocities(known[:, self._d :], self.metrics)

    def find_places(self) -> None:
        """Where the nodes are."""
        if self.moves and self._d == 3:
            self._places[:] = self.grid.positions()

    def add_turning(self, faces: Any, table: Array) -> None:
        """Add how area vectors at faces turn to rows of a table."""
        if self.moves and self._d == 3:
            add_areas(faces, 3, self.grid.turning(), table)

    def judge(self, q: Array, seen: Array) -> None:
        """How far J of q (M, d + 3) is from that of the grid."""
        if self._d == 3:
            J, own = q[:, 0], self.grid.jacobian()[self._owned] if self.moves else q[:, 0]
            seen[J_ERROR] = (np.abs(J - own) / np.abs(own)).max(initial=0.0)

    def initial(self, t: float, q: Array) -> None:
        """Fill q (M, d + 3) with the case's data, with J = 1."""
        X = self.X[:, self._owned]
        rho, *u, T = block_values(self.block, "initial", X, t)
        for c, values in enumerate(self.equations.conserved(1.0, rho, tuple(u), T)):
            q[:, c] = values

    def stretch(self, q: Array) -> None:
        """Let J be that of the grid, at the same density, velocity and temperature."""
        q *= (self.grid.jacobian()[self._owned] / q[:, 0])[:, None]

    def hold(self, q: Array, nodes: Array, u: Array) -> None:
        """Let nodes have the velocities u (n, d), at the same temperature."""
        rows, d = self.part.rows(nodes), self._d
        momentum = q[rows, 1, None] * u
        change = (momentum**2 - q[rows, 2 : 2 + d] ** 2).sum(axis=1) / q[rows, 1]
        q[rows, 2 : 2 + d], q[rows, 2 + d] = momentum, q[rows, 2 + d] + 0.5 * change

    def fields(self, q: Array, rows: slice = slice(None)) -> Array:
        """(…, 2d + 4) what is saved of these rows of the owned nodes: rho, u, T, p, J over that of
        the reference map, x.
        """
        own, J = self._owned[rows], self._reference[rows]
        q = q[own]
        w = self.equations.primitive(tuple(q.T))
        x = self.grid.positions()[:, own]
        return np.stack([w[0], *self.equations.velocity(w), w[2], w[1], q[:, 0] / J, *x], axis=-1)
