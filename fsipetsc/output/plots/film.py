"""Profiles of velocity, temperature, pressure and density, one frame after the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fsipetsc.output.plots.frames import moment
from fsipetsc.output.plots.profiles import domain
from fsipetsc.output.plots.quantities import PROFILES
from fsipetsc.output.plots.scales import axis_label, extremes, named, scaled
from fsipetsc.output.plots.style import COLORS
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Run

DPI = 100
SHOWN = PROFILES[:4]
MARGIN = 0.05  # of a panel's height, above and below what occurs


def film(run: Run, chosen: Sequence[int], fields: Sequence[str] = ()) -> Iterator[np.ndarray]:
    """(height, width, 3) of each chosen frame, colors from 0 to 255. The axes are those of the whole run.

    fields: names of what is shown, four at most. InputError.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 5.0), dpi=DPI)
    canvas, curves = FigureCanvasAgg(figure), []
    there = [quantity for quantity in PROFILES if any(quantity.of(layer.kind) for layer in run.layers)]
    named(fields, [quantity.name for quantity in there])
    shown = [q for q in there if (q.name in fields if fields else q in SHOWN)][: len(SHOWN)]
    grid = figure.subplots(2, 2, sharex=True, squeeze=False)
    for axes in grid.flat[len(shown) :]:
        axes.set_visible(False)
    for axes, quantity in zip(grid.flat, shown):
        layers = [layer for layer in run.layers if quantity.of(layer.kind)]
        values = [np.asarray(quantity.values(layer)) for layer in layers]
        scale = scaled(run, quantity.label, quantity.unit, *values, start=np.concatenate([v[0] for v in values]))
        low, high = extremes(*map(scale, values))
        axes.set_ylim(low - MARGIN * (high - low or 1.0), high + MARGIN * (high - low or 1.0))
        axes.set_title(scale.label, loc="left")
        curves += [(axes.plot([], [], color=COLORS[layer.kind])[0], layer, scale(v)) for layer, v in zip(layers, values)]
    grid[0, 0].set_xlim(domain(run))
    figure.supxlabel(axis_label(run, "x", "m"), fontsize=9)
    for number, frame in enumerate(chosen):
        for line, layer, values in curves:
            line.set_data(layer.x[frame], values[frame])
        set_title(figure, of_run(run, moment(run, frame)))
        if number == 0:
            canvas.draw()
            figure.set_layout_engine("none")  # nothing moves from now on but the lines
        canvas.draw()
        yield np.array(canvas.buffer_rgba())[..., :3]
