"""What is counted at each step: mass of each gas, energy, momentum, entropy, the least J."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.output.plots.scales import scaled, time_axis
from fsipetsc.output.plots.style import LINES, SERIES, thin
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = np.ndarray
#: title, unit, and the series that are drawn together; whether as what they have changed by since the start
PANELS = (
    ("mass, change", "kg/m", ("mass",), True),
    ("energy, change", "J/m", ("energy",), True),
    ("momentum, change", "kg/s", ("momentum_x", "momentum_y"), True),
    ("entropy, change", "J/(m K)", ("entropy",), True),
    ("least J", "", ("least_J",), False),
    ("departure of J", "", ("J_error",), False),
)


def draw(figure: Figure, run: Run) -> None:
    """A panel for each of them; integrals per length across the plane."""
    panels = [panel for panel in PANELS if all(name in run.series for name in panel[2])]
    rows = -(-len(panels) // 2)
    figure.set_size_inches(7.6, 0.6 + 2.2 * rows)
    grid = figure.subplots(rows, 2, squeeze=False)
    for axes, (title, unit, names, change) in zip(grid.flat, panels):
        _panel(axes, run, title, unit, [curve for name in names for curve in curves(run, name, change)])
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)
    set_title(figure, of_run(run, "ledgers"))


def curves(run: Run, name: str, change: bool) -> list[tuple[str, Array]]:
    """(label, (nsteps,)) of a series: of a layer each where it has several columns, less that at the start if so asked."""
    values = run.series[name]
    if change:
        initial = run.summary[f"initial_{name}"] if f"initial_{name}" in run.summary else values[0]
        values = values - np.asarray(initial)
    if values.ndim == 1:
        return [(name.removeprefix("momentum_"), values)]
    blocks = [layer.name for layer in run.layers if name != "mass" or layer.kind == "fluid"]
    return list(zip(blocks, values.T, strict=True))


def _panel(axes: Axes, run: Run, title: str, unit: str, some: list[tuple[str, Array]]) -> None:
    scale, few = scaled(run, title, unit, *(values for _, values in some)), thin(len(run.series["t"]))
    for k, (label, values) in enumerate(some):
        look = {"color": SERIES[k % len(SERIES)], "linestyle": LINES[k % len(LINES)]}
        axes.plot(run.series["t"][few], scale(values)[few], **look, linewidth=1.0, label=label)
    if len(some) > 1:
        axes.legend()
    axes.set_ylabel(scale.label)
    scale.limit(axes)
    time_axis(axes, run)
