"""Pictures of a convergence study: error against grid spacing and against time (Figs. 6 and 7 of the paper)."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.operators.sbp import operator
from fsipetsc.output.plots.style import ORDERS, STYLE, drawing
from fsipetsc.output.plots.titles import set_title

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fsipetsc.analysis.convergence_table import ConvergenceStudy

def convergence_figures(study: ConvergenceStudy, path: str | os.PathLike[str], note: str = "") -> list[Path]:
    """Draw both pictures beside PATH, as PATH without suffix + "-error.png" and "-cost.png".

    None without matplotlib or without a run that went well.
    note: added to the titles. FileError if they cannot be written.
    """
    try:
        matplotlib = drawing()
        from matplotlib.figure import Figure
    except ImportError:
        return []
    if not study.errors:
        return []
    ranks = f"{study.ranks} rank{'s' * (study.ranks > 1)}"
    title = f"{study.case}, errors at {study.time}  ({ranks}{', ' if note else ''}{note})"
    written = []
    with matplotlib.rc_context(STYLE):
        for name, draw in (("error", draw_errors), ("cost", draw_cost)):
            figure = Figure()
            draw(figure, study)
            set_title(figure, title)
            target = Path(path).with_name(f"{Path(path).stem}-{name}.png")
            try:
                figure.savefig(target)
            except OSError as error:
                raise FileError(f"{target}: cannot write the picture: {error.strerror or error}") from error
            written.append(target)
    return written


def draw_errors(figure: Figure, study: ConvergenceStudy) -> None:
    """Errors of all unknowns together against the grid spacing, a panel for the fluid and one for the solid (Fig. 6).

    Without an exact solution differences of a grid from the next finer one, a panel for each layer and one for the series.
    """
    figure.set_size_inches(3.8 * max(2, len(study.errors)), 3.8)
    for axes, kind in zip(figure.subplots(1, len(study.errors), sharey=True, squeeze=False)[0], study.errors):
        for order, i in _each(study):
            label = operator(order).name + _last_rate(study, kind, i)
            axes.loglog(study.hs, _above_zero(study.errors[kind]["combined"][i]), **_line(order), label=label)
        axes.set_title(kind + ("  (brackets: order of the last refinement)" if len(study.hs) > 1 else ""), loc="left")
        axes.set_xlabel("grid spacing h" + "  [m]" * (study.units == "SI"))
        axes.set_xticks(study.hs, [f"{h:.4g}" for h in study.hs], fontsize=8)
        axes.minorticks_off()
        axes.legend(loc="lower right")
    what = "error" if study.exact else "relative difference from the next grid"
    figure.axes[0].set_ylabel(f"{what} in {study.norm}, all unknowns")


def draw_cost(figure: Figure, study: ConvergenceStudy) -> None:
    """The largest error of fluid and solid, or of layers and series, against the wall time (Fig. 7)."""
    from matplotlib.ticker import LogFormatterSciNotation, NullFormatter

    figure.set_size_inches(4.8, 3.8)
    axes = figure.subplots()
    larger = np.fmax.reduce([study.errors[kind]["combined"] for kind in study.errors])
    for order, i in _each(study):
        axes.loglog(study.wall_time[i], _above_zero(larger[i]), **_line(order), label=operator(order).name)
    low, high = axes.get_xlim()
    first = np.floor(np.log10(low * 1.5))
    axes.set_xlim(10**first, 10 ** max(np.ceil(np.log10(high / 1.5)), first + 1))  # a decade at least
    axes.xaxis.set_major_formatter(LogFormatterSciNotation())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(f"wall time on {study.ranks} rank{'s' * (study.ranks > 1)}  [s]")
    what = "error" if study.exact else "difference from the next grid"
    axes.set_ylabel(f"{what} in {study.norm}, the largest of {' and '.join(study.errors)}")
    axes.legend(loc="lower left")


def _each(study: ConvergenceStudy) -> Iterator[tuple[int, int]]:
    return ((order, i) for i, order in enumerate(study.orders) if np.isfinite(study.wall_time[i]).any())


def _above_zero(errors: np.ndarray) -> np.ndarray:
    """Errors as a logarithmic axis takes them: one that is exactly 0 has no place there."""
    return np.where(errors > 0, errors, np.nan)


def _line(order: int) -> dict[str, Any]:
    color, marker = ORDERS[order]
    return {"color": color, "marker": marker, "markersize": 4}


def _last_rate(study: ConvergenceStudy, kind: str, i: int) -> str:
    """The observed order of the finest refinement, in brackets."""
    rate = study.rates(kind)[i, -1 if study.exact else -2]
    return f"  ({rate:.1f})" if np.isfinite(rate) else ""
