"""Velocity, temperature and pressure over x and t."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.checks import counted
from fsipetsc.output.plots.profiles import domain
from fsipetsc.output.plots.quantities import SPACE_TIME, Quantity
from fsipetsc.output.plots.scales import Scale, axis_label, extremes, scaled, value_at_rest
from fsipetsc.output.plots.style import bar_above, in_two_lines, thin
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Layer, Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure, FigureBase

Array = np.ndarray
MAX_FRAMES, MAX_POINTS = 500, 1000  # of a layer
SMOOTH = 200  # rows at least
BOTH_SIGNS = 0.1  # a departure to the other side of rest that is smaller than this part does not count


def draw(figure: Figure, run: Run) -> None:
    """A map for each quantity, with the interfaces as lines."""
    figure.set_size_inches(3.5 * len(SPACE_TIME), 4.4)
    figure.set_layout_engine("constrained", w_pad=0.12)
    draw_maps(figure, run, SPACE_TIME)
    set_title(figure, of_run(run, f"space and time, {counted(run.nframes, 'frame')}"))


def draw_maps(figure: FigureBase, run: Run, quantities: Sequence[Quantity]) -> None:
    """The maps alone, side by side; quantities: of which some layer has each."""
    grid = figure.subplots(1, len(quantities), sharex=True, sharey=True, squeeze=False)[0]
    step = max(1, run.nframes // MAX_FRAMES)
    for axes, quantity in zip(grid, quantities):
        layers = [layer for layer in run.layers if quantity.of(layer.kind)]
        values = [quantity.values(layer)[::step] for layer in layers]
        scale = scaled(run, quantity.label, quantity.unit, *values, start=np.concatenate([v[0] for v in values]))
        colors = palette(quantity.colormap, scale, values)
        for layer, own in zip(layers, values):
            x, t, smooth = mesh(run, layer, own, step)
            picture = axes.pcolormesh(x, t, np.ma.masked_invalid(scale(smooth)), rasterized=True, **colors)
        for position in _interface_positions(run):
            axes.plot(*position, color="white", linewidth=1.8)
            axes.plot(*position, color="black", linewidth=0.8)
        axes.grid(visible=False)
        axes.set_xlabel(axis_label(run, "x", "m"))
        bar_above(figure, picture, axes, in_two_lines(scale.label), aspect=30)
    grid[0].set_xlim(domain(run))
    grid[0].set_ylim(run.time[0], run.time[-1])
    grid[0].set_ylabel(axis_label(run, "t", "s"))


def palette(colormap: str, scale: Scale, values: Sequence[Array], both: str = "RdBu_r") -> dict[str, object]:
    """Color map and its limits: light where nothing happens, that is at the value at rest. both: for values above and below."""
    low, high = extremes(*values)
    rest = value_at_rest(high - low, *(v[0] for v in values))
    up, down = high - rest, rest - low
    low, high, rest = (float(scale(np.float64(v))) for v in (low, high, rest))
    if high <= low:
        return {"cmap": both, "vmin": low - 0.5, "vmax": high + 0.5}
    if min(up, down) > BOTH_SIGNS * max(up, down) or colormap == "viridis":
        most = max(high - rest, rest - low)
        return {"cmap": both, "vmin": rest - most, "vmax": rest + most}
    return {"cmap": colormap if up > down else f"{colormap}_r", "vmin": low, "vmax": high}


def mesh(run: Run, layer: Layer, values: Array, step: int) -> tuple[Array, Array, Array]:
    """x, t and values of a layer, (rows, points): few frames become many rows, smooth in time at each X."""
    stride = max(1, len(layer.X) // MAX_POINTS)
    time = run.time[::step]
    x = refined(_without_gaps(layer)[::step, ::stride], time)
    t = refined(np.repeat(time[:, None], x.shape[1], axis=1), time)
    return x, t, refined(values[:, ::stride], time)


def refined(rows: Array, time: Array) -> Array:
    """Rows between the frames, by cubics with the slopes of the parabolas through three frames, so that no edges show.

    What is not a number in one of these is taken from the other:
    points come and go at the ends of the fluids.
    """
    parts = max(1, SMOOTH // (len(rows) - 1))
    s = (np.arange(parts) / parts)[:, None]
    span = np.diff(time)[:, None]
    slopes = np.gradient(rows, time, axis=0, edge_order=2)
    before = np.where(np.isfinite(rows[:-1]), rows[:-1], rows[1:])
    after = np.where(np.isfinite(rows[1:]), rows[1:], rows[:-1])
    chord = (after - before) / span
    left, right = (np.where(np.isfinite(slope), slope, chord) * span for slope in (slopes[:-1], slopes[1:]))
    cubic = (
        (1 + 2 * s) * (1 - s) ** 2 * before[:, None]
        + s * (1 - s) ** 2 * left[:, None]
        + s**2 * (3 - 2 * s) * after[:, None]
        - s**2 * (1 - s) * right[:, None]
    )
    return np.concatenate([cubic.reshape(-1, rows.shape[1]), rows[-1:]])


def _without_gaps(layer: Layer) -> Array:
    """The positions, continued by the grid where there are none: pictures need a place for what they do not show."""
    shift = layer.x - layer.X
    known = np.isfinite(shift)
    count = np.maximum(known.sum(axis=1, keepdims=True), 1)
    mean = np.where(known, shift, 0.0).sum(axis=1, keepdims=True) / count
    return np.where(known, layer.x, layer.X + mean)


def _interface_positions(run: Run) -> Iterator[tuple[Array, Array]]:
    """Position and time of each interface over the saved frames."""
    if "x_interface" in run.series and len(run.series["t"]):
        inside = run.series["t"] <= run.time[-1]
        some = thin(inside.sum())
        for x in run.series["x_interface"][inside].T:
            yield x[some], run.series["t"][inside][some]
