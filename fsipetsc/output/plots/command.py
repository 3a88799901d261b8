"""The command `plot`: a page of a result, all pictures, or a film."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.output.plots.film import animate
from fsipetsc.output.plots.page import page, pictures
from fsipetsc.output.plots.style import STYLE, needed, save
from fsipetsc.output.reader import Run, open_run

PICTURES = (".png", ".pdf", ".svg")
_KNOWN = (*PICTURES, ".gif", ".jpg", ".jpeg", ".eps", ".tif", ".tiff", ".webp", ".mp4")


def draw(path: str, given: Mapping[str, str]) -> list[Path]:
    """Do what the options ask for (fsipetsc.cli); the files that have been written.

    Raises FileError if the result cannot be read or a file cannot be written, InputError for
    options that cannot be followed or without matplotlib.
    """
    times = _times(given["-times"]) if "-times" in given else ()
    names = tuple(map(str.strip, given["-fields"].split(","))) if "-fields" in given else ()
    where, every, film = Path(given.get("-o", os.curdir)), "-all" in given, "-animate" in given
    if every and film:
        raise InputError("plot: -all and -animate are two things; give one of them")
    suffixes = (".gif",) if film else () if every else PICTURES
    if where.suffix.lower() in _KNOWN and where.suffix not in suffixes:
        named = f", or a name that ends with {', '.join(suffixes)}" if suffixes else ""
        raise InputError(f"plot: -o {where}: expected a directory{named}")
    if film:
        return [animate(path, where, names)]
    matplotlib = needed("plot")
    from matplotlib.figure import Figure

    with open_run(path) as run, matplotlib.rc_context(STYLE), np.errstate(all="ignore"):
        if every:
            return list(_all(run, where, times))
        figure = Figure()
        page(figure, run, names, times)
        if where.suffix not in suffixes:
            where = where / f"{Path(path).stem}.png"
        return [save(figure, where)]


def _all(run: Run, folder: Path, times: Sequence[float]) -> Iterator[Path]:
    """All pictures of a result, each by itself, as RUN-NAME.png."""
    from matplotlib.figure import Figure

    for name, draw_on in pictures(run, times):
        figure = Figure()
        draw_on(figure)
        yield save(figure, folder / f"{Path(run.path).stem}-{name}.png")


def _times(text: str) -> tuple[float, ...]:
    try:
        times = tuple(float(word) for word in text.split(","))
    except ValueError:
        times = (float("nan"),)
    if not all(map(isfinite, times)):
        raise InputError(f"plot: -times {text}: expected times with commas, as 0,0.25")
    return times
