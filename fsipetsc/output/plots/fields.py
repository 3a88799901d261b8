"""Fields over space at some times: profiles in one dimension, maps on the grids as they are in two.

In three dimensions the maps are those of the plane in the middle of the blocks' second axis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fsipetsc.output.plots.quantities import Quantity
from fsipetsc.output.plots.scales import Scale, colours, extremes, moment, scaled
from fsipetsc.output.plots.style import COLORS, bar_above, few_ticks, legend_above
from fsipetsc.output.reader import BlockLayer, Layer, Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase

Array = np.ndarray
WIDTH = 10.2  # inches, of all panels beside each other
HIGHEST = 4.4  # inches, of a panel
ABOVE = 0.4  # inches, of what stands above and below a panel
BAR = 0.62  # inches, of a colour bar with its label
MARGIN = 0.02  # of the extent, around it
FLAT = 0.1  # of its largest span: a frame in which a field has less shows nothing
ALIKE = 4.0  # gas and solid share a scale that is less than so many times the span of each
THIN = 0.2  # height over width; what is thinner is drawn higher than it is
#: least ratio of width to height -> panels beside each other, and in all
_SHAPES = ((1.25, 2, 4), (0.6, 3, 3), (0.0, 5, 5))
_STRESSES = ("s_xx", "s_yy", "s_zz", "s_xy", "s_yz", "s_xz")
_SAME_UNIT = {"m/s": ("u", "v", "w"), "Pa": ("p", "sigma", *_STRESSES)}


class Shown(NamedTuple):
    """How values of a kind of layer are drawn: scale, arguments of pcolormesh, ends of the bar."""

    scale: Scale
    look: dict[str, Any]
    extend: str


def how_shown(
    run: Run,
    quantity: Quantity,
    values: Mapping[str, Array],
    start: Mapping[str, Array],
    later: Mapping[str, Array],
) -> dict[str, Shown]:
    """Of each kind of layer; one for both where their ranges are alike.

    values, start, later: by kind, all that is drawn, what there is at the start, and what decides
    about colours; flat arrays.
    """
    kinds = sorted(values)  # the colours of the gas, where both kinds have the same
    parts = [quantity.of(kind) for kind in kinds]
    comparable = run.dimension == 1 or parts[0].label == parts[-1].label
    of_all = np.ptp(extremes(*values.values()))
    share = comparable and of_all < ALIKE * min(np.ptp(extremes(v)) for v in values.values())
    beside = largest_beside(run, quantity)
    found = {}
    for some in [kinds] if share else [[kind] for kind in kinds]:
        label = quantity.title if share else quantity.of(some[0]).label
        if len(kinds) > 1 and not share and comparable:
            label = f"{'gas' if some[0] == 'fluid' else 'solid'}: {label}"
        all_, first, some_later = (
            np.concatenate([part[kind] for kind in some]) for part in (values, start, later)
        )
        scale = scaled(run, label, quantity.unit, all_, start=first, beside=beside)
        shown = Shown(scale, *colours(some[0], scale, some_later, first, extremes(all_)))
        found.update(dict.fromkeys(some, shown))
    return found


def largest_beside(run: Run, quantity: Quantity) -> float:
    """Size of what has the same unit, in the last frame."""
    fields = [layer.frame(-1) for layer in run.layers]
    names = _SAME_UNIT.get(quantity.unit, ())
    return max(map(abs, extremes(*(f[name] for f in fields for name in names if name in f))))


class View:
    """A quantity of a run at some frames, and what all of its panels have in common.

    layers   those that have the quantity
    shown    kind of layer -> how it is drawn
    place    the scale of positions
    limits   (left, right), (lower, upper) of a panel, scaled
    labels   of its two axes
    ratio    its width over its height
    """

    shown: dict[str, Shown]
    place: Scale
    limits: list[Array]
    labels: tuple[str, str]
    ratio: float

    def __init__(self, run: Run, quantity: Quantity, frames: Sequence[int]) -> None:
        self.run, self.quantity, self.frames = run, quantity, list(frames)
        self.layers = [layer for layer in run.layers if quantity.of(layer.kind)]

    def values(self, layer: Layer | BlockLayer, frame: int) -> Array:
        """Of a frame, not scaled: (n,), or (m, n) of a map."""
        fields = {"X": layer.X, **layer.frame(frame)}
        return in_plane(self.quantity.of(layer.kind).values(fields))

    def flat(self, frames: Sequence[int]) -> dict[str, Array]:
        """Kind of layer -> all values at these frames, one after the other."""
        found: dict[str, list[Array]] = {}
        for layer in self.layers:
            found.setdefault(layer.kind, []).extend(self.values(layer, k).ravel() for k in frames)
        return {kind: np.concatenate(values) for kind, values in found.items()}


def line_name(run: Run) -> str:
    """Of the coordinate in one dimension."""
    return "r" if run.header.get("symmetry") else "x"


class Profiles(View):
    """In one dimension: curves with one vertical axis."""

    ratio = 1.6

    def __init__(self, run: Run, quantity: Quantity, frames: Sequence[int]) -> None:
        super().__init__(run, quantity, frames)
        every, start = (np.concatenate([*self.flat(some).values()]) for some in (self.frames, [0]))
        scale = scaled(run, quantity.title, quantity.unit, every, start=start)
        self.shown = {layer.kind: Shown(scale, {}, "neither") for layer in self.layers}
        ends = np.array(domain(run, self.layers))
        self.place = scaled(run, line_name(run), "m", ends)
        low, high = extremes(scale(every))
        margin = 2 * MARGIN * (high - low) or 0.1 * abs(low) or 1.0
        self.limits = [self.place(ends), np.array([low - margin, high + margin])]
        self.labels = self.place.label, scale.label.replace(", ", ",\n", 1)

    def draw(self, axes: Axes, frame: int) -> dict[str, Any]:
        """Draw one frame."""
        for layer in self.layers:
            values = self.shown[layer.kind].scale(self.values(layer, frame))
            x = self.place(layer.frame(frame)["x"])
            axes.plot(x, values, color=COLORS[layer.kind], label=layer.kind)
        axes.set(xlim=self.limits[0], ylim=self.limits[1])
        return {}


class Maps(View):
    """In two and three dimensions. The colours are those of the frames after the first one, from
    which all may decay.
    """

    def __init__(self, run: Run, quantity: Quantity, frames: Sequence[int]) -> None:
        super().__init__(run, quantity, frames)
        later = self.flat(self.frames[1:] or self.frames)
        self.shown = how_shown(run, quantity, self.flat(self.frames), self.flat([0]), later)
        pairs = [self.positions(layer, frame) for layer in self.layers for frame in self.frames]
        ranges = np.array([extremes(*along) for along in zip(*pairs)])
        self.place = scaled(run, "x", "m", ranges)
        margin = MARGIN * np.ptp(ranges, axis=1).max() * np.array([-1.0, 1.0])
        self.limits = [*self.place(ranges + margin)]
        label = self.place.label
        self.labels = label, label.replace("x", "y" if run.dimension == 2 else "z", 1)
        self.ratio = float(np.ptp(self.limits[0]) / np.ptp(self.limits[1]))

    def positions(self, layer: BlockLayer, frame: int) -> tuple[Array, Array]:
        """Horizontal and vertical ones, (m, n) each."""
        fields = layer.frame(frame)
        return in_plane(fields["x"]), in_plane(fields["y" if self.run.dimension == 2 else "z"])

    def draw(self, axes: Axes, frame: int) -> dict[str, Any]:
        """Draw one frame; kind of layer -> what there is to make a colour bar of."""
        pictures = {}
        for layer in self.layers:
            shown = self.shown[layer.kind]
            x, y = map(self.place, self.positions(layer, frame))
            values = shown.scale(self.values(layer, frame))
            for axis in layer.rings if self.run.dimension == 2 else ():  # it ends where it begins
                x, y, values = (np.append(v, v.take([0], axis), axis) for v in (x, y, values))
            pictures[layer.kind] = shaded(axes, x, y, values, shown.look)
            if layer.kind == "solid":
                outline(axes, x, y)
        axes.grid(visible=False)
        aspect = "equal" if self.ratio <= 1 / THIN else "auto"
        axes.set(xlim=self.limits[0], ylim=self.limits[1], aspect=aspect)
        return pictures


def view_of(run: Run, quantity: Quantity, frames: Sequence[int]) -> Profiles | Maps:
    """What there is in this dimension."""
    return (Profiles if run.dimension == 1 else Maps)(run, quantity, frames)


def in_plane(values: Array) -> Array:
    """Of three dimensions what lies in the middle of the second axis."""
    return values[:, values.shape[1] // 2] if values.ndim == 3 else values


def domain(run: Run, layers: Sequence[Layer | BlockLayer]) -> tuple[float, float]:
    """The ends of layers in one dimension at all times.

    The last point of an outer gas may be a ghost point, up to a spacing behind a wall: the
    innermost place of an end that moves less than that is the wall.
    """
    ends = []
    for k, out, back in ((0, np.nanmin, np.nanmax), (-1, np.nanmax, np.nanmin)):
        layer = layers[k]
        x = out(layer.x, axis=1)
        outer = layer.kind == "fluid" and layer is run.layers[k] and len(run.layers) > 1
        wall = outer and np.ptp(x) < 1.001 * layer.h
        ends.append(float(back(x) if wall else out(x)))
    return ends[0], ends[1]


def frames_of(run: Run, quantity: Quantity, times: Sequence[float] = ()) -> list[int]:
    """The frames nearest to these times, or evenly from the first that shows something."""
    if times:
        return sorted({run.at(t) for t in times})
    spans = np.zeros(run.nframes)
    for layer in run.layers:
        if part := quantity.of(layer.kind):
            values = part.values({"X": layer.X, **{name: layer[name] for name in part.needs}})
            values = values.reshape(run.nframes, -1)
            spans = np.fmax(spans, np.nanmax(values, axis=1) - np.nanmin(values, axis=1))
    begin = int(np.argmax(spans >= FLAT * spans.max()))
    _, count = shape(view_of(run, quantity, [run.nframes - 1]).ratio)
    return sorted({run.at(t) for t in np.linspace(run.time[begin], run.time[-1], count)})


def shape(ratio: float) -> tuple[int, int]:
    """How many panels of this ratio stand beside each other, and how many are drawn."""
    return next((columns, count) for least, columns, count in _SHAPES if ratio >= least)


def sizes(view: Profiles | Maps) -> tuple[int, float, float]:
    """Columns, width of a panel and height of all of them with their bars [inches]."""
    columns = min(shape(view.ratio)[0], len(view.frames))
    rows = -(-len(view.frames) // columns)
    ratio = min(view.ratio, 1 / THIN)
    width = min(WIDTH / columns - 0.4, HIGHEST * ratio)
    bars = len({id(shown) for shown in view.shown.values() if shown.look})
    return columns, width, rows * (width / ratio + ABOVE) + BAR * bars + 0.45


def draw(figure: FigureBase, view: Profiles | Maps) -> None:
    """A panel for each frame, colour bars or a legend above."""
    columns, width, _ = sizes(view)
    rows = -(-len(view.frames) // columns)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes, frame in zip(grid.flat, view.frames):
        pictures = view.draw(axes, frame)
        axes.set_title(moment(view.run, frame), loc="left")
    for axes in grid.flat[len(view.frames) :]:
        axes.set_visible(False)
    for axes in grid[-1]:
        axes.set_xlabel(view.labels[0])
    for axes in grid[:, 0]:
        axes.set_ylabel(view.labels[1])
    few_ticks(grid[0, 0], width)
    if not pictures and len(view.shown) > 1:
        legend_above(grid[0, -1], side="right")
    draw_bars(figure, view, pictures, list(grid.flat))


def draw_bars(figure: FigureBase, view: View, pictures: Mapping[str, Any], axes: Any) -> None:
    """A colour bar above the panels for each scale."""
    for kind in {id(view.shown[kind]): kind for kind in pictures}.values():
        shown = view.shown[kind]
        bar_above(figure, pictures[kind], axes, shown.scale.label, shown.extend)


def shaded(axes: Axes, x: Array, y: Array, values: Array, look: dict[str, Any]) -> Any:
    """Values on a grid, smooth between its points."""
    values = np.ma.masked_invalid(values)
    return axes.pcolormesh(x, y, values, shading="gouraud", rasterized=True, **look)


def outline(axes: Axes, x: Array, y: Array, inside: int = 8) -> None:
    """The edges of a solid, and some lines of its grid across it, which show how it is deformed."""
    edges = [(x[0], y[0]), (x[-1], y[-1]), (x[:, 0], y[:, 0]), (x[:, -1], y[:, -1])]
    closed = [np.array_equal(edges[k], edges[k + 1]) for k in (0, 2)]
    for edge, skip in zip(edges, np.repeat(closed, 2)):
        if not skip:
            axes.plot(*edge, color="black", linewidth=0.8)
    longer = int(np.argmax(x.shape))
    step = max(1, (x.shape[longer] - 1) // inside)
    for line in range(step, x.shape[longer] - 1, step):
        across = x.take(line, longer), y.take(line, longer)
        axes.plot(*across, color="black", linewidth=0.3, alpha=0.5)
