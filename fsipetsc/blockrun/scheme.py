"""The semi-discrete scheme of blocks: one right-hand side, for any number of dimensions and ranks.

    complete   particles share what is extensive; the grids of the gas follow the solids;
               velocities obey the constraints
    rates      volume terms of each block, what passes open faces, forcing; then the constraints
               of the particles

Each part of a block is a record in a box, and so are the particles; compiled functions do with them
what there is to do. A rank that has all blocks makes stages in one call, and many steps where no
data depend on time (fsipetsc.scheme.steps); else the same functions are called between the
exchanges. `y` is a fsipetsc.parallel.block_layout.BlockVector; `f` an array of the same layout.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.columns import OF_INTERFACES, gain_of, slices
from fsipetsc.blockrun.gas_part import GasPart
from fsipetsc.blockrun.particle_system import ParticleSystem
from fsipetsc.blockrun.solid_part import SolidPart
from fsipetsc.blocks.particles import particles_of
from fsipetsc.blocks.values import block_values
from fsipetsc.errors import InputError
from fsipetsc.operators.boxed import Box
from fsipetsc.parallel.block_layout import BlockVector
from fsipetsc.process.libraries import libraries
from fsipetsc.process.together import together
from fsipetsc.scheme import particles as kernels
from fsipetsc.scheme import steps as stages
from fsipetsc.scheme.block_monitor import LEAST_J, MONITORED
from fsipetsc.scheme.normals import add_areas, turned_faces
from fsipetsc.scheme.part import PartCalls
from fsipetsc.scheme.particle_heat import weigh_heat

if TYPE_CHECKING:
    from fsipetsc.blockrun.block_state import BlockState

Array = NDArray[Any]
#: by order: how much shorter steps are with dissipation of strength 1 at shocks. That alone is a
#: number of -1.6 at Courant number 0.8, of 2.785 that the classical method bears; next to the ends
#: of 8/4 more
PACE_AT_SHOCKS = {2: 1.0, 4: 1.0, 6: 1.0, 8: 4.0 / 3.0}


class Scheme:
    """Right-hand side of the problem of a state on this rank's parts of its blocks. Making one is
    collective. InputError.

    form: fsipetsc.blockrun.block_state.BlockForm, of convection and dissipation. alone: there is
    one rank, which may make stages in one call.

    What comes in from outside is integrated in auxiliary unknowns, in the order of
    fsipetsc.blockrun.columns.gained. steady: no data of conditions, forcing, jumps depend on time.
    fault: the first error of a function of the case's on this rank, after `initial`. The rank goes
    on with the data before it, so that others do not wait for its messages; all end after the step.
    """

    def __init__(
        self,
        state: BlockState,
        order: int,
        form: Any,
        alone: bool,
        announce: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.problem, self._instant, layout = state.problem, state.instant, state.layout
        problem = self.problem
        self.dimension = d = problem.dimension
        particles, blocks = particles_of(problem), problem.blocks

        def make() -> dict[int, GasPart | SolidPart]:
            kinds = {"fluid": GasPart, "solid": SolidPart}
            of = layout.parts.items()
            return {k: kinds[blocks[k].kind](layout, part, order, form) for k, part in of}

        self.parts = together(layout.comm, make)  # a grid or a prestress may be wrong on some ranks
        self._gases = [part for part in self.parts.values() if isinstance(part, GasPart)]
        made = libraries(layout.comm, [part.text for part in self.parts.values()], announce)
        for part, library in zip(self.parts.values(), made, strict=True):
            part.library = library
        self._solids = [part for part in self.parts.values() if isinstance(part, SolidPart)]
        inertia = {part.part.k: part.inertia for part in self._solids}
        self.particles = ParticleSystem(layout, particles, inertia, self._instant)
        for gas in self._gases:
            gas.follow(particles, self.particles)
        self._came = gain_of(problem)
        self._gain = Box(self._came)  # as compiled code takes it
        #: compiled code does not find area vectors of solids in three dimensions, nor how they turn
        self.alone = alone and d < 3
        columns = slices(state.latest.dtype)
        begins = {name: at.start for name, at in columns.items()}
        self._at_faces = {k: self.particles.faces_at(k) for k in self.parts}
        #: of gases, the faces whose area vectors are wanted: axis, index along it
        self._turning = {
            gas.part.k: turned_faces(self._at_faces[gas.part.k], gas.part.patch)
            for gas in self._gases
        }
        about = begins, self.particles, self.alone, list(state.interface_ends())
        self._does = {k: p.calls(self._at_faces[k], *about) for k, p in self.parts.items()}
        self._of_gases = [(gas, self._does[gas.part.k]) for gas in self._gases]
        first = columns.get(OF_INTERFACES[0], slice(0, 0))
        ends = slice(first.start, first.start + len(OF_INTERFACES) * (first.stop - first.start))
        at_ends = state.latest_numbers[ends].reshape(len(OF_INTERFACES), -1)
        pace = max(1.0, form.shock * PACE_AT_SHOCKS[order])
        memory = state.y.array, state.stage.array, *np.zeros((3, layout.local_size))
        noted = state.extremes, state.rates, state.results, state.latest_numbers, at_ends, pace
        planned = state.batch, state.rows, np.zeros(2)
        self._found = stages.Found(*memory, self._gain, *noted, *planned)
        self._found_box = Box(self._found)
        self.steady = problem.steady_data
        self.fault: InputError | None = None
        self._filled: tuple[Any] | None = None  # the instant that the data are of

    @cached_property
    def _all(self) -> Any:
        """All that compiled code takes for stages in one call."""
        found, gain, particles = self._found_box, self._gain, self.particles.box
        y = self._found.y
        takes = (particles,), (), (), (particles,), (particles,)
        takes += (particles, y), (y, y, gain), (y, found)
        parts = [
            with_calls(PartCalls, part, zip(functions, takes, strict=True))
            for part, *functions in self._does.values()
        ]
        return Box(stages.All(tuple(parts), self.particles.calls(y, gain), found))

    def initial(self, t: float, y: BlockVector) -> None:
        """Fill y with the data of the case at time t [s]. InputError for what its functions return,
        those of exact solutions, conditions and forcing as well.
        """
        for k, part in self.parts.items():
            part.initial(t, y.owned(k))
            if part.block.exact is not None:
                block_values(part.block, "exact", part.X[:, part.owned], t)
        self._refresh(t)

    def stretch(self, t: float, y: BlockVector) -> None:
        """Let J of gases be that of the grid where the solids have it, at fixed density, velocity
        and temperature; at walls the gas has their velocity, at its temperature.
        """
        self._refresh(t)
        self._share(y)
        for gas in self._gases:
            gas.stretch(y.owned(gas.part.k))
            gas.impose_velocities(y.owned(gas.part.k), *self.particles.at_walls(gas.part.k))

    def _refresh(self, t: float) -> None:
        """Data of the case at time t [s]. InputError the first time; later ones are kept."""
        differs = self.particles.prescribed.by_differences
        instant = None if self.steady else (t, self._instant() if differs else 0.0)
        if self._filled is not None and self._filled[0] == instant:
            return
        try:
            self.particles.prescribed.refresh(t)
            for part in self.parts.values():
                part.refresh(t)
        except InputError as error:
            if self._filled is None:
                raise
            self.fault = self.fault or error
        self._filled = (instant,)

    def complete(self, t: float, y: BlockVector) -> None:
        """Impose on y, in place, all conditions of its particles. Collective."""
        self._refresh(t)
        if self.alone:
            stages.run(self._all, stages.COMPLETE, y.array, y.array)
            return
        particles, box = self.particles, self.particles.box
        self._share(y)
        if particles.slips:
            for does in self._does.values():
                does.normals(does.part, box)
            particles.areas.exchange()
            kernels.end_normals(box, False)
        if particles.stores:
            kernels.begin_stored(box, y.array)
            y.fill_halos()
            for does in self._does.values():
                does.store(does.part, box, y.array)
            particles.stored.exchange()
            weigh_heat(box)
        kernels.impose_conditions(box, y.array, self._gain)
        if particles.slips:  # the conditions have changed velocities
            self._follow()
        for _, does in self._of_gases:
            does.swing(does.part)

    def _share(self, y: BlockVector) -> None:
        """Add up what members have, and let the grids follow the displacement of solids and walls.
        Collective.
        """
        kernels.weigh(self.particles.box, y.array)
        self.particles.sums.exchange()
        kernels.end_sums(self.particles.box, self._gain)
        self._follow()
        for _, does in self._of_gases:
            does.move(does.part)

    def _follow(self) -> None:
        """Ranks of a gas tell each other by what its grid moves. Collective."""
        for gas, does in self._of_gases:
            does.follow(does.part, self.particles.box)
            gas.gather.gather()

    def rates(self, t: float, y: BlockVector, f: Array) -> None:
        """f = dy/dt for a completed y. Collective."""
        self._refresh(t)
        if self.alone:
            stages.run(self._all, stages.RATES, y.array, f)
            return
        particles, box = self.particles, self.particles.box
        self._came.numbers[:] = 0.0
        y.begin()
        if particles.slips:
            for gas, does in self._of_gases:
                does.turn(does.part, box)
                if gas.moves and self.dimension == 3:
                    faces = self._at_faces[gas.part.k]
                    turning = gas.grid.turning(self._turning[gas.part.k])
                    add_areas(faces, 3, turning, particles.areas.table)
            particles.areas.exchange()
            kernels.end_normals(box, True)
        y.end()
        for solid in self._solids:
            solid.faces.turn(y.ghosted(solid.part.k), solid.library)
        for does in self._does.values():
            does.rates(does.part, y.array, f, self._gain)
        kernels.weigh(box, f)
        particles.sums.exchange()
        kernels.end_rates(box, y.array, f, self._gain)

    def step(
        self,
        t: float,
        dt: float,
        y: BlockVector,
        stage: BlockVector,
        ends: Callable[[BlockVector], bool] = lambda now: False,
    ) -> bool:
        """A step of the classical Runge-Kutta method from y at t [s] to the completed one at
        t + dt. Collective. It is PETSc's ``-ts_type rk -ts_rk_type 4`` up to round-off.

        It begins with what follows from y alone, so that a step after a restart has the same bits.
        ends: called with each completed stage; where it says True, the step ends, and returns True.
        """
        k, total, now = self._found.k, self._found.total, y
        for number, instant in enumerate((t, t + 0.5 * dt, t + 0.5 * dt, t + dt)):
            self.complete(instant, now)
            if number > 0 and ends(now):
                return True
            self.rates(instant, now, k)
            now = stage if number < stages.STAGES - 1 else y
            stages.advance(y.array, k, now.array, total, number, dt)
        self.complete(t + dt, y)
        return ends(y)

    def steps(self, t: float, dt: float) -> tuple[bool, float, float]:
        """The steps of a batch from t [s] on, the first of dt [s]: whether all ended well, and
        the time that is reached; or begin and length of a step that is to be made anew.
        """
        self._refresh(t)
        self._found.now[:] = t, dt
        ended_well = stages.run(self._all, stages.STEPS, self._found.stage, self._found.k)
        return bool(ended_well), float(self._found.now[0]), float(self._found.now[1])

    def monitor(self, y: BlockVector) -> None:
        """Put extremes and shares of the integrals of this rank's nodes, and what is recorded of
        interfaces, where the state has it. y: the solution, completed, whose halos are filled.
        """
        found, blocks = self._found, len(self.problem.blocks)
        found.extremes[:], found.latest[:] = 0.0, 0.0
        found.extremes[1:].reshape(blocks, MONITORED)[:, LEAST_J] = -np.inf
        if self.alone:
            stages.run(self._all, stages.MONITOR, y.array, y.array)
            return
        for does in self._does.values():
            does.monitor(does.part, y.array, self._found_box)

    def forget(self) -> None:
        """Clear what gases remember of a bad state: no NaN may stay there for another step."""
        for gas in self._gases:
            gas.volume.forget()
