"""Fields over space at some times: profiles in one dimension, maps on the grids as they are in two.
And fields of one dimension over x and t.

In three dimensions the maps are those of the plane in the middle of the blocks' second axis.
"""

from collections.abc import Mapping, Sequence
from itertools import chain, product
from typing import Any

import numpy as np

from fsipetsc.checks import Array
from fsipetsc.output.plots import style
from fsipetsc.output.plots.style import Axes, FigureBase, Wanted, extremes, labelled, shaded
from fsipetsc.output.quantities import Quantity, unit_of, written
from fsipetsc.output.reader import Layer, Run

WIDTH = 10.2  # inches, of all panels beside each other
HIGHEST = 4.4  # inches, of a panel
ABOVE = 0.4  # inches, of what stands above and below a panel
BAR = 0.72  # inches, of a colour bar with its label
MARGIN = 0.02  # of the extent, around it
THIN = 0.2  # height over width; what is thinner is drawn higher than it is
ALIKE = 0.1  # span of values over the larger one; if gas and solid have more, they share colours
NEAR = 1e-4  # of values that span less of their size, one is subtracted
STILL = 1e-3  # of the largest speed; there are no streamlines where it is less
TIMES = 500  # about, of a map over x and t
STREAM = 150  # points along each side of a panel, between which streamlines go
SIDES = (0, 0), (0, -1), (1, 0), (1, -1)  # axis and index of an edge of a block
LINES = 40  # of the grid in a solid as long as a panel
WIDE = 1.25  # width over height; of what is wider, two panels stand beside each other, else three


class View:
    """A quantity of a run at some frames, and what all of its panels have in common.

    layers   those that have the quantity, and in two and three dimensions solids
    base     what is subtracted from values that vary by little, else 0
    scales   kind of layer -> colours of its maps, for frames after the start
    bars     kind of layer -> label of its colour bar, which other kinds may share
    limits   (left, right), (lower, upper) of a panel
    labels   of its two axes
    ratio    its width over its height
    """

    def __init__(
        self, run: Run, quantity: Quantity, frames: Sequence[int], wanted: Wanted = style.USUAL
    ) -> None:
        self.run, self.quantity, self.wanted, self.base = run, quantity, wanted, 0.0
        kinds = {*quantity.labels, *["solid"][: run.dimension - 1]}
        self.layers = [layer for layer in run.layers if layer.kind in kinds]
        self.frames = list(frames)
        known = [[self.at(layer, k) for k in self.frames] for layer in self.layers]
        *ranges, (low, high) = np.array([extremes(*along) for along in zip(*chain(*known))])
        size = max(-low, high)
        if style.NOTHING * size < high - low < NEAR * size:
            self.base = round(float(low), int(-np.log10(high - low)) - 1)
        self.scales, self.bars = dict[str, dict[str, Any]](), dict[str, str]()
        self._colour([[at[-1] - self.base for at in of] for of in known])
        last = "r" if run.header.get("symmetry") else "xyz"[run.dimension - 1]
        last = labelled(run, last, "m")
        if run.dimension == 1:
            margin = 2 * MARGIN * (high - low) or 0.1 * abs(low) or 1.0
            self.limits = [ranges[0], np.array([low - margin, high + margin]) - self.base]
            self.labels, self.ratio = (last, self.label(quantity.title).replace("; ", ",\n")), 1.6
        else:
            margin = MARGIN * np.ptp(ranges, axis=1).max() * np.array([-1.0, 1.0])
            self.limits = [*(ranges + margin)]
            self.labels = labelled(run, "x", "m"), last
            self.ratio = float(np.ptp(self.limits[0]) / np.ptp(self.limits[1]))

    def at(self, layer: Layer, frame: int, more: str = "") -> list[Array]:
        """Return places of a frame, horizontal ones and of maps vertical ones, more fields, and
        values. Of three dimensions what lies in the middle of the second axis.
        """
        fields = {"X": layer.X, **layer.frame(frame)}
        found = [fields[x] for x in ("x", "xy", "xz")[self.run.dimension - 1] + more]
        if layer.kind in self.quantity.labels:
            found.append(self.quantity.values(layer.kind, fields) - self.base)
        else:
            found.append(np.full_like(found[0], np.nan))
        for axis in layer.rings if self.run.dimension == 2 else ():  # it ends where it begins
            found = [np.append(v, v.take([0], axis), axis) for v in found]
        return [v[:, v.shape[1] // 2] if v.ndim == 3 else v for v in found]

    def label(self, name: str) -> str:
        """Return a name with what is subtracted, and the unit."""
        less = f" less {self.base:.12g}" if self.base else ""
        return labelled(self.run, name + less, self.quantity.unit)

    def _colour(self, values: list[list[Array]]) -> None:
        """Make scales and bars, which gas and solid share if their values have similar spans."""
        quantity, labels = self.quantity, self.quantity.labels
        last = [layer.frame(-1) for layer in self.run.layers]
        same = [v for of in last for k, v in of.items() if written(unit_of(k)) == quantity.unit]
        size = max(map(abs, extremes(*same)))
        begins = int(self.frames[0] == 0)  # initial data may go far beyond what follows
        known: dict[str, list[Array]] = {kind: [] for kind in labels}
        for layer, of in zip(self.layers, values):
            known.get(layer.kind, []).extend(of[begins:] or of)
        spans = [np.ptp(extremes(*of)) for of in known.values()]
        alike = len({*map(quantity.signed, labels)}) == 1 and min(spans) >= ALIKE * max(spans)
        for kinds in [[*labels]] if alike else [[kind] for kind in labels]:
            shown = np.concatenate([np.ravel(v) for kind in kinds for v in known[kind]])
            name = quantity.name if "fluid" in kinds else "solid"
            scale = style.colours(shown, quantity.signed(kinds[0]), name, size)
            label = "; ".join(dict.fromkeys(labels[kind] for kind in kinds))
            if not alike and label == quantity.title and len(labels) > 1:
                label = f"{'gas' if kinds == ['fluid'] else 'solid'}: {label}"
            self.bars[kinds[0]] = label
            self.scales |= dict.fromkeys(kinds, scale)

    def draw(self, axes: Axes, frame: int) -> dict[str, Any]:
        """Draw one frame; kind of layer -> what there is to make a colour bar of."""
        maps, solids, plane = {}, [], self.run.dimension > 1
        axes.set(xlim=self.limits[0], ylim=self.limits[1], xlabel=self.labels[0])
        style.label_y(axes, self.labels[1])
        axes.set_aspect("equal" if plane and self.ratio <= 1 / THIN else "auto")
        for layer in self.layers:
            found = self.at(layer, frame)
            if not plane:
                axes.plot(*found, color=style.COLORS[layer.kind], label=layer.kind)
                continue
            solids += [found[:2]] * (layer.kind == "solid")
            if scale := self.scales.get(layer.kind):
                maps[layer.kind] = shaded(axes, *found, scale)
                levels = np.linspace(scale["vmin"], scale["vmax"], self.wanted.contours + 2)[1:-1]
                low, high = extremes(found[-1])
                if (levels := levels[(low < levels) & (levels < high)]).size:
                    axes.contour(*found, levels, colors="black", linewidths=0.4)
        self._outline(axes, solids)
        if self.wanted.streamlines and plane:
            self._streamlines(axes, frame)
        return maps

    def _outline(self, axes: Axes, solids: list[list[Array]]) -> None:
        """Draw edges of solids that are not between two blocks, and a fine grid, which deforms."""
        edges = [[v.take(end, k) for v in of] for of, (k, end) in product(solids, SIDES)]
        places = [frozenset(zip(*edge)) for edge in edges]
        for edge, (color, width) in product(edges, style.OUTLINE):
            if places.count(frozenset(zip(*edge))) == 1:
                axes.plot(*edge, color=color, linewidth=width)
        for (x, y), axis in product(solids, (0, 1)):
            steps = np.hypot(np.diff(x, axis=axis), np.diff(y, axis=axis))
            lines = max(1.0, LINES * steps.sum(axis).max() / np.ptp(self.limits, axis=1).max())
            nodes = range(0, x.shape[axis], max(1, round(x.shape[axis] / lines)))[1:]
            grid = [np.moveaxis(v.take(nodes, axis), axis, 1) for v in (x, y)]
            axes.plot(*grid, color="black", linewidth=0.3, alpha=0.5)

    def _streamlines(self, axes: Axes, frame: int) -> None:
        """Draw lines along the velocities of gases, as they are at a frame."""
        from matplotlib.tri import LinearTriInterpolator, Triangulation

        x, y = (np.linspace(*bounds, STREAM) for bounds in self.limits)
        flow = np.full((2, STREAM, STREAM), np.nan)
        for layer in self.layers:
            if layer.kind == "fluid":
                *at, u, v, _ = self.at(layer, frame, "uv" if self.run.dimension == 2 else "uw")
                n = np.arange(u.size).reshape(u.shape)
                a, b, c, d = (of.ravel() for of in (n[:-1, :-1], n[:-1, 1:], n[1:, :-1], n[1:, 1:]))
                mesh = Triangulation(*map(np.ravel, at), np.r_[np.c_[a, b, c], np.c_[b, d, c]])
                for of, values in zip(flow, (u, v)):
                    found = LinearTriInterpolator(mesh, values.ravel())(*np.meshgrid(x, y))
                    np.copyto(of, found.data, where=~found.mask)
        speed = np.hypot(*flow)
        flow[:, speed < STILL * np.nanmax(speed)] = np.nan
        axes.streamplot(x, y, *flow, color="white", linewidth=0.5, arrowsize=0.5)


def frames_of(run: Run, quantity: Quantity, times: Sequence[float] = ()) -> list[int]:
    """Return the frames nearest to these times; if there are none, three or four of all, evenly."""
    count = 4 if View(run, quantity, [run.nframes - 1]).ratio >= WIDE else 3
    return sorted({run.at(t) for t in times or np.linspace(run.time[0], run.time[-1], count)})


def sizes(view: View, count: int) -> tuple[int, float, float]:
    """Return columns, width of a panel and height of so many with their bars [inches]."""
    columns = min(2 if view.ratio >= WIDE else 3, count)
    ratio = min(view.ratio, 1 / THIN)
    width = min(WIDTH / columns - 0.4, HIGHEST * ratio)
    bars = BAR * len(view.bars) * (view.run.dimension > 1)
    return columns, width, -(-count // columns) * (width / ratio + ABOVE) + bars + 0.45


def draw(figure: FigureBase, view: View) -> None:
    """A panel for each frame, colour bars or a legend above."""
    columns, width, _ = sizes(view, len(view.frames))
    grid = style.panels(figure, len(view.frames), columns, sharex=True, sharey=True)
    for axes, frame in zip(grid.flat, view.frames):
        maps = view.draw(axes, frame)
        axes.set_title(style.moment(view.run, frame), loc="left")
        axes.label_outer()
    grid[0, 0].locator_params(axis="x", nbins=min(4, int(1 + 2 * width)))
    if not maps and len(view.scales) > 1:
        style.legend_above(grid[0, -1], side="right")
    draw_bars(figure, view, maps, list(grid.flat))


def draw_bars(figure: FigureBase, view: View, maps: Mapping[str, Any], axes: Any) -> None:
    """Draw colour bars above the panels."""
    wide = isinstance(axes, list)
    size = {"aspect": 50, "shrink": 0.7} if wide else {"aspect": 25}
    for kind, label in view.bars.items() if maps else ():
        bar = figure.colorbar(maps[kind], ax=axes, location="top", pad=0.02, **size)
        bar.set_label(view.label(label), loc="left")
        bar.outline.set_visible(False)
        bar.ax.locator_params(nbins=6 if wide else 4)


def draw_over_time(figure: FigureBase, run: Run, quantities: Sequence[Quantity]) -> None:
    """Draw a map of each quantity over x and t, with the interfaces as lines."""
    grid = figure.subplots(1, len(quantities), sharex=True, sharey=True, squeeze=False)[0]
    x_interface = run.series.get("x_interface", np.empty((0, 0)))
    n, parts = run.nframes, max(1, TIMES // run.nframes)  # of the time between two frames
    t = np.interp(np.arange((n - 1) * parts + 1) / parts, np.arange(n), run.time)
    for axes, quantity in zip(grid, quantities):
        view, maps = View(run, quantity, range(run.nframes)), {}
        for layer in view.layers:
            values = np.array([view.at(layer, frame)[-1] for frame in view.frames])
            x, values = (  # at more times, else the triangles that are drawn show
                np.transpose([np.interp(t, run.time, of) for of in rows.T])
                for rows in (layer.X + filled(layer.x - layer.X, 0.0), filled(values))
            )
            at = np.broadcast_to(t[:, None], x.shape)
            maps[layer.kind] = shaded(axes, x, at, values, view.scales[layer.kind])
        for x, (color, width) in product(x_interface.T, style.OUTLINE):
            axes.plot(x, run.series["t"], color=color, linewidth=width)
        draw_bars(figure, view, maps, axes)
        style.time_axis(axes, run, "y")
        axes.set(xlim=view.limits[0], ylim=run.time[[0, -1]], xlabel=view.labels[0], ylabel="")
    grid[0].set_ylabel(labelled(run, "t", "s"))
    grid[0].locator_params(axis="x", nbins=4)


def filled(rows: Array, none: float = np.nan) -> Array:
    """Return rows in which points in reserve, of the gases of the paper's method, have what the
    nearest active point has: maps need a place and a value for all. none: what a row without a
    number has.
    """
    rows, index = rows.copy(), np.arange(rows.shape[1])
    for row in rows:
        there = np.isfinite(row)
        row[:] = np.interp(index, index[there], row[there]) if there.any() else none
    return rows
