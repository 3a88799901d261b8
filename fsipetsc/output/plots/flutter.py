"""The picture of a flutter study: growth and frequency of the panel's modes over the dynamic pressure, runs and theory."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.output.plots.style import SERIES, STYLE, drawing
from fsipetsc.output.plots.titles import set_title

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fsipetsc.analysis.flutter_table import FlutterStudy


def flutter_figure(study: FlutterStudy, path: str | os.PathLike[str]) -> list[Path]:
    """Draw it at PATH; nothing without matplotlib or without a run that went well. FileError if it cannot be written."""
    try:
        matplotlib = drawing()
        from matplotlib.figure import Figure
    except ImportError:
        return []
    if not any(study.of(mach) for mach in study.machs):
        return []
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.4, 4.0))
        draw(figure, study)
        facts = f"mass {study.mass:g}, thickness {study.thickness:g}"
        set_title(figure, f"growth of the panel's motion, {facts}: runs (marks), thin panel in quasi-steady flow (lines)")
        try:
            figure.savefig(path)
        except OSError as error:
            raise FileError(f"{path}: cannot write the picture: {error.strerror or error}") from error
    return [Path(path)]


def draw(figure: Figure, study: FlutterStudy) -> None:
    """Growth on the left, frequency on the right, both over sqrt(D/m); a colour for each Mach number."""
    growth, frequency = figure.subplots(1, 2)
    colours = (*SERIES[1:], SERIES[0])
    for n, mach in enumerate(study.machs):
        runs, colour = study.of(mach), colours[n % len(colours)]
        if not runs:
            continue
        dynamic = np.linspace(runs[0].dynamic, runs[-1].dynamic, 201)
        theory = np.array([study.thin(mach, d) for d in dynamic])
        for k in range(2):
            growth.plot(dynamic, theory[:, k].real, color=colour, lw=0.8)
            frequency.plot(dynamic, theory[:, k].imag, color=colour, lw=0.8)
        x = [run.dynamic for run in runs for _ in run.pair]
        s = np.array([s / study.unit(mach, run.dynamic) for run in runs for s in run.pair])
        growth.plot(x, s.real, ls="", marker="o", ms=4, color=colour, label=f"M = {mach:g}")
        frequency.plot(x, s.imag, ls="", marker="o", ms=4, color=colour)
    growth.axvline(636.57, color="#8a8a8a", ls="--", lw=0.8)
    frequency.axvline(636.57, color="#8a8a8a", ls="--", lw=0.8)
    growth.set_title("growth / √(D/m)", loc="left")
    frequency.set_title("angular frequency / √(D/m)", loc="left")
    for axes in (growth, frequency):
        axes.set_xlabel("λ = 2 q L³ / (D √(M²−1))")
    growth.legend(loc="upper left")
