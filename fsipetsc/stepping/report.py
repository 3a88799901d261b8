"""What a run says: a line at the start, progress, a summary at the end. Rank 0 speaks."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mpi4py import MPI

from fsipetsc.checks import counted
from fsipetsc.stepping.state import State

#: wall seconds between two reports of progress: rewritten in place on a terminal; else line by line, ever rarer
_IN_PLACE, _LINES, _RAREST = 1.0, 2.0, 60.0


class Reporter:
    """Messages of a run; silent with -fsi_quiet and on all ranks but the first."""

    def __init__(self, comm: MPI.Comm, name: str, opt: Mapping[str, Any]) -> None:
        self._speaks = comm.rank == 0 and not opt["fsi_quiet"]
        # Open MPI gives the ranks a terminal of their own, whatever the output really goes to
        launched = any(name in os.environ for name in ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"))
        self._terminal = sys.stdout.isatty() and not launched
        self._shows = self._speaks and (sys.stdout.isatty() or opt["fsi_progress"])
        self._interval = _IN_PLACE if self._terminal else _LINES
        self._name, self._opt, self._comm = name, opt, comm
        self._begun = self._last = time.monotonic()
        self._open_line = False
        self._m, self._s, self._place = " m", " s", "x = {:.6g}"
        self._next = 32  # steps before the clock is asked

    def line(self, text: str) -> None:
        """Print a line."""
        if self._speaks:
            if self._open_line:
                print()
                self._open_line = False
            print(text, flush=True)

    def begin(self, state: State) -> None:
        """Say what is going to be computed."""
        self._m, self._s = state.problem.unit("m"), state.problem.unit("s")
        self._place = "x = {:.6g}" if state.problem.dimension == 1 else "y = {:.6g} on average"
        points, reserve = state.points, state.reserve
        held = f" ({reserve} more in reserve)" if reserve else ""
        ranks = counted(self._comm.size, "rank")
        self.line(
            f"{self._name}: order {state.op.name}, h = {state.h:g}{self._m}, {points} points{held} on {ranks}, "
            f"to t = {self._opt['ts_max_time']:g}{self._s}"
        )

    def start(self) -> None:
        """The time loop begins: what is left is reckoned from here."""
        self._begun = self._last = time.monotonic()

    def step(self, steps: int, t: float, dt: float) -> None:
        """Show progress now and then."""
        if not self._shows or steps < self._next:
            return
        self._next, now = steps + 32, time.monotonic()
        if now - self._last < self._interval:
            return
        self._last = now
        if not self._terminal:
            self._interval = min(1.5 * self._interval, _RAREST)
        end = self._opt["ts_max_time"]
        left = (now - self._begun) * (end - t) / t if t > 0 else 0.0
        done = f"  t = {t:.4g} of {end:g}{self._s} ({100 * t / end:.0f} %)"
        text = f"{done}, step {steps}, dt = {dt:.3g}{self._s}, {_duration(left)} left"
        if self._terminal:
            print(f"\r{text:<78}", end="", flush=True)
            self._open_line = True
        else:
            print(text, flush=True)

    def end(self, summary: Mapping[str, Any], errors: Mapping[str, Any] | None, path: Path) -> None:
        """Print the summary."""
        steps, wall = summary["steps"], summary["wall_time"]
        cost = f", {1e6 * wall / steps:.1f} µs per step" if steps else ""
        rejected = f" ({summary['rejected_steps']} rejected)" if summary["rejected_steps"] else ""
        early = summary["message"] if summary["status"] == "done" else ""
        how = early or f"{summary['status']} at t = {summary['t']:g}{self._s}"
        self.line(f"{how}: {counted(steps, 'step')}{rejected} in {_duration(wall)}{cost}")
        places = ", ".join(f"{name} at {self._place.format(x)}" for name, x in summary["interfaces"].items())
        points = counted(summary["points"], "point")
        self.line(f"interfaces: {places}; {points}" if places else points)
        self.line(_phases(summary["phases"]))
        for kind, values in (errors or {}).items():
            listed = ", ".join(f"{name} {value:.3e}" for name, value in values.items())
            self.line(f"{self._opt['fsi_norm']} errors in the {kind}: {listed}")
        self.line(f"result in {path}")


def _phases(seconds: Mapping[str, float]) -> str:
    """Where the time went, in a line."""
    total = sum(seconds.values())
    return "phases: " + ", ".join(f"{k} {_duration(v)} ({100 * v / max(total, 1e-9):.0f} %)" for k, v in seconds.items())


def _duration(seconds: float) -> str:
    """Seconds in words that fit their size."""
    if seconds < 60:
        return f"{seconds:.3g} s"
    if seconds < 3600:
        return f"{int(seconds // 60)} min {int(seconds % 60)} s"
    return f"{int(seconds // 3600)} h {int(seconds % 3600 // 60)} min"
