"""The semi-discrete scheme of blocks: one right-hand side, for any number of dimensions and ranks.

    complete   particles share what is extensive; the grids of the gas follow the solids;
               velocities obey the constraints
    rates      volume terms of each block, what passes open faces, forcing; then the constraints
               of the particles

A phase is a list of calls: procedures of parts and particles (fsipetsc.kernels.procedure), and
exchanges between ranks, which C makes, too (fsipetsc.parallel.exchange). C makes all calls of a
phase, and those of many steps where no data depend on time. `y` is a
fsipetsc.parallel.block_layout.BlockVector; `f` an array of the same layout.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fsipetsc.blockrun.block_part import Recorded
from fsipetsc.blockrun.columns import OF_INTERFACES, gain_of, slices
from fsipetsc.blockrun.gas_part import GasPart
from fsipetsc.blockrun.particle_system import ParticleSystem
from fsipetsc.blockrun.recorded_data import Recorder
from fsipetsc.blockrun.solid_part import SolidPart
from fsipetsc.blocks.particles import particles_of
from fsipetsc.blocks.values import block_values
from fsipetsc.errors import InputError
from fsipetsc.kernels.calls import Calls, calling_code
from fsipetsc.parallel.block_layout import BlockVector
from fsipetsc.parallel.exchange import Reduction, exchange_text
from fsipetsc.process.libraries import libraries
from fsipetsc.process.together import together
from fsipetsc.scheme import steps as stages
from fsipetsc.scheme.batch import ALLOWED, plan_next
from fsipetsc.scheme.normals import turned_faces
from fsipetsc.scheme.plan import BAD, SAID_STOP
from fsipetsc.scheme.timed import OF_STAGES, TIMES, set_time
from fsipetsc.stepping.state import FAULT

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

    form: fsipetsc.blockrun.block_state.BlockForm, of convection and dissipation.

    What comes in from outside is integrated in auxiliary unknowns, in the order of
    fsipetsc.blockrun.columns.gained. steady: no data of conditions, forcing, jumps depend on time.
    asks: some do, and not all of these are recorded: Python is asked at each stage. not_recorded:
    why, on this rank.
    fault: the first error of a function of the case's on this rank, after `initial`. The rank goes
    on with the data before it, so that others do not wait for its messages; all end after the step.
    """

    def __init__(
        self,
        state: BlockState,
        order: int,
        form: Any,
        announce: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.problem, self._instant, layout = state.problem, state.instant, state.layout
        self._layout = layout
        problem = self.problem
        particles, blocks = particles_of(problem), problem.blocks

        def make() -> dict[int, GasPart | SolidPart]:
            kinds = {"fluid": GasPart, "solid": SolidPart}
            of = layout.parts.items()
            return {k: kinds[blocks[k].kind](layout, part, order, form) for k, part in of}

        self.parts = together(layout.comm, make)  # a grid or a prestress may be wrong on some ranks
        self._gases = [part for part in self.parts.values() if isinstance(part, GasPart)]
        self._solids = [part for part in self.parts.values() if isinstance(part, SolidPart)]
        inertia = {part.part.k: part.inertia for part in self._solids}
        self.particles = ParticleSystem(layout, particles, inertia, self._instant)
        for gas in self._gases:
            gas.follow(particles, self.particles)
        self._came = gain_of(problem)
        #: the solution, and two stages: each becomes the next one
        self._now = state.y, *state.stages, state.stages[0]
        self._found = self._memory(state, max(1.0, form.shock * PACE_AT_SHOCKS[order]))
        self._at_faces = {k: self.particles.faces_at(k) for k in self.parts}
        for gas in self._gases if problem.dimension == 3 else ():
            faces = self._at_faces[gas.part.k]
            gas.grid.name_faces(turned_faces(faces, gas.part.patch))
        self.steady = problem.steady_data
        self._compile(state, announce)
        self._phases: dict[Any, Calls] = {}
        self.fault: InputError | None = None
        self._filled: tuple[Any] | None = None  # the instant that the data are of

    def _memory(self, state: BlockState, pace: float) -> stages.Found:
        """What steps take and fill."""
        first = slices(state.latest.dtype).get(OF_INTERFACES[0], slice(0, 0))
        ends = slice(first.start, first.start + len(OF_INTERFACES) * (first.stop - first.start))
        at_ends = state.latest_numbers[ends].reshape(len(OF_INTERFACES), -1)
        memory = state.y.array, np.zeros(state.layout.local_size), state.before
        noted = state.extremes, state.rates, state.results, state.latest_numbers, at_ends, pace
        now, stage = np.zeros((2, 3))
        return stages.Found(*memory, self._came, *noted, state.plan, now, stage, self._left())

    def _left(self) -> Array:
        """(runs, 2) of the numbers of this rank's part of a world vector with rates that something
        adds to after a sweep.
        """
        left = np.ones(self._layout.local_size, bool)
        for part in self.parts.values():
            left[part.part.begin : part.part.end].reshape(part.part.dof, -1)[:, part.free_nodes] = 0
        ends = np.flatnonzero(np.diff(left, prepend=False, append=False))
        return ends.reshape(-1, 2).astype(np.int64)

    def _compile(self, state: BlockState, announce: Callable[[str], None]) -> None:
        """Record all procedures, and load them. Collective. InputError."""
        columns = slices(state.latest.dtype)
        about = Recorded(
            self.particles.record,
            self.particles,
            self._came,
            self._found,
            self._at_faces,
            {name: at.start for name, at in columns.items()},
            list(state.interface_ends()),
        )
        comm, found = state.comm, self._found
        codes = together(comm, lambda: [part.record(about) for part in self.parts.values()])
        self._calling = calling_code(exchange_text())
        record = self._calling.procedure
        of_found = stages.begin_monitor, stages.note_extremes, stages.note_gained
        of_step = stages.begin_step, *of_found, stages.end_step
        self._does = {f.__name__: record(f.__name__, f, found) for f in of_step}
        self._does["clear_gain"] = record("clear_gain", stages.clear_gain, self._came)
        self._does["plan_next"] = state.planning = record("plan_next", plan_next, found.plan)
        self._stages = [f"stage_{number}" for number in range(stages.STAGES)]
        for number, name in [(None, "rates"), *enumerate(self._stages)]:
            self._does[f"begin_{name}"] = record(f"begin_{name}", stages.begin_stage(number), found)
            if number is not None:
                self._does[name] = record(name, stages.advance(number), found)
        for name, part_of_step in TIMES.items():
            self._does[name] = record(name, set_time(part_of_step), found.now)
        self._record_data(comm)
        codes = [*codes, *self._data, self.particles.procedures(self._came), self._calling]
        made = libraries(comm, [code.text for code in codes], announce)
        for code, library in zip(codes, made, strict=True):
            code.load(library)
        self._check_recorded(comm)
        self._does |= self.particles.does
        self._does["reduce"] = Reduction(comm, state.extremes)
        halos = self._layout.halos, *(part.inside for part in self._layout.parts.values())
        particles = self.particles.sums, self.particles.areas, self.particles.stored
        gathers = (gas.gather for gas in self._gases)
        for exchange in (*halos, *particles, *gathers, self._does["reduce"]):
            exchange.load(self._calling.library)
        self.particles.begin()
        for gas in self._gases:
            gas.begin()

    def _record_data(self, comm: Any) -> None:
        """Record data that depend on time, if all can be. Collective."""
        having = () if self.steady else (*self.parts.values(), self.particles.prescribed)
        self._recorders = [Recorder() for _ in having]
        for part, recorder in zip(having, self._recorders, strict=True):
            part.record_data(recorder)
        self.not_recorded = [why for recorder in self._recorders for why in recorder.refused]
        self.asks = comm.allreduce(bool(self.not_recorded), MPI.LOR)
        recorders = [] if self.asks else self._recorders
        codes = [recorder.code(self._found.now) for recorder in recorders]
        self._data = [code for code in codes if code is not None]

    def _check_recorded(self, comm: Any) -> None:
        """Let Python be asked if recorded data are not finite at t = 0, as those of a wall that
        begins with an infinite acceleration. So it is after a restart, too. Collective.
        """
        if not self.steady and not self.asks:
            self._fill(0.0)
            bad = [recorder.faulty() for recorder in self._recorders]
            self.not_recorded = [f"{what}: it is not finite at t = 0" for what in bad if what]
            self.asks = comm.allreduce(bool(self.not_recorded), MPI.LOR)

    def _fill(self, t: float) -> None:
        """Let C fill the recorded data at time t [s]."""
        self._found.now[stages.AT] = t
        for code in self._data:
            code.procedures[0]()

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
        """Let grids of gases follow the solids, and J be that of the grid, at the same density,
        velocity and temperature. Gas at walls then gets their velocity, at the same temperature.
        """
        self._refresh(t)
        self._do("share", y.array)
        for gas in self._gases:
            gas.stretch(y.owned(gas.part.k))
            gas.impose_velocities(y.owned(gas.part.k), *self.particles.at_walls(gas.part.k))

    def _refresh(self, t: float) -> None:
        """Data of the case at time t [s]. InputError the first time; later ones are kept."""
        if self.asks or self._filled is None or self.particles.prescribed.doubtful:
            self._ask(t)
        if not self.asks:
            self._fill(t)

    def _ask(self, t: float) -> None:
        """Ask Python for the data at time t [s]. InputError the first time."""
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

    # phases: procedures, and exchanges between them

    def _calls(self, phase: str, y: Array, f: Array) -> list[Any]:
        """The calls of a phase, with the world vectors that each takes. It reads as the method."""
        particles, parts = self.particles, self.parts.values()
        slips, stores, found = particles.slips, particles.stores, list[Any]()

        def call(*names: str, of: tuple[Array, ...] = (y, f)) -> None:
            for name in names:
                found.append((self._does[name], of[: len(self._does[name].vectors)]))

        def each(name: str) -> None:
            does = (part.does[name] for part in parts if name in part.does)
            found.extend((procedure, (y, f)[: len(procedure.vectors)]) for procedure in does)

        def exchange(one: Any) -> None:
            if not one.empty:
                found.append((one, (y,)[: len(one.vectors)]))

        def halos(inside: bool = False) -> None:
            exchange(self._layout.halos)
            for part in parts:
                if part.part.has_halo and (inside or part.reads_ghosted):
                    exchange(part.part.inside)
            each("images")

        def follow() -> None:
            each("follow")
            for gas in self._gases:
                exchange(gas.gather)

        if phase == "share":
            call("weigh")
            exchange(particles.sums)
            call("end_sums")
            follow()
            each("move")
        if phase == "impose":
            if slips:
                each("normals")
                exchange(particles.areas)
                call("end_normals")
            if stores:
                call("begin_stored")
                halos()
                each("store")
                exchange(particles.stored)
                call("weigh_heat")
            call("impose_conditions")
            if slips:  # the conditions have changed velocities
                follow()
            each("swing")
        if phase == "rates" or phase in self._stages:
            call(f"begin_{phase}", "clear_gain")
            if slips:
                each("turn")
                exchange(particles.areas)
                call("end_turning")
            halos()
            each("finish")
            each("rates")
            call("weigh", of=(f,))
            exchange(particles.sums)
            call("end_rates")
        if phase in self._stages:
            call(phase, of=(f,))
        if phase == "halos":
            halos(inside=True)
        if phase == "inside":  # of those that have halos already
            for part in parts:
                if part.part.has_halo and not part.reads_ghosted:
                    exchange(part.part.inside)
        if phase == "monitor":
            call("begin_monitor")
            halos()
            each("finish")
            each("monitor")
            if self._layout.comm.size > 1:
                call("reduce")
            call("note_extremes")
        return found

    def _do(self, phases: str, y: Array, f: Array | None = None) -> None:
        """Make the calls of phases, whose names have blanks between; f: y if not given."""
        vectors = y, y if f is None else f
        key = phases, *(vector.ctypes.data for vector in vectors)
        if key not in self._phases:
            calls = [call for phase in phases.split() for call in self._calls(phase, *vectors)]
            self._phases[key] = Calls(self._calling.library, calls)
        self._phases[key]()

    def complete(self, t: float, y: BlockVector) -> None:
        """Impose on y, in place, all conditions of its particles. Collective."""
        self._refresh(t)
        self._do("share impose", y.array)

    def rates(self, t: float, y: BlockVector, f: Array) -> None:
        """f = dy/dt for a completed y. Collective."""
        self._refresh(t)
        self._do("rates", y.array, f)

    def _steps_of_stages(self) -> list[tuple[str, BlockVector, BlockVector]]:
        """The phase of each stage, of which vector it takes the rates, and where it goes."""
        return list(zip(self._stages, self._now, (*self._now[1:], self._now[0]), strict=True))

    def step(
        self, t: float, dt: float, ends: Callable[[BlockVector], bool] | None = None
    ) -> bool:
        """A step of the classical Runge-Kutta method from the solution at t [s] to the completed
        one at t + dt. Collective. It is PETSc's ``-ts_type rk -ts_rk_type 4`` up to round-off.

        It begins with what follows from y alone, so that a step after a restart has the same bits.
        ends: if given, called with each completed stage; where it says True, the step ends, and
        returns True.
        """
        y = self._now[0]
        self._found.now[1] = dt
        instants = t, t + 0.5 * dt, t + 0.5 * dt, t + dt
        for (name, now, to), instant in zip(self._steps_of_stages(), instants, strict=True):
            self._refresh(instant)
            if ends is None:
                self._do(f"share impose {name}", now.array, to.array)
            else:
                self._do("share impose", now.array)
                if now is not y and ends(now):
                    return True
                self._do(name, now.array, to.array)
        self.complete(t + dt, y)
        return ends is not None and ends(y)

    def steps(self, t: float, dt: float) -> tuple[bool, float, float]:
        """Make the steps of a batch from t [s] on, the first of dt [s]. Returns whether all ended
        well, and the time that is reached; else begin and length of the step to be made anew.
        """
        self._refresh(t)
        found, does = self._found, self._does
        if self.fault is not None:
            found.results[SAID_STOP] = FAULT
        if "batch" not in self._phases:
            calls: list[Any] = [(does["begin_step"], ())]
            y, data = self._now[0], [(code.procedures[0], ()) for code in self._data]
            for (name, now, to), time in zip(self._steps_of_stages(), OF_STAGES, strict=True):
                if data and time:
                    calls += [(does[time], ()), *data]
                for phase in ("share", "impose", name):
                    calls += self._calls(phase, now.array, to.array)
            for phase in ("share", "impose", "monitor"):
                calls += self._calls(phase, y.array, y.array)
            calls.append((does["note_gained"], (y.array,)))
            self._phases["batch"] = Calls(self._calling.library, [*calls, (does["end_step"], ())])
        found.now[:2] = t, dt
        results, batch = found.results, found.plan.batch
        self._phases["batch"].batch(results[BAD:], batch[ALLOWED:])
        return bool(results[BAD] == 0.0), float(found.now[0]), float(found.now[1])

    def check_data(self, times: Sequence[float]) -> None:
        """InputError where recorded data are wrong at some of these times [s]. Collective."""

        def check() -> None:
            for t in times:
                self.particles.prescribed.refresh(t)
                for part in self.parts.values():
                    part.refresh(t)
                self._fill(t)
                for what in filter(None, (recorder.faulty() for recorder in self._recorders)):
                    why = "expected a motion with a finite acceleration"
                    raise InputError(f"{what} is not finite at t = {t:.6g}: {why}")

        if self._data and not self.asks:
            together(self._layout.comm, check)

    def monitor(self, y: BlockVector) -> None:
        """Put extremes of all ranks, shares of the integrals of this rank's nodes, and what is
        recorded of interfaces, where the state has it; fill ghosted arrays. y: the solution,
        completed. Collective.
        """
        self._do("monitor inside", y.array)

    def fill_halos(self, y: BlockVector) -> None:
        """Fill the ghosted arrays of all parts. Collective."""
        self._do("halos", y.array)

    def note_gained(self, y: BlockVector) -> None:
        """Put what came in into the record of the step."""
        self._does["note_gained"](y.array)

    def destroy(self) -> None:
        """Release the messages, before the layout."""
        self.particles.destroy()
        for gas in self._gases:
            gas.gather.destroy()

    def forget(self) -> None:
        """Clear what gases remember of a bad state: no NaN may stay there for another step."""
        for gas in self._gases:
            gas.volume.forget()
