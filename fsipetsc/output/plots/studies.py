"""Pictures of studies: convergence, flutter.

Each function returns the files that it has written, none without matplotlib or without a run that
went well, and raises FileError if a picture cannot be written.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fsipetsc.checks import counted
from fsipetsc.operators.sbp import operator
from fsipetsc.output.plots.style import GREY, ORDERS, SERIES, STYLE, save, set_title

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fsipetsc.analysis.convergence_table import ConvergenceStudy


class Curves(NamedTuple):
    """Of a Mach number: lambda (n,), s (n, 2) of two modes over sqrt(D/m), by runs and theory."""

    mach: float
    dynamic: np.ndarray
    found: np.ndarray
    fine: np.ndarray
    theory: np.ndarray


def _written(
    path: str | os.PathLike[str], title: str, draw: Callable[[Figure], None]
) -> list[Path]:
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError:
        return []
    with matplotlib.rc_context(STYLE):
        figure = Figure()
        draw(figure)
        set_title(figure, title)
        return [save(figure, path)]


def convergence_figures(study: ConvergenceStudy, path: str | os.PathLike[str]) -> list[Path]:
    """Error over grid spacing and over time, as PATH without suffix + "-error.png", "-cost.png":
    Figs. 6 and 7 of the paper.
    """
    title = f"{study.case}, errors at {study.time}  ({counted(study.ranks, 'rank')})"
    base, drawings = Path(path).with_suffix(""), {"error": draw_errors, "cost": draw_cost}
    written: list[Path] = []
    for name, draw in drawings.items() if study.errors else ():
        written += _written(f"{base}-{name}.png", title, partial(draw, study=study))
    return written


def draw_errors(figure: Figure, study: ConvergenceStudy) -> None:
    """Errors of all unknowns over the grid spacing; in brackets the order of the last refinement.

    A panel for fluid and solid each. Without an exact solution differences of a grid from the next
    finer one, a panel for each layer and one for the series.
    """
    figure.set_size_inches(3.8 * max(2, len(study.errors)), 3.8)
    grid = figure.subplots(1, len(study.errors), sharey=True, squeeze=False)[0]
    for axes, kind in zip(grid, study.errors):
        rates = study.rates(kind)[:, -1 if study.exact else -2]
        for i, order in enumerate(study.orders):
            rate = f"  ({rates[i]:.1f})" if np.isfinite(rates[i]) else ""
            errors = study.errors[kind]["combined"][i]
            errors = np.where(errors > 0, errors, np.nan)  # a logarithmic axis has no place for 0
            axes.loglog(study.hs, errors, **_look(order, rate))
        axes.set_title(kind, loc="left")
        axes.set_xlabel("grid spacing h" + "  [m]" * (study.units == "SI"))
        axes.set_xticks(study.hs, [f"{h:.4g}" for h in study.hs], fontsize=8)
        axes.minorticks_off()
        axes.legend(loc="lower right")
    what = "error" if study.exact else "relative difference\nfrom the next grid"
    grid[0].set_ylabel(f"{what} in {study.norm}, all unknowns")


def draw_cost(figure: Figure, study: ConvergenceStudy) -> None:
    """The largest error of fluid and solid, or of layers and series, over the wall time."""
    figure.set_size_inches(4.8, 3.8)
    axes = figure.subplots()
    largest = np.fmax.reduce([errors["combined"] for errors in study.errors.values()])
    for i, order in enumerate(study.orders):
        errors = np.where(largest[i] > 0, largest[i], np.nan)
        axes.loglog(study.cost["wall_time"][i], errors, **_look(order))
    axes.set_xlabel(f"wall time on {counted(study.ranks, 'rank')}  [s]")
    what = "error" if study.exact else "difference from the next grid"
    axes.set_ylabel(f"{what} in {study.norm},\nthe largest of {' and '.join(study.errors)}")
    axes.legend(loc="lower left")


def _look(order: int, rate: str = "") -> dict[str, Any]:
    color, marker = ORDERS[order]
    label = operator(order).name + rate
    return {"color": color, "marker": marker, "markersize": 4, "label": label}


def flutter_figure(
    curves: Sequence[Curves], critical: float, facts: str, path: str | os.PathLike[str]
) -> list[Path]:
    """Growth and frequency of modes over the dynamic pressure, with a line at the critical one."""

    def draw(figure: Figure) -> None:
        figure.set_size_inches(8.4, 4.0)
        titles = "growth / √(D/m)", "angular frequency / √(D/m)"
        for axes, part, title in zip(figure.subplots(1, 2), (np.real, np.imag), titles):
            for n, one in enumerate(curves):
                look = {"color": SERIES[(n + 1) % len(SERIES)]}
                axes.plot(one.fine, part(one.theory), lw=0.8, **look)
                marks = axes.plot(one.dynamic, part(one.found), ls="", marker="o", ms=4, **look)
                marks[0].set_label(f"M = {one.mach:g}")
            axes.axvline(critical, color=GREY, ls="--", lw=0.8)
            axes.set_title(title, loc="left")
            axes.set_xlabel("λ = 2 q L³ / (D √(M²−1))")
        figure.axes[0].legend(loc="upper left")

    what = "runs (marks), thin panel in quasi-steady flow (lines)"
    title = f"growth of the panel's motion, {facts}: {what}"
    return _written(path, title, draw) if curves else []
