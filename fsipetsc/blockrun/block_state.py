"""The state of a run of blocks: what stepping and the writer ask for, ``right_hand_side``,
``step``, ``finish``, ``capture`` …; the equations are those of fsipetsc.blockrun.scheme.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.blockrun.gas_part import loose_gases
from fsipetsc.blockrun.notes import NOTES, imaginary_waves, most_crushed
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
from fsipetsc.blockrun.scheme import Scheme
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.errors import InputError
from fsipetsc.kernels.memory import zeros
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.parallel.block_layout import BlockLayout, BlockVector, NaturalOrder
from fsipetsc.process.together import agree, together
from fsipetsc.scheme.block_monitor import LEAST_J, MONITORED
from fsipetsc.scheme.plan import BAD, DT, FLAGS, LIMITS, MADE, RATE, TIME
from fsipetsc.scheme.runge_kutta import STAGES, Found
from fsipetsc.state import State

#: of how many parts a step is made, one after the other, until its state is physical
PARTS = 1, 2, 4, 8, 16


#: records of steps that are kept before they are written
KEPT = 4096
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
    """A run's solution on blocks: its steps, checkpoints, and what is said of it; making one, and
    all methods, are collective on ``comm``. InputError where blocks, order and ranks do not fit.

    recorded: nodes to be recorded at each step, which have a name and X. announce: called on rank
    0, with a message, before and after kernels are compiled.

    y: this rank's part of the solution, ``solution`` the same as a world vector; stages: three
    vectors; before: y where the last step began. latest_numbers: those of the last record of a
    step. rates: (blocks, 2), largest ones of convection and diffusion [1/s]; extremes: what the
    monitor finds. h: size of the smallest cells [m]. orders: block -> what brings its nodes into
    the order in which they are saved. loose: gases on which a constant force acts node by node.
    retries: steps that were made anew in parts. told: solids of which it was said that they are
    beyond their law.
    """

    NOTES = NOTES

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
        self.h = float(min(problem.spacings))
        self.shocks, self.loose = form.shock > 0.0, loose_gases(problem, form.convection)
        self.lossy, auxiliary = lossy(problem), gained(problem).itemsize // 8
        self.layout = BlockLayout(comm, problem, order, self.shocks, partition, auxiliary)
        self.y = BlockVector(self.layout)
        self.stages = tuple(BlockVector(self.layout) for _ in range(3))
        size = (self.layout.local_size, None)
        self.solution = PETSc.Vec().createWithArray(self.y.array, size=size, comm=comm)
        self.recorded = tuple(recorded)
        record = step_record(problem, len(problem.interfaces), len(self.recorded))
        self.latest_numbers = self._lay_journal(record, KEPT)[FLAGS + LIMITS :]
        self.extremes = np.zeros(1 + MONITORED * len(problem.blocks))
        self.rates = np.zeros((len(problem.blocks), 2))
        self.before = zeros(self.layout.local_size)
        pace = max(1.0, form.shock * PACE_AT_SHOCKS[order])
        vectors, columns = (self.y, *self.stages), self.latest.dtype
        found = self._memory(pace)
        self.scheme = Scheme(vectors, self.layout, order, form, found, columns, announce)
        self.planning = self.scheme.does["plan_next"]
        self.shapes, self.parts = self.layout.shapes, self.scheme.parts
        d, symmetry = problem.dimension, problem.symmetry
        kinds = enumerate(block.kind for block in problem.blocks)
        names = [(k, len(fields_of(kind, d, symmetry))) for k, kind in kinds]
        self.orders = [NaturalOrder(self.layout, k, columns) for k, columns in names]
        self._recorded_here = here_of(self)
        self.retries = 0
        self._tried = 1  # in how many parts the last step was made
        self.told: set[int] = set()
        self.evaluations, self._t = 0, 0.0

    def _memory(self, pace: float) -> Found:
        """What steps take and fill; pace: how much shorter they are."""
        first = slices(self.latest.dtype).get(OF_INTERFACES[0], slice(0, 0))
        ends = slice(first.start, first.start + len(OF_INTERFACES) * (first.stop - first.start))
        now, stage = np.zeros(3), np.zeros(2)
        return Found(
            y=self.y.array,
            stages=tuple(stage.array for stage in self.stages),
            total=zeros(self.layout.local_size),
            before=self.before,
            gain=gain_of(self.problem),
            extremes=self.extremes,
            rates=self.rates,
            results=self.results,
            latest=self.latest_numbers,
            at_ends=self.latest_numbers[ends].reshape(len(OF_INTERFACES), -1),
            pace=pace,
            plan=self.plan,
            now=now,
            stage=stage,
            left=np.empty((0, 2), np.int64),  # known once there are parts
        )

    # set-up

    def check_data(self) -> None:
        """Ask the case's functions for all data at t = 0. InputError."""
        together(self.comm, lambda: self.scheme.initial(0.0, self.y))

    def check_motion(self, t_end: float) -> None:
        """InputError where walls do not have the velocity with which they move until t_end [s]."""
        together(self.comm, lambda: self.scheme.particles.prescribed.check_motion(t_end))

    def set_initial(self) -> None:
        """Initial data of all blocks and J of the grids. InputError."""
        self.check_data()
        self.y.auxiliary[:] = 0.0
        self.scheme.stretch(0.0, self.y)
        agree(self.comm, self.fault)

    def set_data(self, t: float) -> None:
        """The next evaluation of the right-hand side is at time t [s]."""
        self._t = t

    # steps

    def right_hand_side(self, y: np.ndarray, f: np.ndarray) -> None:
        """f = dy/dt of this rank's part, at y completed; y stays as it is."""
        self.evaluations += 1
        f[f.size - self.layout.auxiliary :] = 0.0
        self._load_stage(y)
        self.scheme.rates(self._t, self.stages[0], f)

    def _load_stage(self, y: np.ndarray) -> None:
        self.stages[0].array[:] = y
        self.scheme.complete(self._t, self.stages[0])

    def project(self, y: np.ndarray) -> None:
        """Let this rank's part y obey all conditions, in place."""
        self._load_stage(y)
        y[:] = self.stages[0].array

    def step(self, t: float, dt: float, steady: bool) -> None:
        """A step dt [s] of the fused method from the completed solution at t [s], and the others of
        its batch.
        """
        more = True
        while more:
            if not self.scheme.asks and not self.recorded:
                made = self.batch[MADE]
                ended_well, t, dt = self.scheme.steps(t, dt)
                self.scheme.fill_halos(self.y)
                self.evaluations += STAGES * max(int(self.batch[MADE] - made), int(ended_well))
                self._t, self._tried = t, 1
                if ended_well:
                    break
                self.scheme.forget()
            self._advance(t, dt)
            t = self._t
            more = self.plan_next()
            dt = float(self.batch[DT])

    def _advance(self, t: float, dt: float) -> None:
        """Make the step; one that leaves an unphysical state is made anew in 2, 4 … parts."""
        before, rate = self.y.array.copy(), self.results[RATE]
        for parts in PARTS:
            for part in range(parts):
                self.evaluations += STAGES
                begin = t + dt * part / parts
                self.scheme.step(begin, dt / parts)
            self._t, self._tried = t + dt, parts
            self._monitor()
            if self.results[BAD] == 0.0 or parts == PARTS[-1]:
                break
            self.y.array[:], self.results[RATE] = before, rate
            self.scheme.forget()
            self.retries += 1
        self.before[:] = before  # each part has kept that before it

    def finish(self) -> None:
        """Complete a step that PETSc has made."""
        self.scheme.complete(self._t, self.y)
        self.solution.stateIncrease()
        self._monitor()
        if not self._failed:
            self.before[:] = self.y.array

    @property
    def _failed(self) -> bool:
        """The run cannot go on from the state that was monitored last."""
        return bool(self.results[BAD]) or not self.results[RATE] < np.inf

    def go_to_fault(self, unphysical: Callable[[], Any]) -> str:
        """Repeat the step that has failed, and let y be its first unphysical stage: NaN spreads
        from there. Steps of PETSc's other methods are repeated by the classical one; if that does
        not fail, y stays. Returns what was wrong with solids before the step, or what is wrong with
        their waves now, or "". InputError where data that depend on time were wrong.
        """
        if not self.batch[MADE]:
            return ""
        last, dt = self.y.array.copy(), float(self.batch[DT]) / self._tried
        end = float(self.batch[TIME])
        begin = end - dt * self._tried
        halves = range(2 * self._tried + 1)
        self.scheme.check_data([begin + 0.5 * dt * half for half in halves])
        self.y.array[:] = self.before
        self.scheme.forget()
        self.scheme.monitor(self.y)
        said = "; ".join(imaginary_waves(self, begin, set())) or most_crushed(self)
        for part in range(self._tried):
            if self.scheme.step(begin + part * dt, dt, self._fails):
                break
        else:
            self.y.array[:] = last
            self.scheme.monitor(self.y)
        least_J = -self.extremes[1:].reshape(-1, MONITORED)[:, LEAST_J]
        if not said and least_J.min() > 0.0:
            return "; ".join(imaginary_waves(self, end, set()))
        return said

    def _fails(self, now: BlockVector) -> bool:
        """Whether a completed stage is unphysical; if so, y is this stage. Collective."""
        rate = float(self.results[RATE])
        self.scheme.monitor(now)
        failed = self._failed
        if failed and now is not self.y:
            self.y.array[:] = now.array
            self.scheme.monitor(self.y)
        elif not failed:
            self.results[RATE] = rate  # that of the step, for differences in time
        return failed

    def _monitor(self) -> None:
        """What is known of the completed solution: bounds of all ranks, shares of the integrals."""
        self.scheme.monitor(self.y)
        note_nodes(self, self._recorded_here)
        self.scheme.note_gained(self.y)

    # checkpoints

    def more(self) -> Mapping[str, np.ndarray]:
        """The auxiliary unknowns of all ranks, added up, by the name that files have."""
        every = self.comm.gather(self.y.auxiliary) or []
        return {"behind": sum(every, np.zeros(self.layout.auxiliary))}

    def go_on(self, t: float, arrays: Mapping[str, np.ndarray]) -> None:
        """Find what the scheme derives of the solution, which stays as it is."""
        behind = arrays["behind"]  # asked for on all ranks, so that all fail alike
        self.y.auxiliary[:] = behind if self.comm.rank == 0 else 0.0
        self._t = t
        self.before[:] = self.y.array
        self._load_stage(self.y.array)
        self.scheme.fill_halos(self.y)

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
    def asks(self) -> bool:
        """Python is asked for data at each stage."""
        return self.scheme.asks

    @property
    def fault(self) -> InputError | None:
        """The first error of a function of the case's, on this rank."""
        return self.scheme.fault

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
        return self.parts[k].fields(self.y.ghosted(k))

    def save(self) -> dict[int, np.ndarray]:
        """What is saved of this rank's nodes: number of a block -> (local, columns), to be copied
        before the next call (RunWriter.write_frame). Collective."""
        none, every = np.empty(0), enumerate(self.orders)
        return {k: of.reorder(self.saved(k) if k in self.parts else none) for k, of in every}

    def destroy(self) -> None:
        """Free messages and vectors."""
        self.scheme.destroy()
        for order in self.orders:
            order.destroy()
        self.solution.destroy()
        self.layout.destroy()
