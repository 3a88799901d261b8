"""The phases of a right-hand side on blocks, which read as the method:

    share      members add up what is extensive; the grids of the gas follow the solids
    impose     the unknowns obey the conditions
    rates      volume terms of each block, what passes open faces, forcing; then the constraints
               of the particles

A phase is a list of calls: procedures of parts and of particles (fsipetsc.kernels.procedure), and
exchanges between ranks (fsipetsc.parallel.exchange). C makes all calls of a list.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fsipetsc.blockrun.block_part import Recorded
from fsipetsc.blockrun.gas_part import GasPart
from fsipetsc.blockrun.saved import slices
from fsipetsc.blockrun.solid_part import SolidPart
from fsipetsc.kernels.calls import Calls, calling_code
from fsipetsc.parallel.block_layout import BlockLayout, BlockVector
from fsipetsc.parallel.exchange import Reduction, exchange_text
from fsipetsc.particles.members import particles_of
from fsipetsc.particles.system import ParticleSystem
from fsipetsc.process.libraries import libraries
from fsipetsc.process.together import together
from fsipetsc.scheme import runge_kutta as stages
from fsipetsc.scheme.normals import turned_faces
from fsipetsc.scheme.plan import RATE, plan_next
from fsipetsc.scheme.recorded_data import OF_STAGES, TIMES, Recorder, set_time

Array = NDArray[Any]
#: names of the procedures of the stages of a step
STAGES = [f"stage_{number}" for number in range(stages.STAGES)]


class Phases:
    """This rank's parts of blocks, the particles they meet in, all procedures of both, and the
    phases as lists of their calls, each made once. Making one is collective. InputError.

    form: fsipetsc.blockrun.block_state.BlockForm. found: what steps take and fill; its left is
    found here. columns: of the record of a step, the type of `latest` there. announce: called on
    rank 0, with a message, before and after kernels are compiled.

    parts: block -> this rank's part; gases: those of gas; particles: in which they meet. does:
    procedures by name, also those between phases (fsipetsc.scheme.runge_kutta). data: code that
    fills recorded data. asks: some data depend on time, and not all of these are recorded: Python
    is asked for them. not_recorded: why, on this rank.
    """

    def __init__(
        self,
        layout: BlockLayout,
        order: int,
        form: Any,
        found: stages.Found,
        columns: np.dtype,
        announce: Callable[[str], None],
    ) -> None:
        self.layout, self.problem, self.found = layout, layout.problem, found
        problem = layout.problem
        particles, blocks = particles_of(problem), problem.blocks

        def make() -> dict[int, GasPart | SolidPart]:
            kinds = {"fluid": GasPart, "solid": SolidPart}
            of = layout.parts.items()
            return {k: kinds[blocks[k].kind](layout, part, order, form) for k, part in of}

        self.parts = together(layout.comm, make)  # a grid or a prestress may be wrong on some ranks
        self.gases = [part for part in self.parts.values() if isinstance(part, GasPart)]
        solids = (part for part in self.parts.values() if isinstance(part, SolidPart))
        inertia = {part.part.k: part.inertia for part in solids}
        self.particles = ParticleSystem(layout, particles, inertia, self.instant)
        self._at_faces = {k: self.particles.faces_at(k) for k in self.parts}
        for gas in self.gases:
            faces = turned_faces(self._at_faces[gas.part.k], gas.part.patch)
            gas.follow(particles, self.particles, faces)
        self.found = found._replace(left=self._left())
        self.steady = problem.steady_data
        self._compile(columns, announce)
        self._made: dict[Any, Calls] = {}
        self._calls: list[Any] = []  # those of the list in the making
        self._y = self._f = found.y

    def instant(self) -> float:
        """A time [s] in which little happens, for differences in time: a power of two, so that it
        is the same in most steps, and data need not be asked for again where the next step begins.
        """
        rate, h = float(self.found.results[RATE]), float(min(self.problem.spacings))
        _, power = math.frexp(0.25 / rate if 0.0 < rate < np.inf else 1e-3 * h)
        return math.ldexp(0.25, power)

    def _left(self) -> Array:
        """(runs, 2) of the numbers of this rank's part of a world vector with rates that something
        adds to after a sweep.
        """
        left = np.ones(self.layout.local_size, bool)
        for part in self.parts.values():
            left[part.part.begin : part.part.end].reshape(part.part.dof, -1)[:, part.free_nodes] = 0
        ends = np.flatnonzero(np.diff(left, prepend=False, append=False))
        return ends.reshape(-1, 2).astype(np.int64)

    def _compile(self, columns: np.dtype, announce: Callable[[str], None]) -> None:
        """Record all procedures, and load them. Collective. InputError."""
        comm, found = self.layout.comm, self.found
        about = Recorded(
            self.particles,
            found,
            self._at_faces,
            {name: at.start for name, at in slices(columns).items()},
            list(self.layout.interface_ends()),
        )
        codes = together(comm, lambda: [part.record(about) for part in self.parts.values()])
        self.calling = calling_code(exchange_text())
        record = self.calling.procedure
        of_found = stages.begin_monitor, stages.note_extremes, stages.note_gained
        of_step = stages.begin_step, *of_found, stages.end_step
        self.does = {f.__name__: record(f.__name__, f, found) for f in of_step}
        self.does["clear_gain"] = record("clear_gain", stages.clear_gain, found.gain)
        self.does["plan_next"] = record("plan_next", plan_next, found.plan)
        for number, name in [(None, "rates"), *enumerate(STAGES)]:
            self.does[f"begin_{name}"] = record(f"begin_{name}", stages.begin_stage(number), found)
            if number is not None:
                self.does[name] = record(name, stages.advance(number), found)
        for name, part_of_step in TIMES.items():
            self.does[name] = record(name, set_time(part_of_step), found.now)
        self._record_data(comm)
        codes = [*codes, *self.data, self.particles.procedures(found.gain), self.calling]
        made = libraries(comm, [code.text for code in codes], announce)
        for code, library in zip(codes, made, strict=True):
            code.load(library)
        self._check_recorded(comm)
        self.does |= self.particles.does
        self.does["reduce"] = Reduction(comm, found.extremes)
        halos = self.layout.halos, *(part.inside for part in self.layout.parts.values())
        particles = self.particles.sums, self.particles.areas, self.particles.stored
        gathers = (gas.gather for gas in self.gases)
        for exchange in (*halos, *particles, *gathers, self.does["reduce"]):
            exchange.load(self.calling.library)
        self.particles.begin()
        for gas in self.gases:
            gas.begin()

    def _record_data(self, comm: Any) -> None:
        """Record data that depend on time, if all can be. Collective."""
        having = () if self.steady else (*self.parts.values(), self.particles.prescribed)
        self.recorders = [Recorder() for _ in having]
        for part, recorder in zip(having, self.recorders, strict=True):
            part.record_data(recorder)
        self.not_recorded = [why for recorder in self.recorders for why in recorder.refused]
        self.asks = comm.allreduce(bool(self.not_recorded), MPI.LOR)
        recorders = [] if self.asks else self.recorders
        codes = [recorder.code(self.found.now) for recorder in recorders]
        self.data = [code for code in codes if code is not None]

    def _check_recorded(self, comm: Any) -> None:
        """Let Python be asked if recorded data are not finite at t = 0, as those of a wall that
        begins with an infinite acceleration. So it is after a restart, too. Collective.
        """
        if not self.steady and not self.asks:
            self.fill(0.0)
            bad = [recorder.faulty() for recorder in self.recorders]
            self.not_recorded = [f"{what}: it is not finite at t = 0" for what in bad if what]
            self.asks = comm.allreduce(bool(self.not_recorded), MPI.LOR)

    def fill(self, t: float) -> None:
        """Let C fill the recorded data at time t [s]."""
        self.found.now[stages.AT] = t
        for code in self.data:
            code.procedures[0]()

    def destroy(self) -> None:
        """Release the messages, before the layout."""
        self.particles.destroy()
        for gas in self.gases:
            gas.gather.destroy()

    def do(self, phases: str, y: Array, f: Array | None = None) -> None:
        """Make the calls of phases, whose names have blanks between; f: y if not given."""
        f = y if f is None else f
        key = phases, y.ctypes.data, f.ctypes.data
        if key not in self._made:
            for phase in phases.split():
                self._phase(phase, y, f)
            self._made[key] = self._list()
        self._made[key]()

    def batch(
        self, stages: Sequence[tuple[str, BlockVector, BlockVector]], solution: BlockVector
    ) -> Calls:
        """The calls of one of many steps made together, with its monitor and the plan of the next
        one. stages: name, whose rates it takes, where it goes.
        """
        if "batch" not in self._made:
            y, data = solution.array, [(code.procedures[0], ()) for code in self.data]
            self._call("begin_step")
            for (name, now, to), time in zip(stages, OF_STAGES, strict=True):
                if data and time:
                    self._call(time)
                    self._calls += data
                for phase in ("share", "impose", name):
                    self._phase(phase, now.array, to.array)
            for phase in ("share", "impose", "monitor"):
                self._phase(phase, y, y)
            self._call("note_gained", "end_step")
            self._made["batch"] = self._list()
        return self._made["batch"]

    def _list(self) -> Calls:
        """The calls that were added since the last list."""
        calls, self._calls = self._calls, []
        return Calls(self.calling.library, calls)

    def _phase(self, name: str, y: Array, f: Array) -> None:
        """Add the calls of a phase, one of the methods below, or of a stage."""
        self._y, self._f = y, f
        if name in STAGES:
            self._rates(name)
            self._call(name, of=(f,))
        else:
            getattr(self, f"_{name}")()

    def _share(self) -> None:
        """Members add up what is extensive; grids follow."""
        self._call("weigh")
        self._exchange(self.particles.sums)
        self._call("end_sums")
        self._follow()
        self._each("move")

    def _impose(self) -> None:
        """The unknowns obey the conditions, and grids have their velocities."""
        if self.particles.slips:
            self._each("normals")
            self._exchange(self.particles.areas)
            self._call("end_normals")
        if self.particles.stores:
            self._call("begin_stored")
            self._fill()
            self._each("store")
            self._exchange(self.particles.stored)
            self._call("weigh_heat")
        self._call("impose_conditions")
        if self.particles.slips:  # the conditions have changed velocities
            self._follow()
        self._each("swing")

    def _rates(self, name: str = "rates") -> None:
        """f = dy/dt, or, of a stage, what follows from it. name: "rates", or that of the stage."""
        self._call(f"begin_{name}", "clear_gain")
        if self.particles.slips:
            self._each("turn")
            self._exchange(self.particles.areas)
            self._call("end_turning")
        self._fill()
        self._each("rates")
        self._call("weigh", of=(self._f,))
        self._exchange(self.particles.sums)
        self._call("end_rates")

    def _monitor(self) -> None:
        """Extremes of all ranks, and this rank's shares of integrals."""
        self._call("begin_monitor")
        self._fill()
        self._each("monitor")
        if self.layout.comm.size > 1:
            self._call("reduce")
        self._call("note_extremes")

    def _halos(self) -> None:
        """Fill ghosted arrays whole."""
        self._fill(inside=True)

    def _inside(self) -> None:
        """Fill the owned nodes of those ghosted arrays that have only their halos."""
        for part in self.parts.values():
            if part.part.has_halo and not part.reads_ghosted:
                self._exchange(part.part.inside)

    def _fill(self, inside: bool = False) -> None:
        """Fill halos; the owned nodes of ghosted arrays too where something reads them there."""
        self._exchange(self.layout.halos)
        for part in self.parts.values():
            if part.part.has_halo and (inside or part.reads_ghosted):
                self._exchange(part.part.inside)
        self._each("images")

    def _follow(self) -> None:
        """Tell the grids of gases where their particles are."""
        self._each("follow")
        for gas in self.gases:
            self._exchange(gas.gather)

    def _call(self, *names: str, of: tuple[Array, ...] | None = None) -> None:
        """Call procedures, with y and f if ``of`` is not given."""
        for name in names:
            procedure = self.does[name]
            vectors = (self._y, self._f) if of is None else of
            self._calls.append((procedure, vectors[: len(procedure.vectors)]))

    def _each(self, name: str) -> None:
        """Call the procedure of this name of each part that has it."""
        for procedure in (part.does[name] for part in self.parts.values() if name in part.does):
            self._calls.append((procedure, (self._y, self._f)[: len(procedure.vectors)]))

    def _exchange(self, one: Any) -> None:
        """Exchange with other ranks, if there is something to be exchanged."""
        if not one.empty:
            self._calls.append((one, (self._y,)[: len(one.vectors)]))
