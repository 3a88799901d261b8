"""What all pictures share: colours, line styles, sizes, legends, colour bars, titles.

The colours are those of Okabe and Ito, which eyes that do not tell red from green tell apart.
"""

from __future__ import annotations

import os
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import operator
from fsipetsc.output.file_layout import writing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase

    from fsipetsc.output.reader import Run

BLUE, RED, GREEN, ORANGE, PURPLE, GREY, BLACK = (
    "#0072b2", "#d55e00", "#009e73", "#e69f00", "#a0528c", "#8a8a8a", "#222222",
)  # fmt: skip
COLORS = {"fluid": BLUE, "solid": RED}
#: colour maps, white where nothing happens
MAPS = {"fluid": "RdBu_r", "solid": "PuOr_r"}
#: colours and line styles of curves in one panel, in turn
SERIES = (BLACK, ORANGE, BLUE, GREEN, PURPLE)
LINES = ("-", "--", "-.", ":")
#: colour and marker of an order of accuracy
ORDERS = {2: (GREEN, "s"), 4: (BLUE, "o"), 6: (RED, "^"), 8: (BLACK, "D")}
MAX_POINTS = 5000  # of a line
TICK = 0.55  # inches, of the number at a tick of a horizontal axis

STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.linewidth": 0.8,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 5),
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


def needed(command: str) -> ModuleType:
    """matplotlib. InputError where it is not installed."""
    try:
        import matplotlib
    except ImportError as error:
        wanted = "matplotlib is not installed (pip install matplotlib)"
        raise InputError(f"{command}: {wanted}") from error
    return matplotlib


def save(figure: Figure, target: str | os.PathLike[str]) -> Path:
    """Write a figure, in the format that the name ends with. FileError where it cannot be."""
    path = Path(target)
    with writing(path):
        figure.savefig(path)
    return path


def set_title(figure: Figure, title: str) -> None:
    """The title of the whole figure, at the top left, broken where it is wider than the figure."""
    figure.suptitle(title, x=0.01, ha="left", fontsize=10, weight="bold", wrap=True)


def of_run(run: Run, what: str) -> str:
    """What is shown, then case, order, grid spacing, ranks, and whether the run has ended."""
    facts = []
    if "fsi_order" in run.options:
        facts.append(f"order {operator(run.options['fsi_order']).name}")
    if "fsi_h" in run.options:
        si = run.header.get("units", "SI") == "SI"
        facts.append(f"h = {run.options['fsi_h']:g}{' m' if si else ''}")
    if "ranks" in run.summary:
        ranks = run.summary["ranks"]
        facts.append(f"{ranks} rank{'s' * (ranks > 1)}")
    if not run.complete:
        facts.append("unfinished")
    return f"{run.case}, {what}" + (f"  ({', '.join(facts)})" if facts else "")


def legend_above(axes: Axes, side: str = "left", most: int = 5) -> None:
    """A legend above a panel, at this side of it, of so many entries at most."""
    entries: dict[str, Any] = dict(zip(*reversed(axes.get_legend_handles_labels())))
    names = list(entries)
    if len(names) > most:
        names, entries = [*names[: most - 1], "…"], {**entries, "…": entries[names[most - 1]]}
    if names:
        corner = (0, 1) if side == "left" else (1, 1)
        place = {"loc": f"lower {side}", "bbox_to_anchor": corner, "borderaxespad": 0.1}
        columns = 1 if max(map(len, names)) > 12 else 2
        axes.legend([entries[name] for name in names], names, ncol=columns, **place)


def bar_above(figure: FigureBase, picture: Any, axes: Any, label: str, extend: str) -> None:
    """A colour bar above panels; extend: at which ends values lie beyond it."""
    from matplotlib.ticker import MaxNLocator

    wide = isinstance(axes, list)
    look = {"aspect": 50, "shrink": 0.7} if wide else {"aspect": 25}
    made = figure.colorbar(picture, ax=axes, location="top", pad=0.02, extend=extend, **look)
    made.set_label(label)
    made.outline.set_visible(False)
    made.locator = MaxNLocator(6 if wide else 4)
    made.update_ticks()


def line_look(k: int) -> dict[str, Any]:
    """Colour and style of curve k in a panel."""
    return {"color": SERIES[k % len(SERIES)], "linestyle": LINES[k % len(LINES)]}


def few_ticks(axes: Axes, width: float) -> None:
    """So many at the horizontal axis that their numbers have room in this width [inches]."""
    from matplotlib.ticker import MaxNLocator

    axes.xaxis.set_major_locator(MaxNLocator(max(1, min(6, int(width / TICK)))))
