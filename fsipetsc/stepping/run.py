"""One run from options to result file."""

import datetime
import signal
import threading
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.errors import ComputationError, FsiError, InputError, Interrupted
from fsipetsc.options import read_options
from fsipetsc.output.checkpoint_file import CheckpointError
from fsipetsc.output.geometry_picture import geometry_rows, outlines
from fsipetsc.output.info import table
from fsipetsc.output.writer import RunWriter
from fsipetsc.process.program import say
from fsipetsc.state import State
from fsipetsc.stepping import restart
from fsipetsc.stepping.integrator import Integrator
from fsipetsc.stepping.progress import Reporter, bound_of_step
from fsipetsc.stepping.restart import Past
from fsipetsc.stepping.solve import build_problem, make_state
from fsipetsc.stepping.soundness import Ledgers

SET_UP, LOOP, OUTPUT = "set-up", "time loop", "output"
#: before the place of what a run that failed has computed
REMAINS = "; what was computed before is in "


def stage(name: str) -> AbstractContextManager[Any]:
    """What is done within belongs to a stage of -log_view; one within another interrupts it."""
    return PETSc.Log.Stage(name) if PETSc.Log.isActive() else nullcontext()


@contextmanager
def signals_noted(heed: Callable[[int], object]) -> Iterator[None]:
    """SIGTERM, SIGINT and SIGHUP let the current batch of steps end; all ranks stop together.

    heed: gets the number of a signal. One that comes before the first step is answered after it;
    one after the last step is not answered. A second SIGINT ends at once. A signal that is ignored
    stays so, as SIGHUP under nohup.
    """

    def note(number: int, frame: object) -> None:
        heed(number)
        if number == signal.SIGINT:
            signal.signal(number, signal.SIG_DFL)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    stopping = signal.SIGTERM, signal.SIGINT, signal.SIGHUP
    heeded = [number for number in stopping if signal.getsignal(number) is not signal.SIG_IGN]
    earlier = {number: signal.signal(number, note) for number in heeded}
    try:
        yield
    finally:
        for number, handler in earlier.items():
            signal.signal(number, handler)


def run_given(
    case: Any, given: Mapping[str, str], comm: MPI.Comm, check: bool = False
) -> dict[str, Any]:
    """Run the case with the options that the user gave, from its beginning or a checkpoint.

    Returns the options in force. check: as of ``run_case``. Collective; raises what that raises.
    """
    past = restart.find_past(case, given, comm)
    options = read_options(case, given, inherited=None if past is None else past.options)
    if past is not None:
        restart.check_options(past, options, given)
    run_case(case, options, comm, past, check)
    return options


def run_case(
    case: Any,
    options: dict[str, Any],
    comm: MPI.Comm,
    past: Past | None = None,
    check: bool = False,
) -> None:
    """Build the case's problem, integrate it and write its result. Collective on comm.

    past: a checkpoint to go on from. check: do what comes before the first step, and say what was
    found instead of writing a result. Raises InputError, ComputationError (after writing what was
    computed), FileError, Interrupted.
    """
    with stage(SET_UP):
        problem = build_problem(case, options, comm)
        quiet = comm.rank > 0 or options["fsi_quiet"]
        state = make_state(problem, options, comm, (lambda text: None) if quiet else say)
    with state:
        with stage(SET_UP):
            if past is not None:
                restart.check_problem(past, state)
            state.check_data()  # before there is a file
            state.check_motion(options["ts_max_time"])
            report = Reporter(case.NAME, options, state)
            if check:
                _check_start(state, options, report)
                return
            run = _Run(case, options, state, past, report)
        with closing(run.writer), signals_noted(run.integrator.heed):
            run.go()


def _check_start(state: State, opt: Mapping[str, Any], report: Reporter) -> None:
    """Set the initial data, and print what the case is made of, notes, and the first step."""
    problem = state.problem
    (integrator := Integrator(state, opt)).start()
    report.begin()
    report.line(table(geometry_rows(outlines(problem, opt["fsi_h"]), problem.unit("m"))))
    report.notes("begin")
    report.line(report.first_step())
    report.note(integrator.beyond)
    report.line("checked, and not run")


class _Run:
    """One run: integrator, writer, checkpoints, ledgers, report."""

    def __init__(
        self, case: Any, opt: Mapping[str, Any], state: State, past: Past | None, report: Reporter
    ) -> None:
        self.name, self.opt, self.comm = case.NAME, opt, state.comm
        self.problem, self.state, self.past, self.report = state.problem, state, past, report
        self.unit = self.problem.unit("s")
        self.checkpoint = restart.checkpoint_name(opt["fsi_checkpoint"], opt["fsi_output"])
        other = restart.check_place(self.comm, self.checkpoint, opt, past)
        self.checks = opt["fsi_check"] is not None
        self.ledgers = Ledgers(state.invariants, opt["fsi_check"], self.unit)
        self.saved_at = -1.0
        self.integrator = Integrator(
            state,
            opt,
            on_frame=self._frame,
            on_series=lambda: self._write(self.writer.write_series),
            on_step=self.report.step,
            on_checkpoint=self._checkpoint,
        )
        # a number of its own, by which result and checkpoints are recognised, and when it began
        created = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
        self.mark, after = {"run": uuid.uuid4().hex, "created": created}, None
        if past is not None:
            self.mark = past.header["run"]
            after = (*past.header["result"], past.header["memory"]["t"])
        about = self._header(), state.grids(), self._take, after, other
        self.writer = RunWriter(self.comm, opt["fsi_output"], *about)

    def _header(self) -> dict[str, Any]:
        """Return what is known of the run at its start, for the result."""
        problem = self.problem
        return {
            "case": self.name,
            "options": dict(self.opt),
            "dimension": problem.dimension,
            "versions": restart.versions(),
            "ranks": self.comm.size,
            "interfaces": problem.interface_names,
            **self.state.header(),
            "notes": list(problem.notes),
            "units": problem.units,
            "laws": self.state.invariants,
            **self.mark,
        }

    # what the integrator calls

    def _frame(self, t: float) -> None:
        self.state.time = t
        with stage(OUTPUT):
            self.writer.write_frame(t, self.state.save())
            self.report.notes("saved")
        self.saved_at = t
        if self.checks:
            self._write(self.writer.write_series)

    def _write(self, action: Callable[[], None]) -> None:
        """Let the writer write. Raise ComputationError on all ranks if a law that must hold, by
        -fsi_check, does not. Collective.
        """
        with stage(OUTPUT):
            action()
        if self.checks and (fault := self.comm.bcast(self.ledgers.fault)):
            allowed = f"-fsi_check {self.opt['fsi_check']:g} allows no more"
            raise ComputationError(f"{fault}; {allowed}")

    def _take(self) -> np.ndarray:
        """Return the steps since the last time, of which the ledgers learn. Collective."""
        steps = self.integrator.take_series()
        if self.comm.rank == 0:
            self.ledgers.add(steps)
        return steps

    def _checkpoint(self) -> None:
        """Write all that has been computed, and then the checkpoint that goes on from there."""
        with stage(OUTPUT):
            self._write(self.writer.flush)  # what does not hold is nothing to go on from
            more = {
                "run": self.mark,
                "memory": self.integrator.memory(),
                "ledgers": self.ledgers.memory(),
                "saved_at": self.saved_at,
                "result": [self.writer.nframes, self.writer.rows],
            }
            restart.write_checkpoint(self.state, self.checkpoint, self.name, self.opt, more)

    # the course of the run

    def go(self) -> None:
        """Begin or go on, integrate, and complete the result, also after a failure."""
        for old, new in self.writer.moved:
            self.report.line(f"kept the earlier {old.name} as {new}")
        failure: FsiError | None = None
        found: dict[str, dict[str, float]] | None = None
        try:
            self._begin()
            with stage(LOOP):
                self.integrator.run()
            if self.integrator.t > self.saved_at:  # ended between two saved times
                self._frame(self.integrator.t)
            self._write(self.writer.flush)  # so that the summary knows what it took
            found = self.state.errors(self.integrator.t, self.opt["fsi_norm"])
            self.report.notes("end")
        except (ComputationError, InputError, CheckpointError) as error:
            failure, self.checks = error, False
            self._write(self.writer.flush)
        number = self.integrator.stop_signal
        summary = self._summary(failure)
        self.writer.finish(summary, found, join=not number)  # there may be no time to join it
        path = self.writer.path
        where = f"{self.writer.folder} (opened as {path.name})" if number else str(path)
        self.report.end(summary, found, where)
        if failure is not None:
            failure.args = (f"{failure}{REMAINS}{where}",)
            raise failure
        if number:
            when = f"{signal.Signals(number).name} at t = {self.integrator.t:.6g}{self.unit}"
            kept = f"the result so far is in {where}, the checkpoint in {self.checkpoint}"
            raise Interrupted(number, f"stopped by {when}; {kept}")

    def _begin(self) -> None:
        report, integrator, past = self.report, self.integrator, self.past
        report.begin()
        with stage(SET_UP):
            if past is None:
                integrator.start()
                report.notes("begin")
                self.ledgers.begin(integrator.initial)
            else:
                header = past.header
                integrator.resume(header["memory"], past.arrays)
                report.note(*past.notes)
                when = f"step {integrator.steps}, t = {integrator.t:.6g}{self.unit}"
                report.line(f"goes on from {past.path}: {when}")
                self.ledgers.begin(integrator.initial, header["ledgers"])
                self.saved_at = header["saved_at"]
                if not self.writer.nframes:  # a file of its own
                    self._frame(integrator.t)
        report.start(integrator.t, integrator.steps)
        report.note(integrator.beyond)

    def _summary(self, failure: FsiError | None) -> dict[str, Any]:
        integrator, state, ledgers = self.integrator, self.state, self.ledgers
        status = "failed" if failure else "stopped" if integrator.stop_signal else "done"
        message = str(failure or "")
        if status == "done" and not integrator.complete:
            end = f"-ts_max_time {self.opt['ts_max_time']:g}{self.unit}"
            message = f"ended by -ts_max_steps at t = {integrator.t:g}{self.unit}, before {end}"
        return {
            "status": status,
            "message": message,
            "t": integrator.t,
            "steps": integrator.steps,
            "rejected_steps": getattr(state, "retries", 0),
            "rhs_evaluations": state.evaluations,
            "interfaces": dict(zip(self.problem.interface_names, state.places)),
            "points": state.points,
            "wall_time": integrator.wall_time,
            "bound": bound_of_step(state, self.opt),
            "departures": ledgers.departures,
            "J_error": ledgers.J_error,
            **({"lost_energy": ledgers.lost} if getattr(state, "lossy", False) else {}),
            **{f"initial_{name}": value for name, value in integrator.initial.items()},
        }
