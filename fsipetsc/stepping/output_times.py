"""Which step comes next: the bound on the step, and the times that must be hit exactly."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Sequence

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.output.reader import open_run
from fsipetsc.scheme.time_step import next_step

#: profiles of a run
MOST = 10_000_000


def saved_times(
    t_end: float, interval: float | None, times: Sequence[float] | None, unit: str = " s"
) -> list[float]:
    """Times [s] in [0, t_end] at which profiles are saved: every ``interval`` and at the ``times``, and at the end.

    Raises InputError for times beyond the run's end, and for more than MOST; unit: what stands behind a time in its message.
    """
    saved = set(times or ())
    if beyond := sorted(t for t in saved if t > t_end):
        why = f"the run ends at -ts_max_time {t_end:g}{unit}"
        raise InputError(f"-fsi_output_times: {listed(beyond)}{unit} would not be reached, {why}")
    if interval is not None:
        if t_end / interval > MOST:
            raise InputError(f"-fsi_output_dt {interval:g} would save more than {MOST} profiles to t = {t_end:g}{unit}")
        saved.update(min(k * interval, t_end) for k in range(math.floor(t_end / interval * (1 + 1e-12)) + 1))
    saved.add(t_end)
    return sorted(saved)


def times_without_frame(times: Collection[float], t: float, path: str | os.PathLike[str]) -> str:
    """Those of the times [s] up to t at which the result has no frame, listed; "" if there are none. FileError."""
    early = sorted(time for time in times if time <= t)
    if not early:
        return ""
    with open_run(path) as run:
        frames = np.asarray(run.time)
    return listed([time for time in early if not np.isclose(frames, time, rtol=1e-12, atol=0.0).any()])


def listed(times: Sequence[float]) -> str:
    """The first ones."""
    return ", ".join(f"{t:g}" for t in times[:5]) + (" …" if len(times) > 5 else "")


class OutputTimes:
    """Hands out steps so that every target is the end of a step, without a tiny step before it."""

    def __init__(self, targets: Sequence[float]) -> None:
        self._targets = sorted(targets)
        self._next = 0

    def pass_time(self, t: float) -> bool:
        """Note that the time t [s] is reached; True if it is a target."""
        reached = False
        while self._next < len(self._targets) and self._targets[self._next] <= t:
            reached, self._next = True, self._next + 1
        return reached

    @property
    def done(self) -> bool:
        """All targets are reached."""
        return self._next == len(self._targets)

    @property
    def target(self) -> float:
        """The next time [s] that must be hit."""
        return self._targets[self._next]

    def step(self, t: float, bound: float) -> tuple[float, float]:
        """(step, time after it) [s]: at most ``bound``; with less than two steps to the next target they are equal."""
        return next_step(t, self.target, bound)
