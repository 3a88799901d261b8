"""The picture of `convergence` and `verify`: errors over the grid spacing, and what is beside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fsipetsc.operators.sbp import operator
from fsipetsc.output.plots.style import ORDERS, STYLE, save, set_title
from fsipetsc.studies.verdicts import Curve, Row


def picture(
    title: str, panels: Mapping[str, Sequence[Row]], path: Path, curve: Curve | None = None
) -> list[Path]:
    """A panel of errors for the rows of each heading, and one of a curve over its reference.

    Returns the file, none without matplotlib or without rows. FileError.
    """
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError:
        return []
    if not any(panels.values()):
        return []
    with matplotlib.rc_context({**STYLE, "savefig.dpi": 80}):
        count = len(panels) + bool(curve)
        figure = Figure(figsize=(2.0 + 5.0 * count, 4.2), layout="constrained")
        axes = list(figure.subplots(1, count, squeeze=False)[0])
        if curve:
            beside = axes.pop(0)
            thick = {"color": "0.6", "linewidth": 3, "label": "reference"}
            beside.plot(curve.x_reference, curve.reference, **thick)
            beside.plot(curve.x, curve.ours, ".", markersize=4, label="computed")
            beside.set(xlabel=curve.labels[0], ylabel=curve.labels[1])
            beside.legend()
        for panel, (heading, rows) in zip(axes, panels.items(), strict=True):
            _errors(panel, rows)
            panel.set_title(heading, loc="left")
        axes[0].set_ylabel("errors")
        set_title(figure, title)
        return [save(figure, path)]


def _errors(axes: Any, rows: Sequence[Row]) -> None:
    """Errors over the grid spacing; a logarithmic axis has no place for 0. Of one quantity the
    orders have colours, and that of the last refinement is in brackets; else quantities have.
    """
    from matplotlib import colormaps

    names, orders = (list(dict.fromkeys(of)) for of in zip(*[row[1:3] for row in rows]))
    for row in rows:
        color, marker = ORDERS[row.order][:2]
        rate = f"  ({row.observed[-1]:.1f})" if np.isfinite(row.observed[-1:]).any() else ""
        label = operator(row.order).name + rate
        if len(names) > 1:
            k = names.index(row.quantity)
            color = colormaps["tab20"]((2 * k + k // 10) % 20)
            label = row.quantity if row.order == orders[0] else ""
        errors = np.where(np.array(row.errors) > 0.0, row.errors, np.nan)
        look = {"color": color, "marker": marker, "markersize": 4, "label": label}
        axes.loglog(row.spacings[: len(errors)], errors, **look)
    for order in orders if len(names) > 1 else ():
        axes.plot([], [], ORDERS[order][1], color="black", label=operator(order).name)
    spacings = sorted({h for row in rows for h in row.spacings})
    axes.set_xlabel("grid spacing h")
    axes.set_xticks([], minor=True)
    axes.set_xticks(spacings, [f"{h:.4g}" for h in spacings], fontsize=8)
    axes.legend(fontsize="x-small", loc="upper left", bbox_to_anchor=(1.0, 1.0))
