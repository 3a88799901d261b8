"""PETSc's TS drives: its explicit methods make the steps, hooks around them do the rest.

The right-hand side (stepping.petsc_path) projects a work copy of each stage; the post-step hook projects the new solution,
lets the embedded boundaries move, records the step, and says how long the next step is. A fluid grid that is used up ends
one TSSolve; the grids are laid anew and the next one goes on.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from petsc4py import PETSc

from fsipetsc.blockrun.columns import point_names
from fsipetsc.errors import clear_frames
from fsipetsc.process.together import agree
from fsipetsc.scheme.burst import LONGEST, MADE, SHORTEST, TIME
from fsipetsc.scheme.plan import EXHAUSTED, LOW, RATE, SAID_STOP, STOP, TOO_SHORT, shares
from fsipetsc.scheme.time_step import longest_step
from fsipetsc.stepping import verdicts
from fsipetsc.stepping.fused import NAME, FusedRK4
from fsipetsc.stepping.output_times import OutputTimes
from fsipetsc.stepping.pauses import OUT_OF_TIME, Pauses
from fsipetsc.stepping.phases import logged
from fsipetsc.stepping.series import Series
from fsipetsc.stepping.state import FAULT, State

#: flags and limits of all ranks end here
LAST = STOP + 1
#: with -fsi_check: steps after which conservation is looked at
CHECKED = 256
#: dimension -> points (of all ranks, spare ones too) times steps in one call
MOST_POINTS = {1: 250_000, 2: 2_000_000}
#: what is kept in a checkpoint as it is
_KEPT = "steps", "t", "dt_range", "wall_time", "initial", "beyond"
#: what is noted of a step alone, not of a state
OF_STEPS = (
    *("impulse", "impulse_x", "impulse_y", "impulse_z", "mass_in", "energy_in"),
    *("x_interface", "u_interface"),  # of blocks in one dimension
)


class Integrator:
    """Integrates a state in time; all methods are collective.

    opt: options in force. saved: times at which ``on_frame(t)`` is called. ``on_series()`` is called when the series
    must be written, ``on_step(steps, t, dt)`` after every burst of steps, ``on_grids()`` when the grids have been laid anew,
    ``on_check()`` every CHECKED steps with -fsi_check, ``on_checkpoint()`` when a checkpoint is due (stepping.pauses).
    """

    def __init__(
        self,
        state: State,
        opt: Mapping[str, Any],
        saved: list[float],
        on_frame: Callable[[float], None],
        on_series: Callable[[], None],
        on_step: Callable[[int, float, float], None],
        on_grids: Callable[[], None],
        on_check: Callable[[], None] = lambda: None,
        on_checkpoint: Callable[[], None] = lambda: None,
    ) -> None:
        self.state, self.opt = state, opt
        self.series = Series(state)
        self._next_check = CHECKED if opt["fsi_check"] else np.inf
        self._on_frame, self._on_series, self._on_step, self._on_grids = on_frame, on_series, on_step, on_grids
        self._on_check, self._on_checkpoint = on_check, on_checkpoint
        self.pauses = Pauses(opt, state.comm.rank == 0)
        self._times = OutputTimes(saved)
        self._steady = state.problem.steady_data
        self.steps = 0
        self.t = 0.0
        self.dt_range = [np.inf, 0.0]
        self.wall_time = self._begun = 0.0
        self.before = 0, 0.0  # steps and wall time [s] of the parts of the run before this one
        self.stop_signal = 0
        self.out_of_time = False
        self._fused = opt["ts_type"] == NAME
        self.burst_limit = 0  # most steps in one go; 0: steps are made one by one, stage by stage
        if self._fused and self._steady:  # no longer than a signal may have to wait
            points = state.points + state.reserve
            most = MOST_POINTS.get(state.problem.dimension, MOST_POINTS[2])
            self.burst_limit = max(1, min(opt["fsi_burst"], most // points))
        self._rates: PETSc.Vec | None = None
        self._error: BaseException | None = None
        self.initial: dict[str, Any] = {}
        self.beyond = ""  # what is to be said of steps that are too long

    @property
    def evaluations(self) -> int:
        """Of the right-hand side, in steps that were made anew, too."""
        return self.state.evaluations

    @property
    def complete(self) -> bool:
        """The end time is reached."""
        return self._times.done

    @property
    def _stopped(self) -> bool:
        """Before the end, as somebody wanted it."""
        return bool(self.stop_signal) or self.out_of_time

    def compile(self, announce: Callable[[str], None]) -> None:
        """Compile what PETSc's own methods call, if one of them is used, or load it. Not collective."""
        if not self._fused:
            self.state.compile_path(announce)

    # what TS calls

    def _right_hand_side(self, ts: PETSc.TS, t: float, Y: PETSc.Vec, F: PETSc.Vec) -> None:
        if not self._steady:
            self.state.set_data(t)
        self.state.right_hand_side(Y.getArray(readonly=True), F.getArray())

    def _post_step(self, ts: PETSc.TS) -> None:
        try:
            self._after_step(ts)
        except BaseException as error:  # through PETSc it would become an error stack; raised again after TSSolve
            self._error = error
            ts.setConvergedReason(PETSc.TS.ConvergedReason.CONVERGED_USER)

    def _after_step(self, ts: PETSc.TS) -> None:
        if self.burst_limit:
            t, made, *steps = self.state.burst[[TIME, MADE, SHORTEST, LONGEST]].tolist()
        else:
            t, made, steps = self._target, 1, [self._step] * 2
            if not self._fused:
                self._complete()
            self.series.write(t, self._step)
        if self.state.results[STOP] >= FAULT:  # the step was made with data that are wrong
            agree(self.state.comm, self.state.fault)
        ts.setTime(t)  # the sum of steps may miss a target by round-off
        self.t, self.steps = t, self.steps + int(made)
        ts.setStepNumber(self.steps)
        self.dt_range = [min(self.dt_range[0], steps[0]), max(self.dt_range[1], steps[1])]
        flags = self.state.results[:LAST].tolist()
        self.series.keep(int(made) - 1)  # the last one only if it is sound
        verdicts.check(self.state, t, self.steps, flags, self.opt, self.beyond)
        self.series.keep(1)
        self._on_step(self.steps, t, steps[1])
        if self.steps >= self._next_check:
            self._next_check = self.steps + CHECKED
            self._on_check()
        if not self.series.room:
            self._on_series()
        if self._times.pass_time(t):
            self._on_frame(t)
        self.stop_signal, self.out_of_time = int(flags[STOP]), flags[STOP] == OUT_OF_TIME
        last = self._times.done or self._stopped or self.steps >= self.opt["ts_max_steps"]
        if self.pauses.due(self.steps, flags[STOP], last):
            self._on_checkpoint()
        if last:
            ts.setConvergedReason(PETSc.TS.ConvergedReason.CONVERGED_TIME)
            self._say_the_ends(ts)
        elif flags[LOW]:
            ts.setConvergedReason(PETSc.TS.ConvergedReason.CONVERGED_USER)
            self._say_the_ends(ts)
        else:
            ts.restartStep()  # the last rates of a step are no longer those of its completed solution
            self._plan_step(ts)

    def _say_the_ends(self, ts: PETSc.TS) -> None:
        """Give TS, which has stopped, the ends that the clock follows: -ts_view shows them."""
        ts.setMaxTime(self.opt["ts_max_time"])
        ts.setMaxSteps(self.opt["ts_max_steps"])

    def _complete(self) -> None:
        """Complete a step that PETSc has made."""
        if not self._steady:
            self.state.set_data(self._target)
        self.state.finish()

    # steps

    def _plan_step(self, ts: PETSc.TS) -> None:
        bound = longest_step(self.opt["fsi_cfl"], self.opt["ts_dt"] or 0.0, float(self.state.results[RATE]))
        self._step, self._target = self._times.step(self.t, bound)
        self.state.results[SAID_STOP] = self.pauses.word() if self.state.fault is None else FAULT
        ts.setTimeStep(self._step)
        if self.burst_limit:
            opt, series = self.opt, self.series
            allowed = self.pauses.allowed(self.steps, min(self.burst_limit, opt["ts_max_steps"] - self.steps, series.room))
            times = self.t, self._step, self._target, self._times.target
            bounds = opt["fsi_cfl"], opt["ts_dt"] or 0.0, allowed
            self.state.burst[:] = *times, *bounds, 0, np.inf, 0.0, series.count

    def _create(self) -> PETSc.TS:
        opt = self.opt
        ts = PETSc.TS().create(comm=self.state.comm)
        ts.setProblemType(PETSc.TS.ProblemType.NONLINEAR)
        if self._fused:
            ts.setType(PETSc.TS.Type.PYTHON)
            ts.setPythonContext(FusedRK4(self.state))
        else:
            ts.setType(opt["ts_type"])
            ts.setRHSFunction(self._right_hand_side, self._rates)
        if opt["ts_type"] == "rk":
            ts.setRKType(opt["ts_rk_type"])
        ts.setPostStep(logged("fsi hooks", self._post_step))
        ts.setExactFinalTime(PETSc.TS.ExactFinalTime.STEPOVER)
        ts.setSolution(self.state.solution)
        if self._fused:  # PETSc knows it as "python"
            PETSc.Options().setValue("ts_type", "python")
        ts.setFromOptions()
        PETSc.Options().setValue("ts_type", opt["ts_type"])
        # OutputTimes alone says when to stop, because the sum of the steps may be short of the end by round-off
        ts.setMaxTime(1e300)
        ts.setMaxSteps(np.iinfo(np.int32).max)
        return ts

    def start(self) -> None:
        """Set the initial data and save the first frame."""
        state = self.state
        state.set_initial()
        while state.results[LOW] and not (state.results[EXHAUSTED] or state.results[TOO_SHORT]):
            state.grow()
        self._on_grids()
        if not self._steady:
            state.set_data(self.t)  # with differences in time of the length that a step has
        state.finish()
        verdicts.check(state, self.t, self.steps, state.results[:LAST].tolist(), self.opt, self.beyond)
        found = {name: state.latest[name] for name in shares(state.latest.dtype) if name not in (*OF_STEPS, *point_names(3))}
        self.initial = {name: state.comm.allreduce(share).tolist() for name, share in found.items()}
        self.beyond = verdicts.beyond_bound(state, self.opt)
        self._times.pass_time(self.t)
        self._on_frame(self.t)

    def memory(self) -> dict[str, Any]:
        """What ``resume`` needs beside the state; as JSON holds it."""
        return {
            **{name: getattr(self, name) for name in _KEPT},
            "dt_range": list(self.dt_range),
            "evaluations": self.evaluations,
            "wall_time": self.wall_time + (time.perf_counter() - self._begun),
        }

    def resume(self, memory: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
        """Be where ``memory`` and ``state.capture()`` told of: then the same steps follow. InputError as of restore."""
        state = self.state
        for name in _KEPT:
            setattr(self, name, memory[name])
        self.before = self.steps, self.wall_time
        state.evaluations = memory["evaluations"]
        state.restore(arrays, self.t)
        self._times.pass_time(self.t)
        if state.results[LOW] and not self._times.done:
            state.grow()
        self._on_grids()

    def run(self) -> None:
        """Integrate to the end, a signal, or a failure, which is raised with the series complete."""
        self._begun = time.perf_counter()
        try:
            while not self._times.done and not self._stopped and self.steps < self.opt["ts_max_steps"]:
                if not self._fused:
                    self._rates = self.state.solution.duplicate()
                ts = self._create()
                ts.setTime(self.t)
                ts.setStepNumber(self.steps)
                self._plan_step(ts)
                try:
                    ts.solve(self.state.solution)
                except BaseException as error:
                    # what a step of ours raised: as it is with releases up to 3.18, with later ones wrapped
                    cause = (error.__cause__ if isinstance(error, PETSc.Error) else None) or error
                    clear_frames(cause)
                    raise cause from None
                finally:
                    clear_frames(self._error)  # before the TS is destroyed: petsc4py loses one that somebody else still holds
                    ts.destroy()
                    if self._rates is not None:
                        self._rates.destroy()
                if self._error is not None:
                    raise self._error
                if self.state.results[LOW] and not self._times.done:
                    self.state.grow(self.series.count)
                    self._on_grids()
        finally:
            self.wall_time += time.perf_counter() - self._begun
