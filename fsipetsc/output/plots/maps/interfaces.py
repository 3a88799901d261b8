"""How far the interfaces have moved, and the pressure on the solid: over X and time, and at some points over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.output.interface_line import InterfaceLine
from fsipetsc.output.plots.scales import axis_label, scaled
from fsipetsc.output.plots.space_time import palette
from fsipetsc.output.plots.style import LINES, SERIES, bar_above, in_two_lines
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = np.ndarray
POINTS = 3  # whose deflection is drawn as a line


def draw(figure: Figure, run: Run) -> None:
    """A row for each interface: its deflection over X and t, the pressure on the solid, the deflection of some points."""
    lines = [run.interface(k) for k in range(len(run.interfaces))]
    figure.set_size_inches(10.5, 0.5 + 3.4 * len(lines))
    grid = figure.subplots(len(lines), 3, squeeze=False)
    for row, line in zip(grid, lines):
        deflection = scaled(run, "deflection", "m", line.displacement)
        colored = palette("viridis", deflection, [line.displacement])
        _map(figure, row[0], run, line.X, deflection(line.displacement), deflection.label, colored)
        row[0].set_title(line.name, loc="left")
        load = line.pressure
        scale = scaled(run, "pressure on the solid", "Pa", load, start=load[0])
        _map(figure, row[1], run, line.X, scale(load), scale.label, palette("viridis", scale, [load]))
        for color, point in enumerate(points(line)):
            label = f"X = {line.X[point]:.4g}"
            row[2].plot(
                run.time,
                deflection(line.displacement[:, point]),
                color=SERIES[color],
                linestyle=LINES[color],
                marker="." if run.nframes < 30 else "",
                label=label,
            )
        row[2].set(xlabel=axis_label(run, "t", "s"), ylabel=deflection.label, xlim=(run.time[0], run.time[-1]))
        row[2].legend()
    set_title(figure, of_run(run, "interfaces"))


def points(line: InterfaceLine) -> list[int]:
    """Those at the quarters of the line."""
    last = len(line.X) - 1
    return sorted({round(last * k / (POINTS + 1)) for k in range(1, POINTS + 1)})


def _map(figure: Figure, axes: Axes, run: Run, X: Array, values: Array, label: str, colored: dict) -> None:
    picture = axes.pcolormesh(X, run.time, values, shading="gouraud", rasterized=True, **colored)
    axes.grid(visible=False)
    axes.set(xlabel=axis_label(run, "X", "m"), ylabel=axis_label(run, "t", "s"))
    bar_above(figure, picture, axes, in_two_lines(label), aspect=30)
