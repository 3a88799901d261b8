"""One run from options to result file."""

from __future__ import annotations

import signal
import time
from collections.abc import Mapping
from contextlib import closing, suppress
from typing import Any

import numpy as np
from mpi4py import MPI

from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.errors import ComputationError, FileError, FsiError, InputError, Interrupted
from fsipetsc.options import read_options
from fsipetsc.options.sources import Given
from fsipetsc.output.checkpoint_file import CheckpointError
from fsipetsc.output.file_layout import describe
from fsipetsc.output.writer import RunWriter
from fsipetsc.problem import Problem
from fsipetsc.scheme.conservation_check import ConservationCheck
from fsipetsc.stepping.checkpoints import CheckpointKeeper
from fsipetsc.stepping.integrator import Integrator
from fsipetsc.stepping.ledgers import Ledgers
from fsipetsc.stepping.limits import Limits
from fsipetsc.stepping.output_times import saved_times, times_without_frame
from fsipetsc.stepping.phases import LOOP, OUTPUT, SET_UP, Phases
from fsipetsc.stepping.report import Reporter
from fsipetsc.stepping.restart import Past, check_options, check_problem, find_past
from fsipetsc.stepping.signals import asks, ends
from fsipetsc.stepping.solve import build_problem, make_state
from fsipetsc.stepping.state import State
from fsipetsc.stepping.verdicts import cold_layers
from fsipetsc.stepping.versions import versions


def run_given(case: Any, given: Mapping[str, Given], comm: MPI.Comm) -> dict[str, Any]:
    """Run the case with the options that the user gave, from its beginning or a checkpoint; those in force.

    Collective; raises what ``run_case`` raises.
    """
    past = find_past(case, given, comm)
    options = read_options(case, given, inherited=None if past is None else past.options)
    if past is not None:
        check_options(past, options, given)
    run_case(case, options, comm, past)
    return options


def run_case(case: Any, options: dict[str, Any], comm: MPI.Comm, past: Past | None = None) -> None:
    """Build the case's problem, integrate it and write its result. Collective on comm.

    past: a checkpoint to go on from. Raises InputError, ComputationError (after writing what was computed), FileError,
    Interrupted.
    """
    phases = Phases()
    with phases(SET_UP):
        problem = build_problem(case, options, comm)
        state = make_state(problem, options, comm)
    with state:
        with phases(SET_UP):
            if past is not None:
                check_problem(past, problem, describe(state.journal.dtype))
            state.check_data()  # before there is a file
            keeper = CheckpointKeeper(comm, case.NAME, options, state, past)
            run = _Run(case, options, comm, phases, state, keeper)
        with closing(run.writer), asks(run.integrator.pauses), ends(run.integrator.pauses):
            run.go()


class _Run:
    """The pieces of one run, wired together."""

    def __init__(
        self,
        case: Any,
        opt: Mapping[str, Any],
        comm: MPI.Comm,
        phases: Phases,
        state: State,
        keeper: CheckpointKeeper,
    ) -> None:
        self.case, self.opt, self.comm, self.phases, self.keeper = case, opt, comm, phases, keeper
        self.problem, self.state = state.problem, state
        times = opt["ts_max_time"], opt["fsi_output_dt"], opt["fsi_output_times"]
        saved = saved_times(*times, self.problem.unit("s"))
        after = keeper.written_before
        self.writer = RunWriter(comm, opt["fsi_output"], self._header(), after=after, settle=keeper.settle)
        self.writer.take_series = self._take
        self.report = Reporter(comm, case.NAME, opt)
        self.saved_at = -1.0
        self.watch: ConservationCheck | None = None
        self.fault: str | None = None  # on rank 0, what the watch has found
        self.checks = bool(opt["fsi_check"])
        self.ledgers, self.limits = Ledgers(self.problem.invariants), Limits(opt)
        hooks = self._frame, self._series, self.report.step, self._grids, self._check, self._checkpoint
        self.integrator = Integrator(self.state, opt, saved, *hooks)

    def _header(self) -> dict[str, Any]:
        return {
            "case": self.case.NAME,
            "options": dict(self.opt),
            "dimension": self.problem.dimension,
            "versions": versions(),
            "ranks": self.comm.size,
            "layers": self.state.header(),
            "interfaces": interface_names(self.problem),
            **({"interface_faces": self.problem.interface_faces} if isinstance(self.problem, RunProblem) else {}),
            "points": self.state.recorded,
            "notes": list(self.problem.notes),
            "units": self.problem.units,
            "laws": self.problem.invariants,
            **self.keeper.run,
        }

    def _grids(self) -> None:
        self.writer.start_segment(self.state.grids())
        self._look()  # frames of the earlier grids may have been written, and steps with them

    def _frame(self, t: float) -> None:
        self.limits.note(self.state, t)
        with self.phases(OUTPUT, "fsi frame"):
            self.writer.write_frame(t, self.state.save)
        self.saved_at = t
        self._look()

    def _take(self) -> np.ndarray | None:
        """Hand over the records of the steps that have been made since the last time. Collective."""
        series = self.integrator.series
        if not series.count:
            return None
        self._watch()
        steps = series.take(self.comm)
        if self.comm.rank == 0:
            self.ledgers.add(steps)
        return steps

    def _watch(self) -> None:
        """Let the watch see the steps that it has not seen yet. Collective."""
        if not self.checks:
            return
        steps = self.integrator.series.add_up(self.comm)
        if self.comm.rank == 0 and self.fault is None:
            self.fault = self._conservation().look(steps)

    def _conservation(self) -> ConservationCheck:
        """The watch, which begins with the integrals at t = 0. On rank 0."""
        if self.watch is None:
            invariants, unit = self.problem.invariants, self.problem.unit("s")
            self.watch = ConservationCheck(invariants, self.integrator.initial, self.opt["fsi_check"], unit)
        return self.watch

    def _check(self) -> None:
        self._watch()
        self._look()

    def _series(self) -> None:
        with self.phases(OUTPUT, "fsi series"):
            self.writer.write_series()
        self._look()

    def _flush(self) -> None:
        with self.phases(OUTPUT, "fsi finish"):
            self.writer.flush()
        self._look()

    def _checkpoint(self) -> None:
        """Write all that has been computed, and then the checkpoint that goes on from there."""
        begun = time.perf_counter()
        with self.phases(OUTPUT, "fsi checkpoint"):
            self.writer.flush()
            self._look()  # what does not hold is nothing to go on from
            memory = {
                "memory": self.integrator.memory(),
                "watch": self.watch.memory() if self.watch is not None else None,
                "ledgers": self.ledgers.memory(),
                "saved_at": self.saved_at,
                "limits": list(self.limits.changes),
                "result": [self.writer.nframes, self.writer.rows],
                "wall_time_total": self._total(),
            }
            self.keeper.write(memory)
        self.integrator.pauses.written(time.perf_counter() - begun)

    def _resume(self, past: Past) -> None:
        """Go on from a checkpoint."""
        header, integrator = past.header, self.integrator
        integrator.resume(header["memory"], self.keeper.arrays)
        self.ledgers.recall(header.get("ledgers"), integrator.initial)
        self.limits.changes = list(header.get("limits", ()))
        if header["watch"] is not None and self.checks and self.comm.rank == 0:
            self._conservation().recall(header["watch"])
        self._note_missed(past)
        if self.writer.nframes:
            self.saved_at = header["saved_at"]
        else:  # a file of its own
            self._frame(integrator.t)

    def _note_missed(self, past: Past) -> None:
        """Say which output times come too late. A mere note: not collective, and a file that cannot be read ends nothing."""
        asked = set(self.opt["fsi_output_times"] or ()) - set(past.options["fsi_output_times"] or ())
        if self.comm.rank > 0:
            return
        with suppress(FileError):
            missed = times_without_frame(asked, self.integrator.t, self.writer.path)
            if missed:
                missed += self.problem.unit("s")
                self.report.line(f"note: -fsi_output_times: {missed}, before the checkpoint: no frames are made there")

    def _look(self) -> None:
        """Raise ComputationError on all ranks if an invariant that must hold does not, in steps that the watch has seen."""
        if not self.checks:
            return
        fault = self.comm.bcast(self.fault)
        if fault:
            raise ComputationError(f"{fault}; -fsi_check {self.opt['fsi_check']:g} allows no more")

    def go(self) -> None:
        integrator = self.integrator
        for line in self.keeper.kept:
            self.report.line(line)
        failure: FsiError | None = None
        found: dict[str, dict[str, float]] | None = None
        try:
            self.report.begin(self.state)
            for line in self.keeper.lines():
                self.report.line(line)
            with self.phases(SET_UP):
                say = self.report.line
                self.state.compile(say, lambda: (self.state.compile_saving(), integrator.compile(say)))
                if self.keeper.past is None:
                    integrator.start()
                    for line in [*self.state.first_notes(), *cold_layers(self.state)]:
                        self.report.line(line)
                    self.ledgers.begin(integrator.initial)
                else:
                    self._resume(self.keeper.past)
            self.report.start(integrator.t, integrator.steps, integrator.pauses.ends)
            if integrator.beyond:
                self.report.line(f"note: {integrator.beyond}; explicit methods are unstable far beyond it")
            with self.phases(LOOP):
                integrator.run()
            self._last_frame()
            self._flush()  # so that the summary knows what it took
            found = self.state.errors(integrator.t, self.opt["fsi_norm"])
        except (ComputationError, InputError, CheckpointError) as error:
            failure, self.checks = error, False
            self._flush()
        except BaseException as error:
            self._rescue(error)
            raise
        finally:
            self.report.clear()
        summary = self._summary(failure)
        stopped = bool(integrator.stop_signal) or integrator.out_of_time  # then there may be no time to join it
        self.writer.finish(summary, found, join=not stopped)
        where = f"{self.writer.folder} (opened as {self.writer.path.name})" if stopped else str(self.writer.path)
        self.report.end(summary, found, where)
        if failure is not None:
            failure.args = (f"{failure}; what was computed before is in {self.writer.path}",)
            raise failure
        if integrator.stop_signal:
            number = integrator.stop_signal
            name, s = signal.Signals(number).name, self.problem.unit("s")
            kept = f"the result so far is in {where}, the checkpoint in {self.keeper.path}"
            raise Interrupted(number, f"stopped by {name} at t = {integrator.t:.6g}{s}; {kept}")

    def _rescue(self, error: BaseException) -> None:
        """Write what was computed before an error that all ranks have met at the same place.

        Writing takes all ranks: what one of them alone has not written is lost when the others are stopped.
        """
        if isinstance(error, FileError) or not getattr(error, "collective", self.comm.size == 1):
            return
        if self.integrator.initial:
            with suppress(FileError):  # the error itself says more
                self.writer.finish(self._summary(error))

    def _last_frame(self) -> None:
        """A run that ends between two saved times still keeps its last state."""
        if self.integrator.t > self.saved_at:
            self._frame(self.integrator.t)

    def _early_end(self) -> str:
        """What a run says that its steps have ended before its time, else ""."""
        integrator, s = self.integrator, self.problem.unit("s")
        if integrator.complete or integrator.stop_signal:
            return ""
        if integrator.out_of_time:
            return (
                f"ended by -fsi_wall_limit at t = {integrator.t:g}{s}, before -ts_max_time {self.opt['ts_max_time']:g}{s}: "
                f"-fsi_restart {self.keeper.path} goes on"
            )
        return f"ended by -ts_max_steps at t = {integrator.t:g}{s}, before -ts_max_time {self.opt['ts_max_time']:g}{s}"

    def _total(self) -> float | None:
        """Wall time [s] of the run so far with set-up and output, in its earlier parts too; None if that is not known."""
        past = self.keeper.past
        before = 0.0 if past is None else past.header.get("wall_time_total")  # of earlier versions there is none
        return None if before is None else before + self.phases.total()

    def _summary(self, failure: BaseException | None) -> dict[str, Any]:
        integrator = self.integrator
        steps, wall_time = integrator.before
        this = {"steps": integrator.steps - steps, "wall_time": integrator.wall_time - wall_time}
        return {
            "status": "failed" if failure else ("stopped" if integrator.stop_signal else "done"),
            "message": (str(failure) or type(failure).__name__) if failure else self._early_end(),
            "t": integrator.t,
            "steps": integrator.steps,
            "rejected_steps": getattr(self.state, "retries", 0),
            "rhs_evaluations": integrator.evaluations,
            "dt_min": integrator.dt_range[0] if integrator.steps else None,
            "dt_max": integrator.dt_range[1] if integrator.steps else None,
            "points": self.state.points,
            "interfaces": dict(zip(interface_names(self.problem), self.state.places, strict=True)),
            "ranks": self.comm.size,
            "wall_time": integrator.wall_time,
            "wall_time_total": self._total(),
            "part": {**this, "wall_time_total": self.phases.total()},
            "phases": dict(self.phases.seconds),
            "limits": self.limits.changes,
            "departures": self.ledgers.departures,
            "J_error": self.ledgers.J_error,
            **{f"initial_{name}": value for name, value in integrator.initial.items()},
            "versions": versions(),
        }


def interface_names(problem: Problem) -> list[str]:
    """Names of the interfaces, from left to right; of blocks in their order."""
    if isinstance(problem, RunProblem):
        return problem.interface_names
    return [f"{a.name} | {b.name}" for a, b in zip(problem.layers, problem.layers[1:], strict=False)]
