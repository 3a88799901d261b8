"""The picture of a sweep of the linear theory: growth and step over the ratios, for each order."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import operator
from fsipetsc.output.plots.style import STYLE, needed, save, set_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fsipetsc.analysis.spectra import Result

#: colour of the cells where all is well
WELL = "#cfe3f3"
#: rows of the picture: label, number, when all is well
ROWS = (
    ("energy growth over |λ|", "energy", "estimate"),
    ("fastest mode over |λ|", "growth", "stable"),
    ("RK4 step by that without coupling", "step_ratio", "step_kept"),
)


def sweep_figure(results: Sequence[Result], path: str, theory: str) -> list[Path]:
    """Draw it at PATH: a column for each order; nothing without matplotlib. FileError."""
    try:
        matplotlib = needed("stability")
    except InputError:
        return []
    from matplotlib.colors import LogNorm, Normalize
    from matplotlib.figure import Figure

    orders, densities, stiffnesses = (
        list(dict.fromkeys(getattr(r, name) for r in results))
        for name in ("order", "density_ratio", "stiffness_ratio")
    )
    shape = len(orders), len(densities), len(stiffnesses)
    with matplotlib.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(1.6 + 2.4 * len(orders), 9.0))
        grid = figure.subplots(3, len(orders), squeeze=False, sharex=True, sharey=True)
        for row, (label, name, holds) in zip(grid, ROWS):
            values, well = (
                np.array([getattr(r, n) for r in results]).reshape(shape) for n in (name, holds)
            )
            steps, bad = name == "step_ratio", values[~well]
            palette = matplotlib.colormaps["Oranges_r" if steps else "Oranges"].with_extremes(bad=WELL)
            norm = Normalize(0.0, 1.0)
            if not steps and bad.size:
                norm = LogNorm(bad.min() / 2, bad.max() * 2)
            look = {"cmap": palette, "norm": norm, "origin": "lower", "aspect": "auto"}
            for axes, order, field, fine in zip(row, orders, values, well):
                image = axes.imshow(np.ma.array(field, mask=fine), **look)
                axes.set_title(f"order {operator(order).name}")
                axes.set_xticks(range(shape[2]), [f"{s:g}" for s in stiffnesses])
                axes.set_yticks(range(shape[1]), [f"{d:g}" for d in densities])
                _write_numbers(axes, field, fine, steps, lambda v, p=palette, n=norm: p(n(v)))
            if bad.size:
                figure.colorbar(image, ax=row, label=label, aspect=18, pad=0.01)
            row[0].set_ylabel(f"{label}\n\ndensity ratio $m_0/\\hat\\rho$")
        for axes in grid[-1]:
            axes.set_xlabel("stiffness ratio $K/\\hat p$")
        title = f"Interface treatment “{results[0].coupling}”: {theory}"
        set_title(figure, f"{title}\nblue: nothing grows, the step is kept")
        return [save(figure, path)]


def _write_numbers(axes: Axes, field: np.ndarray, fine: np.ndarray, steps: bool, color: Any) -> None:
    """The numbers of cells: all steps, and growth where there is some; white on dark cells."""
    for (i, j), value in np.ndenumerate(field):
        if steps or not fine[i, j]:
            dark = not fine[i, j] and np.dot(color(value)[:3], (0.3, 0.6, 0.1)) < 0.5
            text = f"{value:.2f}" if steps else f"{value:.0e}"
            look = {"ha": "center", "va": "center", "fontsize": 10}
            axes.text(j, i, text, color="white" if dark else "black", **look)
