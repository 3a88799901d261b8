"""The time step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.output.plots.scales import scaled, time_axis
from fsipetsc.output.plots.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SMALL_LEGEND, legend_above, thin
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw(figure: Figure, run: Run) -> None:
    """Its length over time, without the steps that were shortened to hit a saved time."""
    figure.set_size_inches(5.6, 3.4)
    left_out = " (without those that end at a saved time)" if draw_steps(figure.subplots(), run) else ""
    set_title(figure, of_run(run, f"time steps{left_out}"))


def draw_steps(axes: Axes, run: Run) -> bool:
    """The same on given axes, in front of what bounded the steps; whether some were left out."""
    free = unhurried(run)
    t, dt = run.series["t"][free], run.series["dt"][free]
    scale, some = scaled(run, "time step", "s", dt), thin(len(t))
    axes.plot(t[some], scale(dt)[some], color=BLACK, linewidth=1.0)
    axes.set_ylabel(scale.label)
    time_axis(axes, run)
    bounded(axes, run)
    return len(t) < len(free)


def bounded(axes: Axes, run: Run) -> None:
    """Bands of what bounded the steps, with a legend above; nothing for results that do not say it."""
    changes = [(float(t), str(what)) for t, what in run.summary["limits"]] if "limits" in run.summary else []
    ends = [*(t for t, _ in changes), float(run.series["t"][-1])]
    colors: dict[str, str] = {}
    for (begin, what), until in zip(changes, ends[1:]):
        new = what not in colors
        color = colors.setdefault(what, (GREY, ORANGE, BLUE, GREEN, PURPLE, RED)[len(colors) % 6])
        axes.axvspan(begin, until, color=color, alpha=0.3, linewidth=0, label=what if new else None)
    if colors:
        legend_above(axes, **SMALL_LEGEND)


def unhurried(run: Run) -> np.ndarray:
    """(nsteps,) False for the two steps before each saved time, which share what was left; True for all if few remain."""
    t, free = run.series["t"], np.ones(len(run.series["t"]), bool)
    ends = np.searchsorted(t, run.time * (1 - 1e-12))
    ends = ends[ends < len(t)]
    free[ends] = free[np.maximum(ends - 1, 0)] = False
    return free if free.sum() > len(free) // 10 else np.ones_like(free)
