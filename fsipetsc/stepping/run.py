"""One run from options to result file, and what it says. Rank 0 speaks."""

import datetime
import shlex
import signal
import sys
import threading
import time
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fsipetsc.checks import counted, duration
from fsipetsc.errors import ComputationError, FsiError, InputError, Interrupted
from fsipetsc.options import read_options
from fsipetsc.output.file_layout import CheckpointError
from fsipetsc.output.geometry_picture import geometry_rows, outlines
from fsipetsc.output.info import summary_rows, table
from fsipetsc.output.writer import RunWriter
from fsipetsc.process.program import say
from fsipetsc.scheme.plan import RATE, longest_step
from fsipetsc.state import State
from fsipetsc.stepping import restart
from fsipetsc.stepping.integrator import Integrator
from fsipetsc.stepping.notes import Ledgers, long_steps, notes
from fsipetsc.stepping.restart import Past
from fsipetsc.stepping.solve import build_problem, make_state

#: before the place of what a run that failed has computed
REMAINS = "; what was computed before is in "
#: wall seconds between lines of progress; with -fsi_progress or on a terminal
USUAL, OFTEN = 30.0, 5.0
#: by kind of layer: names of the bounds by convection and by diffusion
_BOUNDS = {"fluid": ("sound", "viscosity and conduction"), "solid": ("waves", "conduction")}


@contextmanager
def signals_noted(heed: Callable[[int], object]) -> Iterator[None]:
    """SIGTERM, SIGINT and SIGHUP let the current batch of steps end; all ranks stop together.

    heed: gets the number of a signal. A second SIGINT ends at once. A signal that is ignored stays
    so, as SIGHUP under nohup.
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
    problem = build_problem(case, options, comm)
    quiet = comm.rank > 0 or options["fsi_quiet"]
    state = make_state(problem, options, comm, (lambda text: None) if quiet else say)
    with state:
        if past is not None:
            restart.check_problem(past, state)
        state.check_data()  # before there is a file
        state.check_motion(options["ts_max_time"])
        run = Run(case.NAME, options, state, past)
        if check:
            run.look()
            return
        writer = run.open()
        with closing(writer), signals_noted(run.heed):
            run.go()


def bound_of_step(state: State, opt: Mapping[str, Any]) -> str:
    """Return what bounds the step, as "sound in below"; "" where nothing is known of it."""
    if opt["ts_dt"]:
        return "-ts_dt"
    bounds = state.bounds
    if not np.isfinite(bounds).all() or not bounds.any():
        return ""
    k, which = np.unravel_index(np.argmax(bounds), bounds.shape)
    layer = state.problem.layers[k]
    return f"{_BOUNDS[layer.kind][which]} in {layer.name}"


class Run(Integrator):
    """One run: the steps, with messages, a result, checkpoints, and the laws that must hold."""

    writer: RunWriter

    def __init__(self, name: str, opt: Mapping[str, Any], state: State, past: Past | None) -> None:
        super().__init__(state, opt)
        self.name, self.problem, self.past = name, state.problem, past
        self.s = self.problem.unit("s")
        self.checks = opt["fsi_check"] is not None
        self.long_steps = list[str]()  # what is to be said of them, here and after a failure
        self.ledgers = Ledgers({}, {})  # nothing must hold before there is a state
        self.path = restart.checkpoint_name(opt["fsi_checkpoint"], opt["fsi_output"])
        self._speaks = self.comm.rank == 0 and not opt["fsi_quiet"]
        self._interval = OFTEN if opt["fsi_progress"] or sys.stdout.isatty() else USUAL

    def open(self) -> RunWriter:
        """Begin the result, or go on with it. Collective; InputError, FileError."""
        other = restart.check_place(self.comm, self.path, self.opt, self.past)
        # a number of its own, by which result and checkpoints are recognised, and when it began
        created = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
        self.mark, after = {"run": uuid.uuid4().hex, "created": created}, None
        if self.past is not None:
            self.mark = self.past.header["run"]
            after = (*self.past.header["result"], self.past.header["memory"]["t"])
        header = {
            "case": self.name,
            "options": dict(self.opt),
            "dimension": self.problem.dimension,
            "versions": restart.versions(),
            "ranks": self.comm.size,
            "interfaces": self.problem.interface_names,
            **self.state.header(),
            "notes": list(self.problem.notes),
            "units": self.problem.units,
            "laws": self.state.invariants,
            **self.mark,
        }
        about = header, self.state.grids(), self._take, after, other
        self.writer = RunWriter(self.comm, self.opt["fsi_output"], *about)
        return self.writer

    # what is said

    def line(self, text: str) -> None:
        """Print a line."""
        if self._speaks:
            say(text)

    def note(self, *said: str) -> None:
        """Print each as a note."""
        for text in said:
            self.line(f"note: {text}")

    def _say_what_runs(self) -> None:
        state, h, m = self.state, self.opt["fsi_h"], self.problem.unit("m")
        other = f" (smallest cells {state.h:.3g}{m})" if abs(state.h - h) > 0.01 * h else ""
        self.line(
            f"{self.name}: order {state.op.name}, h = {h:g}{m}{other}, "
            f"{state.points} points on {counted(self.comm.size, 'rank')}, "
            f"to t = {self.opt['ts_max_time']:g}{self.s}"
        )

    def look(self) -> None:
        """Print what the case is made of, notes, and the first step. Collective."""
        opt, state, problem = self.opt, self.state, self.problem
        integrator = Integrator(state, opt)
        integrator.start()
        self._say_what_runs()
        self.line(table(geometry_rows(outlines(problem, opt["fsi_h"]), problem.unit("m"))))
        self.note(*notes(state, "begin"), *long_steps(state, opt))
        dt = float(longest_step(opt["fsi_cfl"], opt["ts_dt"] or 0.0, float(state.results[RATE])))
        count = f"{opt['ts_max_time'] / dt:,.0f} like it to the end"
        self.line(f"first step: {dt:.3g}{self.s}, by {bound_of_step(state, opt)}; {count}")
        self.line("checked, and not run")

    def progress(self, dt: float) -> None:
        """Say how far the run is, if that is due."""
        now = time.monotonic()
        if not self._speaks or now - self._last[2] < self._interval:
            return
        end, most = self.opt["ts_max_time"], self.opt["ts_max_steps"]
        begin, before, since = self._first
        part = max((self.t - begin) / (end - begin), (self.steps - before) / (most - before))
        rate = (self.steps - self._last[1]) / (now - self._last[2])
        bound = bound_of_step(self.state, self.opt)
        self.line(
            f"  t = {self.t:.4g} of {end:g}{self.s} ({100 * part:.0f} %), step {self.steps}, "
            f"dt = {dt:.3g}{self.s}{f' by {bound}' if bound else ''}, {rate:.3g} steps/s, "
            f"{duration((now - since) * (1.0 / part - 1.0))} left"
        )
        self._last = self.t, self.steps, now

    def _say_the_end(self, summary: Mapping[str, Any], errors: Any, place: str) -> None:
        norm = self.opt["fsi_norm"]
        of_kinds = [(f"{norm} errors, {kind}", text) for kind, text in summary_rows(errors or {})]
        self.line(table([*summary_rows(summary, self.s), *of_kinds]))
        self.line(f"result in {place}")
        if summary["status"] == "done":
            self.line(f"next: python -m fsipetsc plot {shlex.quote(self.opt['fsi_output'])}")

    # what is written

    def frame(self) -> None:
        super().frame()
        self.writer.write_frame(self.t, self.state.save())
        self.note(*notes(self.state, "saved", self.t))
        if self.checks:
            self._write(self.writer.write_series)

    def records(self) -> None:
        self._write(self.writer.write_series)

    def _write(self, action: Callable[[], None]) -> None:
        """Let the writer write. Raise ComputationError on all ranks if a law that must hold, by
        -fsi_check, does not. Collective.
        """
        action()
        if self.checks and (fault := self.comm.bcast(self.ledgers.fault)):
            allowed = f"-fsi_check {self.opt['fsi_check']:g} allows no more"
            raise ComputationError(f"{fault}; {allowed}")

    def _take(self) -> np.ndarray:
        """Return the steps since the last time, of which the ledgers learn. Collective."""
        steps = self.take_series()
        if self.comm.rank == 0:
            self.ledgers.add(steps)
        return steps

    def checkpoint(self) -> None:
        """Write all that has been computed, and then the checkpoint that goes on from there."""
        self._write(self.writer.flush)  # what does not hold is nothing to go on from
        more = {
            "run": self.mark,
            "memory": self.memory(),
            "ledgers": self.ledgers.kept,
            "result": [self.writer.nframes, self.writer.rows],
        }
        restart.write_checkpoint(self.state, self.path, self.name, self.opt, more)

    # the course of the run

    def go(self) -> None:
        """Begin or go on, integrate, and complete the result, also after a failure."""
        for old, new in self.writer.moved:
            self.line(f"kept the earlier {old.name} as {new}")
        failure: FsiError | None = None
        found: dict[str, dict[str, float]] | None = None
        try:
            self._begin()
            self.run()
            if self.t > self.saved_at:  # ended between two saved times
                self.frame()
            self._write(self.writer.flush)  # so that the summary knows what it took
            found = self.state.errors(self.t, self.opt["fsi_norm"])
            self.note(*notes(self.state, "end"))
        except (ComputationError, InputError, CheckpointError) as error:
            failure, self.checks = error, False
            if isinstance(error, ComputationError):
                error.args = ("; ".join([str(error), *self.long_steps]),)
            self._write(self.writer.flush)
        number = self.stop_signal
        summary = self._summary(failure)
        self.writer.finish(summary, found, join=not number)  # there may be no time to join it
        path: Path = self.writer.path
        where = f"{self.writer.folder} (opened as {path.name})" if number else str(path)
        self._say_the_end(summary, found, where)
        if failure is not None:
            failure.args = (f"{failure}{REMAINS}{where}",)
            raise failure
        if number:
            when = f"{signal.Signals(number).name} at t = {self.t:.6g}{self.s}"
            kept = f"the result so far is in {where}, the checkpoint in {self.path}"
            raise Interrupted(number, f"stopped by {when}; {kept}")

    def _begin(self) -> None:
        self._say_what_runs()
        if self.past is None:
            self.start()
            self.long_steps = long_steps(self.state, self.opt)
            self.note(*notes(self.state, "begin"), *self.long_steps)
            self._keep_ledgers()
        else:
            header = self.past.header
            self.resume(header["memory"], self.past.arrays)
            when = f"step {self.steps}, t = {self.t:.6g}{self.s}"
            self.line(f"goes on from {self.past.path}: {when}")
            self._keep_ledgers(header["ledgers"])
            if not self.writer.nframes:  # a file of its own
                self.frame()
        self._first = self._last = self.t, self.steps, time.monotonic()

    def _keep_ledgers(self, memory: Mapping[str, Any] | None = None) -> None:
        about = self.state.invariants, self.initial, memory, self.opt["fsi_check"], self.s
        self.ledgers = Ledgers(*about)

    def _summary(self, failure: FsiError | None) -> dict[str, Any]:
        state, ledgers = self.state, self.ledgers
        status = "failed" if failure else "stopped" if self.stop_signal else "done"
        message = str(failure or "")
        if status == "done" and not self.complete:
            end = f"-ts_max_time {self.opt['ts_max_time']:g}{self.s}"
            message = f"ended by -ts_max_steps at t = {self.t:g}{self.s}, before {end}"
        return {
            "status": status,
            "message": message,
            "t": self.t,
            "steps": self.steps,
            "rejected_steps": self.rejected,
            "rhs_evaluations": state.evaluations,
            "interfaces": dict(zip(self.problem.interface_names, state.places)),
            "points": state.points,
            "wall_time": self.wall_time,
            "bound": bound_of_step(state, self.opt),
            "departures": ledgers.departures,
            "J_error": ledgers.J_error,
            **({"lost_energy": ledgers.lost} if getattr(state, "lossy", False) else {}),
            **{f"initial_{name}": value for name, value in self.initial.items()},
        }
