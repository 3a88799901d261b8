"""Which frames are drawn for the times that are asked for, and how their times are written."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.output.plots.scales import unit_of
from fsipetsc.output.reader import Run

SAME = 1e-9  # of the largest time: times that are nearer to each other are one


def check_drawable(run: Run) -> None:
    """InputError for a result that there are no pictures of."""
    if run.dimension > 2:
        beside = Path(run.path).with_suffix(".xdmf").name
        raise InputError(f"{run.path}: no pictures of three dimensions; ParaView opens {beside} beside it")


def at_times(run: Run, times: Sequence[float]) -> list[int]:
    """The frames nearest to the times, each once, in their order."""
    return sorted({run.at(t) for t in times})


def evenly(run: Run, count: int) -> list[int]:
    """So many frames from the first to the last one, fewer where there are fewer."""
    return sorted({round(part * (run.nframes - 1)) for part in np.linspace(0, 1, count)})


def moment(run: Run, frame: int) -> str:
    """When a frame is, as titles say it."""
    return f"t = {run.time[frame]:.4g}{unit_of(run, 's')}"


def outside(run: Run, times: Sequence[float]) -> Iterator[str]:
    """What is to be said of times before the first frame or after the last one, in whose place that one is drawn."""
    if not run.nframes:
        return
    slack = SAME * float(np.max(np.abs(run.time)))
    for side, which, frame in ((-1, "begins", 0), (1, "ends", run.nframes - 1)):
        missed = [f"{t:g}" for t in times if side * (t - run.time[frame]) > slack]
        if missed:
            place = f"{Path(run.path).name} {which} at t = {run.time[frame]:g}{unit_of(run, 's')}"
            yield f"note: -times {','.join(missed)}: {place}; its {'last' if side > 0 else 'first'} frame is drawn"


def apart(a: Run, b: Run, pairs: Sequence[tuple[int, int]]) -> Iterator[str]:
    """What is to be said of frames of two runs that are drawn as if they were of one time, and are not."""
    slack = SAME * float(np.max(np.abs(a.time)))
    told = [f"{a.time[i]:g} and {b.time[j]:g}" for i, j in pairs if abs(a.time[i] - b.time[j]) > slack]
    if told:
        yield f"note: {Path(a.path).name} and {Path(b.path).name} are at other times: t = {', '.join(told)}{unit_of(a, 's')}"
