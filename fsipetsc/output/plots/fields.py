"""Fields over space at some times: profiles in one dimension, maps on the grids as they are in two.
And fields of one dimension over x and t.

In three dimensions the maps are those of the plane in the middle of the blocks' second axis.
"""

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np

from fsipetsc.output.plots import style
from fsipetsc.output.plots.style import Axes, FigureBase, extremes, labelled, shaded
from fsipetsc.output.quantities import Quantity, unit_of, written
from fsipetsc.output.reader import Layer, Run

Array = np.ndarray
WIDTH = 10.2  # inches, of all panels beside each other
HIGHEST = 4.4  # inches, of a panel
ABOVE = 0.4  # inches, of what stands above and below a panel
BAR = 0.72  # inches, of a colour bar with its label
MARGIN = 0.02  # of the extent, around it
THIN = 0.2  # height over width; what is thinner is drawn higher than it is
WIDE = 1.25  # width over height; of what is wider, two panels stand beside each other, else three


class View:
    """A quantity of a run at some frames, and what all of its panels have in common.

    layers   those that have the quantity
    scales   kind of layer -> colours of its maps, for frames after the first one
    limits   (left, right), (lower, upper) of a panel
    labels   of its two axes
    ratio    its width over its height
    """

    def __init__(self, run: Run, quantity: Quantity, frames: Sequence[int]) -> None:
        self.run, self.quantity, self.frames = run, quantity, list(frames)
        self.layers = [layer for layer in run.layers if layer.kind in quantity.labels]
        known = [[self.at(layer, k) for k in self.frames] for layer in self.layers]
        self.scales = self._scales([[values for *_, values in of] for of in known])
        ranges = np.array([extremes(*along) for along in zip(*chain(*known))])[:2]
        last = "r" if run.header.get("symmetry") else "xyz"[run.dimension - 1]
        last = labelled(run, last, "m")
        if run.dimension == 1:
            low, high = ranges[1]
            margin = 2 * MARGIN * (high - low) or 0.1 * abs(low) or 1.0
            self.limits = [ranges[0], np.array([low - margin, high + margin])]
            label = labelled(run, quantity.title, quantity.unit)
            self.labels, self.ratio = (last, label.replace("; ", ",\n")), 1.6
            return
        margin = MARGIN * np.ptp(ranges, axis=1).max() * np.array([-1.0, 1.0])
        self.limits = [*(ranges + margin)]
        self.labels = labelled(run, "x", "m"), last
        self.ratio = float(np.ptp(self.limits[0]) / np.ptp(self.limits[1]))

    def at(self, layer: Layer, frame: int) -> list[Array]:
        """Places of a frame, horizontal ones and of maps vertical ones, and values. Of three
        dimensions what lies in the middle of the second axis.
        """
        fields = {"X": layer.X, **layer.frame(frame)}
        found = [fields[x] for x in ("x", "xy", "xz")[self.run.dimension - 1]]
        found.append(self.quantity.values(layer.kind, fields))
        return [v[:, v.shape[1] // 2] if v.ndim == 3 else v for v in found]

    def _scales(self, values: list[list[Array]]) -> dict[str, dict[str, Any]]:
        """A kind of layer has colours of its own: what comes through to a solid may be little."""
        unit, last = self.quantity.unit, [layer.frame(-1) for layer in self.run.layers]
        same = [v for frame in last for k, v in frame.items() if written(unit_of(k)) == unit]
        beside = max(map(abs, extremes(*same)))
        scales = {}
        for kind in dict.fromkeys(layer.kind for layer in self.layers):
            some = [k for k, layer in enumerate(self.layers) if layer.kind == kind]
            later = [np.ravel(v) for k in some for v in values[k][1:] or values[k]]
            start = [np.ravel(self.at(self.layers[k], 0)[-1]) for k in some]
            moving = self.quantity.name in ("u", "v", "w")
            shown, first = np.concatenate(later), np.concatenate(start)
            scales[kind] = style.colours(kind, shown, first, beside, moving)
        return scales

    def draw(self, axes: Axes, frame: int) -> dict[str, Any]:
        """Draw one frame; kind of layer -> what there is to make a colour bar of."""
        pictures = {}
        axes.set(xlim=self.limits[0], ylim=self.limits[1], xlabel=self.labels[0])
        style.label_y(axes, self.labels[1])
        for layer in self.layers:
            found = self.at(layer, frame)
            if self.run.dimension == 1:
                axes.plot(*found, color=style.COLORS[layer.kind], label=layer.kind)
                continue
            for axis in layer.rings if self.run.dimension == 2 else ():  # it ends where it begins
                found = [np.append(v, v.take([0], axis), axis) for v in found]
            pictures[layer.kind] = shaded(axes, *found, self.scales[layer.kind])
            if layer.kind == "solid":
                outline(axes, *found[:2])
            axes.set_aspect("equal" if self.ratio <= 1 / THIN else "auto")
        return pictures


def frames_of(run: Run, quantity: Quantity, times: Sequence[float] = ()) -> list[int]:
    """The frames nearest to these times; if there are none, three or four of all, evenly."""
    count = 4 if View(run, quantity, [run.nframes - 1]).ratio >= WIDE else 3
    return sorted({run.at(t) for t in times or np.linspace(run.time[0], run.time[-1], count)})


def sizes(view: View, count: int) -> tuple[int, float, float]:
    """Columns, width of a panel and height of so many with their bars [inches]."""
    columns = min(2 if view.ratio >= WIDE else 3, count)
    rows = -(-count // columns)
    ratio = min(view.ratio, 1 / THIN)
    width = min(WIDTH / columns - 0.4, HIGHEST * ratio)
    bars = BAR * len(view.scales) * (view.run.dimension > 1)
    return columns, width, rows * (width / ratio + ABOVE) + bars + 0.45


def draw(figure: FigureBase, view: View) -> None:
    """A panel for each frame, colour bars or a legend above."""
    count = len(view.frames)
    grid = style.panels(figure, count, sizes(view, count)[0], sharex=True, sharey=True)
    for axes, frame in zip(grid.flat, view.frames):
        pictures = view.draw(axes, frame)
        axes.set_title(style.moment(view.run, frame), loc="left")
        axes.label_outer()
    grid[0, 0].locator_params(axis="x", nbins=4)
    if not pictures and len(view.scales) > 1:
        style.legend_above(grid[0, -1], side="right")
    draw_bars(figure, view, pictures, list(grid.flat))


def draw_bars(figure: FigureBase, view: View, pictures: Mapping[str, Any], axes: Any) -> None:
    """A colour bar above the panels for each kind of layer."""
    wide = isinstance(axes, list)
    size = {"aspect": 50, "shrink": 0.7} if wide else {"aspect": 25}
    for kind, picture in pictures.items():
        bar = figure.colorbar(picture, ax=axes, location="top", pad=0.02, **size)
        label, title = view.quantity.labels[kind], view.quantity.title
        if len(pictures) > 1 and label == title:  # of both kinds
            label = f"{'gas' if kind == 'fluid' else 'solid'}: {label}"
        bar.set_label(labelled(view.run, label, view.quantity.unit), loc="left")
        bar.outline.set_visible(False)
        bar.ax.locator_params(nbins=6 if wide else 4)


def draw_over_time(figure: FigureBase, run: Run, quantities: Sequence[Quantity]) -> None:
    """In one dimension a map of each quantity over x and t, with the interfaces as lines."""
    grid = figure.subplots(1, len(quantities), sharex=True, sharey=True, squeeze=False)[0]
    x_interface = run.series.get("x_interface", np.empty((0, 0)))
    some = slice(None, None, max(1, len(x_interface) // style.MAX_POINTS))
    for axes, quantity in zip(grid, quantities):
        view, pictures = View(run, quantity, range(run.nframes)), {}
        for layer in view.layers:
            values = np.array([view.at(layer, frame)[-1] for frame in view.frames])
            x, values = without_gaps(layer, values)
            x, values, t = between(x, values, np.broadcast_to(run.time[:, None], x.shape))
            pictures[layer.kind] = shaded(axes, x, t, values, view.scales[layer.kind])
        for x in x_interface[some].T:
            for color, width in (("white", 1.8), ("black", 0.8)):
                axes.plot(x, run.series["t"][some], color=color, linewidth=width)
        draw_bars(figure, view, pictures, axes)
        style.time_axis(axes, run, "y")
        axes.set(xlim=view.limits[0], ylim=run.time[[0, -1]], xlabel=view.labels[0], ylabel="")
    grid[0].set_ylabel("t")
    grid[0].locator_params(axis="x", nbins=4)


def between(*arrays: Array) -> list[Array]:
    """Arrays (nframes, n) with frames between the frames, linearly: triangles would show."""
    count = len(arrays[0])
    at = np.linspace(0, count - 1, max(count, 500))
    begin = np.minimum(at.astype(int), count - 2)
    part = (at - begin)[:, None]
    return [(1 - part) * values[begin] + part * values[begin + 1] for values in arrays]


def without_gaps(layer: Layer, values: Array) -> tuple[Array, Array]:
    """Positions and values at all points; those that are no part of a layer get the nearest value.

    The gases of the paper's method gain and lose points at their ends; maps need a place for all.
    Where no value of a frame is known, none is drawn.
    """
    x, values, index = layer.x.copy(), values.copy(), np.arange(len(layer.X))
    for row in np.flatnonzero(~np.isfinite(x + values).all(axis=1)):
        known = np.isfinite(x[row] + values[row])
        if known.any():
            x[row] = layer.X + np.interp(index, index[known], (x[row] - layer.X)[known])
            values[row] = np.interp(index, index[known], values[row][known])
        else:
            x[row] = np.where(np.isfinite(x[row]), x[row], layer.X)
    return x, values


def outline(axes: Axes, x: Array, y: Array) -> None:
    """The edges of a solid, and some lines of its grid across it, which show how it is deformed."""
    edges = [(x[0], y[0]), (x[-1], y[-1]), (x[:, 0], y[:, 0]), (x[:, -1], y[:, -1])]
    closed = [np.array_equal(edges[k], edges[k + 1]) for k in (0, 2)]
    for edge, skip in zip(edges, np.repeat(closed, 2)):
        if not skip:
            axes.plot(*edge, color="black", linewidth=0.8)
    longer = int(np.argmax(x.shape))
    step = max(1, (x.shape[longer] - 1) // 8)
    for line in range(step, x.shape[longer] - 1, step):
        across = x.take(line, longer), y.take(line, longer)
        axes.plot(*across, color="black", linewidth=0.3, alpha=0.5)
