"""What is recorded at every step, kept in the state's journal until it is written."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from fsipetsc.parallel.plan import SHARES
from fsipetsc.stepping.state import State

#: steps whose shares are added up at once: they stay in a cache
BLOCK = 2048


class Series:
    """Per-step data of this rank, which fill the state's journal; integrals are this rank's shares until ``take``.

    most: steps after which they must be taken at the latest, if the journal is not full before.
    """

    def __init__(self, state: State, most: int | None = None) -> None:
        self._state, self._most = state, most or len(state.journal)
        self._first = state.journal.dtype.fields[SHARES][1] // 8  # number of a record with which shares begin
        self._sums = np.empty((BLOCK, state.journal.dtype.itemsize // 8 - self._first))
        self.count = 0

    @property
    def room(self) -> int:
        """How many steps may be made before they must be taken."""
        return min(self._most, len(self._state.journal)) - self.count

    def write(self, t: float, dt: float) -> None:
        """Put a step into the journal: time and step [s], with the state's results. A burst does so itself."""
        self._state.journal[self.count] = (t, dt, *self._state.latest)

    def keep(self, steps: int) -> None:
        """The next steps in the journal belong to the series."""
        self.count += steps

    def take(self, comm: MPI.Comm) -> np.ndarray:
        """The records of all steps kept, on rank 0 with the sums over all ranks; the journal is free again. Collective.

        Not copied: the next steps overwrite them.
        """
        steps, self.count = self._state.journal[: self.count], 0
        if comm.size > 1:
            numbers = steps.view(np.float64).reshape(len(steps), -1)
            for begin in range(0, len(steps), BLOCK):
                shares = numbers[begin : begin + BLOCK, self._first :]
                sums = self._sums[: len(shares)]
                sums[:] = shares
                comm.Reduce(MPI.IN_PLACE if comm.rank == 0 else sums, sums, MPI.SUM, 0)
                shares[:] = sums
        return steps
