"""A result over time, as a GIF, by Pillow, which comes with matplotlib."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.errors import FileError, InputError
from fsipetsc.output.plots import film as of_profiles
from fsipetsc.output.plots.plane import film as of_maps
from fsipetsc.output.plots.style import BLUE, RED, STYLE, needed
from fsipetsc.output.reader import Run, open_run

if TYPE_CHECKING:
    from PIL import Image

MOST = 200  # frames of the film; of more, some are left out
SECONDS, FASTEST = 10.0, 20.0  # its length, and at most so many frames in a second
GREYS = 24


def animate(path: str | os.PathLike[str], outdir: str | os.PathLike[str] = ".") -> Path:
    """Draw a result as NAME.gif in `outdir`; its path.

    Raises FileError if the result cannot be read or the film cannot be written, InputError without matplotlib or for a
    result of less than two frames.
    """
    matplotlib = needed("plot")
    target = Path(outdir) / f"{Path(path).stem}.gif"
    with open_run(path) as run, matplotlib.rc_context(STYLE), np.errstate(all="ignore"):
        if run.nframes < 2:
            raise InputError(f"-animate: {os.fspath(path)} has {run.nframes} frames: expected two or more")
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            _write(run, target)
        except OSError as error:
            raise FileError(f"{target}: cannot write the picture: {error.strerror or error}") from error
    return target


def frames(run: Run, chosen: Sequence[int]) -> Iterator[np.ndarray]:
    """(height, width, 3) of each chosen frame, colors from 0 to 255: maps in two dimensions, profiles in one."""
    return (of_maps if run.dimension == 2 else of_profiles).film(run, chosen)


def some(run: Run, most: int) -> range:
    """At most so many frames, evenly, from the first on."""
    return range(0, run.nframes, -(-run.nframes // most))


def shades(run: Run, chosen: Sequence[int]) -> Image.Image:
    """The 256 colors of the film, the same in all frames: those of what is drawn, evenly, and greys for what is written.

    Colors chosen by what is in a frame would leave the bars of maps with steps and false ends.
    """
    from matplotlib import colormaps
    from matplotlib.colors import to_rgb
    from PIL import Image

    black, white = np.zeros(3), np.ones(3)
    rows = [black + np.linspace(0.0, 1.0, GREYS)[:, None] * (white - black)]
    if run.dimension == 2:
        names = of_maps.colormaps(run, chosen)
        each = (256 - GREYS) // len(names)
        rows += [colormaps[name](np.linspace(0.0, 1.0, each))[:, :3] for name in names]
    else:
        rows += [to_rgb(color) + np.linspace(0.0, 0.85, 64)[:, None] * (white - to_rgb(color)) for color in (BLUE, RED)]
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.rint(255 * np.concatenate(rows)).astype(np.uint8).tobytes())
    return palette


def _write(run: Run, target: Path) -> None:
    from PIL import Image

    chosen = some(run, MOST)
    palette = shades(run, chosen)
    drawn = [Image.fromarray(frame).quantize(palette=palette, dither=0) for frame in frames(run, chosen)]
    rate = min(FASTEST, max(1.0, len(drawn) / SECONDS))
    drawn[0].save(target, save_all=True, append_images=drawn[1:], duration=round(1000 / rate), loop=0)
