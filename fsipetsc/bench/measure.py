"""What the command ``bench`` measures on the ranks of a communicator: whole steps, and what they are made of.

Whole steps are timed as a run makes them: PETSc's TS, the hooks, the series; only nothing is written. The phases are
timed apart, in loops over the same state, for a clock within compiled code would cost what it measures:

    conditions  exchange, and then ghost points, ends and interfaces: 4 in a step
    exchange    messages alone: 4 in a step
    reduction   of the bounds on the time step: 1
    points      what else a step does in compiled code: right-hand sides, bounds, integrals, the solution for PETSc
    PETSc       a step of a TS that computes nothing, with the same calls in its hook; one for a burst of steps
    Python      what is left of the whole step: entering compiled code, the hooks' bookkeeping, the series

Where ranks differ the slowest one counts. Of the parts the shortest of several samples counts, for noise only adds, and
what is left refers to the shortest sample of whole steps. In a loop everything is at hand that a step may have to fetch
again, so that the rest can be a few percent off; it is shown as it comes out, even if it is below zero.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from statistics import median
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.bench.loops import apply_conditions_often, exchange_often, reduce_often, triad
from fsipetsc.scheme.runge_kutta import STAGES, do_nothing, make_steps
from fsipetsc.stepping.counts import completion_traffic, stage_traffic
from fsipetsc.stepping.integrator import Integrator
from fsipetsc.stepping.solve import build_problem, make_state

#: a step that changes nothing that can be seen, but is not zero [s]
_TINY = 1e-12


def spacing(points: int) -> float:
    """Grid spacing [m] of the rod, 6 m of gas and solid, that makes about so many points and fits the solid."""
    return 1.0 / max(1, round(points / 6))


class Stand:
    """A problem on the ranks of comm, ready to be timed. All methods are collective on comm; times are in µs.

    Raises InputError where grid, order and ranks do not fit.
    """

    def __init__(
        self, case: Any, opt: Mapping[str, Any], comm: MPI.Comm, announce: Callable[[str], None] = lambda text: None
    ) -> None:
        self.comm, self.options = comm, dict(opt)
        self.state = make_state(build_problem(case, opt, comm), opt, comm)
        self.state.compile(announce)
        self.state.set_initial()
        self.burst = 1  # steps in one go

    def steps(self, count: int) -> float:
        """A step, on the average over the first ``count`` steps from the initial data."""
        comm = self.comm
        integrator = Integrator(
            self.state,
            {**self.options, "ts_max_steps": count},
            [self.options["ts_max_time"]],
            on_frame=lambda t: None,
            on_series=lambda: integrator.series.take(comm),
            on_step=lambda steps, t, dt: None,
            on_grids=lambda: None,
        )
        integrator.start()
        self.burst = integrator.burst_limit
        comm.Barrier()
        integrator.run()
        return 1e6 * comm.allreduce(integrator.wall_time, MPI.MAX) / integrator.steps

    def reduction(self, seconds: float) -> float:
        """The reduction that bounds the time step, over all ranks."""
        plan = self.state.plan
        return clock(self.comm, lambda n: reduce_often(plan.head, plan.memory, int(plan.head["reduced"][0]), n), seconds)

    def phases(self, seconds: float) -> dict[str, float]:
        """The parts of a step; seconds: how long each may be measured."""
        plan, comm = self.state.plan, self.comm
        self.steps(2)  # a state in the midst of a run

        def often(task: Callable[..., None], *arguments: float) -> Callable[[int], None]:
            def repeat(count: int) -> None:
                for _ in range(count):
                    task(plan, *arguments)

            return repeat

        call = clock(comm, often(do_nothing), seconds)
        whole = clock(comm, often(make_steps, _TINY), seconds) - call
        apply_conditions = clock(comm, lambda n: plan.compiled(apply_conditions_often)(*plan, n), seconds)
        exchange = clock(comm, lambda n: exchange_often(*plan, n), seconds)
        reduction = self.reduction(seconds)
        return {
            "inner": whole - STAGES * apply_conditions - reduction,
            "ends": STAGES * (apply_conditions - exchange),
            "exchange": STAGES * exchange + reduction,
            "reduction": reduction,
            "petsc": clock(comm, self._petsc, seconds) / self.burst,
            "call": call / self.burst,
        }

    def _petsc(self, count: int) -> None:
        """Steps of a TS that computes nothing."""
        ts = PETSc.TS().create(comm=self.comm)
        ts.setProblemType(PETSc.TS.ProblemType.NONLINEAR)
        ts.setType(PETSc.TS.Type.PYTHON)
        ts.setPythonContext(_Nothing(self.state.solution))
        ts.setPostStep(_after)
        ts.setExactFinalTime(PETSc.TS.ExactFinalTime.STEPOVER)
        ts.setSolution(self.state.solution)
        ts.setTimeStep(1.0)
        ts.setMaxTime(1e300)
        ts.setMaxSteps(count)
        ts.solve(self.state.solution)
        ts.destroy()

    @property
    def counts(self) -> dict[str, int]:
        """Points, the most of them on a rank, doubles of memory and messages of a step (the most on a rank)."""
        plan, comm = self.state.plan, self.comm
        mine = sum(
            max(0, int(min(r["own_hi"], r["hi"] + 1) - max(r["own_lo"], r["lo"]))) * int(r["present"]) for r in plan.layers
        )
        stage, completion = stage_traffic(plan), completion_traffic(plan)
        return {
            "points": self.state.points,
            "share": comm.allreduce(mine, MPI.MAX),
            "doubles": comm.allreduce(int(plan.memory.size)),
            "sends": comm.allreduce((STAGES - 1) * stage.sends + completion.sends, MPI.MAX),
            "reductions": (STAGES - 1) * (stage.reductions + stage.turns) + completion.reductions + completion.turns,
        }

    def sample(self, seconds: float) -> int:
        """How many steps take so long, about."""
        first = min(self.steps(count) for count in (2, 10))
        return self.comm.bcast(min(20_000, max(6, round(1e6 * seconds / (first or 1.0)))))

    def destroy(self) -> None:
        """Give everything back."""
        self.state.destroy()


def compare(
    case: Any, options: Mapping[str, Mapping[str, Any]], comm: MPI.Comm, seconds: float, repeats: int
) -> dict[str, float]:
    """Name -> a step per point with these options by that with the first ones: the median of pairs made one after the other.

    seconds: of a sample, about; repeats: samples of each. Collective; InputError where grid, order and ranks do not fit.
    """
    stands: dict[str, Stand] = {}
    try:
        for name, opt in options.items():
            stands[name] = Stand(case, opt, comm)
        count = next(iter(stands.values())).sample(seconds)
        samples: dict[str, list[float]] = {name: [] for name in stands}
        for stand in stands.values():
            stand.steps(2)  # for what is loaded at the first use
        for _ in range(repeats):
            for name, stand in stands.items():
                samples[name].append(stand.steps(count) / stand.state.points)
    finally:
        for stand in stands.values():
            stand.destroy()
    first = next(iter(samples.values()))
    return {name: median(a / b for a, b in zip(own, first, strict=True)) for name, own in samples.items()}


class _Nothing:
    """Context of a TS that computes nothing; the calls are those of fsipetsc.stepping.fused."""

    def __init__(self, solution: PETSc.Vec) -> None:
        self._solution = solution

    def step(self, ts: PETSc.TS) -> None:
        t, dt = ts.getTime(), ts.getTimeStep()
        self._solution.stateIncrease()
        ts.setTime(t + dt)


def _after(ts: PETSc.TS) -> None:
    """The calls of the hook in fsipetsc.stepping.integrator."""
    ts.setTime(ts.getTime())
    ts.setTimeStep(1.0)


def clock(comm: MPI.Comm, action: Callable[[int], None], seconds: float) -> float:
    """Time of one repetition [µs] of what ``action(count)`` does ``count`` times: the shortest of five, the slowest rank's."""

    def spent(count: int) -> float:
        comm.Barrier()
        begun = time.perf_counter()
        action(count)
        return comm.allreduce(time.perf_counter() - begun, MPI.MAX)

    count = 1
    spent(count)  # loads or compiles the code
    while (once := spent(count)) < seconds / 20 and count < 1 << 30:
        count *= 2 if once > seconds / 100 else 8
    return 1e6 * min(spent(count) for _ in range(5)) / count


def bandwidth(comm: MPI.Comm, nbytes: int, seconds: float) -> float:
    """Bandwidth [GB/s] of a rank in STREAM's triad on arrays of nbytes together, all ranks of comm at once.

    As in STREAM 24 bytes count for an element, whatever the caches move besides. Collective.
    """
    length = nbytes // 24
    memory = np.ones(3 * length)
    return 24e-3 * length / clock(comm, lambda count: triad(memory, length, count), seconds)
