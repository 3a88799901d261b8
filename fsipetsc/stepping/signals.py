"""Signals that end a run in order.

What a rank wants is a word that goes round with what the ranks tell each other after a step anyway
(SAID_STOP and STOP of fsipetsc.scheme.plan); the largest one counts, and all ranks find it after
the same step. So a signal may come to any rank, and the clock of rank 0 alone is asked. Checkpoints
after a number of steps need no word.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: the word for a checkpoint, below those of signals, which are their numbers
CHECKPOINT = 0.5
#: what ends a run in order
STOPPING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)


@contextmanager
def signals_noted(heed: Callable[[int], object]) -> Iterator[None]:
    """SIGTERM, SIGINT and SIGHUP let the current batch of steps end; all ranks stop together.

    heed: gets the number of a signal. One that comes before the first step is answered after it;
    one after the last step is not answered. A second SIGINT ends at once. A signal that is ignored
    stays so, as SIGHUP under nohup.
    """

    def note(number: int, frame: object) -> None:
        heed(number)
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
