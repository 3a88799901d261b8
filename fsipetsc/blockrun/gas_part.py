"""A rank's part of a gas block: its moving grid, rates, what is saved of it."""

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
from fsipetsc.operators.narrow import STIFFNESS_OF_WIDE
from fsipetsc.operators.undivided import differences, sigma_of
from fsipetsc.parallel.block_layout import BlockLayout, FaceGather, Part
from fsipetsc.scheme import block_look
from fsipetsc.scheme import normals as of_faces
from fsipetsc.scheme.gas_dissipation import gas_dissipation, room
from fsipetsc.scheme.gas_rates import (
    DivergenceForm,
    EntropyForm,
    Inviscid,
    Viscous,
    gas_rates,
    scratch,
)
from fsipetsc.scheme.line_parts import GasLine
from fsipetsc.scheme.line_terms import GasDamping, Undamped

Array = NDArray[Any]
#: names of the components of momentum
MOMENTUM = ("momentum_x", "momentum_y", "momentum_z")


class GasPart(Forced):
    """One part of a gas block. metrics: (d d + d + 1, N), a^k, velocity of the grid, J_t."""

    def __init__(
        self, layout: BlockLayout, part: Part, order: int, form: Any, asked: Asked
    ) -> None:
        self.part, self._layout, self._problem = part, layout, layout.problem
        self.block = self._problem.blocks[part.k]
        self._order = order
        self._d = d = self.block.dimension
        self._like = (0.0,) * d
        self.equations = self.block.material.equations(d)
        self._ranges = ranges_of(part, self.block.shape)
        self.X = self._problem.positions(part.k, self._ranges)
        self._per_h = np.array(self.block.cells, float)
        nodes = self.X.shape[1]
        self.metrics = np.zeros((d * d + d + 1, nodes))
        self._owned = part.ghosted_rows(np.arange(part.numbers.size))
        self._weights, self._asked = weights_of(part, self._owned), asked
        equations, inertia = self.equations, np.ones(nodes)
        self.faces = FaceTerms(self._problem, part, order, equations, inertia, self.X, asked)
        material = self.block.material
        self._form = DivergenceForm() if form.convection == "divergence" else EntropyForm()
        self._friction = Viscous() if material.mu > 0.0 or material.kappa > 0.0 else Inviscid()
        self._sigma, self._shock = sigma_of(form.dissipation, self._problem.joined), form.shock
        if self._sigma > 0.0 or self._shock > 0.0:
            self._differences = differences(d, order, part.bands, self.block.cells)
            self._room = room(d, self._differences)
        self._row = np.zeros((5, part.patch.own[0]))
        forms = self._like, self._form, self._friction
        self._scratch = scratch(*forms, part.bands, part.patch)

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
        self._nodes = nodes
        self._gather = FaceGather(self._layout, k, {"known": nodes}, self._d)
        own, particle = system.nodes[k]
        self._particles = particle[np.searchsorted(own, self._gather.nodes)]
        self.moves = nodes.size > 0
        self.grid.move(np.zeros((nodes.size, self._d)), self.metrics)
        #: J of the reference map, over which that of the solution is saved and looked at
        self._reference = self.grid.jacobian()[self._owned].copy()

    def line(self, column: int, columns: Array) -> GasLine:
        """Itself as a record, in one dimension. column: of its mass in what comes in; columns: of
        its sums in the record of a step. Collective on the block's ranks.
        """
        part, nodes = self.part, self.X.shape[1]
        self.gather = FaceGather(self._layout, part.k, {"known": self._nodes}, 2)
        damping: Any = Undamped()
        if self._sigma > 0.0 or self._shock > 0.0:
            damping = GasDamping(self._sigma, self._shock, self._differences, self._room)
        moved, moving, ends, low, high = self.grid.line()
        return GasLine(
            self.equations,
            self._form,
            self._friction,
            damping,
            *self.faces.line(nodes),
            part.k,
            part.begin,
            column,
            part.local if part.has_halo else np.empty((0, part.dof)),
            self.metrics,
            np.ones(nodes),
            tuple(band.S for band in part.bands),
            tuple(band.weight for band in part.bands),
            part.patch,
            self._scratch,
            self._per_h,
            self._row,
            self._weights,
            follows=self._particles,
            here=self.gather.local,
            known=self.gather.whole["known"] if part.comm.size > 1 else self.gather.local,
            ends=ends,
            moved=moved,
            moving=moving,
            low=low,
            high=high,
            reference=self._reference,
            forcing=self.supplied(3),
            came=np.zeros(3),
            seen=np.zeros(block_look.LOOKED),
            sums=np.zeros(4),
            columns=columns,
        )

    def begin_positions(self, places: Array) -> None:
        """Send what this rank knows of displacements; places: (particles, d)."""
        if self.moves:
            self._gather.local[:] = places[self._particles]
            self._gather.begin()

    def end_positions(self) -> None:
        """a^k of the grid as it is now."""
        if self.moves:
            self._gather.end()
            self.grid.move(self._gather.whole["known"], self.metrics)

    def begin_velocities(self, velocities: Array) -> None:
        """Send what this rank knows of velocities."""
        self.begin_positions(velocities)

    def end_velocities(self) -> None:
        """Velocity of the grid and J_t."""
        if self.moves:
            self._gather.end()
            self.grid.velocities(self._gather.whole["known"], self.metrics)

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

    def look(self, q: Array) -> tuple[Array, dict[str, float]]:
        """What bounds a step, integrals: see fsipetsc.scheme.block_look; q: (N, d + 3)."""
        d, weights = self._d, [band.weight for band in self.part.bands]
        seen, sums = np.zeros(block_look.LOOKED), np.zeros(d + 3)
        arguments = self.equations, self._like, q, self.metrics, self._per_h, STIFFNESS_OF_WIDE
        block_look.gas_look(*arguments, *weights, self.part.patch, self._row, seen, sums)
        if seen[block_look.BAD]:  # no NaN may stay there for a step that is made again
            self._scratch.w[:] = 0.0
        if self.moves:
            J, own = q[self._owned, 0], self.grid.jacobian()[self._owned]
            seen[block_look.J_ERROR] = (np.abs(J - own) / np.abs(own)).max() if J.size else 0.0
        seen[block_look.LEAST_J] = -(q[self._owned, 0] / self._reference).min()
        names = ["mass", *MOMENTUM[:d], "energy", "entropy"]
        return seen, dict(zip(names, sums.tolist(), strict=True))

    def fields(self, q: Array, rows: slice = slice(None)) -> Array:
        """(…, 2d + 4) what is saved of these rows of the owned nodes: rho, u, T, p, J over that of
        the reference map, x.
        """
        own, J = self._owned[rows], self._reference[rows]
        q = q[own]
        w = self.equations.primitive(tuple(q.T))
        x = self.grid.positions()[:, own]
        return np.stack([w[0], *self.equations.velocity(w), w[2], w[1], q[:, 0] / J, *x], axis=-1)

    def add_turning(self, faces: Any, table: Array) -> None:
        """Add how area vectors at faces turn to rows of a table."""
        if self.moves and self._d == 2:
            of_faces.add_turning(faces, self.part, self.metrics, table)
        elif self.moves and self._d == 3:
            of_faces.add_normals(faces, 3, self.grid.turning(), table)

    def rates(self, t: float, q: Array, rates: Array, gain: Array) -> None:
        """rates (M, d + 3) of the volume terms, of faces and of forcing; q: (N, d + 3). What comes
        in is added to gain (d + 2,): mass, impulse, energy.
        """
        bands, d = self.part.bands, self._d
        S, w = [band.S for band in bands], [band.weight for band in bands]
        chosen = self.equations, self._like, self._form, self._friction
        gas_rates(*chosen, q, self.metrics, *S, *w, self.part.patch, rates, self._scratch)
        if self._sigma > 0.0 or self._shock > 0.0:
            strengths, more = (self._sigma, self._shock), (self._differences, self.part.patch)
            equations = self.equations, self._like, self._form
            gas_dissipation(*equations, *strengths, q, self.metrics, *S, *more, rates, self._room)
        self.faces.add(t, q, self.metrics, rates, gain)
        if any(self.equations.force):
            force = np.array(self.equations.force)
            mass, *momentum = self._weights @ q[self._owned, 1 : 2 + d]
            gain[1 : 1 + d] += mass * force
            gain[1 + d] += force @ momentum
        for c, values in enumerate(self.ask(t)):
            supplied = q[self._owned, 0] * values
            rates[:, 1 + c] += supplied
            gain[c] += self._weights @ supplied
