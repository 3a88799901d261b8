"""Pictures of a convergence study: error over grid spacing and over time (Figs. 6, 7 of the paper)."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import operator
from fsipetsc.output.plots.style import ORDERS, STYLE, needed, save, set_title

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fsipetsc.analysis.convergence_table import ConvergenceStudy


def convergence_figures(study: ConvergenceStudy, path: str | os.PathLike[str], note: str = "") -> list[Path]:
    """Draw both pictures beside PATH, as PATH without suffix + "-error.png" and "-cost.png".

    None without matplotlib or without a run that went well. note: added to the titles. FileError
    if they cannot be written.
    """
    try:
        matplotlib = needed("convergence")
    except InputError:
        return []
    if not study.errors:
        return []
    from matplotlib.figure import Figure

    ranks = f"{study.ranks} rank{'s' * (study.ranks > 1)}{', ' if note else ''}{note}"
    written = []
    with matplotlib.rc_context(STYLE):
        for name, draw in (("error", draw_errors), ("cost", draw_cost)):
            figure = Figure()
            draw(figure, study)
            set_title(figure, f"{study.case}, errors at {study.time}  ({ranks})")
            target = Path(path).with_name(f"{Path(path).stem}-{name}.png")
            written.append(save(figure, target))
    return written


def draw_errors(figure: Figure, study: ConvergenceStudy) -> None:
    """Errors of all unknowns together over the grid spacing; brackets: order of the last refinement.

    A panel for fluid and solid each. Without an exact solution differences of a grid from the next
    finer one, a panel for each layer and one for the series.
    """
    figure.set_size_inches(3.8 * max(2, len(study.errors)), 3.8)
    grid = figure.subplots(1, len(study.errors), sharey=True, squeeze=False)[0]
    for axes, kind in zip(grid, study.errors):
        rates = study.rates(kind)[:, -1 if study.exact else -2]
        for order, i in _drawn(study):
            rate = f"  ({rates[i]:.1f})" if np.isfinite(rates[i]) else ""
            label = operator(order).name + rate
            axes.loglog(study.hs, _positive(study.errors[kind]["combined"][i]), **_look(order), label=label)
        axes.set_title(kind, loc="left")
        axes.set_xlabel("grid spacing h" + "  [m]" * (study.units == "SI"))
        axes.set_xticks(study.hs, [f"{h:.4g}" for h in study.hs], fontsize=8)
        axes.minorticks_off()
        axes.legend(loc="lower right")
    what = "error" if study.exact else "relative difference from the next grid"
    grid[0].set_ylabel(f"{what} in {study.norm}, all unknowns")


def draw_cost(figure: Figure, study: ConvergenceStudy) -> None:
    """The largest error of fluid and solid, or of layers and series, over the wall time."""
    figure.set_size_inches(4.8, 3.8)
    axes = figure.subplots()
    largest = np.fmax.reduce([errors["combined"] for errors in study.errors.values()])
    for order, i in _drawn(study):
        look = {**_look(order), "label": operator(order).name}
        axes.loglog(study.wall_time[i], _positive(largest[i]), **look)
    axes.set_xlabel(f"wall time on {study.ranks} rank{'s' * (study.ranks > 1)}  [s]")
    what = "error" if study.exact else "difference from the next grid"
    axes.set_ylabel(f"{what} in {study.norm}, the largest of {' and '.join(study.errors)}")
    axes.legend(loc="lower left")


def _drawn(study: ConvergenceStudy) -> Iterator[tuple[int, int]]:
    """Orders of which a run went well, and their numbers."""
    went_well = np.isfinite(study.wall_time).any(axis=1)
    return ((order, i) for i, order in enumerate(study.orders) if went_well[i])


def _positive(errors: np.ndarray) -> np.ndarray:
    """Errors for a logarithmic axis, which has no place for 0."""
    return np.where(errors > 0, errors, np.nan)


def _look(order: int) -> dict[str, Any]:
    color, marker = ORDERS[order]
    return {"color": color, "marker": marker, "markersize": 4}
