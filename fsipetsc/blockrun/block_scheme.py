"""The semi-discrete scheme of blocks: one right-hand side, for any number of dimensions and ranks.

    complete   particles share what is extensive; the grids of the gas follow the solids;
               velocities obey the constraints
    rates      volume terms of each block, what passes open faces, forcing; then the constraints
               of the particles

`y` is a fsipetsc.parallel.block_layout.BlockVector; `f` an array of the same layout.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.asked import Asked
from fsipetsc.blockrun.gas_part import GasPart
from fsipetsc.blockrun.particle_system import ParticleSystem
from fsipetsc.blockrun.solid_part import SolidPart
from fsipetsc.blocks.particles import particles_of
from fsipetsc.errors import InputError
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.parallel.block_layout import BlockLayout, BlockVector
from fsipetsc.scheme.block_look import LEAST_J, LOOKED

Array = NDArray[Any]


class Scheme:
    """Right-hand side of a problem on this rank's parts of its blocks. Making one is collective on
    ``layout.comm``.

    form: fsipetsc.blockrun.block_state.BlockForm, of convection and dissipation. instant: says a
    time [s] in which little happens.

    What comes in from outside is integrated behind the unknowns of nodes, in the order of
    fsipetsc.blockrun.columns.gained.
    """

    def __init__(
        self,
        layout: BlockLayout,
        problem: Any,
        order: int,
        form: Any,
        instant: Callable[[], float] = lambda: 1e-4,
    ) -> None:
        self.layout, self.problem = layout, problem
        self.dimension = problem.dimension
        particles = particles_of(problem)
        self._asked = asked = Asked()
        self.parts: dict[int, GasPart | SolidPart] = {}
        for part in layout.parts:
            kind = GasPart if problem.blocks[part.k].kind == "fluid" else SolidPart
            self.parts[part.k] = kind(layout, part, order, form, asked)
        self._gases = [part for part in self.parts.values() if isinstance(part, GasPart)]
        solids = {k: part.inertia for k, part in self.parts.items() if isinstance(part, SolidPart)}
        gases = [block.material for block in problem.blocks if block.kind == "fluid"]
        law = gases[0].equations(self.dimension).law if gases else PerfectGas(1.4, 1.0)
        self.particles = ParticleSystem(layout, particles, law, solids, instant, asked)
        for gas in self._gases:
            gas.follow(particles, self.particles)
        fluids = [k for k, block in enumerate(problem.blocks) if block.kind == "fluid"]
        self._columns = {k: column for column, k in enumerate(fluids)}
        self._gain = np.zeros(len(fluids) + self.dimension + 1)

    @property
    def fault(self) -> InputError | None:
        """The first error of a function of the case's on this rank, since when old data are taken.
        """
        return self._asked.fault

    #: whether a rank has all blocks, and makes stages or steps in one call
    alone = False

    def attach(self, columns: Any, ends: Any, alone: bool) -> None:
        """See fsipetsc.blockrun.line_scheme."""

    @property
    def steady(self) -> bool:
        """No data of conditions, forcing or jumps depend on time."""
        timed = self.particles.prescribed.timed or any(part.timed for part in self.parts.values())
        return not timed and self.problem.jumps is None

    def initial(self, t: float, y: BlockVector) -> None:
        """Fill y with the data of the case at time t [s]. InputError for what its functions return,
        those of exact solutions, conditions and forcing as well.
        """
        for k, part in self.parts.items():
            part.initial(t, y.owned(k))
            part.try_exact(t)
            part.faces.ask(t)
            part.ask(t)
        self.particles.prescribed.at(t)
        self.particles.prescribed.displacement(t)

    def stretch(self, t: float, y: BlockVector) -> None:
        """Let J of gases be that of the grid where the solids have it, at fixed density, velocity
        and temperature; at walls the gas has their velocity, at its temperature.
        """
        self._share(t, y)
        self._move(t)
        for gas in self._gases:
            gas.stretch(y.owned(gas.part.k))
            gas.hold(y.owned(gas.part.k), *self.particles.at_walls(gas.part.k))

    def _share(self, t: float, y: BlockVector) -> None:
        """What the members of particles have in common. Collective."""
        self.particles.share(y.array, t, self._gain)

    def complete(self, t: float, y: BlockVector) -> None:
        """Let y obey all that holds its particles, in place. Collective."""
        self.particles.share(y.array, t, self._gain)
        self._move(t)
        self.particles.find_normals(self._metrics)
        if self.particles.stores:
            self._find_stored(y)
        self.particles.settle(y.array, self._gain)
        velocities = self.particles.velocities()
        for gas in self._gases:
            gas.begin_velocities(velocities)
        for gas in self._gases:
            gas.end_velocities()

    def _find_stored(self, y: BlockVector) -> None:
        """What members of solids store, where it matters to temperatures."""
        particles = self.particles
        particles.give_places(y.array)
        y.begin()
        y.end()
        asked = particles.members.items()
        particles.note_stored(
            {k: self.parts[k].stored(y.ghosted(k), nodes) for k, (_, nodes) in asked}
        )

    @property
    def _metrics(self) -> dict[int, Array]:
        return {k: part.metrics for k, part in self.parts.items()}

    def _move(self, t: float) -> None:
        """Let the grids follow the displacement of solids and walls."""
        places = self.particles.places(t)
        for gas in self._gases:
            gas.begin_positions(places)
        for gas in self._gases:
            gas.end_positions()

    def rates(self, t: float, y: BlockVector, f: Array) -> None:
        """f = dy/dt for a completed y. Collective."""
        self._gain[:] = 0.0
        y.begin()
        self.particles.find_turning({gas.part.k: gas.add_turning for gas in self._gases})
        y.end()
        for k, part in self.parts.items():
            came = np.zeros(self.dimension + 2)
            part.rates(t, y.ghosted(k), self.layout.owned(k, f), came)
            self._gain[len(self._columns) :] += came[1:]
            if k in self._columns:
                self._gain[self._columns[k]] += came[0]
        self.particles.constrain(y.array, f, self._gain)

    def bounds(self, t: float, y: BlockVector) -> Array:
        """(blocks, LOOKED) of fsipetsc.scheme.block_look for this rank's nodes; halos of y are
        filled.
        """
        found = np.zeros((len(self.problem.blocks), LOOKED))
        found[:, LEAST_J] = -np.inf
        self._sums = {}
        for k, part in self.parts.items():
            found[k], self._sums[k] = part.look(y.ghosted(k))
        return found

    def integrals(self, t: float, y: BlockVector) -> dict[str, Any]:
        """This rank's shares of the integrals of the solution that ``bounds`` has looked at."""
        names = [f"momentum_{x}" for x in "xyz"[: self.dimension]]
        totals: dict[str, Any] = dict.fromkeys(["energy", *names, "entropy"], 0.0)
        if self._columns:
            totals["mass"] = np.zeros(len(self._columns))
        for k, found in self._sums.items():
            for name, number in found.items():
                if name == "mass":
                    totals["mass"][self._columns[k]] += number
                else:
                    totals[name] += number
        return totals

    def volume_ratio(self, y: BlockVector, k: int) -> Array:
        """(M,) det F of this rank's nodes of the solid block k."""
        return self.parts[k].volume_ratio(y.ghosted(k))

    def at_end(self, y: BlockVector, k: int, row: int, found: Array) -> None:
        """Fill found with x - X, v, sigma, T of an owned node of the solid block k, in one dimension.
        """
        self.parts[k].at_end(y.ghosted(k), row, found)

    def fields(self, t: float, y: BlockVector, k: int) -> Array:
        """(M, columns) what is saved of this rank's nodes of block k."""
        return self.parts[k].fields(y.ghosted(k))

    def destroy(self) -> None:
        """Release messages."""
        self.particles.destroy()
