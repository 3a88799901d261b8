"""Signals before the time loop, and a launcher that has gone. In the loop, fsipetsc.stepping.run answers signals."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from fsipetsc.errors import FsiError

#: what ends a run in order
STOPPING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
_PR_SET_PDEATHSIG = 1


class Interrupted(FsiError):
    """A run that a signal ended. Exit status 128 + signal."""

    def __init__(self, number: int, message: str, *, collective: bool = True) -> None:
        super().__init__(message, collective=collective)
        self.status = 128 + number


def heeded() -> list[signal.Signals]:
    """The stopping signals that are not ignored: nohup ignores SIGHUP on purpose."""
    return [number for number in STOPPING if signal.getsignal(number) is not signal.SIG_IGN]


@contextmanager
def held_back() -> Iterator[None]:
    """Signals wait: within, a rank that left would leave the others waiting, or modules half imported."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def raised(when: str = "") -> Iterator[None]:
    """Signals raise Interrupted, on this rank alone; in the main thread only, as Python has it. when: for the message."""

    def leave(number: int, frame: object) -> None:
        raise Interrupted(number, f"stopped by {signal.Signals(number).name} {when}".rstrip(), collective=False)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    earlier = {number: signal.signal(number, leave) for number in heeded()}
    try:
        yield
    finally:
        for number, handler in earlier.items():
            signal.signal(number, handler)


class Launcher:
    """The process that started this one: mpiexec, if there are several ranks, is not to be survived."""

    def __init__(self) -> None:
        self._process = os.getppid()
        self._launched = any(name in os.environ for name in ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"))

    def follow(self) -> None:
        """Get a SIGTERM when the launcher ends, by whatever; on Linux."""
        if self._launched and sys.platform == "linux":
            ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
            if self.gone():  # before it was asked
                os.kill(os.getpid(), signal.SIGTERM)

    def gone(self) -> bool:
        """It is; then MPI cannot be ended in order, nor all ranks be stopped."""
        return self._launched and os.getppid() != self._process

    def leave_if_gone(self, status: int) -> None:
        """End this process at once, without MPI's farewell, which would wait for the launcher for ever."""
        if self.gone():
            for stream in (sys.stdout, sys.stderr):
                try:
                    stream.flush()
                except (OSError, ValueError):
                    continue
            os._exit(status)
