"""Connects this rank's parts of the layers with its neighbours': where edges are put and found, and what carries them."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from fsipetsc.parallel.layout import Layout
from fsipetsc.parallel.mpi import Requests
from fsipetsc.parallel.shared_memory import make_mailboxes
from fsipetsc.physics.layer import DOF


class Neighbours:
    """Mailboxes of the ranks of a node, if that is wanted and they are on one, else persistent requests. Collective.

    words: of what goes to all ranks in a turn. The buffer that ``connect`` takes has ``buffer`` doubles.
    """

    def __init__(self, layout: Layout, words: int, shared: bool) -> None:
        self._layout, self._words = layout, words
        self._sizes = [layout.halo * DOF[record["kind"]] for record in layout.records]  # doubles of an edge
        edges = 2 * sum(self._sizes)  # out of each layer
        self.mailboxes = make_mailboxes(layout.comm, 8 * (words + edges)) if shared else None
        self.buffer = 0 if self.mailboxes or layout.comm.size == 1 else 2 * edges
        self.requests = Requests([])

    def connect(self, buffer: np.ndarray) -> None:
        """Note in the layers' records where their edges go and come from; with messages, from and to the buffer."""
        requests: list[MPI.Prequest] = []
        comm, at = self._layout.comm, 0
        for k, size in enumerate(self._sizes):
            record = self._layout.records[k]
            for side, rank in enumerate(self._layout.neighbours(k)):
                here, there = at + side * size, at + (1 - side) * size
                if rank < 0:
                    continue
                if self.mailboxes is not None:
                    record["outbox"][side] = self.mailboxes.part(comm.rank) + 8 * (self._words + here)
                    record["inbox"][side] = self.mailboxes.part(rank) + 8 * (self._words + there)
                    continue
                out, into = (buffer[2 * at + j * size :][:size] for j in (side, 2 + side))
                record["outbox"][side], record["inbox"][side] = out.ctypes.data, into.ctypes.data
                # tags: layer and direction of travel
                requests += [comm.Send_init(out, rank, 2 * k + side), comm.Recv_init(into, rank, 2 * k + 1 - side)]
            at += 2 * size
        self.requests = Requests(requests)

    def free(self) -> None:
        """Nothing may be under way. A second call does nothing."""
        self.requests.free()
        if self.mailboxes is not None:
            self.mailboxes.free()
            self.mailboxes = None
