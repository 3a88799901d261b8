"""Fields over space at some times: profiles in one dimension, maps on the grids as they are in two.
And fields of one dimension over x and t.

In three dimensions the maps are those of the plane in the middle of the blocks' second axis.
"""

from collections.abc import Mapping, Sequence
from itertools import chain, product
from typing import Any

import numpy as np

from fsipetsc.output.plots import style
from fsipetsc.output.plots.style import Axes, FigureBase, extremes, refined, shaded
from fsipetsc.output.quantities import Quantity, unit_of, written
from fsipetsc.output.reader import Layer, Run

Array = np.ndarray
WIDTH = 10.2  # inches, of all panels beside each other
HIGHEST = 4.4  # inches, of a panel
ABOVE = 0.4  # inches, of what stands above and below a panel
BAR = 0.72  # inches, of a colour bar with its label
MARGIN = 0.02  # of the extent, around it
THIN = 0.2  # height over width; what is thinner is drawn higher than it is
NEAR = 1e-4  # span of values over their size; of those that span less something is taken
ALIKE = 0.1  # span over that of both; gas and solid that have more share their colours
FINE = 240  # points of a map across a panel
LINES = 40  # of the grid in a solid as long as a panel
SIDES = ((0, 0), (0, -1), (1, 0), (1, -1))  # axis and index of an edge
WIDE = 1.25  # width over height; of what is wider, two panels stand beside each other, else three


class View:
    """A quantity of a run at some frames, and what all of its panels have in common.

    layers   those that have the quantity
    base     what is taken from all values where these vary by little, else 0
    scales   kind of layer -> colours of its maps, for frames after the first one
    limits   (left, right), (lower, upper) of a panel
    ratio    its width over its height
    """

    def __init__(self, run: Run, quantity: Quantity, frames: Sequence[int]) -> None:
        self.run, self.quantity, self.frames, self.base = run, quantity, list(frames), 0.0
        self.layers = [layer for layer in run.layers if layer.kind in quantity.labels]
        known = [[self.at(layer, k) for k in self.frames] for layer in self.layers]
        *ranges, (low, high) = np.array([extremes(*along) for along in zip(*chain(*known))])
        size = max(abs(low), abs(high))
        if style.NOTHING * size < high - low < NEAR * size:
            self.base = round(float(low), int(-np.log10(high - low)) - 1)
        self.scales = self._scales([[of[-1] - self.base for of in some] for some in known])
        if run.dimension == 1:
            margin = 2 * MARGIN * (high - low) or 0.1 * size or 1.0
            vertical = np.array([low - margin, high + margin]) - self.base
            self.limits, self.ratio = [ranges[0], vertical], 1.6
            return
        margin = MARGIN * np.ptp(ranges, axis=1).max() * np.array([-1.0, 1.0])
        self.limits = [*(ranges + margin)]
        self.ratio = float(np.ptp(self.limits[0]) / np.ptp(self.limits[1]))

    def at(self, layer: Layer, frame: int) -> list[Array]:
        """Places of a frame, horizontal ones and of maps vertical ones, and values less the base.
        Of three dimensions what lies in the middle of the second axis.
        """
        fields = {"X": layer.X, **layer.frame(frame)}
        found = [fields[x] for x in ("x", "xy", "xz")[self.run.dimension - 1]]
        found.append(self.quantity.values(layer.kind, fields) - self.base)
        return [v[:, v.shape[1] // 2] if v.ndim == 3 else v for v in found]

    def label(self, name: str) -> str:
        """With what is taken from the values."""
        return f"{name} less {self.base:.12g}" if self.base else name

    def _scales(self, values: list[list[Array]]) -> dict[str, dict[str, Any]]:
        """Kinds of layers whose values are alike share their colours; what comes through to a solid
        may be little.
        """
        quantity, last = self.quantity, [layer.frame(-1) for layer in self.run.layers]
        same = (v for of in last for k, v in of.items() if written(unit_of(k)) == quantity.unit)
        beside, of = max(map(abs, extremes(*same))), dict[str, list[Array]]()
        for layer, some in zip(self.layers, values):
            of.setdefault(layer.kind, []).extend(some[1:] or some)
        whole, signs = [*chain(*of.values())], {*map(quantity.signed, of)}
        alike = min(np.ptp(extremes(*v)) for v in of.values()) > ALIKE * np.ptp(extremes(*whole))
        scales = {}
        for kind in of:
            like, shown = ("fluid", whole) if alike and len(signs) == 1 else (kind, of[kind])
            plain = style.PLAIN.get(f"{like} {quantity.name}", style.PLAIN[like])
            start = [self.at(layer, 0)[-1] for layer in self.layers if layer.kind == kind]
            rest = self.rest(start) if quantity.signed(kind) else None
            maps = style.SIGNED[like], plain
            scales[kind] = style.colours(
                np.concatenate([*map(np.ravel, shown)]), rest, maps, beside
            )
        return scales

    def rest(self, start: list[Array]) -> float:
        """What is white: 0, or of stresses what most points have at the start, in two digits."""
        stress = unit_of(self.quantity.name) == "Pa"
        return float(f"{np.nanmedian(np.concatenate([*map(np.ravel, start)])):.2g}") * stress

    def draw(self, axes: Axes, frame: int) -> dict[str, Any]:
        """Draw one frame; kind of layer -> what there is to make a colour bar of."""
        pictures, solids, run = {}, [], self.run
        names = ["x", "", "xyz"[run.dimension - 1]]
        if run.header.get("symmetry"):
            names[2 - 2 * (run.dimension == 1)] = "r"
        axes.set(xlim=self.limits[0], ylim=self.limits[1])
        style.set_unit(run, axes.xaxis, names[0], "m")
        if run.dimension == 1:
            title = self.label(self.quantity.title).replace("; ", ",\n")
            style.label_y(axes, run, title, self.quantity.unit)
        else:
            style.label_y(axes, run, names[2], "m")
            axes.set_aspect("equal" if self.ratio <= 1 / THIN else "auto")
        for layer in self.layers:
            found = self.at(layer, frame)
            if run.dimension == 1:
                axes.plot(*found, color=style.COLORS[layer.kind], label=layer.kind)
                continue
            for axis in layer.rings if run.dimension == 2 else ():  # it ends where it begins
                found = [np.append(v, v.take([0], axis), axis) for v in found]
            pictures[layer.kind] = shaded(axes, *self.finer(*found), self.scales[layer.kind])
            if layer.kind == "solid":
                solids.append(found[:2])
        self.outline(axes, solids)
        return pictures

    def finer(self, x: Array, y: Array, *values: Array) -> list[Array]:
        """With more points where cells are large, between which edges are curves and not lines."""
        for axis, cells in enumerate(np.array(x.shape) - 1):
            points = 1 + cells * int(np.ceil(FINE * self.length(x, y, axis) / max(1, cells)))
            x, y = (refined(v, points, axis, degree=3) for v in (x, y))
            values = tuple(refined(v, points, axis, degree=1) for v in values)
        return [x, y, *values]

    def length(self, x: Array, y: Array, axis: int) -> float:
        """Of the longest line along an axis, over the width of a panel."""
        steps = np.hypot(np.diff(x, axis=axis), np.diff(y, axis=axis))
        return float(steps.sum(axis).max() / np.ptp(self.limits, axis=1).max())

    def outline(self, axes: Axes, solids: list[list[Array]]) -> None:
        """The edges of solids, thin between two blocks, and lines in them, which show how they are
        deformed.
        """
        edges = [[v.take([side], axis) for v in of] for of in solids for axis, side in SIDES]
        places = [frozenset(zip(*map(np.ravel, edge))) for edge in edges]
        for edge, place in zip(edges, places):
            outer = places.count(place) == 1
            x, y = map(np.ravel, self.finer(*edge))
            for color, width in style.OUTLINE if outer else (("black", 0.3),):
                axes.plot(x, y, color=color, linewidth=width)
        for of, axis in product(solids, (0, 1)):
            count = int(LINES * self.length(*of, axis))
            if count > 1:
                lines = [refined(v, count + 1, axis, degree=3) for v in of]
                lines = [v.take(range(1, count), axis) for v in lines]
                x, y = (np.moveaxis(v, axis, 1) for v in lines)
                axes.plot(x, y, color="black", linewidth=0.3, alpha=0.5)


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
    """A colour bar above the panels for each kind of layer, or for both."""
    wide, run, scales = isinstance(axes, list), view.run, view.scales
    size = {"aspect": 50, "shrink": 0.7} if wide else {"aspect": 25}
    both = len(scales) > 1 and scales["fluid"] == scales["solid"]
    for kind in [*pictures][: 1 if both else 2]:
        bar = figure.colorbar(pictures[kind], ax=axes, location="top", pad=0.02, **size)
        label, unit, scale = view.quantity.labels[kind], view.quantity.unit, scales[kind]
        if both:
            label = view.quantity.title
        elif len(scales) > 1 and label == view.quantity.title:  # of both kinds
            label = f"{'gas' if kind == 'fluid' else 'solid'}: {label}"
        white = 0.5 * (scale["vmin"] + scale["vmax"])
        if scale["cmap"] in style.SIGNED.values() and abs(white) > 1e-9 * scale["vmax"]:
            label += f", white: {style.number(white / style.prefixed(run, unit, kind)[0])}"
        style.set_unit(run, bar.ax.xaxis, view.label(label), unit, kind)
        bar.set_label(bar.ax.get_xlabel(), loc="left")
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
            found = x, np.broadcast_to(run.time[:, None], x.shape), values
            x, t, values = (refined(v, max(len(v), 500), 0, degree=1) for v in found)
            pictures[layer.kind] = shaded(axes, x, t, values, view.scales[layer.kind])
        for x in x_interface[some].T:
            for color, width in style.OUTLINE:
                axes.plot(x, run.series["t"][some], color=color, linewidth=width)
        draw_bars(figure, view, pictures, axes)
        style.time_axis(axes, run, "y")
        axes.set(xlim=view.limits[0], ylim=run.time[[0, -1]], ylabel="")
        style.set_unit(run, axes.xaxis, "r" if run.header.get("symmetry") else "x", "m")
    style.set_unit(run, grid[0].yaxis, "t", "s")
    grid[0].locator_params(axis="x", nbins=4)


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
