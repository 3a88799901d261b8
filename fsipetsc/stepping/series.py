"""What is recorded at every step, kept in a buffer until it is written."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from fsipetsc.parallel.plan import CAPACITY, ENERGY, ENTROPY, FLAGS, FORCE, HEATING, LIMITS, MOMENTUM
from fsipetsc.stepping.state import State

#: columns per interface, as ``fsipetsc.parallel.completion.interface_state`` fills them
_INTERFACE = ("x", "u", "sigma", "T")
_RESIDUALS = ("u", "stress", "T", "flux")


class Series:
    """Per-step data of this rank, in the state's journal; integrals are this rank's shares until ``take`` adds them up."""

    def __init__(self, state: State, entropy: bool) -> None:
        layers = state.problem.layers
        self._state = state
        self._fluids = [k for k, layer in enumerate(layers) if layer.kind == "fluid"]
        self._layers = len(layers)
        self._integrals = {"energy": ENERGY, "momentum": MOMENTUM, "force": FORCE}
        if entropy:
            self._integrals |= {"entropy": ENTROPY, "heating": HEATING}
        self.count = 0

    @property
    def room(self) -> int:
        """How many steps may be made before they must be written."""
        return CAPACITY - self.count

    def write(self, t: float, dt: float) -> None:
        """Put a step into the journal: time and step [s], with the state's results. A burst does so itself."""
        row = self._state.journal[self.count]
        row[0], row[1], row[2:] = t, dt, self._state.results

    def keep(self, steps: int) -> None:
        """The next steps in the journal belong to the series."""
        self.count += steps

    def take(self, comm: MPI.Comm) -> dict[str, np.ndarray]:
        """Name -> array of all steps kept, on rank 0 with the sums over all ranks; empties the buffer. Collective."""
        rows, nI = self._state.journal[: self.count], len(self._state.states)
        n, self.count = self.count, 0
        faces = rows[:, 2 + FLAGS + LIMITS :][:, : 8 * nI].reshape(n, nI, 8)
        shares = rows[:, 2 + FLAGS + LIMITS + 8 * nI :].copy()
        if comm.size > 1:
            comm.Reduce(MPI.IN_PLACE if comm.rank == 0 else shares, shares, MPI.SUM, 0)
        names = [f"{name}_interface" for name in _INTERFACE] + [f"residual_{name}" for name in _RESIDUALS]
        data = {"t": rows[:, 0].copy(), "dt": rows[:, 1].copy()}
        data.update({name: faces[:, :, c].copy() for c, name in enumerate(names)})
        data["mass"] = shares[:, self._fluids]
        for name, at in self._integrals.items():
            data[name] = shares[:, self._layers + at].copy()
        return data
