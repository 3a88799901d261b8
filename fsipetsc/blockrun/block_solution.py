"""The solution of a problem of blocks: its vectors, its scheme, what is known of it."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.blockrun.columns import OF_INTERFACES, gain_of, gained, lossy, slices, step_record
from fsipetsc.blockrun.law_checks import loose_gases
from fsipetsc.blockrun.scheme import Scheme
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.parallel.block_layout import BlockLayout, BlockVector, NaturalOrder
from fsipetsc.scheme.block_monitor import MONITORED
from fsipetsc.scheme.runge_kutta import Found
from fsipetsc.state import State

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


class BlockSolution(State):
    """Solution and scheme of blocks; making one is collective on ``comm``.

    y: this rank's part of the solution, stages: two vectors for stages;
    ``solution`` is the memory of y as a world vector. results: flags and limits as in
    fsipetsc.scheme.plan. journal, latest: records of steps, with this rank's shares of integrals;
    rows, latest_numbers: the same as numbers. rates: (blocks, 2), largest ones of convection and
    diffusion [1/s]; extremes: what the monitor finds. h: size of the smallest cells [m].
    before: y where the last step began. recorded: nodes to be recorded at each step, which have a
    name and X. orders: block -> what brings its nodes into the order in which they are saved.
    announce: called on rank 0, with a message, before and after kernels are compiled. loose: gases
    on which a constant force acts node by node. InputError where blocks, order and ranks do not
    fit.
    """

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
        self.stages = BlockVector(self.layout), BlockVector(self.layout)
        size = (self.layout.local_size, None)
        self.solution = PETSc.Vec().createWithArray(self.y.array, size=size, comm=comm)
        self.recorded = tuple(recorded)
        record = step_record(problem, len(problem.interfaces), len(self.recorded))
        self.rows, numbers = self._lay_journal(record, KEPT)
        self.latest_numbers = numbers[self.results.size :]
        self.extremes = np.zeros(1 + MONITORED * len(problem.blocks))
        self.rates = np.zeros((len(problem.blocks), 2))
        self.before = np.empty_like(self.y.array)
        pace = max(1.0, form.shock * PACE_AT_SHOCKS[order])
        vectors, columns = (self.y, *self.stages), self.latest.dtype
        self.scheme = Scheme(
            self.layout, order, form, vectors, self._memory(pace), columns, announce
        )
        self.planning = self.scheme.planning
        parts = self.scheme.parts.items()
        self.orders = {k: NaturalOrder(part.part, len(part.names)) for k, part in parts}

    def _memory(self, pace: float) -> Found:
        """What steps take and fill; pace: how much shorter they are."""
        first = slices(self.latest.dtype).get(OF_INTERFACES[0], slice(0, 0))
        ends = slice(first.start, first.start + len(OF_INTERFACES) * (first.stop - first.start))
        now, stage = np.zeros((2, 3))
        return Found(
            y=self.y.array,
            total=np.zeros(self.layout.local_size),
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
        return sum(int(np.prod(shape)) for shape in self.layout.shapes)

    @property
    def places(self) -> list[float]:
        """Positions x [m] of the interfaces, in one dimension. Collective."""
        found = np.zeros(len(self.problem.interfaces) * (self.problem.dimension == 1))
        for number, k, row, X in self.layout.interface_ends():
            found[number] = X + self.y.owned(k)[row, 0]
        self.comm.Allreduce(MPI.IN_PLACE, found)
        return found.tolist()

    def fields(self, k: int) -> np.ndarray:
        """(M, columns) of ``fields_of``: what is saved of this rank's nodes of block k."""
        return self.scheme.parts[k].fields(self.y.ghosted(k))

    def save(self) -> dict[int, np.ndarray]:
        """What is saved of this rank's nodes: number of a block -> (local, columns), to be copied
        before the next call (RunWriter.write_frame). Collective."""
        return {k: order.reorder(self.fields(k)) for k, order in sorted(self.orders.items())}

    def destroy(self) -> None:
        """Free messages, vectors, DMDAs and communicators, in this order."""
        self.scheme.destroy()
        for order in self.orders.values():
            order.destroy()
        self.solution.destroy()
        self.layout.destroy()
