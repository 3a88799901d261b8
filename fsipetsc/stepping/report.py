"""What a run says: a line at the start, one now and then, a summary at the end. Rank 0 speaks."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from mpi4py import MPI

from fsipetsc.checks import counted, duration
from fsipetsc.process.streams import say
from fsipetsc.stepping.state import State

#: wall seconds before the first line of progress; with -fsi_progress or on a terminal; the most
FIRST, SOON, RAREST = 10.0, 2.0, 60.0
#: steps after which the clock is asked
STEPS = 32
#: a larger departure of J from the volume of the grid is told
MOST_J_ERROR = 0.01
#: and a larger loss of the kinetic and elastic energy of solids
MOST_LOST = 0.001
#: characters of a line of the summary, and departures that are listed
_WIDTH, _LISTED = 100, 4
#: by kind of layer: names of the bounds by convection and by diffusion
_BOUNDS = {"fluid": ("sound", "friction and conduction"), "solid": ("waves", "conduction")}


def bound_of_step(state: State, opt: Mapping[str, Any]) -> str:
    """What bounds the step, as "sound in below"; "" where nothing is known of it."""
    if opt["ts_dt"]:
        return "-ts_dt"
    rates = state.rates
    if not np.isfinite(rates).all() or not rates.any():
        return ""
    k, which = np.unravel_index(np.argmax(rates), rates.shape)
    layer = state.problem.layers[k]
    return f"{_BOUNDS[layer.kind][which]} in {layer.name}"


def shares(changes: Sequence[Sequence[Any]], end: float) -> list[tuple[str, float]]:
    """(bound, part of the time until ``end`` in which it held), the largest first.

    changes: [time, bound] from which on it did.
    """
    parts: dict[str, float] = {}
    times = [*(t for t, _ in changes), end]
    for (_, what), begin, until in zip(changes, times, times[1:], strict=False):
        parts[what] = parts.get(what, 0.0) + until - begin
    whole = sum(parts.values()) or 1.0
    found = [(what, part / whole) for what, part in parts.items()]
    return sorted(found, key=lambda item: -item[1])


class Reporter:
    """Messages of a run; silent with -fsi_quiet and on all ranks but the first."""

    def __init__(self, comm: MPI.Comm, name: str, opt: Mapping[str, Any], state: State) -> None:
        self._speaks = comm.rank == 0 and not opt["fsi_quiet"]
        self._name, self._opt, self._size, self._state = name, opt, comm.size, state
        self._s = state.problem.unit("s")
        self._interval = SOON if opt["fsi_progress"] or sys.stdout.isatty() else FIRST

    def line(self, text: str) -> None:
        """Print a line."""
        if self._speaks:
            say(text)

    def begin(self) -> None:
        """Say what is going to be computed."""
        state = self._state
        reserve = f" ({state.reserve} more in reserve)" if state.reserve else ""
        grid = getattr(state, "grid_text", f"h = {state.h:g}{state.problem.unit('m')}")
        self.line(
            f"{self._name}: order {state.op.name}, {grid}, {state.points} points{reserve} on "
            f"{counted(self._size, 'rank')}, to t = {self._opt['ts_max_time']:g}{self._s}"
        )

    def start(self, t: float, steps: int) -> None:
        """The time loop begins: what is done and left is reckoned from here."""
        self._first = self._last = t, steps, time.monotonic()
        self._next = steps + 1

    def step(self, steps: int, t: float, dt: float) -> None:
        """Say how far the run is, if that is due."""
        if not self._speaks or steps < self._next:
            return
        self._next = steps + STEPS
        now = time.monotonic()
        if now - self._last[2] < self._interval:
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

    def end(
        self, summary: Mapping[str, Any], errors: Mapping[str, Any] | None, place: str
    ) -> None:
        """Print the summary; place: of the result."""
        if not self._speaks:
            return
        self._say_steps(summary)
        self._say_places(summary)
        self._say_times(summary)
        departures = sorted(summary["departures"].items(), key=_size)
        kept = [f"{name} to {size:.1e}" for name, size in departures[:_LISTED]]
        more = [f"{len(departures) - _LISTED} more"] * (len(departures) > _LISTED)
        self._list("kept", [*kept, *more])
        for text in (*about_volumes(summary["J_error"]), *about_losses(summary)):
            self.line(text)
        for kind, values in (errors or {}).items():
            listed = [f"{name} {value:.3e}" for name, value in values.items()]
            self._list(f"{self._opt['fsi_norm']} errors in the {kind}", listed)
        self.line(f"result in {place}")
        if summary["status"] == "done":
            self.line(f"next: python -m fsipetsc plot {shlex.quote(self._opt['fsi_output'])}")

    def _say_steps(self, summary: Mapping[str, Any]) -> None:
        steps, wall, part = summary["steps"], summary["wall_time"], summary["part"]
        cost = f", {1e6 * wall / steps:.1f} µs per step" if steps else ""
        again = summary["rejected_steps"]
        rejected = f" ({again} rejected)" if again else ""
        early = summary["message"] if summary["status"] == "done" else ""
        how = early or f"{summary['status']} at t = {summary['t']:g}{self._s}"
        self.line(f"{how}: {counted(steps, 'step')}{rejected} in {duration(wall)}{cost}")
        if part["steps"] < steps:
            these = f"{counted(part['steps'], 'step')} of these in {duration(part['wall_time'])}"
            self.line(f"{these} since the restart")

    def _say_places(self, summary: Mapping[str, Any]) -> None:
        problem = self._state.problem
        self._list("solved", [f"{layer.name} ({layer.kind})" for layer in problem.layers])
        axis = " xyz"[problem.dimension]
        mean = " on average" if axis != "x" else ""
        found = summary["interfaces"].items()
        places = [f"{name} at {axis} = {x:.6g}{mean}" for name, x in found]
        points = counted(summary["points"], "point")
        self._list("interfaces", [*places[:-1], f"{places[-1]}; {points}"] if places else [])
        if not places:
            self.line(points)

    def _say_times(self, summary: Mapping[str, Any]) -> None:
        total = max(sum(summary["phases"].values()), 1e-9)
        phases = summary["phases"].items()
        shown = [f"{name} {duration(v)} ({100 * v / total:.0f} %)" for name, v in phases]
        since = " since the restart" if summary["part"]["steps"] < summary["steps"] else ""
        self.line(f"phases{since}: {', '.join(shown)}")
        if not summary["steps"]:
            return
        steps = f"{summary['dt_min']:.3g} … {summary['dt_max']:.3g}{self._s}"
        parts = shares(summary["limits"], summary["t"])
        bounds = [f"{what} ({100 * part:.0f} %)" if part < 1 else what for what, part in parts]
        self._list("dt", [f"{steps}, bounded by {bounds[0]}" if bounds else steps, *bounds[1:]])

    def _list(self, title: str, items: Sequence[str], most: int = 2) -> None:
        """A line of items, or some lines; nothing where there are none."""
        lines: list[str] = []
        for number, item in enumerate(items):
            piece = f"{item}{',' * (number + 1 < len(items))}"
            if lines and len(lines[-1]) + len(piece) < _WIDTH:
                lines[-1] += f" {piece}"
            elif len(lines) == most:
                lines[-1] = f"{lines[-1]} … ({len(items)} in all)"
                break
            else:
                lines.append(f"  {piece}" if lines else f"{title}: {piece}")
        for text in lines:
            self.line(text)


def about_volumes(J_error: float) -> list[str]:
    """A line if J has departed far from the volume of the grid."""
    if J_error <= MOST_J_ERROR:
        return []
    return [f"note: J has departed by {100 * J_error:.2g} % from the volume of the grid (J_error)"]


def about_losses(summary: Mapping[str, Any]) -> list[str]:
    """A line if steps have lost much of the kinetic and elastic energy of solids."""
    lost = summary.get("lost_energy", 0.0)
    if lost <= MOST_LOST:
        return []
    return [
        f"note: the steps have lost {100 * lost:.2g} % of the kinetic and elastic energy of the "
        "solids, which became heat (lost_energy): a smaller -fsi_cfl loses less"
    ]


def _size(item: tuple[str, float]) -> tuple[bool, float]:
    """To sort departures by: nan first, then the largest."""
    return item[1] == item[1], -item[1]
