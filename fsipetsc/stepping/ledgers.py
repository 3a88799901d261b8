"""By how much a run has departed from what must be kept: for its summary and for -fsi_check."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.output.structure import COUNT, MEASURE
from fsipetsc.scheme.conservation_check import Drifts

#: what a checkpoint keeps as it is -> what it must be (fsipetsc.output.structure)
KEPT = {
    "steps": COUNT,
    "departures": {str: MEASURE},
    "J_error": MEASURE,
    "lost": MEASURE,
    "energies": (MEASURE, MEASURE),
}


class Ledgers:
    """The largest departures of a problem's invariants, on rank 0, as records of steps come.

    invariants: see fsipetsc.scheme.conservation_check.Drifts. tolerance: that of -fsi_check, or
    None; unit: what comes after a time in a message.

    departures   name -> largest relative departure of any step so far; nan if one was no number
    J_error      largest departure of J from the volume of the grid, over it; 0 if none is recorded
    lost         most that steps have lost of the kinetic and elastic energy of solids, over its
                 largest value
    fault        the first departure beyond the tolerance, in words; None if there is none
    """

    def __init__(
        self, invariants: Mapping[str, Any], tolerance: float | None = None, unit: str = " s"
    ) -> None:
        self._invariants, self._tolerance, self._unit = invariants, tolerance, unit
        self.steps = 0
        self.departures: dict[str, float] = {}
        self.J_error = self.lost = 0.0
        self.energies = [0.0, 0.0]  # of that energy [J]: the lost sum, the most there was
        self.fault: str | None = None

    def begin(self, initial: Mapping[str, Any], memory: Mapping[str, Any] | None = None) -> None:
        """initial: the integrals at the beginning of the run. memory: of the steps before."""
        memory = dict(memory or {})
        self._drifts = Drifts(self._invariants, initial, memory.pop("drifts", None))
        vars(self).update(memory)

    def memory(self) -> dict[str, Any]:
        """What ``begin`` takes to go on from here, as JSON has it."""
        return {"drifts": self._drifts.memory, **{name: getattr(self, name) for name in KEPT}}

    def add(self, steps: np.ndarray) -> None:
        """The records of some more steps, with the sums over all ranks."""
        if not len(steps):
            return
        names = steps.dtype.names
        if "J_error" in names:
            self.J_error = float(np.maximum(self.J_error, steps["J_error"].max()))
        if "lost_energy" in names:
            self._note_lost(steps["lost_energy"], steps["solid_energy"])
        found = self._drifts.go_on({name: steps[name] for name in names})
        for name, drift in found.items():  # np.maximum: what is no number is larger than all
            largest = np.maximum(self.departures.get(name, 0.0), np.abs(drift).max())
            self.departures[name] = float(largest)
        if self._tolerance is not None and self.fault is None:
            self.fault = self._first_beyond(found, steps["t"])
        self.steps += len(steps)

    def _note_lost(self, lost: np.ndarray, energy: np.ndarray) -> None:
        """What some more steps have lost of an energy."""
        sums = self.energies[0] + np.cumsum(lost)
        most = float(np.maximum(self.energies[1], np.abs(energy).max()))
        self.energies = [float(sums[-1]), most]
        if most != 0.0:
            self.lost = float(np.maximum(self.lost, np.abs(sums).max() / most))

    def _first_beyond(self, found: Mapping[str, np.ndarray], t: np.ndarray) -> str | None:
        """The first step, and the law, with a departure beyond the tolerance."""
        beyond = {name: ~(np.abs(drift) <= self._tolerance) for name, drift in found.items()}
        first = {name: int(np.argmax(broken)) for name, broken in beyond.items() if broken.any()}
        if not first:
            return None
        name, step = min(first.items(), key=lambda entry: entry[1])
        when = f"t = {t[step]:.6g}{self._unit}, step {self.steps + step + 1}"
        return f"{name} has drifted by {found[name][step]:.3g} (relative) at {when}"
