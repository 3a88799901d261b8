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

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.columns import gain_of, spins
from fsipetsc.blockrun.gas_part import GasPart
from fsipetsc.blockrun.particle_system import ParticleSystem
from fsipetsc.blockrun.solid_part import SolidPart
from fsipetsc.blocks.particles import particles_of
from fsipetsc.blocks.values import block_values
from fsipetsc.errors import InputError
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.operators.boxed import Box, with_calls
from fsipetsc.parallel.block_layout import BlockLayout, BlockVector
from fsipetsc.process.together import together
from fsipetsc.scheme import particles as kernels
from fsipetsc.scheme import solid_record
from fsipetsc.scheme.block_monitor import LEAST_J, MONITORED
from fsipetsc.scheme.normals import add_areas
from fsipetsc.scheme.part import PartCalls
from fsipetsc.scheme.runge_kutta import STAGES, advance
from fsipetsc.scheme.steps import COMPLETE, MONITOR, RATES, STEPS, All, Found, run

Array = NDArray[Any]


class Scheme:
    """Right-hand side of a problem on this rank's parts of its blocks. Making one is collective on
    ``layout.comm``.

    form: fsipetsc.blockrun.block_state.BlockForm, of convection and dissipation. instant: says a
    time [s] in which little happens. columns: where the record of a step has which sums. ends:
    number, block, owned row, X of the interfaces in one dimension whose solid's end is here. alone:
    there is one rank, which may make stages in one call. y, stage: arrays of the solution and of a
    stage; buffers: what steps in one call fill, from extremes to journal of
    fsipetsc.scheme.steps.Found.

    What comes in from outside is integrated in auxiliary unknowns, in the order of
    fsipetsc.blockrun.columns.gained. steady: no data of conditions, forcing, jumps depend on time.
    fault: the first error of a function of the case's on this rank, after `initial`. The rank goes
    on with the data before it, so that others do not wait for its messages; all end after the step.
    """

    def __init__(
        self,
        layout: BlockLayout,
        problem: Any,
        order: int,
        form: Any,
        instant: Callable[[], float],
        columns: dict[str, slice],
        ends: Sequence[tuple[int, int, int, float]],
        alone: bool,
        y: Array,
        stage: Array,
        *buffers: Any,
    ) -> None:
        self.problem, self._instant = problem, instant
        self.dimension = d = problem.dimension
        particles, blocks = particles_of(problem), problem.blocks

        def make() -> dict[int, GasPart | SolidPart]:
            kinds = {"fluid": GasPart, "solid": SolidPart}
            of = layout.parts.items()
            return {k: kinds[blocks[k].kind](layout, part, order, form) for k, part in of}

        self.parts = together(layout.comm, make)  # a grid or a prestress may be wrong on some ranks
        self._gases = [part for part in self.parts.values() if isinstance(part, GasPart)]
        self._solids = [part for part in self.parts.values() if isinstance(part, SolidPart)]
        inertia = {part.part.k: part.inertia for part in self._solids}
        fluids = [k for k, block in enumerate(blocks) if block.kind == "fluid"]
        law = blocks[fluids[0]].material.equations(d).law if fluids else PerfectGas(1.4, 1.0)
        self.particles = ParticleSystem(layout, particles, law, inertia, instant)
        for gas in self._gases:
            gas.follow(particles, self.particles)
        self._came = gain_of(problem)
        self._gain = Box(self._came)  # as compiled code takes it
        #: compiled code does not find area vectors of solids in three dimensions, nor how they turn
        self.alone = alone and d < 3
        self._records(columns, ends, fluids)
        self._memory = tuple(np.zeros(layout.local_size) for _ in range(2))
        stages = y, stage, *self._memory, np.zeros_like(y)
        self._found = Found(*stages, self._gain, *buffers, np.zeros(2))
        self._noted = Box(self._found._replace(stage=y))
        self.steady = problem.steady_data
        self.fault: InputError | None = None
        self._filled: tuple[Any] | None = None  # the instant that the data are of

    def _records(self, columns: dict[str, slice], ends: Sequence[Any], fluids: list[int]) -> None:
        """Parts as records in boxes, and what is done with them."""
        first = {name: where.start for name, where in columns.items()}
        momenta = [first[f"momentum_{x}"] for x in "xyz"[: self.dimension]]
        turns = [first[name] for name in spins(self.dimension)]
        self._does: dict[int, PartCalls] = {}
        self._at_faces = {k: self.particles.faces_at(k) for k in self.parts}
        for k, part in self.parts.items():
            faces = self._at_faces[k]
            if isinstance(part, GasPart):
                mass = first["mass"] + fluids.index(k)
                sums = np.array([mass, *momenta, first["energy"], first["entropy"], *turns])
                record: Any = part.record(fluids.index(k), sums, faces, self.alone)
                functions = part.functions
            else:
                own = [(number, row, X) for number, block, row, X in ends if block == k]
                stored = self.particles.telling[k]
                lost = [first[name] for name in ("solid_energy", "lost_energy") if name in first]
                sums = np.array([*momenta, first["energy"], *turns, *lost])
                record = part.record(sums, faces, self.alone, own, stored)
                stores = self.particles.stores and not part.equations.coupled
                functions = solid_record.functions(stores, self.dimension == 1)
            self._does[k] = PartCalls(Box(record), *functions)
        self._of_gases = [(gas, self._does[gas.part.k]) for gas in self._gases]

    @cached_property
    def _all(self) -> Any:
        """All that compiled code takes for stages in one call."""
        found, gain, particles = Box(self._found), self._gain, self.particles.box
        y = self._found.y
        takes = (particles,), (), (), (particles,), (particles,)
        takes += (particles, y), (y, y, gain), (y,), (found,)
        parts = [
            with_calls(PartCalls, part, zip(functions, takes, strict=True))
            for part, *functions in self._does.values()
        ]
        return Box(All(tuple(parts), self.particles.calls(y, gain), found))

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
            run(self._all, COMPLETE, y.array, y.array)
            return
        particles, box = self.particles, self.particles.box
        self._share(y)
        if particles.slips:
            kernels.begin_normals(box)
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
            kernels.end_stored(box)
        kernels.impose_conditions(box, y.array, self._gain)
        if particles.slips:  # the conditions have changed velocities
            self._follow()
        for _, does in self._of_gases:
            does.swing(does.part)

    def _share(self, y: BlockVector) -> None:
        """Add up what members have, and let the grids follow the displacement of solids and walls.
        Collective.
        """
        kernels.begin_sums(self.particles.box, y.array, self._gain)
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
            run(self._all, RATES, y.array, f)
            return
        particles, box = self.particles, self.particles.box
        self._came.numbers[:] = 0.0
        y.begin()
        if particles.slips:
            kernels.begin_normals(box)
            for gas, does in self._of_gases:
                does.turn(does.part, box)
                if gas.moves and self.dimension == 3:
                    faces, turning = self._at_faces[gas.part.k], gas.grid.record.turning()
                    add_areas(faces, 3, turning, particles.areas.table)
            particles.areas.exchange()
            kernels.end_normals(box, True)
        y.end()
        for solid in self._solids:
            solid.faces.turn(y.ghosted(solid.part.k))
        for does in self._does.values():
            does.rates(does.part, y.array, f, self._gain)
        kernels.begin_rates(box, f)
        particles.sums.exchange()
        kernels.end_rates(box, y.array, f, self._gain)

    def step(self, t: float, dt: float, y: BlockVector, stage: BlockVector) -> None:
        """A step of the classical Runge-Kutta method from y at t [s] to the completed one at
        t + dt. Collective. It is PETSc's ``-ts_type rk -ts_rk_type 4`` up to round-off.

        It begins with what follows from y alone, so that a step after a restart has the same bits.
        """
        (k, total), now = self._memory, y
        for number, instant in enumerate((t, t + 0.5 * dt, t + 0.5 * dt, t + dt)):
            self.complete(instant, now)
            self.rates(instant, now, k)
            now = stage if number < STAGES - 1 else y
            advance(y.array, k, now.array, total, number, dt)
        self.complete(t + dt, y)

    def steps(self, t: float, dt: float) -> tuple[bool, float, float]:
        """The steps of a batch from t [s] on, the first of dt [s]: whether all ended well, and
        the time that is reached; or begin and length of a step that is to be made anew.
        """
        self._refresh(t)
        self._found.now[:] = t, dt
        ended_well = run(self._all, STEPS, self._found.stage, self._found.k)
        return bool(ended_well), float(self._found.now[0]), float(self._found.now[1])

    def monitor(self, y: BlockVector) -> None:
        """Put extremes and shares of the integrals of this rank's nodes, and what is recorded of
        interfaces, where `attach` has said. y: the solution, completed, whose halos are filled.
        """
        found, blocks = self._found, len(self.problem.blocks)
        found.extremes[:], found.latest[:] = 0.0, 0.0
        found.extremes[1:].reshape(blocks, MONITORED)[:, LEAST_J] = -np.inf
        if self.alone:
            run(self._all, MONITOR, y.array, y.array)
        for does in self._does.values():
            if not self.alone:
                does.monitor(does.part, y.array)
            does.note(does.part, self._noted)

    def forget(self) -> None:
        """Clear what gases remember of a bad state: no NaN may stay there for another step."""
        for gas in self._gases:
            gas.work.w[:] = 0.0
