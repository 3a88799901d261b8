"""What all pictures share: colours, line styles, sizes, numbers at axes, legends, bars, titles.

The colours are those of Okabe and Ito, which eyes that do not tell red from green tell apart.
"""

import os
import textwrap
from pathlib import Path
from typing import Any

import numpy as np

from fsipetsc.checks import Array, counted
from fsipetsc.output.file_layout import writing
from fsipetsc.output.quantities import is_si
from fsipetsc.output.reader import Run

Axes = Figure = FigureBase = Any  # of matplotlib, without which results are read, too

BLUE, RED, GREEN, ORANGE, BLACK = "#0072b2", "#d55e00", "#009e73", "#e69f00", "#222222"
COLORS = {"fluid": BLUE, "solid": RED}
#: colour maps of what has a sign, white where nothing happens, and of what has none
SIGNED = {"": "RdBu_r", "solid": "PuOr_r"}
PLAIN = {"": "viridis", "rho": "cividis", "T": "inferno", "schlieren": "gray_r", "solid": "cividis"}
#: of lines on maps, seen on any colour
OUTLINE = ("white", 1.8), ("black", 0.8)
#: colours and line styles of curves in one panel, in turn
CURVES = {
    "color": [BLACK, ORANGE, BLUE, GREEN, "#cc79a7"] * 4,
    "linestyle": ["-", "--", "-.", ":"] * 5,
}
LONGEST = 28  # letters in a legend
WIDEST = 20  # letters in a line of the label of a vertical axis
NOTHING = 1e-10  # of the values of a unit: what varies by less is round-off
ROBUST = 1.25  # times the span of 99.8 % of the values: if all span more, colours end with these
BESIDE = 0.05  # of the span of values is at least on either side of white

STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
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


def set_title(figure: Figure, title: str) -> Any:
    """Write the title at the top left, broken where it is wider than the figure."""
    return figure.suptitle(title, x=0.01, ha="left", fontsize=10, weight="bold", wrap=True)


def of_run(run: Run, what: str) -> str:
    """Return case, what is shown, order, spacing, ranks, and whether the run has ended."""
    order, h = run.options["fsi_order"], run.options["fsi_h"]
    sizes = [layer.h or h for layer in run.layers] if run.dimension == 1 else [h]
    h = " to ".join(dict.fromkeys(f"{size:.4g}" for size in (min(sizes), max(sizes))))
    ranks = counted(run.summary["ranks"], "rank") + ", unfinished" * (not run.complete)
    return f"{run.case}, {what}  (order {order}, h = {h}{' m' * is_si(run)}, {ranks})"


def labelled(run: Run, label: str, unit: str) -> str:
    """Return a label with the unit in brackets, where there is one."""
    return f"{label}  [{unit}]" if unit and is_si(run) else label


def moment(run: Run, frame: int) -> str:
    """Return when a frame is, as titles say it."""
    return f"t = {run.time[frame]:.4g}{' s' * is_si(run)}"


def panels(figure: FigureBase, count: int, columns: int, **more: Any) -> Array:
    """Return so many axes, in rows."""
    columns = min(columns, count)
    grid = figure.subplots(-(-count // columns), columns, squeeze=False, **more)
    for axes in grid.flat[count:]:
        axes.set_visible(False)
    return grid.ravel()[:count]


def label_y(axes: Axes, text: str) -> None:
    """Label a vertical axis, in lines that fit a low panel; its power of ten at the left."""
    name, bracket, unit = text.partition("[")
    whole = name + bracket + unit.replace(" ", "\u00a0")  # no line ends within a unit
    lines = [textwrap.fill(line, WIDEST, break_long_words=False) for line in whole.split("\n")]
    axes.set_ylabel("\n".join(lines))
    axes.yaxis.get_offset_text().set_ha("right")


def extremes(*arrays: Array) -> tuple[float, float]:
    """Return smallest and largest of all finite values; 0, 0 if there are none."""
    known = np.concatenate([np.empty(0), *(np.ravel(a[np.isfinite(a)]) for a in arrays)])
    return (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)


def colours(values: Array, signed: bool, name: str, beside: float) -> dict[str, Any]:
    """Return colour map and range of values. Signed ones on both sides of 0 get a map of SIGNED,
    white there, others one of PLAIN; name: of the map.

    Colours end where 99.8 % of the values do, where a few go far beyond. beside: size of what
    has the same unit, beside which round-off is nothing.
    """
    low, high = extremes(values)
    inner = np.nanpercentile(values, [0.1, 99.9]) if low < high else (low, high)
    if high - low > ROBUST * (inner[1] - inner[0]) > 0:
        low, high = map(float, inner)
    size, middle = max(-low, high, beside), 0.5 * (low + high)
    if high - low <= NOTHING * size:
        low, high = middle - (0.1 * size or 1.0), middle + (0.1 * size or 1.0)
    maps = PLAIN
    if signed and min(-low, high) > BESIDE * (high - low):
        maps, high = SIGNED, max(-low, high)
        low = -high
    return {"cmap": maps.get(name, maps[""]), "vmin": low, "vmax": high}


def legend_above(axes: Axes, side: str = "left") -> None:
    """Draw a legend above a panel, at this side of it, of five entries at most."""
    entries: dict[str, Any] = dict(zip(*reversed(axes.get_legend_handles_labels())))
    if names := list(entries)[:5]:
        shown = [textwrap.shorten(name, LONGEST, placeholder=" …") for name in names]
        more = {"ncol": 1 if max(map(len, shown)) > 12 else 2, "borderaxespad": 0.1}
        corner = {"loc": f"lower {side}", "bbox_to_anchor": (side == "right", 1)}
        axes.legend([entries[name] for name in names], shown, **corner, **more)
