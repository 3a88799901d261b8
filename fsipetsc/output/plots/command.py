"""The command `plot`: a page of a run or of two, all pictures, or a film, in the format that a name ends with."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.errors import FileError, InputError
from fsipetsc.output.places import writing
from fsipetsc.output.plots import compare, complain, page, plot, reason
from fsipetsc.output.plots.animation import FILMS, animate
from fsipetsc.output.plots.frames import apart, outside
from fsipetsc.output.plots.style import STYLE, needed
from fsipetsc.output.reader import open_run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES = (".png", ".pdf", ".svg")


def draw(path: str, given: Mapping[str, str], say: Callable[[str], None]) -> list[Path]:
    """Do what the options ask for (fsipetsc.cli); the files that have been written. InputError, FileError.

    say: is told of times that are asked for and that a result does not have.
    """
    times = _times(given["-times"]) if "-times" in given else ()
    fields = tuple(name.strip() for name in given["-fields"].split(",")) if "-fields" in given else ()
    where = Path(given.get("-o", os.curdir))
    _check_together(given, where)
    if "-animate" in given:
        return [animate(path, where, fields)]
    if "-all" in given:
        written = plot(path, where, times)
        with open_run(path) as run:
            notes = list(outside(run, times))
    elif "-compare" in given:
        written, notes = _compare(path, given["-compare"], where, fields, times)
    else:
        written, notes = _page(path, where, fields, times)
    for note in notes:
        say(note)
    return written


_Done = tuple[list[Path], list[str]]  # files, notes


def _page(path: str, where: Path, fields: Sequence[str], times: Sequence[float]) -> _Done:
    faults: list[str] = []
    target = where if where.suffix in PICTURES else where / f"{Path(path).stem}.png"
    with open_run(path) as run:
        _write(target, lambda figure: page.draw(figure, run, fields, times, faults=faults), faults)
        notes = list(outside(run, times))
    complain(path, faults, f"the rest is in {target}")
    return [target], notes


def _compare(path: str, other: str, where: Path, fields: Sequence[str], times: Sequence[float]) -> _Done:
    faults: list[str] = []
    target = where if where.suffix in PICTURES else where / f"{Path(path).stem}-{Path(other).stem}.png"
    with open_run(path) as a, open_run(other) as b:
        _write(target, lambda figure: compare.draw(figure, a, b, fields, times, faults=faults), faults)
        notes = [*outside(a, times), *outside(b, times)] or list(apart(a, b, compare.frames(a, b, times)))
    complain(f"{path} or {other}", faults, f"the rest is in {target}")
    return [target], notes


def _check_together(given: Mapping[str, str], where: Path) -> None:
    """InputError for options that do not go together, and for a file of a format that is not made."""
    several = [name for name in ("-compare", "-all", "-animate") if name in given]
    if len(several) > 1:
        raise InputError(f"plot: {several[0]} and {several[1]} are two things; give one of them")
    if "-animate" in given and "-times" in given:
        raise InputError("plot: -times are of pages; a film has all frames, or 200 of them")
    if "-all" in given and "-fields" in given:
        raise InputError("plot: -fields are of pages and films; -all draws all there are")
    suffixes = FILMS if "-animate" in given else () if "-all" in given else PICTURES
    known = {*PICTURES, *FILMS, ".jpg", ".jpeg", ".bmp", ".webp", ".eps", ".ps", ".tif", ".tiff", ".webm", ".avi", ".mov"}
    if where.suffix.lower() in known and where.suffix not in suffixes:
        wanted = f"a name that ends with {', '.join(suffixes)}, or a directory" if suffixes else "a directory"
        raise InputError(f"plot: -o {where}: expected {wanted}")


def _times(text: str) -> tuple[float, ...]:
    try:
        times = tuple(float(word) for word in text.split(","))
    except ValueError:
        times = (float("nan"),)
    if not all(map(isfinite, times)):
        raise InputError(f"plot: -times {text}: expected times with commas, as 0,0.25")
    return times


def _write(target: Path, draw_on: Callable[[Figure], None], faults: Sequence[str]) -> None:
    """Draw a figure and keep it; faults: what could not be drawn, of numbers of which even axes may fail."""
    matplotlib = needed("plot")
    from matplotlib.figure import Figure

    with matplotlib.rc_context({**STYLE, "svg.fonttype": "none", "pdf.fonttype": 42}), np.errstate(all="ignore"):
        figure = Figure()
        draw_on(figure)
        try:
            with writing(target):
                figure.savefig(target)
        except FileError:
            raise
        except Exception as error:
            if not faults:
                raise
            what = ", ".join(faults)
            raise FileError(f"the result is damaged, nothing of it can be drawn: {what}; {reason(error)}") from error
