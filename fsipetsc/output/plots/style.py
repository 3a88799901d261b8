"""What all pictures share: colours, line styles, sizes, numbers at axes, legends, bars, titles.

The colours are those of Okabe and Ito, which eyes that do not tell red from green tell apart.
"""

import os
import textwrap
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.checks import counted
from fsipetsc.operators.sbp import operator
from fsipetsc.output.file_layout import writing
from fsipetsc.output.quantities import is_si, unit_of
from fsipetsc.output.reader import Run

if TYPE_CHECKING:  # results are read without matplotlib, too
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase
    from matplotlib.text import Text
else:
    Axes = Figure = FigureBase = Text = Any

Array = np.ndarray

BLUE, RED, GREEN, ORANGE, BLACK = "#0072b2", "#d55e00", "#009e73", "#e69f00", "#222222"
PURPLE = "#cc79a7"
COLORS = {"fluid": BLUE, "solid": RED}
#: colour maps of what has a sign, white where nothing happens, and of what has none
SIGNED = {"fluid": "RdBu_r", "solid": "PuOr_r"}
PLAIN = {"fluid": "viridis", "fluid rho": "cividis", "fluid T": "inferno", "solid": "cividis"}
#: of a line on maps, to be seen on any colour
OUTLINE = ("white", 1.8), ("black", 0.8)
PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
#: colours and line styles of curves in one panel, in turn
CURVES = {
    "color": [BLACK, ORANGE, BLUE, GREEN, PURPLE] * 4,
    "linestyle": ["-", "--", "-.", ":"] * 5,
}
#: colour and marker of an order of accuracy
ORDERS = {2: (GREEN, "s"), 4: (BLUE, "o"), 6: (RED, "^"), 8: (BLACK, "D")}
MAX_POINTS = 5000  # of a line
WIDEST = 20  # letters in a line of the label of a vertical axis
#: what varies by less than this part of the values of its unit is round-off
NOTHING = 1e-10
#: values may span so much more than 99.8 % of them before colours end with these
ROBUST = 1.25
#: of the span of values at least so much is on either side of white
BESIDE = 0.05

STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.linewidth": 0.8,
    "axes.formatter.limits": (-2, 4),
    "axes.formatter.use_mathtext": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "legend.handlelength": 1.6,
    "figure.constrained_layout.use": True,
    "figure.constrained_layout.w_pad": 0.08,
    "figure.constrained_layout.h_pad": 0.09,
    "savefig.dpi": 160,
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}


def save(figure: Figure, target: str | os.PathLike[str]) -> Path:
    """Write a figure, in the format that the name ends with. FileError where it cannot be."""
    path = Path(target)
    with writing(path):
        figure.savefig(path, bbox_inches="tight")  # layouts of wide maps cut labels off else
    return path


def set_title(figure: Figure, title: str) -> Text:
    """The title of the whole figure, at the top left, broken where it is wider than the figure."""
    return figure.suptitle(title, x=0.01, ha="left", fontsize=10, weight="bold", wrap=True)


def of_run(run: Run, what: str) -> str:
    """What is shown, then case, order, grid spacing, ranks, and whether the run has ended."""
    order = operator(run.options["fsi_order"]).name
    h = f"{run.options['fsi_h']:g}{' m' * is_si(run)}"
    ranks = counted(run.summary["ranks"], "rank") + ", unfinished" * (not run.complete)
    return f"{run.case}, {what}  (order {order}, h = {h}, {ranks})"


@lru_cache(maxsize=16)
def prefixed(run: Run, unit: str, kind: str = "fluid") -> tuple[float, str]:
    """How large the unit is in which pictures of a run have what is in s, m, Pa, and its name.

    It is that of the time at the end, of the largest coordinate, of the largest pressure or stress
    of this kind of layer in the last frame; kind "step": of the largest step. Of a run without
    units it is 1, and has no name.
    """
    sizes, power = np.zeros(1), 0
    if not is_si(run):
        return 1.0, ""
    if unit == "s":
        sizes = run.series["dt"] if kind == "step" else run.time
    elif unit == "m":
        sizes = np.concatenate([np.ravel(layer.places) for layer in run.layers])
    elif unit == "Pa" and run.nframes:
        fields = (layer.frame(-1) for layer in run.layers if layer.kind == kind)
        sizes = np.array(
            [extremes(v) for of in fields for k, v in of.items() if unit_of(k) == unit]
        )
    if size := np.abs(sizes).max(initial=0.0):
        power = int(np.clip(3 * np.floor(np.log10(size) / 3 + 1e-9), -9, 9))
    return 10.0**power, PREFIXES[power] + unit


def set_unit(run: Run, axis: Any, label: str, unit: str, kind: str = "fluid") -> None:
    """Label an axis, and give its numbers the unit that pictures of this run have them in."""
    size, unit = prefixed(run, unit, kind)
    axis.set_label_text(label + f"  [{unit}]" * bool(unit))
    if size != 1.0:
        axis.set_major_formatter(lambda v, _: number(v / size))


def number(value: float) -> str:
    """As axes have it, with a minus sign."""
    return f"{value:.6g}".replace("-", "\u2212")


def moment(run: Run, frame: int) -> str:
    """When a frame is, as titles say it."""
    size, unit = prefixed(run, "s")
    return f"t = {run.time[frame] / size:.4g} {unit}".rstrip()


def time_axis(axes: Axes, run: Run, which: str = "x") -> None:
    """An axis over the whole run."""
    set_unit(run, getattr(axes, f"{which}axis"), "t", "s")
    axes.locator_params(axis=which, nbins=4 if which == "x" else 8)
    times = np.concatenate([run.time, run.series.get("t", [])])
    axes.set(**{f"{which}lim": (times.min(), times.max())})


def panels(figure: FigureBase, count: int, columns: int, **more: Any) -> Array:
    """Axes in rows of so many, those that are too many invisible."""
    columns = min(columns, count)
    grid = figure.subplots(-(-count // columns), columns, squeeze=False, **more)
    for axes in grid.flat[count:]:
        axes.set_visible(False)
    return grid


def label_y(axes: Axes, run: Run, label: str, unit: str, kind: str = "fluid") -> None:
    """The label of a vertical axis, broken so that its lines fit the height of a low panel.

    The axis's power of ten stays off legends and titles.
    """
    set_unit(run, axes.yaxis, label, unit, kind)
    name, bracket, unit = axes.get_ylabel().partition("[")
    whole = name + bracket + unit.replace(" ", "\u00a0")  # no line ends within a unit
    lines = [textwrap.fill(line, WIDEST, break_long_words=False) for line in whole.split("\n")]
    axes.set_ylabel("\n".join(lines))
    axes.yaxis.get_offset_text().set_ha("right")


def extremes(*arrays: Array) -> tuple[float, float]:
    """Smallest and largest of all finite values; 0, 0 if there are none."""
    known = np.concatenate([np.empty(0), *(np.ravel(a[np.isfinite(a)]) for a in arrays)])
    return (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)


def colours(
    values: Array, rest: float | None, maps: tuple[str, str], beside: float = 0.0
) -> dict[str, Any]:
    """Arguments of pcolormesh for values. Those on both sides of `rest` get the first of the maps,
    which is white there; others, and all where `rest` is None, get the second.

    Colours end where 99.8 % of the values do, where a few go far beyond. beside: size of what has
    the same unit, beside which round-off is nothing.
    """
    low, high = extremes(values)
    inner = np.percentile(values[np.isfinite(values)], [0.1, 99.9]) if low < high else [low, high]
    if high - low > ROBUST * (inner[1] - inner[0]) > 0:
        low, high = map(float, inner)
    size, middle = max(abs(low), abs(high), beside), 0.5 * (low + high)
    if high - low <= NOTHING * size:
        low, high = middle - (0.1 * size or 1.0), middle + (0.1 * size or 1.0)
    if rest is not None and abs(rest) < BESIDE * (high - low):
        rest = 0.0
    if rest is not None and min(rest - low, high - rest) > BESIDE * (high - low):
        half = max(rest - low, high - rest)
        return {"cmap": maps[0], "vmin": rest - half, "vmax": rest + half}
    return {"cmap": maps[1], "vmin": low, "vmax": high}


def shaded(axes: Axes, x: Array, y: Array, values: Array, scale: dict[str, Any]) -> Any:
    """Values on a grid, smooth between its points."""
    values = np.ma.masked_invalid(values)
    axes.grid(visible=False)
    return axes.pcolormesh(x, y, values, shading="gouraud", rasterized=True, **scale)


def refined(values: Array, points: int, axis: int, degree: int) -> Array:
    """So many points along an axis, by polynomials of this degree through those nearest."""
    last = values.shape[axis] - 1
    degree = min(degree, last)
    at = np.arange(points) * last / max(1, points - 1)
    begin = np.clip(at.astype(int) - (degree - 1) // 2, 0, last - degree)
    found: Any = 0.0
    for k in range(degree + 1):
        parts = [(at - begin - j) / (k - j) for j in range(degree + 1) if j != k]
        weights = np.prod(parts, axis=0) if parts else np.ones(points)
        found = found + weights * np.moveaxis(values.take(begin + k, axis), axis, -1)
    return np.moveaxis(found, -1, axis)


def legend_above(axes: Axes, side: str = "left") -> None:
    """A legend above a panel, at this side of it, of five entries at most."""
    entries: dict[str, Any] = dict(zip(*reversed(axes.get_legend_handles_labels())))
    names = list(entries)[:5]
    if names:
        corner = (0, 1) if side == "left" else (1, 1)
        place = {"loc": f"lower {side}", "bbox_to_anchor": corner, "borderaxespad": 0.1}
        columns = 1 if max(map(len, names)) > 12 else 2
        axes.legend([entries[name] for name in names], names, ncol=columns, **place)
