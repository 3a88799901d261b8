"""The picture of a flutter study: growth and frequency of the panel's modes over dynamic pressure."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.output.plots.style import GREY, SERIES, STYLE, needed, save, set_title

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Curves(NamedTuple):
    """Of a Mach number: lambda (n,) and s (n, 2) of two modes over sqrt(D/m), by runs and a theory."""

    mach: float
    dynamic: np.ndarray
    found: np.ndarray
    fine: np.ndarray
    theory: np.ndarray


def flutter_figure(
    curves: Sequence[Curves], critical: float, facts: str, path: str | os.PathLike[str]
) -> list[Path]:
    """Draw them at PATH, with a line at the critical lambda; nothing without matplotlib or curves.

    FileError if the picture cannot be written.
    """
    try:
        matplotlib = needed("flutter")
    except InputError:
        return []
    if not curves:
        return []
    from matplotlib.figure import Figure

    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.4, 4.0))
        draw(figure, curves, critical)
        what = "runs (marks), thin panel in quasi-steady flow (lines)"
        set_title(figure, f"growth of the panel's motion, {facts}: {what}")
        return [save(figure, path)]


def draw(figure: Figure, curves: Sequence[Curves], critical: float) -> None:
    """Growth on the left, frequency on the right; a colour for each Mach number."""
    titles = "growth / √(D/m)", "angular frequency / √(D/m)"
    for axes, part, title in zip(figure.subplots(1, 2), (np.real, np.imag), titles):
        for n, one in enumerate(curves):
            color = SERIES[(n + 1) % len(SERIES)]
            axes.plot(one.fine, part(one.theory), color=color, lw=0.8)
            marks = axes.plot(one.dynamic, part(one.found), ls="", marker="o", ms=4, color=color)
            marks[0].set_label(f"M = {one.mach:g}")
        axes.axvline(critical, color=GREY, ls="--", lw=0.8)
        axes.set_title(title, loc="left")
        axes.set_xlabel("λ = 2 q L³ / (D √(M²−1))")
    figure.axes[0].legend(loc="upper left")
