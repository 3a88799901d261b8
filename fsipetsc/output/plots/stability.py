"""The picture of a sweep of the linear theory: energy growth, fastest mode and step over the ratios, for each order."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.operators.sbp import operator
from fsipetsc.output.plots.style import drawing
from fsipetsc.output.plots.titles import set_title

if TYPE_CHECKING:
    from fsipetsc.analysis.spectra import Result

#: color of the cells where all is well, and size of the numbers in the picture
WELL, NUMBERS = "#cfe3f3", 10
#: rows of the picture: label, number, when all is well
ROWS = (
    ("energy growth over |λ|", "energy", "estimate"),
    ("fastest mode over |λ|", "growth", "stable"),
    ("RK4 step by that without coupling", "step_ratio", "step_kept"),
)


def sweep_figure(results: Sequence[Result], path: str, theory: str) -> list[Path]:
    """Draw it at PATH: a column for each order; nothing without matplotlib. FileError if it cannot be written."""
    try:
        drawing()
        from matplotlib import colormaps
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.colors import LogNorm, Normalize
        from matplotlib.figure import Figure
    except ImportError:
        return []
    orders, densities, stiffnesses = (
        list(dict.fromkeys(getattr(r, name) for r in results)) for name in ("order", "density_ratio", "stiffness_ratio")
    )
    shape = len(orders), len(densities), len(stiffnesses)
    figure = Figure(figsize=(1.6 + 2.4 * len(orders), 9.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(3, len(orders), squeeze=False, sharex=True, sharey=True)
    for row, (label, name, holds) in zip(axes, ROWS):
        values, well = (np.array([getattr(r, n) for r in results]).reshape(shape) for n in (name, holds))
        steps, bad = name == "step_ratio", values[~well]
        # beside blue: told apart without red and green
        palette, norm = colormaps["Oranges_r" if steps else "Oranges"].copy(), Normalize(0.0, 1.0)
        palette.set_bad(WELL)
        if not steps and bad.size:
            norm = LogNorm(bad.min() / 2, bad.max() * 2)
        for ax, order, field, fine in zip(row, orders, values, well):
            masked = np.ma.array(field, mask=fine)
            image = ax.imshow(masked, cmap=palette, norm=norm, origin="lower", aspect="auto")
            ax.set_title(f"order {operator(order).name}")
            ax.set_xticks(range(shape[2]), [f"{s:g}" for s in stiffnesses])
            ax.set_yticks(range(shape[1]), [f"{d:g}" for d in densities])
            for (i, j), value in np.ndenumerate(field):
                if steps or not fine[i, j]:
                    dark = not fine[i, j] and np.dot(palette(norm(value))[:3], (0.3, 0.6, 0.1)) < 0.5
                    color, text = "white" if dark else "black", f"{value:.2f}" if steps else f"{value:.0e}"
                    ax.text(j, i, text, ha="center", va="center", fontsize=NUMBERS, color=color)
        if bad.size:
            figure.colorbar(image, ax=row, label=label, aspect=18, pad=0.01)
        row[0].set_ylabel(f"{label}\n\ndensity ratio $m_0/\\hat\\rho$")
    for ax in axes[-1]:
        ax.set_xlabel("stiffness ratio $K/\\hat p$")
    set_title(figure, f"Interface treatment “{results[0].coupling}”: {theory}\nblue: nothing grows, the step is kept")
    try:
        figure.savefig(path, dpi=160)
    except OSError as error:
        raise FileError(f"{path}: cannot write the picture: {error.strerror or error}") from error
    return [Path(path)]
