"""From a case and options to its problem, its state, the result; what a run says, on rank 0."""

import platform
import shlex
import signal
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager
from datetime import datetime, timezone
from importlib import import_module
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.checks import counted, described, duration
from fsipetsc.errors import ComputationError, FileError, InputError, Interrupted, call, place_of
from fsipetsc.kernels import build
from fsipetsc.options import OF_A_RUN, read_options
from fsipetsc.output import file_layout
from fsipetsc.output.geometry_picture import geometry_rows
from fsipetsc.output.info import summary_rows, table
from fsipetsc.output.reader import open_run
from fsipetsc.output.writer import Kept, RunWriter
from fsipetsc.paper.paper_state import PaperState
from fsipetsc.problem import Problem, blocks_of_line
from fsipetsc.process.together import say, together
from fsipetsc.scheme.plan import RATE, longest_step
from fsipetsc.state import State
from fsipetsc.stepping.block_state import BlockState
from fsipetsc.stepping.integrator import KEPT, Integrator
from fsipetsc.stepping.notes import BEGIN, END, FRAME, Moment, long_steps, notes, of_laws
from fsipetsc.stepping.restart import Past, checkpoint_name, facts, find_past, other_checkpoint

#: before the place of what a run that failed has computed
REMAINS = "; what was computed before is in "
#: wall seconds between lines of progress; with -fsi_progress or on a terminal
USUAL, OFTEN = 30.0, 5.0
#: by kind of layer: names of the bounds by convection and by diffusion
_BOUNDS = {"fluid": ("sound", "viscosity and conduction"), "solid": ("waves", "conduction")}


def build_problem(case: Any, opt: Mapping[str, Any], comm: MPI.Comm) -> Problem | BlockProblem:
    """What the case says: layers for the paper's couplings, else blocks. Collective; InputError."""

    def build() -> Problem | BlockProblem:
        problem = call(case.build, (opt,), "build")
        if isinstance(problem, Problem) and opt["fsi_coupling"] == "conservative":
            return blocks_of_line(problem, opt["fsi_h"], opt["fsi_order"])
        if isinstance(problem, (Problem, BlockProblem)):
            return problem
        found = "nothing (is its return missing?)" if problem is None else described(problem)
        expected = "expected a Problem or BlockProblem"
        raise InputError(f"{place_of(case.build)}: build(opt) returns {found}: {expected}")

    return together(comm, build)


def make_state(
    problem: Any, opt: dict[str, Any], comm: MPI.Comm, announce: Any = lambda text: None
) -> PaperState | BlockState:
    """The state that the options ask for; announce: see `libraries`. Collective; InputError."""
    build.keeps_text = opt["fsi_debug"]
    kind = BlockState if isinstance(problem, BlockProblem) else PaperState
    return kind(comm, problem, opt, announce)


def run_given(case: Any, given: Mapping[str, str], comm: MPI.Comm) -> dict[str, Any]:
    """Run the case from its beginning or a checkpoint and write its result, or with -fsi_check tell
    how it begins; return the options in force. Collective. InputError, ComputationError (what was
    computed is written), FileError, Interrupted.
    """
    past = find_past(case, given, comm)
    options = read_options(case, given, inherited=past.header["options"] if past else {})
    if past is not None:
        past.check_options(options)
    announce = (lambda text: None) if options["fsi_quiet"] else say
    with make_state(build_problem(case, options, comm), options, comm, announce) as state:
        if past is not None:
            past.check(facts(state, options))
        state.set_initial(options["ts_max_time"])
        run = Run(case.NAME, options, state, past)
        if options["fsi_check"]:
            run.look()
        else:
            with closing(run.open()), signals_noted(run):
                run.go()
    return options


@contextmanager
def signals_noted(run: Integrator) -> Iterator[None]:
    """SIGTERM, SIGINT and SIGHUP let the current batch of steps end; all ranks stop together. A
    second SIGINT ends at once. A signal that is ignored stays so, as SIGHUP under nohup.
    """

    def note(number: int, frame: object) -> None:
        run.signal = number
        if number == signal.SIGINT:
            signal.signal(number, signal.SIG_DFL)

    main = threading.current_thread() is threading.main_thread()  # no other may heed them
    with ExitStack() as left:
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP) if main else ():
            if signal.getsignal(number) is not signal.SIG_IGN:
                left.callback(signal.signal, number, signal.signal(number, note))
        yield


class Run(Integrator):
    """One run: the steps, with messages, a result, checkpoints, and the laws that must hold.

    Making one completes initial data, or goes on; no file is touched. Collective. InputError.
    """

    writer: RunWriter

    def __init__(self, name: str, opt: Mapping[str, Any], state: State, past: Past | None) -> None:
        super().__init__(state, opt, past)
        self.name, self.problem, self.past = name, state.problem, past
        self.s, self.m = self.problem.unit("s"), self.problem.unit("m")
        self.path = checkpoint_name(opt)
        self._speaks = self.comm.rank == 0 and not opt["fsi_quiet"]
        self._job = self.t, self.steps, self.wall_time  # where this job begins
        self._told: set[int] = set()  # of fsipetsc.stepping.notes.Moment
        self._long_steps = long_steps(self._now)
        self._interval = OFTEN if opt["fsi_progress"] or sys.stdout.isatty() else USUAL
        self._next_line = time.monotonic() + self._interval

    def line(self, *texts: str) -> None:
        for text in texts if self._speaks else ():
            say(text)

    @property
    def _now(self) -> Moment:
        return Moment(self.state, self.opt, self.t, self._told)

    def note(self, when: str) -> None:
        """Say what is to be said at a moment. Collective."""
        self.line(*(f"note: {text}" for text in notes(when, self._now)))

    def _say_what_runs(self) -> None:
        state = self.state
        self.line(
            f"{self.name}: order {state.op.name}, h = {self.opt['fsi_h']:g}{self.m}, "
            f"{state.points} points on {counted(self.comm.size, 'rank')}, "
            f"to t = {self.opt['ts_max_time']:g}{self.s}"
        )
        if self.past is not None:
            when = f"step {self.steps}, t = {self.t:.6g}{self.s}"
            self.line(f"goes on from {self.past.path}: {when}")

    def look(self) -> None:
        """Print what the case is made of, notes, and the first step. Collective."""
        opt = self.opt
        self._say_what_runs()
        if isinstance(self.problem, BlockProblem):
            self.line(table(geometry_rows(self.problem)))
        self.note(BEGIN)
        rate = float(self.state.results[RATE])
        dt = float(longest_step(opt["fsi_cfl"], opt["ts_dt"] or 0.0, rate))
        count = f"{(opt['ts_max_time'] - self.t) / dt:,.0f} like it to the end"
        self.line(f"first step: {dt:.3g}{self.s}, by {self.bound}; {count}", "checked, and not run")

    @property
    def bound(self) -> str:
        """What bounds the step, as "sound in below"; "" where nothing is known of it."""
        if self.opt["ts_dt"]:
            return "-ts_dt"
        bounds = self.state.bounds
        if not np.isfinite(bounds).all() or not bounds.any():
            return ""
        k, which = np.unravel_index(np.argmax(bounds), bounds.shape)
        layer = self.problem.layers[k]
        return f"{_BOUNDS[layer.kind][which]} in {layer.name}"

    def say_progress(self, dt: float) -> None:
        now = time.monotonic()
        if not self._speaks or now < self._next_line:
            return
        self._next_line = now + self._interval
        end, most = self.opt["ts_max_time"], self.opt["ts_max_steps"]
        t, steps, wall_time = self._job
        done, before = max(self.t / end, self.steps / most), max(t / end, steps / most)
        took = self.wall_time - wall_time
        bound = f" by {self.bound}" if self.bound else ""
        self.line(
            f"  t = {self.t:.4g} of {end:g}{self.s} ({100 * done:.0f} %), step {self.steps}, "
            f"dt = {dt:.3g}{self.s}{bound}, {(self.steps - steps) / took:.3g} steps/s, "
            f"{duration(took * (1.0 - done) / (done - before))} left"
        )

    def open(self) -> RunWriter:
        """Begin the result, or go on with it. Collective; InputError, FileError."""
        other = together(self.comm, lambda: other_checkpoint(self.path, self.opt, self.past))
        after = Kept(*self.past.header["result"]) if self.past else None
        packages = "fsipetsc", "petsc4py", "mpi4py", "numpy"
        header = {
            "case": self.name,
            "options": dict(self.opt),
            "dimension": self.problem.dimension,
            "versions": {
                **{name: import_module(name).__version__ for name in packages},
                "python": platform.python_version(),
                "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
                "mpi": MPI.Get_library_version().split(",")[0].split("\n")[0],
            },
            "ranks": self.comm.size,
            "interfaces": self.problem.interface_names,
            **self.state.header(),
            "notes": list(self.problem.notes),
            "units": self.problem.units,
            "laws": self.problem.invariants,
            "created": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        }
        about = header, self.state.grids(), self.take_series, after, other
        self.writer = RunWriter(self.comm, self.opt["fsi_output"], *about)
        return self.writer

    def frame(self) -> None:
        """Save the state. Collective."""
        self.saved_at = self.t
        self.writer.write_frame(self.t, self.state.save())
        self.note(FRAME)

    def follow_up(self, longest: float, passed: bool, due: bool) -> None:
        self.say_progress(longest)
        if self.full:
            self.writer.flush(now=False)
        if passed:
            self.frame()
        if due:
            self.checkpoint()

    def checkpoint(self) -> None:
        """Write all that has been computed, and then the checkpoint that goes on from there."""
        self.writer.flush()
        header = {
            "case": self.name,
            "options": {k: v for k, v in self.opt.items() if k not in OF_A_RUN},
            "facts": facts(self.state, self.opt),
            "memory": {name: getattr(self, name) for name in KEPT},
            "result": Kept(self.writer.mark, self.writer.nframes, self.writer.rows, self.t),
        }
        arrays, write = self.state.capture(), file_layout.write_checkpoint
        together(self.comm, lambda: arrays and write(self.path, header, arrays))

    def go(self) -> None:
        """Integrate, and complete the result, also after a failure. Collective."""
        self.line(*(f"kept the earlier {a.name} as {b}" for a, b in self.writer.moved))
        self._say_what_runs()
        failure: Exception | None = None
        found: dict[str, dict[str, float]] | None = None
        try:
            if not self.writer.nframes:
                self.initial = self.reached or self.initial  # of a restart with a file of its own
                self.frame()
            if self.past is None:
                self.note(BEGIN)
            self.run()
            if self.t > self.saved_at:  # ended between two saved times
                self.frame()
            found = self.state.errors(self.t, self.opt["fsi_norm"])
            self.note(END)
        except (ComputationError, InputError, file_layout.CheckpointError) as error:
            failure = error
            if isinstance(error, ComputationError):
                error.args = ("; ".join([str(error), *self._long_steps]),)
        number = self.stop_signal
        try:
            self.writer.flush()
            summary = self._summary(failure)
            self.writer.finish(summary, found, join=not number)  # there may be no time to join it
        except FileError as error:
            if failure is None:
                raise
            failure.args = (f"{failure}; {error}",)
            raise failure from None
        folder, path = self.writer.folder, self.writer.path
        where = f"{folder} (opened as {path.name})" if number else str(path)
        norm, errors = self.opt["fsi_norm"], summary_rows(found or {})
        of_kinds = [(f"{norm} errors, {kind}", text) for kind, text in errors]
        self.line(table([*summary_rows(summary, self.s), *of_kinds]), f"result in {where}")
        if summary["status"] == "done":
            self.line(f"next: python -m fsipetsc plot {shlex.quote(self.opt['fsi_output'])}")
        if failure is not None:
            failure.args = (f"{failure}{REMAINS}{where}",)
            raise failure
        if number:
            when = f"{signal.Signals(number).name} at t = {self.t:.6g}{self.s}"
            kept = f"the result so far is in {where}, the checkpoint in {self.path}"
            raise Interrupted(number, f"stopped by {when}; {kept}")

    def _summary(self, failure: Exception | None) -> dict[str, Any]:
        status = "failed" if failure else "stopped" if self.stop_signal else "done"
        message = str(failure or "")
        written = self.comm.rank == 0 and self.writer.rows
        series = together(self.comm, lambda: open_run(self.writer.path).series if written else {})
        places = series["x_interface"][-1].tolist() if "x_interface" in series else ()
        if status == "done" and self._targets:
            end = f"-ts_max_time {self.opt['ts_max_time']:g}{self.s}"
            message = f"ended by -ts_max_steps at t = {self.t:g}{self.s}, before {end}"
        return {
            "status": status,
            "message": message,
            "t": self.t,
            "steps": self.steps,
            "rejected_steps": self.rejected,
            "rhs_evaluations": self.state.evaluations,
            "interfaces": dict(zip(self.problem.interface_names, places)),
            "points": self.state.points,
            "wall_time": self.wall_time,
            "bound": self.bound,
            **of_laws(series, self.problem.invariants, self.initial),
            **{f"initial_{name}": value for name, value in self.initial.items()},
        }
