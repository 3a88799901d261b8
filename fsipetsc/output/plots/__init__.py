"""Pictures of a result, one file for each kind: fluid blue, solid red, over the Eulerian coordinate."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.output.places import writing
from fsipetsc.output.plots import balances, interfaces, maps, profiles, space_time, steps
from fsipetsc.output.plots.frames import check_drawable
from fsipetsc.output.plots.quantities import PROFILES
from fsipetsc.output.plots.style import STYLE, needed
from fsipetsc.output.reader import Run, open_run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Item = TypeVar("Item")


def plot(
    path: str | os.PathLike[str],
    outdir: str | os.PathLike[str] = ".",
    times: Sequence[float] | None = None,
) -> list[Path]:
    """Draw all pictures of a result, each by itself; returns the PNG files, named after the result.

    times   of the profiles (the nearest saved frames are taken); by default some at which there is something to see

    Raises FileError if the result cannot be read or the pictures cannot be written, InputError without matplotlib. Of a
    damaged result all that can be drawn is drawn first; the error names the other pictures.
    """
    matplotlib = needed("plot")
    folder, written = Path(outdir), []
    faults: list[str] = []
    with open_run(path) as run, matplotlib.rc_context(STYLE), np.errstate(all="ignore"):
        check_drawable(run)
        for name, picture in drawn(run, faults, times):
            target = folder / f"{Path(path).stem}-{name}.png"
            with writing(target):
                target.write_bytes(picture)
            written.append(target)
    complain(path, faults, f"{len(written)} pictures of it are in {folder}" if written else "")
    return written


def drawn(run: Run, faults: list[str], times: Sequence[float] | None = None) -> Iterator[tuple[str, bytes]]:
    """Name and PNG of each picture; of a damaged result those that can be drawn. faults: gets what the others failed of."""
    from matplotlib.figure import Figure

    for name, draw in whole(pictures(run, times), faults, "others"):
        figure, kept = Figure(), io.BytesIO()
        try:
            draw(figure)
            figure.savefig(kept, format="png")
        except Exception as error:  # there is no end to what may be wrong with damaged numbers
            faults.append(f"{name} ({reason(error)})")
            continue
        yield name, kept.getvalue()


def complain(path: str | os.PathLike[str], faults: Sequence[str], done: str) -> None:
    """FileError if something could not be drawn; done: what there is nevertheless."""
    if faults:
        there = f"; {done}" if done else ""
        raise FileError(f"{os.fspath(path)}: the result is damaged, not drawn: {', '.join(faults)}{there}")


def whole(found: Iterator[Item], faults: list[str], what: str) -> Iterator[Item]:
    """What is found until something fails, which is noted."""
    try:
        yield from found
    except Exception as error:
        faults.append(f"{what} ({reason(error)})")


def reason(error: Exception) -> str:
    """Its message in a line."""
    return " ".join(str(error).split())[:200] or type(error).__name__


def pictures(run: Run, times: Sequence[float] | None = None) -> Iterator[tuple[str, Callable[[Figure], None]]]:
    """Names and drawing functions of the pictures that this run has the data for."""
    if run.dimension == 2:
        yield from maps.pictures(run, times)
        return
    if run.nframes:
        for quantity in PROFILES:
            if any(quantity.of(layer.kind) for layer in run.layers):
                yield quantity.name, partial(profiles.draw, run=run, quantity=quantity, times=times)
    if run.nframes > 4:
        yield "xt", partial(space_time.draw, run=run)
    if len(run.series.get("t", ())) < 2:
        return
    has = set(run.series)
    if "x_interface" in has:
        yield "interfaces", partial(interfaces.draw_positions, run=run)
    if has & set(interfaces.TRACES):
        yield "traces", partial(interfaces.draw_traces, run=run)
    if has & set(interfaces.RESIDUALS):
        yield "residuals", partial(interfaces.draw_residuals, run=run)
    if {"force", "momentum"} <= has:
        yield "momentum", partial(balances.draw_momentum, run=run)
    if balances.departures(run):
        yield "balance", partial(balances.draw_balances, run=run)
    if "dt" in has:
        yield "steps", partial(steps.draw, run=run)
