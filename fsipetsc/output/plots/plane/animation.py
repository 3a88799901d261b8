"""The maps of pressure and stress over time, as a GIF, by Pillow, which comes with matplotlib."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.errors import FileError, InputError
from fsipetsc.output.plots.plane.maps import bar, colors, domain, panel, panel_size
from fsipetsc.output.plots.plane.quantities import MAPS
from fsipetsc.output.plots.scales import axis_label, unit_of
from fsipetsc.output.plots.style import STYLE, drawing
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Run, open_run

if TYPE_CHECKING:
    from PIL import Image

MOST = 200  # frames of the film; of more, some are left out
SECONDS, FASTEST = 10.0, 20.0  # its length, and at most so many frames in a second
DPI, GREYS = 100, 24


def animate(path: str | os.PathLike[str], outdir: str | os.PathLike[str] = ".") -> Path:
    """Draw a result of two dimensions as NAME.gif in `outdir`; its path.

    Raises FileError if the result cannot be read or the film cannot be written, InputError without matplotlib, for a
    result of one dimension or one of less than two frames.
    """
    try:
        matplotlib = drawing()
    except ImportError as error:
        raise InputError("plot: matplotlib is not installed (pip install matplotlib)") from error
    target = Path(outdir) / f"{Path(path).stem}.gif"
    with open_run(path) as run, matplotlib.rc_context(STYLE), np.errstate(all="ignore"):
        if run.dimension != 2 or run.nframes < 2:
            found = f"{run.nframes} of them" if run.dimension == 2 else "one dimension"
            raise InputError(f"-animate: {os.fspath(path)} has {found}: expected two dimensions and two frames or more")
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            _film(run, target)
        except OSError as error:
            raise FileError(f"{target}: cannot write the picture: {error.strerror or error}") from error
    return target


def _film(run: Run, target: Path) -> None:
    """One panel, drawn anew for each frame; scales and extent are those of the whole run."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    pair, chosen = MAPS[0], range(0, run.nframes, -(-run.nframes // MOST))
    scales = [found for quantity in (pair.gas, pair.solid) if (found := colors(run, quantity, chosen))]
    ranges = domain(run)
    width, height = (1.5 * side for side in panel_size(ranges))
    figure = Figure(figsize=(max(5.0, width + 0.8), height + 1.0 + 0.55 * len(scales)), dpi=DPI)
    canvas, axes, frames = FigureCanvasAgg(figure), figure.subplots(), []
    shades = _shades([own.palette["cmap"] for own in scales])
    for frame in chosen:
        axes.clear()
        pictures = panel(axes, run, frame, scales)
        axes.set(aspect="equal", xlim=ranges[0], ylim=ranges[1])
        axes.set(xlabel=axis_label(run, "x", "m"), ylabel=axis_label(run, "y", "m"))
        axes.set_title(f"t = {run.time[frame]:.4g}{unit_of(run, 's')}", loc="left")
        if frame == 0:
            for own, picture in zip(scales, pictures):
                bar(figure, picture, own, axes, 6)
            set_title(figure, of_run(run, pair.title))
            canvas.draw()
            figure.set_layout_engine("none")  # nothing moves from now on but what is drawn
        canvas.draw()
        frames.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3]).quantize(palette=shades, dither=0))
    rate = min(FASTEST, max(1.0, len(frames) / SECONDS))
    frames[0].save(target, save_all=True, append_images=frames[1:], duration=round(1000 / rate), loop=0)


def _shades(names: Sequence[str]) -> Image.Image:
    """The 256 colors of the film, the same in all frames: of the color maps, evenly, and greys for what is written.

    Colors chosen by what is in a frame would leave the bars with steps and false ends.
    """
    from matplotlib import colormaps
    from PIL import Image

    greys = np.repeat(np.linspace(0.0, 1.0, GREYS)[:, None], 3, axis=1)
    each = (256 - GREYS) // len(names)
    rows = [greys, *(colormaps[name](np.linspace(0.0, 1.0, each))[:, :3] for name in names)]
    shades = Image.new("P", (1, 1))
    shades.putpalette(np.rint(255 * np.concatenate(rows)).astype(np.uint8).tobytes())
    return shades
