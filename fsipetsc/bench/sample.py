"""Time steps of a problem as a run makes them, timed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mpi4py import MPI

from fsipetsc.stepping.integrator import Integrator
from fsipetsc.stepping.solve import build_problem, make_state


class Sample:
    """A problem on the ranks of comm, compiled. All methods are collective on comm.

    nodes: of all blocks. InputError where grid, order and ranks do not fit.
    """

    def __init__(self, case: Any, opt: Mapping[str, Any], comm: MPI.Comm) -> None:
        self._comm, self._options = comm, dict(opt)
        self._state = make_state(build_problem(case, opt, comm), opt, comm)
        self._state.compile(lambda text: None)
        self._state.set_initial()
        self.nodes, self.destroy = self._state.points, self._state.destroy

    def steps(self, count: int) -> float:
        """Time [µs] of a step, on the average over the first ``count`` from the initial data."""
        comm, end = self._comm, [self._options["ts_max_time"]]
        integrator = Integrator(
            *(self._state, {**self._options, "ts_max_steps": count}, end),
            on_frame=lambda t: None,
            on_series=lambda: integrator.series.take(comm),
            on_step=lambda steps, t, dt: None,
            on_grids=lambda: None,
        )
        integrator.start()
        comm.Barrier()
        integrator.run()
        return 1e6 * comm.allreduce(integrator.wall_time, MPI.MAX) / integrator.steps

    def count(self, seconds: float) -> int:
        """How many steps take about so many seconds; makes some first, for what is made once."""
        self.steps(2)
        step = min(self.steps(10), self.steps(10))
        return min(20_000, max(6, round(1e6 * seconds / (step or 1.0))))
