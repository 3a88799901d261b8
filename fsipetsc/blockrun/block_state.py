"""The state of a run of blocks; what is done in a stage says fsipetsc.blockrun.phases."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.blockrun.gas_part import loose_gases
from fsipetsc.blockrun.phases import Phases
from fsipetsc.blockrun.saved import (
    OF_INTERFACES,
    compared,
    fields_of,
    gain_of,
    gained,
    grids,
    header,
    here_of,
    lossy,
    note_nodes,
    powers,
    seen,
    slices,
    step_record,
)
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.checks import block_values
from fsipetsc.errors import InputError
from fsipetsc.kernels.arrays import zeros
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.parallel.block_layout import BlockLayout, BlockVector
from fsipetsc.process.together import agree, together
from fsipetsc.scheme.monitor import MONITORED
from fsipetsc.scheme.plan import FLAGS, LIMITS, SAID_STOP
from fsipetsc.scheme.runge_kutta import STAGES, Found
from fsipetsc.state import FAULT, State

#: by order: how much shorter steps are with dissipation of strength 1 at shocks. That alone is a
#: number of -1.6 at Courant number 0.8, of 2.785 that the classical method bears; next to the ends
#: of 8/4 more
PACE_AT_SHOCKS = {2: 1.0, 4: 1.0, 6: 1.0, 8: 4.0 / 3.0}


class BlockForm(NamedTuple):
    """convection: "auto", "entropy" or "divergence"; dissipation, shock: times the usual size."""

    convection: str = "auto"
    dissipation: float = 0.0
    shock: float = 0.0


class BlockState(State):
    """A run's solution on blocks. Making one is collective on ``comm``. InputError where blocks,
    order and ranks do not fit.

    recorded: nodes to be recorded at each step, which have a name and X. announce: called on rank
    0, with a message, before and after kernels are compiled.

    y: this rank's part of the solution. latest_numbers: those of the last record of a step. bounds:
    (blocks, 2), largest rates of convection and diffusion [1/s]; extremes: what the monitor finds.
    h: size of the smallest cells [m]. loose: gases on which a constant force acts node by node.
    told: solids of which it was said that they are beyond their law.
    """

    MOST_PARTS = 16
    _filled: tuple[Any] | None = None  # the instant that the data are of

    def __init__(
        self,
        comm: MPI.Comm,
        problem: BlockProblem,
        order: int,
        form: BlockForm = BlockForm(),  # noqa: B008
        partition: str = "auto",
        recorded: Sequence[Any] = (),
        announce: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.comm, self.problem, self.op = comm, problem, OPERATORS[order]
        self.h = problem.spacing
        self.shocks, self.loose = form.shock > 0.0, loose_gases(problem, form.convection)
        self.lossy, auxiliary = lossy(problem), gained(problem).itemsize // 8
        self.layout = BlockLayout(comm, problem, order, self.shocks, partition, auxiliary)
        self._now = [BlockVector(self.layout) for _ in range(STAGES)]  # the solution, and stages
        self.y = self._now[0]
        size = (self.layout.local_size, None)
        self.solution = PETSc.Vec().createWithArray(self.y.array, size=size, comm=comm)
        self.recorded = tuple(recorded)
        record = step_record(problem, len(problem.interfaces), len(self.recorded))
        self.latest_numbers = self._lay_journal(record)[FLAGS + LIMITS :]
        self.changing = self.y.array, self.results, self.batch
        self.extremes = np.zeros(1 + MONITORED * len(problem.blocks))
        self.bounds = np.zeros((len(problem.blocks), 2))
        found = self._memory(max(1.0, form.shock * PACE_AT_SHOCKS[order]))
        columns = self.latest.dtype
        self.phases = Phases(self.layout, order, form, found, columns, announce)
        self._take_calls(self.phases.calling.library, self.phases.does["plan_next"])
        self.shapes, self.parts = self.layout.shapes, self.phases.parts
        self._recorded_here = here_of(self)
        self._shown = self.y
        self.told: set[int] = set()

    def _memory(self, pace: float) -> Found:
        """What steps take and fill; pace: how much shorter they are."""
        first = slices(self.latest.dtype).get(OF_INTERFACES[0], slice(0, 0))
        ends = slice(first.start, first.start + len(OF_INTERFACES) * (first.stop - first.start))
        return Found(
            y=self.y.array,
            stages=tuple(stage.array for stage in self._now[1:]),
            total=zeros(self.layout.local_size),
            gain=gain_of(self.problem),
            extremes=self.extremes,
            rates=self.bounds,
            results=self.results,
            latest=self.latest_numbers,
            at_ends=self.latest_numbers[ends].reshape(len(OF_INTERFACES), -1),
            pace=pace,
            plan=self.plan,
            time=np.zeros(1),
            stage=np.zeros(2),
            left=np.empty((0, 2), np.int64),  # known once there are parts
        )

    # data of the case

    def check_data(self) -> None:
        """Fill the solution with the data of the case at t = 0. InputError for what its functions
        return, those of exact solutions, conditions and forcing as well.
        """

        def fill() -> None:
            for k, part in self.parts.items():
                part.initial(0.0, self.y.owned(k))
                if part.block.exact is not None:
                    block_values(part.block, "exact", part.X[:, part.owned], 0.0)
            self.set_data(0.0)

        together(self.comm, fill)

    def check_motion(self, t_end: float) -> None:
        """InputError where walls do not have the velocity with which they move until t_end [s]."""
        together(self.comm, lambda: self.phases.particles.prescribed.check_motion(t_end))

    def set_initial(self) -> None:
        """Initial data of all blocks. Grids of gases follow the solids, and J is that of the grid,
        at the same density, velocity and temperature; gas at walls gets their velocity. InputError.
        """
        self.check_data()
        self.y.auxiliary[:] = 0.0
        self.set_data(0.0)
        self._do("share", STAGES)
        self._do("grid", STAGES)
        for gas in self.phases.gases:
            k = gas.part.k
            gas.stretch(self.y.owned(k))
            gas.impose_velocities(self.y.owned(k), *self.phases.particles.at_walls(k))
        agree(self.comm, self.fault)

    def set_data(self, t: float) -> None:
        """Let data be those at time t [s]. InputError the first time; later ones are the fault:
        the rank goes on with the data before, so that others do not wait for its messages.
        """
        prescribed = self.phases.particles.prescribed
        if self.phases.asks or self._filled is None:
            length = self.phases.instant() if prescribed.by_differences else 0.0
            instant = None if self.phases.steady else (t, length)
            if self._filled is None or self._filled[0] != instant:
                try:
                    prescribed.refresh(t)
                    for part in self.parts.values():
                        part.refresh(t)
                except InputError as error:
                    if self._filled is None:
                        raise
                    self.fault = self.fault or error
                    self.results[SAID_STOP] = FAULT
                self._filled = (instant,)
        if not self.phases.asks:
            self.phases.fill(t)

    # steps

    @property
    def asks(self) -> bool:
        """Python is asked for data at each stage, or for what is recorded of nodes."""
        return self.phases.asks or bool(self.recorded)

    def load(self, n: int, y: np.ndarray) -> None:
        if n < STAGES:
            self._now[n].array[:] = y

    def unload(self, n: int, y: np.ndarray) -> None:
        y[:] = self._now[n].array

    def phase(self, name: str, n: int, f: np.ndarray | None = None) -> list[Any]:
        now, after = (self._now[k % STAGES].array for k in (n, n + 1))
        names = {"fulfil": "share impose", "advance": f"stage_{n}", "complete": "monitor"}
        if name == "data":
            return self.phases.calls(f"data_{n}", now)
        return self.phases.calls(names.get(name, name), now, after if f is None else f)

    def show(self, n: int) -> None:
        self._shown = self._now[n % STAGES]
        self._do("halos", n)

    def complete(self) -> None:
        super().complete()
        self._do("inside", STAGES)
        note_nodes(self, self._recorded_here)

    def begin(self) -> None:
        for gas in self.phases.gases:
            gas.volume.rows[:] = 0.0  # no NaN may stay there for another step
        self.load(1, self.y.array)
        self._do("fulfil", 1)
        self.show(0)

    def repeat(self, look: Callable[[], Any]) -> Any:
        """As of any state; Python is asked for recorded data, as it says what is wrong."""
        self.phases.asks, self._filled = not self.phases.steady, ((np.inf, 0.0),)
        return super().repeat(look)

    # checkpoints

    def more(self) -> Mapping[str, np.ndarray]:
        """The auxiliary unknowns of all ranks, added up, by the name that files have."""
        every = self.comm.gather(self.y.auxiliary) or []
        return {"behind": sum(every, np.zeros(self.layout.auxiliary))}

    def take(self, arrays: Mapping[str, np.ndarray]) -> None:
        behind = arrays["behind"]  # asked for on all ranks, so that all fail alike
        self.y.auxiliary[:] = behind if self.comm.rank == 0 else 0.0

    # what is saved and said

    header, grids, seen, compared, powers = header, grids, seen, compared, powers

    def owned(self, k: int) -> np.ndarray:
        return self.y.owned(k)

    def numbers(self, k: int) -> np.ndarray:
        return self.parts[k].part.numbers if k in self.parts else np.empty(0, np.int64)

    def fields(self, k: int) -> Sequence[str]:
        return fields_of(self.problem.blocks[k].kind, self.problem.dimension, self.problem.symmetry)

    @property
    def invariants(self) -> dict[str, Any]:
        """Those of the problem that hold in this form (fsipetsc.scheme.gas_force)."""
        found = self.problem.invariants
        return {**found, "potential": found["potential"] and not self.loose}

    @property
    def points(self) -> int:
        """The number of nodes of all blocks."""
        return sum(int(np.prod(shape)) for shape in self.shapes)

    @property
    def places(self) -> list[float]:
        """Positions x [m] of the interfaces, in one dimension. Collective."""
        found = np.zeros(len(self.problem.interfaces) * (self.problem.dimension == 1))
        for number, k, row, X in self.layout.interface_ends():
            found[number] = X + self.y.owned(k)[row, 0]
        self.comm.Allreduce(MPI.IN_PLACE, found)
        return found.tolist()

    def saved(self, k: int) -> np.ndarray:
        """(M, columns) of ``fields``: what is saved of this rank's nodes of block k."""
        return self.parts[k].fields(self._shown.ghosted(k))

    def save(self) -> dict[int, np.ndarray]:
        """What is saved of this rank's nodes: number of a block -> (local, columns), to be copied
        before the next call (RunWriter.write_frame). Collective."""
        none = [np.empty((0, len(self.fields(k)))) for k in range(len(self.shapes))]
        saved = [self.saved(k) if k in self.parts else array for k, array in enumerate(none)]
        return {k: self.layout.in_order(k, array) for k, array in enumerate(saved)}

    def destroy(self) -> None:
        """Free messages and vectors."""
        self.phases.destroy()
        self.solution.destroy()
        self.layout.destroy()
