"""What all pictures share: colours, line styles, sizes, numbers at axes, legends, bars, titles.

The colours are those of Okabe and Ito, which eyes that do not tell red from green tell apart.
"""

import os
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.checks import counted
from fsipetsc.operators.sbp import operator
from fsipetsc.output.file_layout import writing
from fsipetsc.output.quantities import is_si
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
#: colour maps, white where nothing happens
MAPS = {"fluid": "RdBu_r", "solid": "PuOr_r"}
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
#: the largest value may be so much more than the 99.8th percentile before colours end there
ROBUST = 1.25

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
    said = run.options["fsi_h"]
    sizes = [layer.h or said for layer in run.layers] if run.dimension == 1 else [said]
    h = " to ".join(dict.fromkeys(f"{size:.4g}" for size in (min(sizes), max(sizes))))
    ranks = counted(run.summary["ranks"], "rank") + ", unfinished" * (not run.complete)
    return f"{run.case}, {what}  (order {order}, h = {h}{' m' * is_si(run)}, {ranks})"


def labelled(run: Run, label: str, unit: str) -> str:
    """With the unit in brackets, where there is one."""
    return f"{label}  [{unit}]" if unit and is_si(run) else label


def moment(run: Run, frame: int) -> str:
    """When a frame is, as titles say it: in ms or µs in short runs."""
    from matplotlib.ticker import EngFormatter

    if not is_si(run):
        return f"t = {run.time[frame]:.4g}"
    number = EngFormatter("s", useMathText=False)
    return f"t = {number.format_data(float(f'{run.time[frame]:.4g}'))}"


def time_axis(axes: Axes, run: Run, which: str = "x") -> None:
    """An axis over the whole run, with prefixes of seconds at its numbers."""
    from matplotlib.ticker import EngFormatter

    axis = getattr(axes, f"{which}axis")
    axis.set_label_text("t")
    axes.locator_params(axis=which, nbins=4 if which == "x" else 8)
    if is_si(run):
        axis.set_major_formatter(EngFormatter("s", useMathText=False))
    times = np.concatenate([run.time, run.series.get("t", [])])
    axes.set(**{f"{which}lim": (times.min(), times.max())})


def panels(figure: FigureBase, count: int, columns: int, **more: Any) -> Array:
    """Axes in rows of so many, those that are too many invisible."""
    columns = min(columns, count)
    grid = figure.subplots(-(-count // columns), columns, squeeze=False, **more)
    for axes in grid.flat[count:]:
        axes.set_visible(False)
    return grid


def label_y(axes: Axes, text: str) -> None:
    """The label of a vertical axis, broken so that its lines fit the height of a low panel.

    The axis's power of ten stays off legends and titles.
    """
    name, bracket, unit = text.partition("[")
    whole = name + bracket + unit.replace(" ", "\u00a0")  # no line ends within a unit
    lines = [textwrap.fill(line, WIDEST, break_long_words=False) for line in whole.split("\n")]
    axes.set_ylabel("\n".join(lines))
    axes.yaxis.get_offset_text().set_ha("right")


def extremes(*arrays: Array) -> tuple[float, float]:
    """Smallest and largest of all finite values; 0, 0 if there are none."""
    known = np.concatenate([np.empty(0), *(np.ravel(a[np.isfinite(a)]) for a in arrays)])
    return (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)


def colours(
    kind: str, values: Array, start: Array, beside: float = 0.0, moving: bool = False
) -> dict[str, Any]:
    """Arguments of pcolormesh for values; white is the median of the values at the start, or 0 if
    these are velocities (moving) that stay closer to 0 than to that median.

    Colours end at the 99.8th percentile of the departures from white where a few points go far
    beyond. beside: size of what has the same unit, beside which round-off is nothing.
    """
    low, high = extremes(values)
    known = start[np.isfinite(start)]
    rest = float(np.median(known)) if known.size else low
    if moving and max(-low, high) < max(rest - low, high - rest):
        rest = 0.0
    away = np.abs(values[np.isfinite(values)] - rest)
    most = float(away.max(initial=0.0))
    half = float(np.percentile(away, 99.8)) if away.size else 0.0
    half = half if most > ROBUST * half > 0 else most
    if high - low <= NOTHING * max(abs(low), abs(high), beside):
        half = 0.1 * max(abs(low), abs(high), beside) or 1.0
    return {"cmap": MAPS[kind], "vmin": rest - half, "vmax": rest + half}


def shaded(axes: Axes, x: Array, y: Array, values: Array, scale: dict[str, Any]) -> Any:
    """Values on a grid, smooth between its points."""
    values = np.ma.masked_invalid(values)
    axes.grid(visible=False)
    return axes.pcolormesh(x, y, values, shading="gouraud", rasterized=True, **scale)


def legend_above(axes: Axes, side: str = "left") -> None:
    """A legend above a panel, at this side of it, of five entries at most."""
    entries: dict[str, Any] = dict(zip(*reversed(axes.get_legend_handles_labels())))
    names = list(entries)[:5]
    if names:
        corner = (0, 1) if side == "left" else (1, 1)
        place = {"loc": f"lower {side}", "bbox_to_anchor": corner, "borderaxespad": 0.1}
        columns = 1 if max(map(len, names)) > 12 else 2
        axes.legend([entries[name] for name in names], names, ncol=columns, **place)
