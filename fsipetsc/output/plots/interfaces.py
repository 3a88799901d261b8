"""Where the interfaces are, how long the solids are, and what holds at the interfaces: over time, step by step."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.output.plots.scales import SMALL, axis_label, logarithmic, scaled, time_axis
from fsipetsc.output.plots.style import COLORS, LINES, SERIES, envelope, in_two_lines, legend_above, thin
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = np.ndarray

TRACES = {
    "u_interface": ("velocity u", "m/s"),
    "sigma_interface": ("stress σ", "Pa"),
    "T_interface": ("temperature T", "K"),
}
RESIDUALS = {
    "residual_u": ("velocity", "m/s"),
    "residual_stress": ("stress", "Pa"),
    "residual_T": ("temperature (its jump, if a side does not conduct)", "K"),
    "residual_flux": ("heat flux", "W/m²"),
}


def draw_positions(figure: Figure, run: Run) -> None:
    """Positions of the interfaces and lengths of the solids; displacements where they are small."""
    lengths = list(_lengths(run))
    figure.set_size_inches(7.6 if lengths else 4.8, 3.4)
    grid = figure.subplots(1, 1 + bool(lengths), squeeze=False)[0]
    positions(grid[0], run)
    grid[0].legend()
    if lengths:
        label, *own = moved("length of the solid", "change of length of the solid", *(length for _, _, length in lengths))
        scale = scaled(run, label, "m", *own)
        for k, ((name, t, _), length) in enumerate(zip(lengths, own)):
            grid[1].plot(t, scale(length), color=COLORS["solid"], linestyle=LINES[k % len(LINES)], label=name)
        grid[1].set_ylabel(scale.label)
        if len(lengths) > 1:
            grid[1].legend()
    for axes in grid:
        time_axis(axes, run)
    set_title(figure, of_run(run, "interfaces"))


def positions(axes: Axes, run: Run) -> None:
    """Of all interfaces, or how far they have moved where that is little."""
    label, x = moved("position x of the interface", "displacement of the interface", run.series["x_interface"])
    scale = scaled(run, label, "m", x)
    per_interface(axes, run, scale(x))
    axes.set_ylabel(scale.label)


def moved(absolute: str, change: str, *arrays: Array) -> tuple[str, Array]:
    """Label and values: as they are, or less the first ones if they vary little over time."""
    span = max(float(np.max(np.ptp(values, axis=0))) for values in arrays)
    if span >= SMALL * max(float(np.max(np.abs(values))) for values in arrays):
        return absolute, *arrays
    return change, *(values - values[0] for values in arrays)


def _lengths(run: Run) -> Iterator[tuple[str, Array, Array]]:
    """Name, times and length of each solid layer: per step between two interfaces, per frame otherwise."""
    x = run.series["x_interface"]
    joints_known = x.ndim == 2 and x.shape[1] == len(run.layers) - 1
    for i, layer in enumerate(run.layers):
        if layer.kind != "solid":
            continue
        if joints_known and 0 < i < len(run.layers) - 1:
            some = thin(len(x))
            yield layer.name, run.series["t"][some], (x[:, i] - x[:, i - 1])[some]
        elif run.nframes > 1:
            yield layer.name, run.time, layer.x[:, -1] - layer.x[:, 0]


def draw_traces(figure: Figure, run: Run) -> None:
    """Velocity, stress and temperature at the interfaces."""
    names = [name for name in TRACES if name in run.series]
    figure.set_size_inches(6.4, 0.7 + 1.9 * len(names))
    grid = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(grid, names):
        scale = scaled(run, *TRACES[name], run.series[name], start=run.series[name][0])
        per_interface(axes, run, scale(run.series[name]))
        scale.limit(axes)
        axes.set_ylabel(in_two_lines(scale.label))
    legend_above(grid[0], side="right", columns=4)
    time_axis(grid[-1], run)
    figure.align_ylabels(grid)
    set_title(figure, of_run(run, "at the interfaces"))


def draw_residuals(figure: Figure, run: Run) -> None:
    """By how much the interface conditions are missed: the largest values of some hundred parts of the run."""
    names = [name for name in RESIDUALS if name in run.series]
    rows = -(-len(names) // 2)
    figure.set_size_inches(7.6, 0.8 + 2.1 * rows)
    grid = figure.subplots(rows, 2, sharex=True, squeeze=False)
    for axes, name in zip(grid.flat, names):
        size = np.abs(run.series[name])
        for k, column in enumerate(size.T):
            t, largest = envelope(run.series["t"], column)
            axes.plot(t, np.where(largest > 0, largest, np.nan), **_line(run, k), linewidth=1.0, marker=".", markersize=2)
        what, unit = RESIDUALS[name]
        axes.set_title(what, loc="left")
        axes.set_ylabel(axis_label(run, "largest residual", unit))
        logarithmic(axes)
    for axes in grid.flat[len(names) :]:
        axes.set_visible(False)
    for axes in grid[-1]:
        time_axis(axes, run)
    if len(run.interfaces) > 1:
        legend_above(grid[0, -1], side="right", columns=4)
    figure.align_ylabels(grid)
    set_title(figure, of_run(run, "residuals of the interface conditions (where not 0)"))


def per_interface(axes: Axes, run: Run, values: Array) -> None:
    """A line for each interface; values: (nsteps, interfaces)."""
    some = thin(len(values))
    for k, column in enumerate(values.reshape(len(values), -1).T):
        axes.plot(run.series["t"][some], column[some], **_line(run, k))


def _line(run: Run, k: int) -> dict[str, Any]:
    """Look and name of the line of interface k."""
    name = run.interfaces[k] if k < len(run.interfaces) else f"interface {k + 1}"
    return {"color": SERIES[k % len(SERIES)], "linestyle": LINES[k % len(LINES)], "label": name}
