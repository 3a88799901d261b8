"""What a run says: a line at the start, one now and then, a summary at the end. Rank 0 speaks."""

import shlex
import sys
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.checks import counted, duration
from fsipetsc.output.info import error_rows, summary_rows, table
from fsipetsc.process.program import say
from fsipetsc.scheme.plan import RATE, longest_step
from fsipetsc.state import State

#: wall seconds before the first line of progress; with -fsi_progress or on a terminal; the most
FIRST, SOON, RAREST = 10.0, 2.0, 60.0
#: by kind of layer: names of the bounds by convection and by diffusion
_BOUNDS = {"fluid": ("sound", "viscosity and conduction"), "solid": ("waves", "conduction")}


def bound_of_step(state: State, opt: Mapping[str, Any]) -> str:
    """Return what bounds the step, as "sound in below"; "" where nothing is known of it."""
    if opt["ts_dt"]:
        return "-ts_dt"
    rates = state.rates
    if not np.isfinite(rates).all() or not rates.any():
        return ""
    k, which = np.unravel_index(np.argmax(rates), rates.shape)
    layer = state.problem.layers[k]
    return f"{_BOUNDS[layer.kind][which]} in {layer.name}"


class Reporter:
    """Messages of a run; silent with -fsi_quiet and on all ranks but the first."""

    def __init__(self, name: str, opt: Mapping[str, Any], state: State) -> None:
        self._speaks = state.comm.rank == 0 and not opt["fsi_quiet"]
        self._name, self._opt, self._state = name, opt, state
        self._s = state.problem.unit("s")
        self._interval = SOON if opt["fsi_progress"] or sys.stdout.isatty() else FIRST

    def line(self, text: str) -> None:
        """Print a line."""
        if self._speaks:
            say(text)

    def note(self, *said: str) -> None:
        """Print each as a note, but for empty ones."""
        for text in filter(None, said):
            self.line(f"note: {text}")

    def notes(self, when: str) -> None:
        """Print what there is to be said of the state at the begin, when saved, or at the end.
        Collective.
        """
        self.note(*self._state.notes(when))

    def begin(self) -> None:
        """Say what is going to be computed."""
        state, h, m = self._state, self._opt["fsi_h"], self._state.problem.unit("m")
        other = f" (smallest cells {state.h:.3g}{m})" if abs(state.h - h) > 0.01 * h else ""
        self.line(
            f"{self._name}: order {state.op.name}, h = {h:g}{m}{other}, "
            f"{state.points} points on {counted(state.comm.size, 'rank')}, "
            f"to t = {self._opt['ts_max_time']:g}{self._s}"
        )

    def first_step(self) -> str:
        """Tell how long it is, and how many like it the run would make."""
        opt, rate = self._opt, float(self._state.results[RATE])
        dt = float(longest_step(opt["fsi_cfl"], opt["ts_dt"] or 0.0, rate))
        count = f"{opt['ts_max_time'] / dt:,.0f} like it to the end"
        return f"first step: {dt:.3g}{self._s}, by {bound_of_step(self._state, opt)}; {count}"

    def start(self, t: float, steps: int) -> None:
        """Reckon what is done and left from here, where the time loop begins."""
        self._first = self._last = t, steps, time.monotonic()

    def step(self, steps: int, t: float, dt: float) -> None:
        """Say how far the run is, if that is due."""
        now = time.monotonic()
        if not self._speaks or now - self._last[2] < self._interval:
            return
        self._interval = min(1.5 * self._interval, RAREST)
        end, most = self._opt["ts_max_time"], self._opt["ts_max_steps"]
        begin, before, since = self._first
        part = max((t - begin) / (end - begin), (steps - before) / (most - before))
        rate = (steps - self._last[1]) / (now - self._last[2])
        bound = bound_of_step(self._state, self._opt)
        self.line(
            f"  t = {t:.4g} of {end:g}{self._s} ({100 * part:.0f} %), step {steps}, "
            f"dt = {dt:.3g}{self._s}{f' by {bound}' if bound else ''}, {rate:.3g} steps/s, "
            f"{duration((now - since) * (1.0 / part - 1.0))} left"
        )
        self._last = t, steps, now

    def end(self, summary: Mapping[str, Any], errors: Mapping[str, Any] | None, place: str) -> None:
        """Print what `info` says of the summary; place: of the result."""
        if not self._speaks:
            return
        norm = self._opt["fsi_norm"]
        of_kinds = [(f"{norm} errors, {kind}", text) for kind, text in error_rows(errors or {})]
        self.line(table([*summary_rows(summary, self._s), *of_kinds]))
        self.line(f"result in {place}")
        if summary["status"] == "done":
            self.line(f"next: python -m fsipetsc plot {shlex.quote(self._opt['fsi_output'])}")
