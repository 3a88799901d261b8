"""When the steps pause for a checkpoint, and when they end before their time.

What a rank wants is a word that goes round with what the ranks tell each other after a step anyway (SAID_STOP and STOP of
fsipetsc.scheme.plan); the largest word counts, and all ranks find it after the same step. So a signal may come to any rank, and
the clock of rank 0 alone is asked. Checkpoints after a number of steps need no word.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import Any

#: words, below those of signals, which are their numbers: a checkpoint is wanted; the wall time is used up
CHECKPOINT, OUT_OF_TIME = 0.25, 0.5
#: seconds that are left for what follows the last step: the ends of other ranks, of the launcher
RESERVE = 1.0


class Pauses:
    """What this rank wants, and what is due. opt: options in force; clock: this rank's is the one that counts."""

    def __init__(self, opt: Mapping[str, Any], clock: bool) -> None:
        self.raised = 0  # number of a signal that ends the run, on this rank
        self.asked = False  # by a signal, on this rank
        self._every = opt["fsi_checkpoint_steps"] or 0
        self._interval = opt["fsi_checkpoint_wall"] if clock else None
        self._limit = opt["fsi_wall_limit"] if clock else None
        self._regular = bool(self._every or opt["fsi_checkpoint_wall"])
        self._begun = self._last = self._looked = time.monotonic()
        self._longest = self._cost = 0.0  # seconds between two looks at the clock, and of a checkpoint

    @property
    def ends(self) -> float:
        """When the last step is to end, by time.monotonic: the wall time less what follows; inf: no matter, or not here."""
        if self._limit is None:
            return math.inf
        return self._begun + self._limit - (RESERVE + 2.0 * self._longest + 3.0 * self._cost)

    def word(self) -> float:
        """What this rank has to say after the next step. To be asked before each burst of steps."""
        if self.raised:
            return float(self.raised)
        if self._limit is not None or self._interval is not None:
            now = time.monotonic()
            self._longest, self._looked = max(self._longest, now - self._looked), now
            if now >= self.ends:
                return OUT_OF_TIME
            if self._interval is not None and now >= self._last + self._interval:
                return CHECKPOINT
        return CHECKPOINT if self.asked else 0.0

    def allowed(self, steps: int, most: int) -> int:
        """How many steps, at most ``most``, may follow on number ``steps`` before a checkpoint is due."""
        return min(most, self._every - steps % self._every) if self._every else most

    def due(self, steps: int, word: float, last: bool) -> bool:
        """Whether there is to be a checkpoint after so many steps, with this word of all ranks. The same on all ranks.

        last: no step follows; whoever wants checkpoints finds the end of the run there, and can go on from it.
        """
        return word != 0.0 or (last and self._regular) or (self._every > 0 and steps % self._every == 0)

    def written(self, seconds: float) -> None:
        """A checkpoint has been written in so many seconds."""
        self.asked, self._cost = False, max(self._cost, seconds)
        self._last = self._looked = time.monotonic()
