"""The picture of a convergence study: errors over the grid spacing, and over time."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fsipetsc.checks import counted
from fsipetsc.operators.sbp import operator
from fsipetsc.output.plots.style import ORDERS, STYLE, Axes, save, set_title
from fsipetsc.studies.convergence_table import Study


def convergence_figure(study: Study, path: Path) -> list[Path]:
    """Figs. 6 and 7 of the paper: a panel for fluid and solid each, or for each layer and the
    series, with the order of the last refinement in brackets; one over the wall time.

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
        *of_kinds, last = figure.subplots(1, count, sharey=True, squeeze=False)[0]
        for axes, kind in zip(of_kinds, kinds):
            rates = study.rates(kind)[:, -1 if study.exact else -2]
            names = [f"  ({rate:.1f})" if np.isfinite(rate) else "" for rate in rates]
            hs = np.tile(study.hs, (len(study.orders), 1))
            _curves(axes, study, hs, study.errors[kind, "combined"], names)
            axes.set_title(kind, loc="left")
            axes.set_xlabel("grid spacing h" + "  [m]" * (study.units == "SI"))
            axes.set_xticks(study.hs, [f"{h:.4g}" for h in study.hs], fontsize=8)
            axes.minorticks_off()
            axes.legend(loc="lower right")
        largest = np.fmax.reduce([study.errors[kind, "combined"] for kind in kinds])
        _curves(last, study, study.cost["wall_time"], largest, [""] * len(study.orders))
        last.set_title("the largest of these", loc="left")
        last.set_xlabel(f"wall time on {counted(study.ranks, 'rank')}  [s]")
        what = "error" if study.exact else "relative difference\nfrom the next grid"
        of_kinds[0].set_ylabel(f"{what} in {study.norm}, all unknowns")
        set_title(figure, f"{study.case}, errors at {study.time}")
        return [save(figure, path)]


def _curves(
    axes: Axes, study: Study, x: np.ndarray, errors: np.ndarray, names: Sequence[str]
) -> None:
    """A curve for each order; names: what follows that of its operator."""
    for order, along, values, name in zip(study.orders, x, errors, names):
        color, marker = ORDERS[order]
        values = np.where(values > 0, values, np.nan)  # a logarithmic axis has no place for 0
        label = operator(order).name + name
        axes.loglog(along, values, color=color, marker=marker, markersize=4, label=label)
