"""What signals want of a run while its steps are made."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from fsipetsc.process.interrupts import heeded, take_over
from fsipetsc.stepping.pauses import Pauses


@contextmanager
def ends(pauses: Pauses) -> Iterator[None]:
    """SIGTERM, SIGINT and SIGHUP let the current burst of steps end; all stop together. A second SIGINT ends at once."""

    def note(number: int, frame: object) -> None:
        pauses.raised = number
        if number == signal.SIGINT:
            signal.signal(number, signal.SIG_DFL)

    earlier = {number: signal.signal(number, note) for number in heeded()}
    pauses.raised = pauses.raised or take_over()  # one that came before, and was not heard
    try:
        yield
    finally:
        for number, handler in earlier.items():
            if signal.getsignal(number) is note:
                signal.signal(number, handler)


@contextmanager
def asks(pauses: Pauses) -> Iterator[None]:
    """SIGUSR1 asks for a checkpoint after the current burst of steps, or once the steps begin."""

    def note(number: int, frame: object) -> None:
        pauses.asked = True

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    earlier = signal.signal(signal.SIGUSR1, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGUSR1, earlier)
