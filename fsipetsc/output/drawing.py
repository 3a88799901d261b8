"""How pictures look, and pictures of fields over space at some times: profiles in one dimension,
maps on the grids as they are in two; and of fields of one dimension over x and t.

In three dimensions the maps are those of the plane in the middle of the blocks' second axis. The
colours are those of Okabe and Ito, which eyes that do not tell red from green tell apart.
"""

import textwrap
from collections.abc import Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.checks import Array, counted
from fsipetsc.output.file_layout import writing
from fsipetsc.output.quantities import FIELDS, is_si, labelled, there, unit_of, values_of
from fsipetsc.output.reader import Layer, Run

Axes = Figure = Any  # of matplotlib, without which results are read, too

BLUE, RED, GREEN, ORANGE, BLACK = "#0072b2", "#d55e00", "#009e73", "#e69f00", "#222222"
PURPLE = "#cc79a7"
#: kind of layer -> colour, and name in pictures and tables
COLORS, NAMES = {"fluid": BLUE, "solid": RED}, {"fluid": "gas", "solid": "solid"}
#: quantity that has no sign -> its colour map; those of what has one, white where nothing happens
PLAIN = {"p": "viridis", "rho": "cividis", "T": "inferno", "schlieren": "gray_r"}
SIGNED = {"fluid": "RdBu_r", "solid": "PuOr_r"}
#: of lines on maps, seen on any colour; of edges between two blocks of a solid
OUTLINE, JOIN = (("white", 1.8), ("black", 0.8)), (("black", 0.3),)
#: inches: width of all panels beside each other; height of a panel at most, of what stands above
#: and below it, of a colour bar with its label
WIDTH, HIGHEST, ABOVE, BAR = 10.2, 4.4, 0.4, 0.72
MARGIN = 0.02  # of the extent, around it
THIN = 0.2  # height over width; what is thinner is drawn higher than it is
#: width over height; of what is wider, two panels stand beside each other, of what is taller six
WIDE, TALL = 1.25, 0.4
STREAM = 150  # points along each side of a panel, between which streamlines go
NOTHING = 1e-10  # of the values of a unit: what varies by less is round-off
NEAR = 1e-3  # of values that span less of their size, one is subtracted
ALIKE = 0.1  # span of values over the larger one; if gas and solid have more, they share colours
BESIDE = 0.05  # of the span of values so much at least is on either side of white
ROWS = 500  # of a map over x and t, at least

#: of the title of a figure: at the left, broken where it is wider than the figure
TITLE: dict[str, Any] = {"x": 0.01, "ha": "left", "fontsize": 10, "weight": "bold", "wrap": True}
STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.formatter.limits": (-2, 4),
    "axes.formatter.use_mathtext": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "figure.constrained_layout.use": True,
    "figure.constrained_layout.w_pad": 0.08,
    "figure.constrained_layout.h_pad": 0.09,
    "savefig.dpi": 160,
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}


def save(figure: Figure, path: Path) -> Path:
    """Write a figure, in the format that the name ends with. FileError where it cannot be."""
    with writing(path):
        figure.savefig(path, bbox_inches="tight")  # layouts of wide maps cut labels off else
    return path


def of_run(run: Run, what: str) -> str:
    """Return case, what is shown, order, nodes, ranks, and whether the run has ended."""
    at_end = [layer.frame(-1)["x"] for layer in run.layers if run.nframes]
    nodes = sum(np.isfinite(x).sum() for x in at_end)  # points in reserve are no nodes
    ranks = counted(run.summary["ranks"], "rank") + ", unfinished" * (not run.complete)
    return f"{run.case}, {what}  (order {run.options['fsi_order']}, {nodes:,} nodes, {ranks})"


def moment(run: Run, frame: int) -> str:
    """Return the time of a frame, as in titles."""
    return f"t = {run.time[frame]:.4g}{' s' * is_si(run)}"


def panels(figure: Figure, count: int, columns: int) -> list[Axes]:
    """Return so many axes, in rows."""
    rows, columns = -(-count // columns), min(columns, count)
    return [figure.add_subplot(rows, columns, k + 1) for k in range(count)]


def label_y(axes: Axes, text: str) -> None:
    """Label a vertical axis, in lines that fit a low panel; its power of ten at the left."""
    lines = [textwrap.fill(line, 20, break_long_words=False) for line in text.split("\n")]
    axes.set_ylabel("\n".join(lines))
    axes.yaxis.get_offset_text().set_ha("right")


def extremes(*arrays: Array, beyond: float = 0.0) -> tuple[float, float]:
    """The range of all finite values but for so many per cent at either end; 0, 0 of none."""
    known = np.concatenate([np.empty(0), *(a[np.isfinite(a)] for a in arrays)])
    low, high = np.percentile(known, (beyond, 100.0 - beyond)) if known.size else (0.0, 0.0)
    return float(low), float(high)


def rounded(value: float, within: float) -> float:
    """Return the number of fewest digits that is so near to a value, 0 if that is."""
    near = (round(float(value), digits) for digits in range(-12, 18))
    return next((one for one in near if abs(one - value) <= within), float(value))


def legend_above(axes: Axes, side: str = "left", most: int = 5, columns: int = 2) -> None:
    """Draw a legend above a panel, at this side of it, of so many entries at most."""
    entries: dict[str, Any] = dict(zip(*reversed(axes.get_legend_handles_labels())))
    shown = [textwrap.shorten(name, 28, placeholder=" …") for name in entries][:most]
    columns = 1 if max(map(len, shown), default=0) > 12 else columns
    corner = {"loc": f"lower {side}", "bbox_to_anchor": (side == "right", 1)}
    axes.legend([*entries.values()][:most], shown, **corner, ncol=columns, borderaxespad=0.1)


class Wanted(NamedTuple):
    """What the options of `plot` ask for; contours: how many lines."""

    fields: Sequence[str] = ()
    times: Sequence[float] = ()
    contours: int = 0
    streamlines: bool = False


USUAL = Wanted()


class View:
    """A quantity of a run at some frames, and what all of its panels have in common.

    labels   kind of layer that has the quantity -> label
    layers   those that have it, and in two and three dimensions solids
    base     kind of layer -> what is subtracted from values that vary by little, else 0
    scales   kind of layer -> colour map and range, for frames after the start
    bars     label of a colour bar -> the same
    """

    def __init__(self, run: Run, name: str, frames: Sequence[int], wanted: Wanted = USUAL) -> None:
        self.run, self.name, self.wanted, self.frames = run, name, wanted, [*frames]
        self.plane, self.labels, self.unit = run.dimension > 1, there(run)[name], FIELDS[name][1]
        kinds, self.base = {*self.labels, *["solid"] * self.plane}, dict.fromkeys(self.labels, 0.0)
        self.layers = [layer for layer in run.layers if layer.kind in kinds]
        known = [(layer.kind, k, self.at(layer, k)) for layer in self.layers for k in self.frames]
        found = zip(*(of for *_, of in known))
        *ranges, _ = np.array([extremes(*along) for along in found])
        for some in [[kind] for kind in self.labels] if self.plane else [[*self.labels]]:
            values = [of[-1] for kind, _, of in known if kind in some]
            low, high = extremes(*values)
            if NOTHING * max(-low, high) < high - low < NEAR * max(-low, high):
                base = rounded(np.nanmedian(values[0]), high - low)
                self.base |= dict.fromkeys(some, base)
                low, high = low - base, high - base
        self._colour([(kind, k, of[-1] - self.base.get(kind, 0.0)) for kind, k, of in known])
        last = labelled(run, "r" if run.header.get("symmetry") else "xyz"[run.dimension - 1], "m")
        if self.plane:
            margin = MARGIN * np.ptp(ranges, axis=1).max() * np.array([-1.0, 1.0])
            self.limits, self.axes = [*(ranges + margin)], (labelled(run, "x", "m"), last)
            self.ratio = float(np.ptp(self.limits[0]) / np.ptp(self.limits[1]))
        else:
            varies = high - low > NOTHING * max(-low, high)
            margin = 2 * MARGIN * (high - low) * varies or 0.1 * abs(low) or 1.0
            self.limits = [ranges[0], np.array([low - margin, high + margin])]
            title = self._label([*self.labels]).replace("; ", ",\n")
            self.axes, self.ratio = (last, title), 1.6
        self.across = 2 if self.ratio >= WIDE else 3 if self.ratio >= TALL else 6

    def _label(self, kinds: Sequence[str], more: str = "") -> str:
        """Return the label of these kinds, with what is subtracted, more, and the unit."""
        base = self.base[kinds[0]]
        label = "; ".join(dict.fromkeys(self.labels[kind] for kind in kinds))
        if len(kinds) < len(self.labels) and len({*self.labels.values()}) == 1:
            label = f"{NAMES[kinds[0]]}: {label}"
        less = f" less {base:.12g}".replace("-", "−") if base else ""
        return labelled(self.run, label + less + more, self.unit)

    def at(self, layer: Layer, frame: int, more: str = "") -> list[Array]:
        """Return places of a frame, horizontal ones and of maps vertical ones, more fields, and
        values. In two dimensions a periodic block ends with the nodes that it begins with.
        """
        fields = layer.frame(frame)
        found = [fields[x] for x in ("x", "xy", "xz")[self.run.dimension - 1] + more]
        has_it = layer.kind in self.labels
        values = values_of(self.name, layer, fields) if has_it else np.nan * found[0]
        found.append(values - self.base.get(layer.kind, 0.0))
        for axis in (0, 1) if self.run.dimension == 2 else ():
            if layer.periodic[1 - axis]:
                first, second, last = (layer.places.take(k, axis)[0] for k in (0, 1, -1))
                period = last - first + second - first  # from the first node to the end
                if np.linalg.norm(period) < 2.0 * np.linalg.norm(second - first):
                    period = [0.0, 0.0]  # as of an annulus
                moved = [*period, *[0.0] * (len(found) - 2)]
                found = [np.append(v, v.take([0], axis) + P, axis) for v, P in zip(found, moved)]
        return [v[:, v.shape[1] // 2] if v.ndim == 3 else v for v in found]

    def size(self, count: int) -> tuple[int, float, float]:
        """Return columns, width of a panel and height of so many with their bars [inches]."""
        columns = min(self.across, count)
        ratio = min(self.ratio, 1 / THIN)
        width = min(WIDTH / columns - 0.4, HIGHEST * ratio)
        bars = BAR * len(self.bars) * self.plane + 0.45
        return columns, width, -(-count // columns) * (width / ratio + ABOVE) + bars

    def _colour(self, values: Sequence[tuple[str, int, Array]]) -> None:
        """Make scales and bars, from kinds of layers, frames and values. Gas and solid share them
        where their values are alike; what comes through to a solid may be little.
        """
        # initial data may go far beyond what follows
        late = [one for one in values if one[1] > 0 or len(self.frames) == 1]
        of_kind = {kind: [v for of, _, v in late if of == kind] for kind in self.labels}
        spans = [np.ptp(extremes(*of)) for of in of_kind.values()]
        stressed = {"stress" in label for label in self.labels.values()}
        alike = len(stressed) == len({*self.base.values()}) == 1
        alike = alike and min(spans) >= ALIKE * max(spans)
        fields = [of for layer in self.run.layers for of in layer.frame(-1).items()]
        same = extremes(*(of for field, of in fields if unit_of(field) == self.unit))
        self.scales, self.bars = dict[str, dict[str, Any]](), dict[str, dict[str, Any]]()
        for kinds in [[*of_kind]] if alike else [[kind] for kind in of_kind]:
            self._scale(kinds, [v for kind in kinds for v in of_kind[kind]], max(map(abs, same)))

    def _scale(self, kinds: list[str], values: list[Array], beside: float) -> None:
        """Choose colour map and range, beyond which a few values may lie, of these kinds.

        What has both signs is white at 0, stresses at what they are in most of a solid at first.
        Round-off, beside the largest number of the same unit, gets one colour.
        """
        (low, high), inner = extremes(*values), extremes(*values, beyond=0.1)
        size = max(-low, high, beside)
        if inner[1] - inner[0] > NOTHING * size:  # else what happens is in few places
            low, high = inner
        if high - low <= NOTHING * size:
            low, high = (0.5 * (low + high) + sign * (0.1 * size or 1.0) for sign in (-1, 1))
        colours = "cividis" if kinds == ["solid"] else PLAIN.get(self.name, "viridis")
        white, more, stress = 0.0, "", "stress" in self.labels[kinds[0]]
        if stress:
            first = [self.at(layer, 0)[-1].ravel() for layer in self.layers if layer.kind in kinds]
            white = rounded(np.nanmedian(np.concatenate(first)), BESIDE * (high - low))
        beyond = min(white - low, high - white) > BESIDE * (high - low)
        if beyond and (stress or self.name not in PLAIN):
            half, colours = max(white - low, high - white), SIGNED[kinds[0]]
            low, high = white - half, white + half
            more = f", white: {white:.6g}".replace("-", "−") * bool(white)
        scale = {"cmap": colours, "vmin": low, "vmax": high}
        self.scales |= dict.fromkeys(kinds, scale)
        self.bars[self._label(kinds, more)] = scale

    def draw(self, axes: Axes, frame: int) -> None:
        """Draw one frame."""
        axes.set(xlim=self.limits[0], ylim=self.limits[1], xlabel=self.axes[0])
        label_y(axes, self.axes[1])
        found = [(layer.kind, self.at(layer, frame)) for layer in self.layers]
        if not self.plane:
            for kind, of in found:
                axes.plot(*of, color=COLORS[kind], label=NAMES[kind])
            return
        axes.set_aspect("equal" if self.ratio <= 1 / THIN else "auto")
        axes.grid(visible=False)
        for kind, of in found:
            if scale := self.scales.get(kind):
                axes.pcolormesh(*of, shading="gouraud", rasterized=True, **scale)
                levels = np.linspace(scale["vmin"], scale["vmax"], self.wanted.contours + 2)[1:-1]
                low, high = extremes(of[-1])
                if (levels := levels[(low < levels) & (levels < high)]).size:
                    axes.contour(*of, levels, colors="black", linewidths=0.4)
        self._outline(axes, [of[:2] for kind, of in found if kind == "solid"])
        if self.wanted.streamlines:
            self._streamlines(axes, frame)

    def _outline(self, axes: Axes, solids: list[list[Array]]) -> None:
        """Draw edges of solids, those between two blocks thin, and a fine grid, which deforms."""
        sides = (*product((0, 1), (0, -1)),)
        edges = [[v.take(end, k) for v in of] for of, (k, end) in product(solids, sides)]
        places = [frozenset(zip(*edge)) for edge in edges]
        for edge, place in zip(edges, places):
            blocks = [k // len(sides) for k, other in enumerate(places) if other == place]
            if len({*blocks}) == len(blocks):  # else it is the seam of a ring
                for color, width in OUTLINE if len(blocks) == 1 else JOIN:
                    axes.plot(*edge, color=color, linewidth=width)
        for (x, y), axis in product(solids, (0, 1)):
            step = np.hypot(np.diff(x, axis=axis), np.diff(y, axis=axis)).mean()
            every = max(1, round(np.ptp(self.limits, axis=1).max() / (40 * step)))
            grid = [np.moveaxis(v, axis, 1)[:, every::every] for v in (x, y)]
            axes.plot(*grid, color="black", linewidth=0.3, alpha=0.5)

    def _streamlines(self, axes: Axes, frame: int) -> None:
        """Draw lines along the velocities of gases, as they are at a frame."""
        from matplotlib.path import Path as Outline
        from scipy.interpolate import griddata

        x, y = (np.linspace(*bounds, STREAM) for bounds in self.limits)
        points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        flow = np.full(points.shape, np.nan)
        for layer in self.layers:
            if layer.kind == "fluid":
                found = self.at(layer, frame, "uv" if self.run.dimension == 2 else "uw")[:4]
                around = [np.r_[v[0], v[:, -1], v[-1, ::-1], v[::-1, 0]] for v in found[:2]]
                inside = Outline(np.transpose(around)).contains_points(points)
                nodes, velocities = np.reshape(found, (2, 2, -1)).swapaxes(1, 2)
                flow[inside] = griddata(nodes, velocities, points[inside])
        speed = np.linalg.norm(flow, axis=-1)
        flow[speed < 1e-3 * extremes(speed)[1]] = np.nan  # there are no lines where gas rests
        lines = flow.T.reshape(2, STREAM, STREAM)
        axes.streamplot(x, y, *lines, color="white", linewidth=0.5, arrowsize=0.5)


def frames_of(run: Run, name: str, times: Sequence[float] = ()) -> list[int]:
    """Return the frames nearest to these times; if there are none, some of all, evenly."""
    across = View(run, name, [run.nframes - 1]).across
    count = 4 if across == 2 else across
    return sorted({run.at(t) for t in times or np.linspace(run.time[0], run.time[-1], count)})


def draw(figure: Figure, view: View) -> None:
    """A panel for each frame, colour bars or a legend above."""
    columns, width, _ = view.size(len(view.frames))
    grid = panels(figure, len(view.frames), columns)
    for axes, frame in zip(grid, view.frames):
        view.draw(axes, frame)
        axes.set_title(moment(view.run, frame))  # at the left there may be a power of ten
        axes.label_outer()
        axes.locator_params(axis="x", nbins=min(4, int(1 + 2 * width)))
    if view.plane:
        draw_bars(figure, view, grid)
    elif len(view.labels) > 1:
        legend_above(grid[columns - 1], side="right")


def draw_bars(figure: Figure, view: View, axes: Any) -> None:
    """Draw colour bars above one panel, or a list of them."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    wide = isinstance(axes, list)
    size = {"aspect": 50, "shrink": 0.7} if wide else {"aspect": 25}
    for label, scale in view.bars.items():
        colours = ScalarMappable(Normalize(scale["vmin"], scale["vmax"]), scale["cmap"])
        bar = figure.colorbar(colours, ax=axes, location="top", pad=0.02, **size)
        bar.set_label(label, loc="left")
        bar.outline.set_visible(False)
        bar.ax.locator_params(nbins=6 if wide else 4)


def draw_over_time(figure: Figure, run: Run, names: Sequence[str]) -> None:
    """Draw a map of each quantity over x and t, with the interfaces as lines. Points in reserve, of
    gases of the paper's method, have what the nearest active point has.
    """
    grid = figure.subplots(1, len(names), sharex=True, sharey=True, squeeze=False)[0]
    t = np.linspace(*run.time[[0, -1]], max(run.nframes, ROWS))  # triangles of few frames show
    at_times = partial(np.interp, t, run.time)
    for axes, name in zip(grid, names):
        view = View(run, name, range(run.nframes))
        for layer in view.layers:
            X, rows = layer.X, [view.at(layer, frame) for frame in view.frames]
            active = [(x, values, np.isfinite(values)) for x, values in rows]
            x = X + [np.interp(X, X[at], (x - X)[at]) for x, _, at in active]
            values = [np.interp(X, X[at], values[at]) for _, values, at in active]
            x, values = (np.apply_along_axis(at_times, 0, of) for of in (x, values))
            scale = view.scales[layer.kind]
            axes.pcolormesh(x, t, values, shading="gouraud", rasterized=True, **scale)
        lines = run.series.get("x_interface", np.empty((0, 0))).T
        for x, (color, width) in product(lines, OUTLINE):
            axes.plot(x, run.series["t"], color=color, linewidth=width)
        draw_bars(figure, view, axes)
        axes.set(xlim=view.limits[0], ylim=run.time[[0, -1]], xlabel=view.axes[0])
        axes.grid(visible=False)
    grid[0].set_ylabel(labelled(run, "t", "s"))
    grid[0].locator_params(axis="x", nbins=4)
