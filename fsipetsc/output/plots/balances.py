"""What must not change: the departures that -fsi_check watches; momentum and the force that changes it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.output.plots.scales import logarithmic, scaled, time_axis
from fsipetsc.output.plots.style import BLACK, GREY, LINES, SERIES, envelope, legend_above, thin
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Run
from fsipetsc.scheme.conservation_check import drifts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = np.ndarray
MOMENTUM = (("force", "force of the ends and body force", "Pa"), ("momentum", "momentum", "kg/(m s)"))


def departures(run: Run) -> dict[str, Array]:
    """Name of what must not change in this run -> its relative departure, (nsteps,); empty if nothing is known of it."""
    invariants, initial = run.header.get("laws"), _initial(run)
    return drifts(invariants, initial, run.series) if invariants and initial and len(run.series["t"]) else {}


def _initial(run: Run) -> Mapping[str, Any]:
    """The integrals at the start; a run that was killed has not noted them."""
    return {name.removeprefix("initial_"): value for name, value in run.summary.items() if name.startswith("initial_")}


def draw_balances(figure: Figure, run: Run) -> None:
    """Departures over time, the largest of some hundred parts of the run; and the tolerance, if the run had one."""
    figure.set_size_inches(5.6, 3.6)
    axes = figure.subplots()
    draw_departures(axes, run)
    legend_above(axes, side="right", columns=3)
    set_title(figure, of_run(run, "departure from the balances"))


def draw_departures(axes: Axes, run: Run) -> None:
    """The same on given axes, without a legend."""
    for k, (name, values) in enumerate(departures(run).items()):
        t, size = envelope(run.series["t"], np.abs(values))
        label = name if (size > 0).any() else f"{name} (none)"
        size = np.where(size > 0, size, np.nan)
        axes.plot(t, size, color=SERIES[k % len(SERIES)], linestyle=LINES[k % len(LINES)], linewidth=1.2, label=label)
    if run.options.get("fsi_check"):
        axes.axhline(run.options["fsi_check"], color=GREY, linestyle=":", label="-fsi_check")
    logarithmic(axes)
    axes.set_ylabel("relative departure")
    time_axis(axes, run)


def draw_momentum(figure: Figure, run: Run) -> None:
    """The force of the ends and of the body force, and the momentum that it changes."""
    figure.set_size_inches(7.6, 3.4)
    some = thin(len(run.series["t"]))
    for axes, (name, label, unit) in zip(figure.subplots(1, 2, sharex=True), MOMENTUM):
        scale = scaled(run, label, unit, run.series[name], start=run.series[name][:1])
        axes.plot(run.series["t"][some], scale(run.series[name][some]), color=BLACK, linewidth=1.0)
        axes.set_ylabel(scale.label)
        scale.limit(axes)
        time_axis(axes, run)
    set_title(figure, of_run(run, "momentum per cross-section, and the force that changes it"))
