"""The pictures of `convergence` and `verify`: errors over the grid spacing, and what is beside."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fsipetsc.operators.sbp import operator
from fsipetsc.output.plots.style import ORDERS, STYLE, save, set_title
from fsipetsc.studies.verdicts import Curve, Row, Study


def convergence_picture(study: Study, about: str, path: Path) -> list[Path]:
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
        looks = {order: dict(zip(("color", "marker"), ORDERS[order])) for order in study.orders}
        for axes, kind in zip(panels, kinds):
            own = [row for row in rows if row.quantity == kind]
            rates = [
                f"  ({row.observed[-1]:.1f})" if np.isfinite(row.observed[-1:]).any() else ""
                for row in own
            ]
            labels = [operator(row.order).name + rate for row, rate in zip(own, rates)]
            _errors(axes, own, [looks[row.order] | {"label": x} for row, x in zip(own, labels)])
            axes.set_title(kind.removesuffix("/combined"), loc="left")
            axes.legend(loc="lower right")
        for order, look in looks.items():
            largest = np.fmax.reduce([row.errors for row in rows if row.order == order] or [[]])
            times = [study.costs.get((order, h), [np.nan])[-1] for h in study.hs]
            last.loglog(times[: len(largest)], largest, markersize=4, **look)
        last.set_title("the largest of these", loc="left")
        last.set_xlabel("wall time  [s]")
        panels[0].set_ylabel(f"{'errors' if study.exact else 'differences'}, all unknowns")
        set_title(figure, about)
        return [save(figure, path)]


def verify_picture(title: str, rows: Sequence[Row], curve: Curve | None, path: Path) -> None:
    """Ours over the reference, of the last run, and errors over the grid spacing. FileError."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context({**STYLE, "savefig.dpi": 80}):
        figure = Figure(figsize=(12.0 if curve else 8.0, 4.2), layout="constrained")
        *beside, axes = figure.subplots(1, 2 if curve else 1, squeeze=False)[0]
        if curve:
            thick = {"color": "0.6", "linewidth": 3, "label": "reference"}
            beside[0].plot(curve.x_reference, curve.reference, **thick)
            beside[0].plot(curve.x, curve.ours, ".", markersize=4, label="computed")
            beside[0].set(xlabel=curve.labels[0], ylabel=curve.labels[1])
            beside[0].legend()
        names, orders = (list(dict.fromkeys(of)) for of in zip(*[row[1:3] for row in rows]))
        colors = [matplotlib.colormaps["tab20"]((2 * k + k // 10) % 20) for k in range(len(names))]
        looks = []
        for row in rows:
            look = {"color": colors[names.index(row.quantity)], "marker": ORDERS[row.order][1]}
            looks.append({**look, "label": row.quantity if row.order == orders[0] else None})
        _errors(axes, rows, looks)
        for order in orders:
            axes.plot([], [], ORDERS[order][1], color="black", label=operator(order).name)
        axes.set_ylabel("error")
        axes.legend(fontsize="x-small", loc="upper left", bbox_to_anchor=(1.0, 1.0))
        set_title(figure, title)
        save(figure, path)


def _errors(axes: Any, rows: Sequence[Row], looks: Sequence[dict[str, Any]]) -> None:
    """Errors over the grid spacing; a logarithmic axis has no place for 0."""
    for row, look in zip(rows, looks, strict=True):
        errors = np.where(np.array(row.errors) > 0.0, row.errors, np.nan)
        axes.loglog(row.spacings[: len(errors)], errors, markersize=4, **look)
    spacings = sorted({h for row in rows for h in row.spacings})
    axes.set_xlabel("grid spacing h")
    axes.set_xticks([], minor=True)
    axes.set_xticks(spacings, [f"{h:.4g}" for h in spacings], fontsize=8)
