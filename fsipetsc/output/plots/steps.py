"""The time step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.output.plots.scales import scaled, time_axis
from fsipetsc.output.plots.style import BLACK, thin
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(figure: Figure, run: Run) -> None:
    """Its length over time, without the steps that were shortened to hit a saved time."""
    figure.set_size_inches(5.6, 3.4)
    axes, free = figure.subplots(), unhurried(run)
    t, dt = run.series["t"][free], run.series["dt"][free]
    scale, some = scaled(run, "time step", "s", dt), thin(len(t))
    axes.plot(t[some], scale(dt)[some], color=BLACK, linewidth=1.0)
    axes.set_ylabel(scale.label)
    time_axis(axes, run)
    left_out = " (without those that end at a saved time)" if len(t) < len(free) else ""
    set_title(figure, of_run(run, f"time steps{left_out}"))


def unhurried(run: Run) -> np.ndarray:
    """(nsteps,) False for the two steps before each saved time, which share what was left; True for all if few remain."""
    t, free = run.series["t"], np.ones(len(run.series["t"]), bool)
    ends = np.searchsorted(t, run.time * (1 - 1e-12))
    ends = ends[ends < len(t)]
    free[ends] = free[np.maximum(ends - 1, 0)] = False
    return free if free.sum() > len(free) // 10 else np.ones_like(free)
