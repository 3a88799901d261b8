"""A result over time: maps, or in one dimension profiles, one frame after the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from fsipetsc.errors import InputError
from fsipetsc.output.file_layout import writing
from fsipetsc.output.plots.fields import View, draw_bars, sizes
from fsipetsc.output.plots.quantities import chosen
from fsipetsc.output.plots.style import moment, of_run, set_title
from fsipetsc.output.reader import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 100
MOST = 200  # frames of a film; of more, some are left out
SECONDS = 10.0  # its length


def animate(run: Run, target: Path, names: Sequence[str] = ()) -> Path:
    """Draw a result as the GIF `target`; names: fields that are shown.

    FileError if the film cannot be written, InputError for a result of less than two frames,
    and for a field that there is not.
    """
    from matplotlib.animation import PillowWriter
    from matplotlib.figure import Figure

    if run.nframes < 2:
        raise InputError(f"-animate: there are {run.nframes} frames: expected two or more")
    chosen(run, names)  # an error comes before the film
    frames, figure = some(run, MOST), Figure(dpi=DPI)
    writer = PillowWriter(fps=max(1.0, len(frames) / SECONDS))
    with writing(target, "the film"), writer.saving(figure, target, DPI):
        for _ in drawn(figure, run, frames, names):
            writer.grab_frame()
    return target


def some(run: Run, most: int) -> range:
    """At most so many frames, evenly, from the first on."""
    return range(0, run.nframes, -(-run.nframes // most))


def drawn(
    figure: Figure, run: Run, frames: Sequence[int], names: Sequence[str] = ()
) -> Iterator[int]:
    """Each frame, once it is on the figure; scales and colours are the same in all. InputError."""
    views = [View(run, quantity, frames) for quantity in chosen(run, names)]
    _, width, height = sizes(View(run, views[0].quantity, frames[:1]))
    size = (10.8, 3.4) if run.dimension == 1 else (len(views) * (width + 1.2), height + 0.9)
    figure.set_size_inches(*size)
    grid = figure.subplots(1, len(views), squeeze=False)[0]
    for frame in frames:
        for axes, view in zip(grid, views):
            for artist in [*axes.lines, *axes.collections]:
                artist.remove()
            pictures = view.draw(axes, frame)
            axes.set(xlabel=view.labels[0], ylabel=view.labels[1])
            if frame == frames[0]:
                draw_bars(figure, view, pictures, axes)
        set_title(figure, of_run(run, moment(run, frame)))
        if frame == frames[0]:
            figure.draw_without_rendering()
            figure.set_layout_engine("none")  # only what is drawn moves from now on
        yield frame
