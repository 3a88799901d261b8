"""What is recorded at every step, kept in a buffer until it is written."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from fsipetsc.parallel.plan import ENERGY, ENTROPY, FLAGS, FORCE, HEATING, INTEGRALS, LIMITS, MOMENTUM
from fsipetsc.problem import Problem

#: steps that are kept before they must be written: the same on all ranks
CAPACITY = 4096
#: columns per interface, as ``fsipetsc.parallel.completion.interface_state`` fills them
_INTERFACE = ("x", "u", "sigma", "T")
_RESIDUALS = ("u", "stress", "T", "flux")


class Series:
    """Per-step data of this rank; integrals are this rank's shares until ``take`` adds them up."""

    def __init__(self, problem: Problem, entropy: bool) -> None:
        nI = len(problem.interfaces)
        self._fluids = [k for k, layer in enumerate(problem.layers) if layer.kind == "fluid"]
        self._time = np.zeros((CAPACITY, 2))
        self._results = np.zeros((CAPACITY, FLAGS + LIMITS + 8 * nI + len(problem.layers) + INTEGRALS))
        self._faces = self._results[:, FLAGS + LIMITS :][:, : 8 * nI].reshape(CAPACITY, nI, 8)
        self._shares = self._results[:, FLAGS + LIMITS + 8 * nI :]
        self._layers = len(problem.layers)
        self._integrals = {"energy": ENERGY, "momentum": MOMENTUM, "force": FORCE}
        if entropy:
            self._integrals |= {"entropy": ENTROPY, "heating": HEATING}
        self.count = 0

    @property
    def full(self) -> bool:
        """No room for another step."""
        return self.count == CAPACITY

    def record(self, t: float, dt: float, results: np.ndarray) -> None:
        """Keep one step: time and step [s], results of the completed step (stepping.state)."""
        k = self.count
        self._time[k, 0], self._time[k, 1] = t, dt
        self._results[k] = results
        self.count += 1

    def take(self, comm: MPI.Comm) -> dict[str, np.ndarray]:
        """Name -> array of all steps kept, on rank 0 with the sums over all ranks; empties the buffer. Collective."""
        n, self.count = self.count, 0
        shares = np.zeros_like(self._shares[:n]) if comm.rank == 0 else None
        comm.Reduce(np.ascontiguousarray(self._shares[:n]), shares, MPI.SUM, 0)
        if shares is None:
            shares = self._shares[:n]
        names = [f"{name}_interface" for name in _INTERFACE] + [f"residual_{name}" for name in _RESIDUALS]
        data = {"t": self._time[:n, 0].copy(), "dt": self._time[:n, 1].copy()}
        data.update({name: self._faces[:n, :, c].copy() for c, name in enumerate(names)})
        data["mass"] = shares[:, self._fluids]
        for name, at in self._integrals.items():
            data[name] = shares[:, self._layers + at].copy()
        return data
