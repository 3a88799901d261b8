"""The picture of a flutter study: growth and frequency of the panel's modes over the dynamic pressure, runs and theory."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.output.plots.style import SERIES, STYLE, drawing
from fsipetsc.output.plots.titles import set_title

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Curves(NamedTuple):
    """Of a Mach number: lambda (n,) and s (n, 2) of two modes over sqrt(D/m), by runs and by a theory."""

    mach: float
    dynamic: np.ndarray
    found: np.ndarray
    fine: np.ndarray
    theory: np.ndarray


def flutter_figure(curves: Sequence[Curves], critical: float, facts: str, path: str | os.PathLike[str]) -> list[Path]:
    """Draw them at PATH, with a line at the critical lambda; nothing without matplotlib or without a run that went well.
    FileError if it cannot be written.
    """
    try:
        matplotlib = drawing()
        from matplotlib.figure import Figure
    except ImportError:
        return []
    if not curves:
        return []
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.4, 4.0))
        draw(figure, curves, critical)
        set_title(figure, f"growth of the panel's motion, {facts}: runs (marks), thin panel in quasi-steady flow (lines)")
        try:
            figure.savefig(path)
        except OSError as error:
            raise FileError(f"{path}: cannot write the picture: {error.strerror or error}") from error
    return [Path(path)]


def draw(figure: Figure, curves: Sequence[Curves], critical: float) -> None:
    """Growth on the left, frequency on the right, both over sqrt(D/m); a colour for each Mach number."""
    growth, frequency = figure.subplots(1, 2)
    colours = (*SERIES[1:], SERIES[0])
    for n, one in enumerate(curves):
        colour = colours[n % len(colours)]
        marks = {"ls": "", "marker": "o", "ms": 4, "color": colour}
        for axes, part in ((growth, np.real), (frequency, np.imag)):
            axes.plot(one.fine, part(one.theory), color=colour, lw=0.8)
            axes.plot(one.dynamic, part(one.found), **marks)
        growth.lines[-1].set_label(f"M = {one.mach:g}")
    growth.axvline(critical, color="#8a8a8a", ls="--", lw=0.8)
    frequency.axvline(critical, color="#8a8a8a", ls="--", lw=0.8)
    growth.set_title("growth / √(D/m)", loc="left")
    frequency.set_title("angular frequency / √(D/m)", loc="left")
    for axes in (growth, frequency):
        axes.set_xlabel("λ = 2 q L³ / (D √(M²−1))")
    growth.legend(loc="upper left")
