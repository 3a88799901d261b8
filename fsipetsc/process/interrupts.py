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


#: (number, message) of the signals that have come within ``raised`` and that nobody has taken over
_noted: list[tuple[int, str]] = []


class Interrupted(FsiError):
    """A run that a signal ended. Exit status 128 + signal."""

    def __init__(self, number: int, message: str, *, collective: bool = True) -> None:
        super().__init__(message, collective=collective)
        self.args = number, message  # what makes it again, on another rank
        self.status = 128 + number

    def __str__(self) -> str:
        return str(self.args[-1])


def heeded() -> list[signal.Signals]:
    """The stopping signals that are not ignored: nohup ignores SIGHUP on purpose."""
    return [number for number in STOPPING if signal.getsignal(number) is not signal.SIG_IGN]


@contextmanager
def held_back() -> Iterator[None]:
    """Signals wait: within, a rank that left would leave the others waiting, or modules half imported.

    What answers them stays: a library that starts may answer one itself, as UCX, below MPI, does with SIGHUP.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)
    answers = {number: signal.getsignal(number) for number in STOPPING}
    try:
        yield
    finally:
        if threading.current_thread() is threading.main_thread():
            for number, answer in answers.items():
                if answer is not None:  # one of C's that was there before
                    signal.signal(number, answer)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def came() -> Interrupted | None:
    """What a signal within ``raised`` has raised, on this rank; it may have been swallowed or said to be another error."""
    return Interrupted(*_noted[0], collective=False) if _noted else None


def take_over() -> int:
    """The number of a signal that has come within ``raised``, else 0. Who asks ends the run: `came` knows no more of it."""
    number = _noted[0][0] if _noted else 0
    _noted.clear()
    return number


@contextmanager
def raised(when: str = "") -> Iterator[None]:
    """Signals raise Interrupted, on this rank alone; in the main thread only, as Python has it. when: for the message.

    That may be at any place, where an exception is taken for another error or goes unheard, as in a callback. So the
    signal is noted, too: whatever leaves this context then is Interrupted, and who goes on asks `came` or `take_over`.
    """

    def leave(number: int, frame: object) -> None:
        _noted.append((number, f"stopped by {signal.Signals(number).name} {when}".rstrip()))
        raise Interrupted(*_noted[-1], collective=False)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    _noted.clear()
    earlier = {number: signal.signal(number, leave) for number in heeded()}
    try:
        yield
    except Exception as error:
        if _noted and not isinstance(error, Interrupted):
            raise Interrupted(*_noted[0], collective=isinstance(error, FsiError) and error.collective) from error
        raise
    else:
        if _noted:
            name = signal.Signals(_noted[0][0]).name
            raise Interrupted(_noted[0][0], f"{name} came; what it was to stop is done", collective=False)
    finally:
        _noted.clear()
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
