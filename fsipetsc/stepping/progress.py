"""How far a run is: a bar on a terminal, else a line now and then."""

from __future__ import annotations

import math
import os
import shutil
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

from fsipetsc.checks import duration

#: wall seconds between two looks at the bar; from the first line to the next, ever longer; with -fsi_progress from the first
_BAR, _FIRST, _ASKED, _RAREST = 0.1, 10.0, 2.0, 60.0
#: steps after which the clock is asked, at first
_STEPS = 32
_LAUNCHED = "OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"


def on_terminal() -> bool:
    """Whether somebody sees the standard output as it comes.

    A launcher gives the ranks terminals of their own, whatever its output goes to; where it runs on this machine, that is seen.
    """
    if not sys.stdout.isatty():
        return False
    if not any(name in os.environ for name in _LAUNCHED):
        return True
    try:
        return os.path.realpath(f"/proc/{os.getppid()}/fd/1").startswith(("/dev/pts/", "/dev/tty"))
    except OSError:
        return False


class Progress:
    """Shown by one rank. end: time at which the run ends; unit: behind it; asked: -fsi_progress; most: steps in all."""

    def __init__(self, end: float, unit: str, asked: bool, most: float = math.inf) -> None:
        self._end, self._unit, self._most = end, unit, most
        self._bar = _new_bar() if on_terminal() else None
        self._interval = _BAR if self._bar is not None else _ASKED if asked else _FIRST
        self._next, self._shown = 0, False

    def start(self, t: float, steps: int, until: float = math.inf) -> None:
        """The time loop begins at time t: what is done and left is reckoned from here. until: the clock's time when it ends."""
        self._begin = self._seen = t, steps, time.monotonic()
        self._until = until
        self._next = steps + 1

    def step(self, steps: int, t: float, dt: float, reason: Callable[[], str]) -> None:
        """Show it, if that is due. reason: says why a step is no longer than that."""
        if steps < self._next:
            return
        now, (_, before, last) = time.monotonic(), self._seen
        if now - last < self._interval:
            self._next = steps + (_STEPS if self._bar is None else 1)
            return
        self._seen = t, steps, now
        part, to = self._done(t, steps, now)
        left = f"{duration((now - self._begin[2]) * (1.0 / part - 1.0))} left{to}"
        why, rate = reason(), _handy((steps - before) / (now - last))
        if self._bar is not None:
            self._shown = True
            self._bar.n, self._bar.ncols = part, shutil.get_terminal_size().columns - 1
            self._bar.set_description_str(f"t {t:.4g}/{self._end:g}{self._unit}", refresh=False)
            bound = f"dt {dt:.3g}{self._unit}{f': {why}' if why else ''}"
            self._bar.set_postfix_str(f"{left}, step {steps} ({rate}/s), {bound}")
            return
        self._interval = min(1.5 * self._interval, _RAREST)
        done = f"  t = {t:.4g} of {self._end:g}{self._unit} ({100 * part:.0f} %), step {steps}"
        bound = f"dt = {dt:.3g}{self._unit}{f' by {why}' if why else ''}"
        print(f"{done}, {bound}, {rate} steps/s, {left}", flush=True)

    def _done(self, t: float, steps: int, now: float) -> tuple[float, str]:
        """Part of the way to the end that comes first, and which end that is, if it is not the run's time."""
        ends = (self._end, ""), (self._most, " to -ts_max_steps"), (self._until, " to -fsi_wall_limit")
        parts = [
            ((at - begin) / (end - begin) if end > begin else 1.0, to)
            for at, begin, (end, to) in zip((t, steps, now), self._begin, ends, strict=True)
        ]
        part, to = max(parts, key=lambda entry: entry[0])
        return min(part, 1.0), to

    def clear(self) -> None:
        """Make room for a line: the bar comes back with the next step that shows it."""
        if self._shown:
            self._bar.clear()
            self._shown = False


def _new_bar() -> Any:
    """A bar of parts of 1; None without tqdm."""
    try:
        from tqdm import tqdm
    except ImportError:
        return None

    class Bar(tqdm):
        monitor_interval = 0  # no thread that looks after it

    Bar.set_lock(threading.RLock())  # that of one process is enough
    layout = "{desc} |{bar:10}|{percentage:3.0f} %{postfix}"
    return Bar(total=1.0, file=sys.stdout, bar_format=layout, ncols=80, nrows=24, leave=False, mininterval=0, delay=1e9)


def _handy(rate: float) -> str:
    return f"{rate / 1e3:.3g}k" if rate >= 1e3 else f"{rate:.3g}"
