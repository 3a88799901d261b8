"""Fields of one dimension over x and t; in two what the interfaces do, over X and t."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.output.interface_line import InterfaceLine
from fsipetsc.output.plots.fields import WIDTH, domain, how_shown, line_name
from fsipetsc.output.plots.quantities import Quantity
from fsipetsc.output.plots.scales import Scale, colours, extremes, scaled, time_scale
from fsipetsc.output.plots.style import MAX_POINTS, bar_above, few_ticks, legend_above, line_look
from fsipetsc.output.reader import BlockLayer, Layer, Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase

Array = np.ndarray
LEAST_FRAMES = 5  # of fewer, profiles say more
ROWS, COLUMNS = 500, 800  # of a map, at least about the pixels that it has on a page
ENDS = 20  # of an interface this part at either end, with its corners, does not decide on colours
INTERFACE_POINTS = (0.25, 0.5, 0.75)  # of an interface, whose deflection is drawn as a curve


def draw(figure: FigureBase, run: Run, quantities: Sequence[Quantity]) -> None:
    """A map for each quantity, with the interfaces as lines."""
    grid = figure.subplots(1, len(quantities), sharex=True, sharey=True, squeeze=False)[0]
    ends = np.array(domain(run, run.layers))
    place, time = scaled(run, line_name(run), "m", ends), time_scale(run)
    for axes, quantity in zip(grid, quantities):
        axes.set(xlim=place(ends), ylim=time(run.time[[0, -1]]), xlabel=place.label)
        axes.grid(visible=False)
        _map(figure, axes, run, quantity, (place, time))
        for x, t in interface_positions(run):
            axes.plot(place(x), time(t), color="white", linewidth=1.8)
            axes.plot(place(x), time(t), color="black", linewidth=0.8)
    grid[0].set_ylabel(time.label)
    few_ticks(grid[0], 0.9 * WIDTH / len(grid))


def _map(
    figure: FigureBase, axes: Axes, run: Run, quantity: Quantity, scales: tuple[Scale, Scale]
) -> None:
    place, time = scales
    layers = [layer for layer in run.layers if quantity.of(layer.kind)]
    values: dict[str, list[Array]] = {}
    for layer in layers:
        fields = {"X": layer.X, **{name: layer[name] for name in layer.fields}}
        values.setdefault(layer.kind, []).append(quantity.of(layer.kind).values(fields))
    flat = {kind: np.concatenate([*map(np.ravel, some)]) for kind, some in values.items()}
    start = {kind: np.concatenate([v[0] for v in some]) for kind, some in values.items()}
    shown = how_shown(run, quantity, flat, start, flat)
    left = {kind: iter(some) for kind, some in values.items()}
    bars = {}
    for layer in layers:
        scale, look, extend = shown[layer.kind]
        x, colour = without_gaps(layer, next(left[layer.kind]))
        picture = draw_map(axes, place(x), time(run.time), scale(colour), look)
        bars[scale.label] = picture, extend
    for label, (picture, extend) in bars.items():
        bar_above(figure, picture, axes, label.replace(", ", ",\n", 1), extend)


def draw_map(axes: Axes, x: Array, t: Array, values: Array, look: dict[str, Any]) -> Any:
    """Values (nframes, n) at places x of the same shape and times t, as an image.

    It is linear between frames along each grid point, and between grid points at each time. Cells
    shaded by matplotlib are thin where frames are few, and show their edges as bands.
    """
    ends = extremes(x)
    columns = ends[0] + (np.arange(COLUMNS) + 0.5) / COLUMNS * (ends[1] - ends[0])
    rows = t[0] + (np.arange(ROWS) + 0.5) / ROWS * (t[-1] - t[0])
    image = np.empty((ROWS, COLUMNS))
    for row, at in zip(image, rows):
        later = int(np.clip(np.searchsorted(t, at), 1, len(t) - 1))
        part = (at - t[later - 1]) / (t[later] - t[later - 1])
        place, value = (a[later - 1] + part * (a[later] - a[later - 1]) for a in (x, values))
        row[:] = np.interp(columns, place, value, left=np.nan, right=np.nan)
    area = {"extent": (*ends, t[0], t[-1]), "origin": "lower", "aspect": "auto"}
    limits = axes.get_xlim(), axes.get_ylim()
    picture = axes.imshow(np.ma.masked_invalid(image), interpolation="nearest", **area, **look)
    axes.set(xlim=limits[0], ylim=limits[1])
    return picture


def without_gaps(layer: Layer | BlockLayer, values: Array) -> tuple[Array, Array]:
    """Positions and values at all points; those that are no part of a layer get the nearest value.

    The gases of the paper's method gain and lose points at their ends; maps need a place for all.
    """
    x, values, index = layer.x.copy(), values.copy(), np.arange(len(layer.X))
    for row in np.flatnonzero(~np.isfinite(x + values).all(axis=1)):
        known = np.isfinite(x[row] + values[row])
        if known.any():
            shift = np.interp(index, index[known], (x[row] - layer.X)[known])
            x[row] = layer.X + shift
            values[row] = np.interp(index, index[known], values[row][known])
    return x, values


def interface_positions(run: Run) -> list[tuple[Array, Array]]:
    """Position and time of each interface, as recorded at the steps."""
    if not len(run.series.get("x_interface", ())):
        return []
    some = slice(None, None, max(1, len(run.series["t"]) // MAX_POINTS))
    return [(x, run.series["t"][some]) for x in run.series["x_interface"][some].T]


def draw_interfaces(figure: FigureBase, run: Run) -> None:
    """In two dimensions a row for each interface.

    Its deflection and the pressure on the solid over X and t, the deflection of some points.
    """
    lines = [run.interface(k) for k in range(len(run.interfaces))]
    for row, line in zip(figure.subplots(len(lines), 3, squeeze=False), lines):
        load = line.pressure
        row[0].set_title(line.name, loc="left")
        for axes, label, unit, values in (
            (row[0], "deflection", "m", line.displacement),
            (row[1], "pressure on the solid", "Pa", load),
        ):
            scale = scaled(run, label, unit, values, start=values[0])
            end = values.shape[1] // ENDS
            inner = values[:, end : values.shape[1] - end]
            look, extend = colours("fluid", scale, inner, values[0], extremes(values))
            place, time = scaled(run, "X", "m", line.X), time_scale(run)
            axes.set(xlim=place(line.X[[0, -1]]), ylim=time(run.time[[0, -1]]))
            x = np.broadcast_to(place(line.X), values.shape)
            picture = draw_map(axes, x, time(run.time), scale(values), look)
            axes.grid(visible=False)
            axes.set(xlabel=place.label, ylabel=time.label)
            bar_above(figure, picture, axes, scale.label.replace(", ", ",\n", 1), extend)
        draw_deflection(row[2], run, line)


def draw_deflection(axes: Axes, run: Run, line: InterfaceLine) -> None:
    """The deflection of some points over time."""
    scale, time = scaled(run, "deflection", "m", line.displacement), time_scale(run)
    place = scaled(run, "X", "m", line.X)
    for k, part in enumerate(INTERFACE_POINTS):
        point = round(part * (len(line.X) - 1))
        label = f"X = {place(line.X[point]):.3g}"
        axes.plot(time(run.time), scale(line.displacement[:, point]), **line_look(k), label=label)
    axes.set(xlabel=time.label, ylabel=scale.label, xlim=time(run.time[[0, -1]]))
    legend_above(axes)
