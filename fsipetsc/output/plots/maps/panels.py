"""Maps on the grids as they are at some times, with the lines of the interfaces; gas and solid each with a scale of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.output.plots.frames import at_times, moment
from fsipetsc.output.plots.maps.quantities import OF_SOLIDS, Pair
from fsipetsc.output.plots.profiles import PANELS, frames
from fsipetsc.output.plots.quantities import Quantity
from fsipetsc.output.plots.scales import Scale, axis_label, extremes, scaled
from fsipetsc.output.plots.space_time import palette
from fsipetsc.output.plots.style import bar_above, in_two_lines
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import BlockLayer, Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = np.ndarray
SIZE = 3.6  # inches, the longer side of a panel
TICK = 0.45  # inches, that the number at a tick of the horizontal axis takes
NARROW = 1.3  # inches, the width of panels that would leave no room for what stands above them, if they were moved together


@dataclass(frozen=True)
class Colors:
    """Scale and colors of a quantity of some layers, the same at all times that are shown; range: of the scaled values."""

    quantity: Quantity
    scale: Scale
    palette: dict[str, Any]
    range: tuple[float, float]


def colors(run: Run, quantity: Quantity, chosen: Sequence[int]) -> Colors | None:
    """Those for the chosen frames and the first one; None if no layer has the quantity."""
    layers = [layer for layer in run.layers if quantity.of(layer.kind)]
    if not layers:
        return None
    shown = [np.stack([quantity.values(layer, frame) for frame in (0, *chosen)]) for layer in layers]
    start = np.concatenate([values[0].ravel() for values in shown])
    scale = scaled(run, quantity.label, quantity.unit, *shown, start=start)
    both = OF_SOLIDS if quantity.solid else "RdBu_r"
    return Colors(quantity, scale, palette(quantity.colormap, scale, shown, both), extremes(*map(scale, shown)))


def draw(figure: Figure, run: Run, pair: Pair, times: Sequence[float] | None) -> None:
    """A panel for each of the times, or for those of `profiles.frames`."""
    chosen = chosen_frames(run, pair.gas, pair.solid, times)
    ranges = domain(run)
    width, height = panel_size(ranges)
    columns = min(len(chosen), 2 if width > NARROW else 4)
    rows = -(-len(chosen) // columns)
    scales = [found for quantity in (pair.gas, pair.solid) if (found := colors(run, quantity, chosen))]
    figure.set_size_inches(max(5.0, 0.7 + (width + 0.3) * columns), 0.6 + 0.6 * len(scales) + (height + 0.4) * rows)
    together(figure, width)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes, frame in zip(grid.flat, chosen):
        pictures = panel(axes, run, frame, scales)
        axes.set(aspect="equal", xlim=ranges[0], ylim=ranges[1])
        axes.set_title(moment(run, frame), loc="left")
    for axes in grid.flat[len(chosen) :]:
        axes.set_visible(False)
    few_ticks(grid[0, 0], width)
    for own, picture in zip(scales, pictures):
        bar(figure, picture, own, grid, 6)
    figure.supxlabel(axis_label(run, "x", "m"), fontsize=9)
    figure.supylabel(axis_label(run, "y", "m"), fontsize=9)
    set_title(figure, of_run(run, pair.title_of({layer.kind for layer in run.layers})))


def chosen_frames(
    run: Run, gas: Quantity, solid: Quantity, times: Sequence[float] | None, count: int = PANELS
) -> list[int]:
    """The frames nearest to the times, or so many worth a panel: as the gas has it, the solid where there is none."""
    if times:
        return at_times(run, times)
    has_gas = any(layer.kind == "fluid" for layer in run.layers)
    return frames(run, gas if has_gas else solid, count)[0]


def panel(axes: Axes, run: Run, frame: int, scales: Sequence[Colors]) -> list[Any]:
    """Draw one frame; what there is to make a color bar of, one for each scale: None if no layer has it."""
    drawn = {}
    axes.grid(visible=False)
    for layer in run.layers:
        fields = layer.frame(frame)
        for number, own in enumerate(scales):
            if own.quantity.of(layer.kind):
                drawn[number] = mesh(axes, layer, fields, own, frame)
        if layer.kind == "solid":
            outline(axes, layer, fields)
    return [drawn.get(number) for number in range(len(scales))]


def mesh(axes: Axes, layer: BlockLayer, fields: dict[str, Array], own: Colors, frame: int) -> Any:
    """A quantity of a block on its grid as it is."""
    values = own.scale(own.quantity.values(layer, frame))
    x, y, values = (closed(layer, array) for array in (fields["x"], fields["y"], values))
    return axes.pcolormesh(x, y, np.ma.masked_invalid(values), shading="gouraud", rasterized=True, **own.palette)


def closed(layer: BlockLayer, values: Array) -> Array:
    """Values of a block; of a ring with those at its beginning once more, so that it closes."""
    for axis in layer.rings:
        values = np.concatenate([values, np.take(values, [0], axis=axis)], axis=axis)
    return values


def outline(axes: Axes, layer: BlockLayer, fields: dict[str, Array], inside: int = 8) -> None:
    """The edges of a solid, which are the interfaces too, and some lines of its grid, which show how it is deformed.

    These go across it: along its shorter side.
    """
    x, y = (closed(layer, fields[name]) for name in ("x", "y"))
    for axis in (0, 1):
        if axis not in layer.rings:
            for line in (0, -1):
                axes.plot(np.take(x, line, axis), np.take(y, line, axis), color="black", linewidth=0.8)
    longer = int(np.argmax(x.shape))
    count = x.shape[longer] - 1
    step = max(1, count // inside)
    for line in range(0 if longer in layer.rings else step, count, step):
        axes.plot(np.take(x, line, longer), np.take(y, line, longer), color="black", linewidth=0.3, alpha=0.5)


def bar(figure: Figure, picture: Any, own: Colors, grid: Any, ticks: int) -> None:
    """A color bar above the panels, of the values that there are: pressures below 0 would be a riddle."""
    label = in_two_lines(own.scale.label) if ticks < 6 else own.scale.label
    made = bar_above(figure, picture, grid, label, ticks, aspect=8 * ticks, shrink=0.9)
    if own.range[0] < own.range[1] and own.scale.constant is None:
        made.ax.set_xlim(own.range)


def together(figure: Figure, width: float) -> None:
    """Panels of this width [inches] stand close to each other, narrow ones apart, across the whole figure."""
    figure.set_layout_engine("compressed" if width > NARROW else "constrained")


def few_ticks(axes: Axes, width: float = SIZE) -> None:
    """So many that their numbers have room in panels of this width [inches]; of narrow ones the middle alone."""
    from matplotlib.ticker import FixedLocator, MaxNLocator

    room = int(width / TICK)
    low, high = axes.get_xlim()
    axes.xaxis.set_major_locator(MaxNLocator(min(room, 5)) if room > 1 else FixedLocator([0.5 * (low + high)]))


def domain(run: Run) -> tuple[tuple[float, float], tuple[float, float]]:
    """(left, right), (lower, upper) of all layers at all times."""
    return tuple(extremes(*(layer[name] for layer in run.layers)) for name in ("x", "y"))


def panel_size(ranges: tuple[tuple[float, float], tuple[float, float]]) -> tuple[float, float]:
    """Width and height [inches] of what covers these ranges."""
    width, height = (high - low for low, high in ranges)
    return SIZE * min(1.0, width / height), SIZE * min(1.0, height / width)
