"""By how much a run has departed from what must be kept, for its summary: on rank 0, piece by piece as steps are written."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.scheme.conservation_check import Drifts


class Ledgers:
    """The largest departures of the invariants of a problem (fsipetsc.scheme.conservation_check.drifts).

    departures   name -> largest relative departure of any step so far; nan if one was no number
    J_error      largest departure of J from the volume of the grid, over it; 0 if none is recorded
    """

    def __init__(self, invariants: Mapping[str, Any]) -> None:
        self._invariants = invariants
        self._drifts: Drifts | None = None
        self.departures: dict[str, float] = {}
        self.J_error = 0.0

    def begin(self, initial: Mapping[str, Any]) -> None:
        """initial: the integrals at the beginning of the run."""
        if self._invariants and initial:
            self._drifts = Drifts(self._invariants, initial)

    def add(self, steps: np.ndarray) -> None:
        """The records of some more steps, on rank 0 with the sums over all ranks."""
        if len(steps) and "J_error" in (steps.dtype.names or ()):
            self.J_error = float(np.maximum(self.J_error, steps["J_error"].max()))
        if self._drifts is None or not len(steps):
            return
        found = self._drifts.go_on({name: steps[name] for name in steps.dtype.names or ()})
        for name, drift in found.items():  # np.maximum: what is no number is larger than all
            self.departures[name] = float(np.maximum(self.departures.get(name, 0.0), np.abs(drift).max()))

    def memory(self) -> dict[str, Any] | None:
        """What ``recall`` takes, as JSON has it."""
        if self._drifts is None:
            return None
        kept = {"departures": dict(self.departures), "J_error": self.J_error}
        return {"drifts": self._drifts.memory(), **kept}

    def recall(self, memory: Mapping[str, Any] | None, initial: Mapping[str, Any]) -> None:
        """Go on behind the steps of which ``memory`` tells; without it nothing is known of them, and nothing said."""
        if memory is None:
            self._invariants, self._drifts = {}, None
            return
        self._drifts = Drifts(self._invariants, initial)
        self._drifts.recall(memory["drifts"])
        self.departures = dict(memory["departures"])
        self.J_error = memory.get("J_error", 0.0)
