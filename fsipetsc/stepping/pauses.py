"""When the steps pause for a checkpoint, and which signals end them.

What a rank wants is a word that goes round with what the ranks tell each other after a step anyway
(SAID_STOP and STOP of fsipetsc.scheme.plan); the largest one counts, and all ranks find it after
the same step. So a signal may come to any rank, and the clock of rank 0 alone is asked. Checkpoints
after a number of steps need no word.
"""

import math
import signal
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

#: the word for a checkpoint, below those of signals, which are their numbers
CHECKPOINT = 0.5
#: what ends a run in order
STOPPING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)


class Pauses:
    """What this rank wants, and what is due. opt: options in force; clock: this rank's counts."""

    def __init__(self, opt: Mapping[str, Any], clock: bool) -> None:
        self.raised = 0  # number of a signal that ends the run, on this rank
        self._every = opt["fsi_checkpoint_steps"] or 0
        wall = opt["fsi_checkpoint_wall"]
        self._interval = wall if clock and wall else math.inf
        self._regular = bool(self._every or wall)
        self._last = time.monotonic()

    def word(self) -> float:
        """What this rank has to say after the next batch of steps."""
        if self.raised:
            return float(self.raised)
        return CHECKPOINT if time.monotonic() >= self._last + self._interval else 0.0

    def allowed(self, steps: int, most: int) -> int:
        """How many steps, at most ``most``, may follow on number ``steps`` before a checkpoint."""
        return min(most, self._every - steps % self._every) if self._every else most

    def due(self, steps: int, word: float, last: bool) -> bool:
        """Whether a checkpoint follows so many steps, with this word of all ranks.

        last: no step follows; who wants checkpoints can go on from the end of the run, too.
        """
        regular = self._every > 0 and steps % self._every == 0
        return word != 0.0 or (last and self._regular) or regular

    def written(self) -> None:
        """A checkpoint has been written."""
        self._last = time.monotonic()


@contextmanager
def signals_noted(pauses: Pauses) -> Iterator[None]:
    """SIGTERM, SIGINT and SIGHUP let the current batch of steps end; all ranks stop together.

    One that comes before the first step is answered after it; one after the last step is not
    answered. A second SIGINT ends at once. A signal that is ignored stays so, as SIGHUP under
    nohup.
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
