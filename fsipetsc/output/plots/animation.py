"""A result over time, as a GIF, by Pillow, which comes with matplotlib, or as an MP4, by ffmpeg."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.errors import FileError, InputError
from fsipetsc.output.places import writing
from fsipetsc.output.plots import film as of_profiles
from fsipetsc.output.plots.frames import check_drawable
from fsipetsc.output.plots.maps import film as of_maps
from fsipetsc.output.plots.style import BLUE, RED, STYLE, needed
from fsipetsc.output.reader import Run, open_run

if TYPE_CHECKING:
    from PIL import Image

MOST = 200  # frames of the film; of more, some are left out
SECONDS, FASTEST = 10.0, 20.0  # its length, and at most so many frames in a second
GREYS = 24
FILMS = (".gif", ".mp4")


def animate(path: str | os.PathLike[str], out: str | os.PathLike[str] = ".", fields: Sequence[str] = ()) -> Path:
    """Draw a result as NAME.gif in the directory `out`, or as the file `out`, which ends with one of FILMS; its path.

    fields: names of what is shown, those of the page. Raises FileError if the result cannot be read or the film cannot be
    written, InputError without matplotlib, or for an MP4 ffmpeg, and for a result of less than two frames.
    """
    matplotlib = needed("plot")
    target = Path(out) if Path(out).suffix in FILMS else Path(out) / f"{Path(path).stem}.gif"
    program = ffmpeg() if target.suffix == ".mp4" else ""
    with open_run(path) as run, matplotlib.rc_context(STYLE), np.errstate(all="ignore"):
        check_drawable(run)
        if run.nframes < 2:
            raise InputError(f"-animate: {os.fspath(path)} has {run.nframes} frames: expected two or more")
        chosen = some(run, MOST)
        rate = min(FASTEST, max(1.0, len(chosen) / SECONDS))
        with writing(target):
            if program:
                _write_mp4(frames(run, chosen, fields), target, rate, program)
            else:
                _write_gif(run, chosen, fields, target, rate)
    return target


def ffmpeg() -> str:
    """The program that makes MP4s. InputError where there is none."""
    found = shutil.which("ffmpeg")
    if found:
        return found
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        wanted = "ffmpeg is not installed (apt-get install ffmpeg, or pip install imageio-ffmpeg)"
        raise InputError(f"plot -animate: {wanted}; a name that ends with .gif needs none") from None


def frames(run: Run, chosen: Sequence[int], fields: Sequence[str] = ()) -> Iterator[np.ndarray]:
    """(height, width, 3) of each chosen frame, colors from 0 to 255: maps in two dimensions, profiles in one."""
    return (of_maps if run.dimension == 2 else of_profiles).film(run, chosen, fields)


def some(run: Run, most: int) -> range:
    """At most so many frames, evenly, from the first on."""
    return range(0, run.nframes, -(-run.nframes // most))


def shades(run: Run, chosen: Sequence[int], fields: Sequence[str] = ()) -> Image.Image:
    """The 256 colors of the film, the same in all frames: those of what is drawn, evenly, and greys for what is written.

    Colors chosen by what is in a frame would leave the bars of maps with steps and false ends.
    """
    from matplotlib import colormaps
    from matplotlib.colors import to_rgb
    from PIL import Image

    black, white = np.zeros(3), np.ones(3)
    rows = [black + np.linspace(0.0, 1.0, GREYS)[:, None] * (white - black)]
    if run.dimension == 2:
        names = of_maps.colormaps(run, chosen, fields)
        each = (256 - GREYS) // len(names)
        rows += [colormaps[name](np.linspace(0.0, 1.0, each))[:, :3] for name in names]
    else:
        rows += [to_rgb(color) + np.linspace(0.0, 0.85, 64)[:, None] * (white - to_rgb(color)) for color in (BLUE, RED)]
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.rint(255 * np.concatenate(rows)).astype(np.uint8).tobytes())
    return palette


def _write_gif(run: Run, chosen: Sequence[int], fields: Sequence[str], target: Path, rate: float) -> None:
    from PIL import Image

    palette = shades(run, chosen, fields)
    drawn = [Image.fromarray(frame).quantize(palette=palette, dither=0) for frame in frames(run, chosen, fields)]
    drawn[0].save(target, save_all=True, append_images=drawn[1:], duration=round(1000 / rate), loop=0)


def _write_mp4(pictures: Iterator[np.ndarray], target: Path, rate: float, program: str) -> None:
    """By way of files: where PETSc answers signals, a pipe whose reader ends early would end this program, too."""
    from PIL import Image

    with tempfile.TemporaryDirectory() as folder:
        for number, picture in enumerate(pictures):
            height, width = (side - side % 2 for side in picture.shape[:2])  # even, which most players want
            Image.fromarray(np.ascontiguousarray(picture[:height, :width])).save(Path(folder, f"{number:04}.png"))
        command = [program, "-loglevel", "error", "-nostdin", "-y", "-framerate", f"{rate:g}", "-i", f"{folder}/%04d.png"]
        done = subprocess.run([*command, "-pix_fmt", "yuv420p", str(target)], capture_output=True, check=False)
    if done.returncode:
        lines = done.stderr.decode(errors="replace").strip().splitlines() or ["no reason given"]
        raise FileError(f"{target}: ffmpeg cannot write the film: {lines[-1]}")
