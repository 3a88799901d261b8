"""The picture of a convergence study: errors over the grid spacing, and over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.operators.sbp import operator
from fsipetsc.output.plots.style import ORDERS, STYLE, save, set_title

if TYPE_CHECKING:
    from fsipetsc.studies.convergence import Study


def convergence_figure(study: Study, about: str, units: str, path: Path) -> list[Path]:
    """Figs. 6 and 7 of the paper: a panel for fluid and solid each, or for each layer and the
    series, with the order of the last refinement in brackets; one over the wall time.

    Returns the file, none without matplotlib or without a run that went well. FileError.
    """
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError:
        return []
    rows = [row for row in study.rows if row.quantity.endswith("/combined")]
    if not rows:
        return []
    kinds = [*dict.fromkeys(row.quantity for row in rows)]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(3.4 * (len(kinds) + 1), 3.8))
        *panels, last = figure.subplots(1, len(kinds) + 1, sharey=True, squeeze=False)[0]
        for order in study.orders:
            color, marker = ORDERS[order]
            style = {"color": color, "marker": marker, "markersize": 4}
            own = [row for row in rows if row.order == order]
            for row in own:
                rate = row.observed[-1] if row.observed else np.nan
                label = operator(order).name + (f"  ({rate:.1f})" if np.isfinite(rate) else "")
                axes = panels[kinds.index(row.quantity)]
                # a logarithmic axis has no place for 0
                errors = np.where(np.array(row.errors) > 0, row.errors, np.nan)
                axes.loglog(study.hs[: len(errors)], errors, label=label, **style)
            if own:
                largest = np.fmax.reduce([row.errors for row in own])
                times = [study.costs.get((order, h), [np.nan])[-1] for h in study.hs]
                last.loglog(times[: len(largest)], largest, **style)
        for axes, kind in zip(panels, kinds):
            axes.set_title(kind.removesuffix("/combined"), loc="left")
            axes.set_xlabel("grid spacing h" + "  [m]" * (units == "SI"))
            axes.set_xticks(study.hs, [f"{h:.4g}" for h in study.hs], fontsize=8)
            axes.set_xticks([], minor=True)
            axes.legend(loc="lower right")
        last.set_title("the largest of these", loc="left")
        last.set_xlabel("wall time  [s]")
        panels[0].set_ylabel(f"{'errors' if study.exact else 'differences'}, all unknowns")
        set_title(figure, about)
        return [save(figure, path)]
