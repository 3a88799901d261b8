"""The maps of pressure and stress, one frame after the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fsipetsc.output.plots.frames import moment
from fsipetsc.output.plots.maps.page import pairs_of
from fsipetsc.output.plots.maps.panels import bar, colors, domain, few_ticks, panel, panel_size
from fsipetsc.output.plots.scales import axis_label
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Run

DPI = 100


def film(run: Run, chosen: Sequence[int], fields: Sequence[str] = ()) -> Iterator[np.ndarray]:
    """(height, width, 3) of each chosen frame, colors from 0 to 255. Scales and extent are those of the whole run.

    fields: the name of what is shown, the first one counts. InputError.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    pair = pairs_of(fields)[0]
    scales = [found for quantity in (pair.gas, pair.solid) if (found := colors(run, quantity, chosen))]
    ranges = domain(run)
    width, height = (1.5 * side for side in panel_size(ranges))
    figure = Figure(figsize=(max(5.0, width + 0.8), height + 1.0 + 0.55 * len(scales)), dpi=DPI)
    canvas, axes = FigureCanvasAgg(figure), figure.subplots()
    for number, frame in enumerate(chosen):
        axes.clear()
        pictures = panel(axes, run, frame, scales)
        axes.set(aspect="equal", xlim=ranges[0], ylim=ranges[1])
        few_ticks(axes, width)
        axes.set(xlabel=axis_label(run, "x", "m"), ylabel=axis_label(run, "y", "m"))
        axes.set_title(moment(run, frame), loc="left")
        if number == 0:
            for own, picture in zip(scales, pictures):
                bar(figure, picture, own, axes, 6)
            set_title(figure, of_run(run, pair.title_of({layer.kind for layer in run.layers})))
            canvas.draw()
            figure.set_layout_engine("none")  # nothing moves from now on but what is drawn
        canvas.draw()
        yield np.array(canvas.buffer_rgba())[..., :3]


def colormaps(run: Run, chosen: Sequence[int], fields: Sequence[str] = ()) -> list[str]:
    """Names of the color maps in the film: of the gas, of the solid."""
    pair = pairs_of(fields)[0]
    return [found.palette["cmap"] for quantity in (pair.gas, pair.solid) if (found := colors(run, quantity, chosen))]
