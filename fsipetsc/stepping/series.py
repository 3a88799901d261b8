"""What is recorded at every step, kept in the state's journal until it is written."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from fsipetsc.scheme.plan import shares
from fsipetsc.stepping.snapshot import as_numbers
from fsipetsc.stepping.state import State

#: steps whose shares are added up at once: they stay in a cache
CACHED_STEPS = 2048


class Series:
    """Per-step data of this rank, which fill the state's journal; integrals are this rank's shares until ``add_up``."""

    def __init__(self, state: State) -> None:
        self._state = state
        record = state.journal.dtype
        self._first = record.fields[shares(record)[0]][1] // 8  # number of a record with which shares begin
        self._sums = np.empty((CACHED_STEPS, state.journal.dtype.itemsize // 8 - self._first))
        self._journal: np.ndarray | None = None
        self._numbers = self._latest = np.empty(0)
        self.count = self._added = 0

    @property
    def room(self) -> int:
        """How many steps may be made before they must be taken."""
        return len(self._state.journal) - self.count

    def write(self, t: float, dt: float) -> None:
        """Put a step into the journal: time and step [s], with the state's results. A burst does so itself."""
        if self._journal is not self._state.journal:  # it has been laid anew
            self._journal = self._state.journal
            self._numbers = self._journal.view(np.float64).reshape(len(self._journal), -1)
            self._latest = as_numbers(self._state.latest)
        row = self._numbers[self.count]
        row[0], row[1], row[2:] = t, dt, self._latest

    def keep(self, steps: int) -> None:
        """The next steps in the journal belong to the series."""
        self.count += steps

    def add_up(self, comm: MPI.Comm) -> np.ndarray:
        """The records of the steps kept since the last time, on rank 0 with the sums over all ranks. Collective.

        Not copied: once they are taken, the next steps overwrite them.
        """
        steps, self._added = self._state.journal[self._added : self.count], self.count
        if comm.size > 1:
            numbers = steps.view(np.float64).reshape(-1, steps.itemsize // 8)
            for begin in range(0, len(steps), CACHED_STEPS):
                own = numbers[begin : begin + CACHED_STEPS, self._first :]
                sums = self._sums[: len(own)]
                sums[:] = own
                comm.Reduce(MPI.IN_PLACE if comm.rank == 0 else sums, sums, MPI.SUM, 0)
                own[:] = sums
        return steps

    def take(self, comm: MPI.Comm) -> np.ndarray:
        """Likewise all that are in the journal, which is free again. Collective."""
        self.add_up(comm)
        steps, self.count, self._added = self._state.journal[: self.count], 0, 0
        return steps
