"""By how much a run has departed from what must be kept, for its summary: on rank 0, piece by piece as steps are written."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.scheme.conservation_check import Drifts


class Ledgers:
    """The largest departures of the invariants of a problem (fsipetsc.scheme.conservation_check.drifts).

    departures   name -> largest relative departure of any step so far
    """

    def __init__(self, invariants: Mapping[str, Any]) -> None:
        self._invariants = invariants
        self._drifts: Drifts | None = None
        self.departures: dict[str, float] = {}

    def add(self, steps: np.ndarray, initial: Mapping[str, Any]) -> None:
        """The records of some more steps, on rank 0 with the sums over all ranks; initial: the integrals at t = 0."""
        if not self._invariants or not len(steps) or not initial:
            return
        if self._drifts is None:
            self._drifts = Drifts(self._invariants, initial)
        found = self._drifts.go_on({name: steps[name] for name in steps.dtype.names or ()})
        for name, drift in found.items():
            self.departures[name] = max(self.departures.get(name, 0.0), float(np.abs(drift).max()))

    def memory(self) -> dict[str, Any] | None:
        """What ``recall`` takes, as JSON has it."""
        if self._drifts is None:
            return None
        return {"drifts": self._drifts.memory(), "departures": dict(self.departures)}

    def recall(self, memory: Mapping[str, Any] | None, initial: Mapping[str, Any]) -> None:
        """Go on behind the steps of which ``memory`` tells; without it nothing is known of them, and nothing said."""
        if memory is None:
            self._invariants, self._drifts = {}, None
            return
        self._drifts = Drifts(self._invariants, initial)
        self._drifts.recall(memory["drifts"])
        self.departures = dict(memory["departures"])
