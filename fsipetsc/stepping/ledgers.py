"""By how much a run has departed from what must be kept: for its summary and for -fsi_check."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.scheme.conservation_check import Drifts

#: what a checkpoint keeps as it is
KEPT = "steps", "departures", "J_error", "energies"
#: a part of the run's energy that may be round-off: of a smaller one no share is told
ROUND_OFF = 1e-12


class Ledgers:
    """The largest departures of a problem's invariants, on rank 0, as records of steps come.

    invariants: see fsipetsc.scheme.conservation_check.Drifts. tolerance: that of -fsi_check, or
    None; unit: what comes after a time in a message.

    departures   name -> largest relative departure of any step so far; nan if one was no number
    J_error      largest departure of J from the volume of the grid, over it; 0 if none is recorded
    energies     [J] kinetic and elastic energy of solids that all steps have lost, less what they
                 have won; the most that there was of it; the most that there was of all energy
    fault        the first departure beyond the tolerance, in words; None if there is none
    """

    def __init__(
        self, invariants: Mapping[str, Any], tolerance: float | None = None, unit: str = " s"
    ) -> None:
        self._invariants, self._tolerance, self._unit = invariants, tolerance, unit
        self.steps = 0
        self.departures: dict[str, float] = {}
        self.J_error = 0.0
        self.energies = [0.0, 0.0, 0.0]
        self.fault: str | None = None

    def begin(self, initial: Mapping[str, Any], memory: Mapping[str, Any] | None = None) -> None:
        """initial: the integrals at the beginning of the run. memory: of the steps before."""
        memory = dict(memory or {})
        first = (abs(initial.get(name, 0.0)) for name in ("solid_energy", "energy"))
        self.energies[1:] = map(float, first)
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
            self._note_lost(*(steps[name] for name in ("lost_energy", "solid_energy", "energy")))
        found = self._drifts.go_on({name: steps[name] for name in names})
        for name, drift in found.items():  # np.maximum: what is no number is larger than all
            largest = np.maximum(self.departures.get(name, 0.0), np.abs(drift).max())
            self.departures[name] = float(largest)
        if self._tolerance is not None and self.fault is None:
            self.fault = self._first_beyond(found, steps["t"])
        self.steps += len(steps)

    def _note_lost(self, lost: np.ndarray, of_solids: np.ndarray, of_all: np.ndarray) -> None:
        """What some more steps have lost, step by step: the same sum however they are cut."""
        summed, *most = self.energies
        for k, energy in enumerate((of_solids, of_all)):
            most[k] = float(np.maximum(most[k], np.abs(energy).max()))
        self.energies = [float(np.cumsum([summed, *lost])[-1]), *most]

    @property
    def lost(self) -> float:
        """Share of their largest kinetic and elastic energy that solids have lost to the steps."""
        summed, of_solids, of_all = self.energies
        return summed / of_solids if of_solids > ROUND_OFF * of_all else 0.0

    def _first_beyond(self, found: Mapping[str, np.ndarray], t: np.ndarray) -> str | None:
        """The first step, and the law, with a departure beyond the tolerance."""
        beyond = {name: ~(np.abs(drift) <= self._tolerance) for name, drift in found.items()}
        first = {name: int(np.argmax(broken)) for name, broken in beyond.items() if broken.any()}
        if not first:
            return None
        name, step = min(first.items(), key=lambda entry: entry[1])
        when = f"t = {t[step]:.6g}{self._unit}, step {self.steps + step + 1}"
        return f"{name} has drifted by {found[name][step]:.3g} (relative) at {when}"
