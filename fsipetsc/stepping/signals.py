"""What signals want of a run while its steps are made."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from fsipetsc.stepping.pauses import Pauses

#: what ends a run in order
STOPPING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)


@contextmanager
def ends(pauses: Pauses) -> Iterator[None]:
    """SIGTERM, SIGINT and SIGHUP let the current burst of steps end; all ranks stop together.

    One that comes before the first step is answered after it; one after the last step is not
    answered. A second SIGINT ends at once. A signal that is ignored stays so, as SIGHUP under nohup.
    """

    def note(number: int, frame: object) -> None:
        pauses.raised = number
        if number == signal.SIGINT:
            signal.signal(number, signal.SIG_DFL)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heeded = [n for n in STOPPING if signal.getsignal(n) is not signal.SIG_IGN]
    earlier = {number: signal.signal(number, note) for number in heeded}
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
