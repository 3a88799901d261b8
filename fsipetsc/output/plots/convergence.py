"""The picture of a convergence study: errors over the grid spacing, and over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.checks import counted
from fsipetsc.operators.sbp import operator
from fsipetsc.output.plots.style import ORDERS, STYLE, Axes, save, set_title

if TYPE_CHECKING:
    from fsipetsc.analysis.convergence_table import Study


def convergence_figure(study: Study, path: Path) -> list[Path]:
    """Figs. 6 and 7 of the paper: a panel for fluid and solid each, or for each layer and the
    series, and one over the wall time.

    Returns the file, none without matplotlib or without a run that went well. FileError.
    """
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError:
        return []
    if not study.errors:
        return []
    with matplotlib.rc_context(STYLE):
        kinds = list(dict.fromkeys(kind for kind, _ in study.errors))
        count = len(kinds) + 1
        figure = Figure(figsize=(3.4 * count, 3.8))
        grid = figure.subplots(1, count, sharey=True, squeeze=False)[0]
        for axes, kind in zip(grid, kinds):
            _over_spacing(axes, study, kind)
        _over_time(grid[-1], study)
        what = "error" if study.exact else "relative difference\nfrom the next grid"
        grid[0].set_ylabel(f"{what} in {study.norm}, all unknowns")
        set_title(figure, f"{study.case}, errors at {study.time}")
        return [save(figure, path)]


def _over_spacing(axes: Axes, study: Study, kind: str) -> None:
    """Errors of all unknowns of a kind; in brackets the order of the last refinement."""
    rates = study.rates(kind)[:, -1 if study.exact else -2]
    for i, order in enumerate(study.orders):
        rate = f"  ({rates[i]:.1f})" if np.isfinite(rates[i]) else ""
        _curve(axes, np.array(study.hs), study.errors[kind, "combined"][i], order, rate)
    axes.set_title(kind, loc="left")
    axes.set_xlabel("grid spacing h" + "  [m]" * (study.units == "SI"))
    axes.set_xticks(study.hs, [f"{h:.4g}" for h in study.hs], fontsize=8)
    axes.minorticks_off()
    axes.legend(loc="lower right")


def _over_time(axes: Axes, study: Study) -> None:
    """The largest error of all kinds."""
    largest = np.fmax.reduce([e for (_, name), e in study.errors.items() if name == "combined"])
    for i, order in enumerate(study.orders):
        _curve(axes, study.cost["wall_time"][i], largest[i], order)
    axes.set_title("the largest of these", loc="left")
    axes.set_xlabel(f"wall time on {counted(study.ranks, 'rank')}  [s]")


def _curve(axes: Axes, x: np.ndarray, errors: np.ndarray, order: int, rate: str = "") -> None:
    color, marker = ORDERS[order]
    errors = np.where(errors > 0, errors, np.nan)  # a logarithmic axis has no place for 0
    label = operator(order).name + rate
    axes.loglog(x, errors, color=color, marker=marker, markersize=4, label=label)
