"""What a run says: a line at the start, progress, a summary at the end that fits on a screen. Rank 0 speaks."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mpi4py import MPI

from fsipetsc.checks import counted, duration
from fsipetsc.stepping.limits import reason, shares
from fsipetsc.stepping.progress import Progress
from fsipetsc.stepping.state import State

#: a larger departure of J from the volume of the grid is told
MOST_J_ERROR = 0.01
#: characters of a line of the summary, and departures that are listed
_WIDTH, _LISTED = 100, 4


class Reporter:
    """Messages of a run; silent with -fsi_quiet and on all ranks but the first."""

    def __init__(self, comm: MPI.Comm, name: str, opt: Mapping[str, Any]) -> None:
        self._speaks = comm.rank == 0 and not opt["fsi_quiet"]
        self._name, self._opt, self._comm = name, opt, comm
        self._progress: Progress | None = None
        self._state: State | None = None
        self._m, self._s, self._place = " m", " s", "x = {:.6g}"

    def line(self, text: str) -> None:
        """Print a line."""
        if self._speaks:
            self.clear()
            print(text, flush=True)

    def clear(self) -> None:
        """Take away what stands on a terminal for a moment only."""
        if self._progress is not None:
            self._progress.clear()

    def begin(self, state: State) -> None:
        """Say what is going to be computed."""
        self._state = state
        self._m, self._s = state.problem.unit("m"), state.problem.unit("s")
        axis = " xyz"[state.problem.dimension]
        self._place = f"{axis} = {{:.6g}}{' on average' if axis != 'x' else ''}"
        points, reserve = state.points, state.reserve
        held = f" ({reserve} more in reserve)" if reserve else ""
        ranks = counted(self._comm.size, "rank")
        grid = getattr(state, "grid_text", f"h = {state.h:g}{self._m}")
        self.line(
            f"{self._name}: order {state.op.name}, {grid}, {points} points{held} on {ranks}, "
            f"to t = {self._opt['ts_max_time']:g}{self._s}"
        )

    def start(self, t: float, steps: int, until: float) -> None:
        """The time loop begins; until: see Progress."""
        if self._speaks:
            opt = self._opt
            self._progress = Progress(opt["ts_max_time"], self._s, opt["fsi_progress"], opt["ts_max_steps"])
            self._progress.start(t, steps, until)

    def step(self, steps: int, t: float, dt: float) -> None:
        """Show progress now and then."""
        if self._progress is not None:
            self._progress.step(steps, t, dt, lambda: reason(self._state, self._opt))

    def end(self, summary: Mapping[str, Any], errors: Mapping[str, Any] | None, path: Path) -> None:
        """Print the summary."""
        if not self._speaks:
            return
        steps, wall = summary["steps"], summary["wall_time"]
        cost = f", {1e6 * wall / steps:.1f} µs per step" if steps else ""
        rejected = f" ({summary['rejected_steps']} rejected)" if summary["rejected_steps"] else ""
        early = summary["message"] if summary["status"] == "done" else ""
        how = early or f"{summary['status']} at t = {summary['t']:g}{self._s}"
        self.line(f"{how}: {counted(steps, 'step')}{rejected} in {duration(wall)}{cost}")
        part, since = summary["part"], ""
        if part["steps"] < steps:
            since = " since the restart"
            self.line(f"{counted(part['steps'], 'step')} of these in {duration(part['wall_time'])}{since}")
        self._list("solved", [f"{layer.name} ({layer.kind})" for layer in self._state.problem.layers])
        places = [f"{name} at {self._place.format(x)}" for name, x in summary["interfaces"].items()]
        points = counted(summary["points"], "point")
        if places:
            self._list("interfaces", [*places[:-1], f"{places[-1]}; {points}"])
        else:
            self.line(points)
        self.line(_phases(summary["phases"], since))
        if steps:
            parts = shares(summary["limits"], summary["t"])
            bounds = [f"{what} ({100 * part:.0f} %)" if part < 1 else what for what, part in parts]
            range_of_dt = f"{summary['dt_min']:.3g} … {summary['dt_max']:.3g}{self._s}"
            self._list("dt", [f"{range_of_dt}, bounded by {bounds[0]}" if bounds else range_of_dt, *bounds[1:]])
        kept = sorted(summary["departures"].items(), key=lambda item: (item[1] == item[1], -item[1]))  # nan first
        more = [f"{len(kept) - _LISTED} more"] * (len(kept) > _LISTED)
        self._list("kept", [*(f"{name} to {size:.1e}" for name, size in kept[:_LISTED]), *more])
        for text in about_volumes(summary["J_error"]):
            self.line(text)
        for kind, values in (errors or {}).items():
            listed = [f"{name} {value:.3e}" for name, value in values.items()]
            self._list(f"{self._opt['fsi_norm']} errors in the {kind}", listed)
        self.line(f"result in {path}")
        if summary["status"] == "done":
            self.line(f"next: python -m fsipetsc plot {shlex.quote(self._opt['fsi_output'])}")

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


def _phases(seconds: Mapping[str, float], since: str) -> str:
    """Where the time went, in a line; since: when, if it is not all."""
    total = sum(seconds.values())
    return f"phases{since}: " + ", ".join(f"{k} {duration(v)} ({100 * v / max(total, 1e-9):.0f} %)" for k, v in seconds.items())
