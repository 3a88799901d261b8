"""What of the page of a run (fsipetsc.output.plots.page) is another thing in two dimensions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.output.interface_line import InterfaceLine
from fsipetsc.output.plots.frames import evenly, moment
from fsipetsc.output.plots.maps.interfaces import points
from fsipetsc.output.plots.maps.panels import bar, chosen_frames, colors, domain, few_ticks, panel
from fsipetsc.output.plots.maps.quantities import ALL, MAPS, Pair
from fsipetsc.output.plots.scales import axis_label, named, scaled
from fsipetsc.output.plots.style import LINES, SERIES, SMALL_LEGEND, legend_above, shade
from fsipetsc.output.reader import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase

WIDTH = 10.2  # inches, of all maps beside each other
HIGHEST = 4.2  # inches, of a map
BAR, TITLE = 0.62, 0.3  # inches, of a color bar with its label, and of the time above a map
#: least ratio of width to height -> maps beside each other, and in all
_SHAPES = ((2.0, 2, 4), (0.8, 4, 4), (0.0, 6, 6))


def maps_of(run: Run, fields: Sequence[str], times: Sequence[float]) -> tuple[float, Callable[[FigureBase], None]]:
    """Height [inches] and drawing function of maps: of pressure and stress, or what is asked for. InputError."""
    pairs, ranges = pairs_of(fields), domain(run)
    columns, count = shape(ranges)
    chosen = chosen_frames(run, pairs[0].gas, pairs[0].solid, times, count)
    columns = min(columns, len(chosen))
    rows = -(-len(chosen) // columns)
    width, height = size_of(ranges, WIDTH / columns)
    bars = len({layer.kind for layer in run.layers})
    heights = [rows * (height + TITLE) + BAR * bars + 0.3] * len(pairs)
    return sum(heights), partial(_maps, run=run, pairs=pairs, chosen=chosen, columns=columns, width=width)


def pairs_of(fields: Sequence[str]) -> list[Pair]:
    """What is shown of gases and solids, by name; the first that there is where none is asked for. InputError."""
    known = {pair.name: pair for pair in ALL}
    named(fields, list(known))
    return [known[name] for name in fields] or [MAPS[0]]


def shape(ranges: Sequence[tuple[float, float]]) -> tuple[int, int]:
    """How many maps of this shape stand beside each other, and how many are drawn where no times are given."""
    (left, right), (low, high) = ranges
    return next((columns, count) for least, columns, count in _SHAPES if (right - left) / (high - low) >= least)


def size_of(ranges: Sequence[tuple[float, float]], room: float) -> tuple[float, float]:
    """Width and height [inches] of a map for which there is so much room."""
    (left, right), (low, high) = ranges
    width = min(room - 0.35, HIGHEST * (right - left) / (high - low))
    return width, width * (high - low) / (right - left)


def _maps(figure: FigureBase, run: Run, pairs: Sequence[Pair], chosen: Sequence[int], columns: int, width: float) -> None:
    parts = figure.subfigures(len(pairs), 1, squeeze=False)[:, 0]
    for part, pair in zip(parts, pairs):
        grid = part.subplots(-(-len(chosen) // columns), columns, sharex=True, sharey=True, squeeze=False)
        scales = [found for quantity in (pair.gas, pair.solid) if (found := colors(run, quantity, chosen))]
        maps(part, grid, run, chosen, scales, width)


def maps(figure: FigureBase, grid: np.ndarray, run: Run, chosen: Sequence[int], scales: Sequence, width: float) -> None:
    """Maps of the chosen frames on a grid of axes, with color bars above."""
    ranges = domain(run)
    for axes, frame in zip(grid.flat, chosen):
        pictures = panel(axes, run, frame, scales)
        axes.set(aspect="equal", xlim=ranges[0], ylim=ranges[1])
        axes.set_title(moment(run, frame), loc="left", fontsize=8)
    for axes in grid.flat[len(chosen) :]:
        axes.set_visible(False)
    few_ticks(grid[0, 0], width)
    for axes in grid[-1]:
        axes.set_xlabel(axis_label(run, "x", "m"))
    for axes in grid[:, 0]:
        axes.set_ylabel(axis_label(run, "y", "m"))
    for own, picture in zip(scales, pictures):
        bar(figure, picture, own, list(grid.flat), 6)


def panels(run: Run) -> list[Callable[[Axes], None]]:
    """How an interface moves, or what is found along the middle of a layer where there is none."""
    if run.nframes < 2:
        return []
    if not run.interfaces:
        return [partial(_cut, run=run)]
    lines = [run.interface(k) for k in range(len(run.interfaces))]
    moved = max(lines, key=lambda line: float(np.nanmax(np.abs(line.displacement))))
    return [partial(_shape, run=run, line=moved), partial(_deflection, run=run, line=moved)]


def _shape(axes: Axes, run: Run, line: InterfaceLine) -> None:
    """The interface as a line at some times, the later the darker."""
    scale = scaled(run, "deflection", "m", line.displacement)
    for place, frame in enumerate(some := evenly(run, 5)):
        look = {"color": shade(place, len(some)), "linewidth": 1.2, "label": f"t = {run.time[frame]:.4g}"}
        axes.plot(line.X, scale(line.displacement[frame]), **look)
    axes.set(xlabel=axis_label(run, "X", "m"), ylabel=scale.label)
    legend_above(axes, columns=2, title=line.name if len(run.interfaces) > 1 else None, **SMALL_LEGEND)


def _deflection(axes: Axes, run: Run, line: InterfaceLine) -> None:
    """The deflection of some points over time."""
    scale = scaled(run, "deflection", "m", line.displacement)
    for k, point in enumerate(points(line)):
        look = {"color": SERIES[k % len(SERIES)], "linestyle": LINES[k % len(LINES)], "linewidth": 1.2}
        axes.plot(run.time, scale(line.displacement[:, point]), **look, label=f"X = {line.X[point]:.4g}")
    axes.set(xlabel=axis_label(run, "t", "s"), ylabel=scale.label, xlim=(run.time[0], run.time[-1]))
    legend_above(axes, columns=2, **SMALL_LEGEND)


def _cut(axes: Axes, run: Run) -> None:
    """Pressure, or the stress, along the middle of the first block, in the direction in which it is longer."""
    layer = run.layers[0]
    (left, right), (low, high) = domain(run)
    upright = high - low > right - left
    name = "p" if layer.kind == "fluid" else "s_yy" if upright else "s_xx"
    some = evenly(run, 4)
    span = [np.ptp(layer.places[..., axis], axis=-1).mean() for axis in (0, 1)]  # along rows of the array
    rows = (span[1] > span[0]) == upright
    middle = (layer.shape[0] // 2, slice(None)) if rows else (slice(None), layer.shape[1] // 2)
    cuts = [(layer.frame(frame)["y" if upright else "x"][middle], layer.frame(frame)[name][middle]) for frame in some]
    label = "pressure" if name == "p" else f"stress {name}"
    scale = scaled(run, label, "Pa", *(values for _, values in cuts), start=cuts[0][1])
    for place, (frame, (where, values)) in enumerate(zip(some, cuts)):
        look = {"color": shade(place, len(some)), "linewidth": 1.2, "label": f"t = {run.time[frame]:.4g}"}
        axes.plot(where, scale(values), **look)
    axes.set(xlabel=axis_label(run, "y" if upright else "x", "m"), ylabel=f"{scale.label}, in the middle")
    legend_above(axes, columns=2, **SMALL_LEGEND)
