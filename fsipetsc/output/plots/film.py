"""A result over time: maps, or in one dimension profiles, one frame after the other."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.output.file_layout import writing
from fsipetsc.output.plots.fields import Maps, Profiles, draw_bars, sizes, view_of
from fsipetsc.output.plots.quantities import chosen, there
from fsipetsc.output.plots.scales import moment
from fsipetsc.output.plots.style import BLUE, RED, STYLE, needed, of_run, set_title
from fsipetsc.output.reader import Run, open_run

if TYPE_CHECKING:
    from PIL import Image

DPI = 100
MOST = 200  # frames of a film; of more, some are left out
SECONDS, FASTEST = 10.0, 20.0  # its length, and at most so many frames in a second


def animate(
    path: str | os.PathLike[str], out: str | os.PathLike[str] = ".", names: Sequence[str] = ()
) -> Path:
    """Draw a result as NAME.gif in the directory `out`, or as the file `out`; its path.

    names: fields that are shown. Raises FileError if the result cannot be read or the film cannot
    be written, InputError without matplotlib, or for a result of less than two frames.
    """
    matplotlib = needed("plot")
    target = Path(out)
    if target.suffix != ".gif":
        target = target / f"{Path(path).stem}.gif"
    with open_run(path) as run, matplotlib.rc_context(STYLE), np.errstate(all="ignore"):
        if run.nframes < 2:
            there = f"{os.fspath(path)} has {run.nframes} frames"
            raise InputError(f"-animate: {there}: expected two or more")
        first, *others = images(run, some(run, MOST), names)
        rate = min(FASTEST, max(1.0, (1 + len(others)) / SECONDS))
        look = {"save_all": True, "duration": round(1000 / rate), "loop": 0}
        with writing(target, "the film"):
            first.save(target, append_images=others, **look)
    return target


def some(run: Run, most: int) -> range:
    """At most so many frames, evenly, from the first on."""
    return range(0, run.nframes, -(-run.nframes // most))


def images(run: Run, frames: Sequence[int], names: Sequence[str] = ()) -> Iterator[Image.Image]:
    """A picture of each frame, with scales and colours that are the same in all. InputError."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    line = run.dimension == 1
    quantities = there(run) if line and not names else chosen(run, names)
    views = [view_of(run, quantity, frames) for quantity in quantities[: 4 if line else 1]]
    figure = Figure(dpi=DPI)
    canvas, palette = FigureCanvasAgg(figure), _palette(views)
    _, width, height = sizes(view_of(run, quantities[0], frames[:1]))
    figure.set_size_inches(*((8.0, 5.4) if line else (max(5.0, width + 1.2), height + 0.9)))
    grid = figure.subplots(*((1, 1) if len(views) == 1 else (2, 2)), squeeze=False)
    for axes in grid.flat[len(views) :]:
        axes.set_visible(False)
    for number, frame in enumerate(frames):
        for axes, view in zip(grid.flat, views):
            for artist in [*axes.lines, *axes.collections]:
                artist.remove()
            pictures = view.draw(axes, frame)
            axes.set(xlabel=view.labels[0], ylabel=view.labels[1])
            if number == 0:
                draw_bars(figure, view, pictures, axes)
        set_title(figure, of_run(run, moment(run, frame)))
        canvas.draw()
        if number == 0:
            figure.set_layout_engine("none")  # only what is drawn moves from now on
        drawn = Image.fromarray(np.array(canvas.buffer_rgba())[..., :3])
        yield drawn.quantize(palette=palette, dither=0)


def _palette(views: Sequence[Profiles | Maps]) -> Image.Image:
    """The 256 colours of a film, evenly: those of maps and curves, and greys.

    Colours chosen by what is in a frame would leave the bars of maps with steps.
    """
    from matplotlib import colormaps
    from matplotlib.colors import to_rgb
    from PIL import Image

    looks = {id(shown): shown.look for view in views for shown in view.shown.values()}
    maps = [colormaps.get_cmap(look["cmap"]) for look in looks.values() if look]  # or its name
    rows = [np.linspace([0, 0, 0], [1, 1, 1], 24)]
    rows += [np.linspace(to_rgb(color), [1, 1, 1], 16) for color in (BLUE, RED)]
    rows += [cmap(np.linspace(0, 1, 200 // len(maps)))[:, :3] for cmap in maps]
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.rint(255 * np.concatenate(rows)).astype(np.uint8).tobytes())
    return palette
