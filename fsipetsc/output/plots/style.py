"""What all pictures share: colors that everybody can tell apart (those of Okabe and Ito), line styles, sizes."""

from __future__ import annotations

import os
import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colorbar import Colorbar
    from matplotlib.figure import FigureBase

BLUE, RED, GREEN, ORANGE, PURPLE, GREY, BLACK = (
    "#0072b2", "#d55e00", "#009e73", "#e69f00", "#a0528c", "#8a8a8a", "#222222",
)  # fmt: skip
COLORS = {"fluid": BLUE, "solid": RED}
SERIES = (BLACK, ORANGE, BLUE, GREEN, PURPLE)  # of lines that stand for interfaces or for balances, in turn
LINES = ("-", "--", "-.", ":")
#: color and marker of an order of accuracy
ORDERS = {2: (GREEN, "s"), 4: (BLUE, "o"), 6: (RED, "^"), 8: (BLACK, "D")}

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
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "figure.constrained_layout.use": True,
    "figure.constrained_layout.w_pad": 0.08,
    "savefig.dpi": 160,
}
MAX_POINTS = 20_000  # of a line; more cannot be seen
SMALL_LEGEND: dict[str, Any] = {"fontsize": 7, "handlelength": 1.4}


def needed(command: str) -> ModuleType:
    """matplotlib, for a command that is nothing without it. InputError where it is not installed."""
    try:
        return drawing()
    except ImportError as error:
        raise InputError(f"{command}: matplotlib is not installed (pip install matplotlib)") from error


def drawing() -> ModuleType:
    """matplotlib, even where MPLBACKEND names no backend that it has: pictures are files and need none.

    ImportError where it is not installed.
    """
    try:
        import matplotlib
    except ValueError:
        named = os.environ.pop("MPLBACKEND", None)
        if named is None:
            raise
        for name in [name for name in sys.modules if name.split(".")[0] == "matplotlib"]:
            del sys.modules[name]  # half loaded
        try:
            import matplotlib
        finally:
            os.environ["MPLBACKEND"] = named
    return matplotlib


def legend_above(axes: Axes, *entries: Any, side: str = "left", columns: int = 1, **look: Any) -> None:
    """A legend above a panel, at this side of it. entries: handles and labels; without them those of the panel."""
    place = {"loc": f"lower {side}", "bbox_to_anchor": (0 if side == "left" else 1, 1), "borderaxespad": 0.1}
    axes.legend(*entries, **place, ncols=columns, **look)


def bar_above(figure: FigureBase, picture: Any, axes: Any, label: str, ticks: int = 4, **look: Any) -> Colorbar:
    """A color bar above panels."""
    from matplotlib.ticker import MaxNLocator

    made = figure.colorbar(picture, ax=axes, location="top", pad=0.02, **look)
    made.set_label(label)
    made.outline.set_visible(False)
    made.locator = MaxNLocator(ticks)
    return made


def in_two_lines(label: str) -> str:
    """A label that may be too long for its axis (`Scale.label`)."""
    return label.replace(", less", ",\nless")


def shade(place: int, count: int) -> Any:
    """The color of a line that is one of several times, the later the darker."""
    from matplotlib import colormaps

    return colormaps["cividis_r"](0.15 + 0.85 * place / max(count - 1, 1))


def thin(n: int) -> slice:
    """Of n points so many that the picture does not get heavy."""
    return slice(None, None, max(1, n // MAX_POINTS))


def envelope(t: np.ndarray, values: np.ndarray, bins: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """The largest value in each of so many equal parts of the steps, and its time: what is left of noise."""
    parts = np.array_split(np.arange(len(t)), min(bins, len(t)))
    at = np.array([part[np.argmax(values[part])] for part in parts])
    return t[at], values[at]
