"""The loop over steps: each is planned, made by the fused method or by PETSc's TS, and noted."""

import math
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.errors import InputError, clear_frames, petsc_words
from fsipetsc.process.together import agree
from fsipetsc.scheme import plan
from fsipetsc.scheme.observables import INTEGRAL, SERIES
from fsipetsc.state import FAULT, State
from fsipetsc.stepping.notes import check
from fsipetsc.stepping.restart import Past

#: what a rank says of STOP that wants a checkpoint, below the numbers of signals. What ranks say
#: goes round after a step anyway and the largest word counts, so a signal may come to any rank
CHECKPOINT = 0.5
#: points of all ranks times steps in one call, so that a signal need not wait
MOST_POINTS = {1: 250_000, 2: 2_000_000, 3: 2_000_000}
#: most steps in a batch; between batches signals are answered and progress is shown
MOST_STEPS = 64
#: what a checkpoint has beside the state
KEPT = "steps", "rejected", "t", "wall_time", "initial", "reached", "saved_at"


def saved_times(opt: Mapping[str, Any], unit: str = " s") -> list[float]:
    """The times [s] at which profiles are saved, up to the end of the run. InputError."""
    end, interval = opt["ts_max_time"], opt["fsi_output_dt"]
    saved = {end, *(opt["fsi_output_times"] or ())}
    if (last := max(saved)) > end:
        beyond = f"{last:g}{unit} would not be reached, the run ends at -ts_max_time {end:g}{unit}"
        raise InputError(f"-fsi_output_times: {beyond}")
    count = math.floor(end / interval * (1 + 1e-12)) if interval else 0
    return sorted({*saved, *(min(k * interval, end) for k in range(1, count + 1))})


class Integrator:
    """Integrates a state in time, which has initial data, from there or from a checkpoint, the
    ``past``; all methods are collective. InputError.

    opt: options in force. steps, t, wall_time [s] of the loop: reached so far; rejected: steps that
    were tried again; saved_at: time of the last frame. initial: integrals before the first step of
    the result; reached: on rank 0, those after the last step that was taken. signal: the last one
    that came to this rank, or 0; stop_signal: that which has ended the run.
    """

    def __init__(self, state: State, opt: Mapping[str, Any], past: Past | None = None) -> None:
        self.state, self.opt, self.comm = state, opt, state.comm
        self._recorded = 0  # steps in the journal
        self._every, self._wall = opt["fsi_checkpoint_steps"], opt["fsi_checkpoint_wall"]
        self._last_checkpoint = time.monotonic()
        self._targets = saved_times(opt, state.problem.unit("s"))[::-1]  # still to be hit
        self.steps = self.rejected = self.signal = self.stop_signal = 0
        self.t, self.saved_at, self.wall_time = 0.0, -1.0, 0.0
        self._fused = opt["ts_type"] == "fused"
        self._watched = PETSc.Options().hasName("ts_monitor")
        self.initial, self.reached = dict[str, Any](), dict[str, Any]()
        if past is None:
            state.finish()
            check(state, opt, self.t, self.steps)
            kept = [name for name in state.latest.dtype.names if SERIES[name].kind == INTEGRAL]
            self.initial = {k: self.comm.allreduce(state.latest[k]).tolist() for k in kept}
        else:
            vars(self).update(past.header["memory"])
            state.restore(past.arrays, self.t)
        self._pass()
        self.batch_limit = 1  # most steps in one call
        if self._fused and not state.asked and not self._watched:
            most = MOST_POINTS[state.problem.dimension] // state.points
            self.batch_limit = max(1, min(MOST_STEPS, most))

    @property
    def _ended(self) -> bool:
        return bool(not self._targets or self.stop_signal or self.steps >= self.opt["ts_max_steps"])

    def _pass(self) -> bool:
        """Whether the time that is reached is one to be saved."""
        before = len(self._targets)
        while self._targets and self._targets[-1] <= self.t:
            self._targets.pop()
        return len(self._targets) < before

    def take_series(self) -> np.ndarray:
        """The records of steps since the last time, not copied; on rank 0 with sums over ranks."""
        comm, steps, self._recorded = self.comm, self.state.journal[: self._recorded], 0
        if comm.size > 1 and len(steps):
            # from the first integral on these are shares
            name = next(name for name in steps.dtype.names if SERIES[name].kind == INTEGRAL)
            first = steps.dtype.fields[name][1] // 8
            own = steps.view(np.float64).reshape(len(steps), -1)[:, first:]
            sums = own.copy()
            comm.Reduce(MPI.IN_PLACE if comm.rank == 0 else sums, sums, MPI.SUM, 0)
            own[:] = sums
        if comm.rank == 0 and len(steps):
            self.reached = {name: steps[name][-1].tolist() for name in self.initial}
        return steps

    @property
    def full(self) -> bool:
        """Whether the journal has no room for another step."""
        return self._recorded == len(self.state.journal)

    def run(self) -> None:
        """Integrate to the end, a signal, or a failure, which is raised."""
        begun, ts = time.perf_counter() - self.wall_time, self._create()
        try:
            while not self._ended:
                self._plan_step(ts)
                self._step(ts)
                self.wall_time = time.perf_counter() - begun
                self._note()
        finally:
            if self._watched:
                ts.monitor(self.steps, self.t)
            if self._ended and not self._fused:
                ts.viewFromOptions("-ts_view")
            ts.destroy()

    def follow_up(self, longest: float, passed: bool, due: bool) -> None:
        """What follows a batch of steps. longest: of them [s]; passed: whether its end is a time to
        be saved; due: whether a checkpoint is wanted, after so many steps, by the clock of rank 0,
        after a signal, and at the end for those who want any.
        """
        if self.full:
            self.take_series()

    def _create(self) -> PETSc.TS:
        """Return PETSc's TS, which makes the steps of its own methods, and monitors all."""

        def right_hand_side(ts: PETSc.TS, t: float, Y: PETSc.Vec, F: PETSc.Vec) -> None:
            self.state.set_data(t)
            self.state.right_hand_side(Y.getArray(readonly=True), F.getArray())

        ts, database = PETSc.TS().create(comm=self.comm), PETSc.Options()
        ts.setProblemType(PETSc.TS.ProblemType.NONLINEAR)
        ts.setRHSFunction(right_hand_side)
        ts.setExactFinalTime(PETSc.TS.ExactFinalTime.STEPOVER)
        ts.setSolution(self.state.solution)
        database.setValue("ts_type", "rk" if self._fused else self.opt["ts_type"])
        try:
            ts.setFromOptions()
        except PETSc.Error as error:  # -ts_monitor, -ts_view … with a wrong value
            raise InputError(f"an option of PETSc's: {petsc_words(error)}") from None
        database.setValue("ts_type", self.opt["ts_type"])
        return ts

    def _plan_step(self, ts: PETSc.TS) -> None:
        opt, state, target = self.opt, self.state, self._targets[-1]
        courant, fixed = opt["fsi_cfl"], opt["ts_dt"] or 0.0
        bound = plan.longest_step(courant, fixed, float(state.results[plan.RATE]))
        step, after = plan.next_step(self.t, target, bound)
        late = self._wall and time.monotonic() >= self._last_checkpoint + self._wall
        word = self.signal or CHECKPOINT * bool(late and self.comm.rank == 0)
        state.results[plan.SAID_STOP] = word if state.fault is None else FAULT
        left = [opt["ts_max_steps"] - self.steps, len(state.journal) - self._recorded]
        if self._every:
            left.append(self._every - self.steps % self._every)
        times = self.t, step, after, target, courant, fixed
        state.batch[:] = *times, min(self.batch_limit, *left), 0, 0.0, self._recorded
        if self._watched or not self._fused:
            ts.setTime(self.t)  # the sum of steps may miss a target by round-off
            ts.setStepNumber(self.steps)
            ts.setTimeStep(step)
            ts.restartStep()  # the last stage's rates are not those of the completed solution
        if self._watched:
            ts.monitor(self.steps, self.t)

    def _step(self, ts: PETSc.TS) -> None:
        """Make the step that is planned, or a batch of them; note it, and its time and number."""
        state = self.state
        if self._fused:
            state.step()
            if state.results[plan.BAD] and state.MOST_PARTS > 1:
                self._make_anew()
        else:
            state.keep()
            try:
                ts.step()
            except BaseException as error:
                # what a rate raised: as it is with PETSc up to 3.18, with later ones wrapped
                cause = (error.__cause__ if isinstance(error, PETSc.Error) else None) or error
                clear_frames(cause)  # petsc4py loses a TS that somebody else still holds
                raise cause from None
            state.set_data(float(state.batch[plan.NEXT]))
            state.finish()
            state.planning()
        if state.results[plan.STOP] >= FAULT:  # the step was made with data that are wrong
            agree(state.comm, state.fault)

    def _make_anew(self) -> None:
        """Make the steps before an unphysical one again, or if none are, that in 2, 4 … parts."""
        state, made, parts = self.state, int(self.state.batch[plan.MADE]), 2
        if made > 1:
            state.evaluations -= plan.STAGES * made  # counted when they are made once more
            state.go_back()
            state.batch[plan.ALLOWED] = made - 1
            state.step()
            return
        while state.results[plan.BAD] and parts <= state.MOST_PARTS:
            state.go_back()
            state.step_in_parts(parts)
            self.rejected += 1
            parts *= 2

    def _note(self) -> None:
        """Note the batch that was made, and let follow what follows it."""
        self.t, made, longest = self.state.batch[[plan.TIME, plan.MADE, plan.LONGEST]].tolist()
        self.steps += int(made)
        self._recorded += int(made) - 1  # the last one only if it is sound
        check(self.state, self.opt, self.t, self.steps)
        self._recorded += 1
        passed, stop = self._pass(), float(self.state.results[plan.STOP])
        self.stop_signal = int(stop)
        regular = self._every and self.steps % self._every == 0
        due = bool(stop or regular or (self._ended and (self._every or self._wall)))
        self.follow_up(longest, passed, due)
        if due:
            self._last_checkpoint = time.monotonic()
