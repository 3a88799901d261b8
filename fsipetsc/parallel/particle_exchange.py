"""Ranks that own members of the same particles send each other a few numbers of each member.

A particle is the set of nodes, of several blocks, at one place. Every rank that owns one of its
members takes part in it: it gets the numbers of all members, and does the same arithmetic in the
same order as the others. So the ranks that own points of an interface exchange what the interface
needs, and no sum is made by messages.
"""

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


class ParticleExchange:
    """Exchange of numbers of members with the ranks that take part in the same particles.

    particles, owners: (n,), particle and owning rank of each member of the particles in which this
    rank takes part, in an order that all ranks have in common (by particle, say, and within a
    particle by block and node). columns: numbers of a member. tag: another one for each exchange.

    table: (n, columns): first the rows of the members of this rank, in their order, which are to be
    filled before ``exchange``, then those of the other ranks.
    row: (n,), the row of each member. mine: (m,), numbers of the members of this rank.
    Making one is collective on ``comm``; an exchange is between the neighbours alone.
    """

    def __init__(
        self, comm: MPI.Comm, particles: Numbers, owners: Numbers, columns: int, tag: int = 0
    ) -> None:
        particles, owners = np.asarray(particles, np.int64), np.asarray(owners, np.int64)
        me = comm.rank
        self.mine = np.flatnonzero(owners == me)
        others = np.unique(owners[owners != me])
        received = [np.flatnonzero(owners == rank) for rank in others]
        order = np.concatenate([self.mine, *received])
        self.row = np.empty(len(particles), np.int64)
        self.row[order] = np.arange(len(particles))
        self.table = np.zeros((len(particles), columns))
        self._requests: list[MPI.Prequest] = []
        self._packed: list[tuple[Numbers, Array]] = []
        begin = len(self.mine)
        for rank, members in zip(others.tolist(), received, strict=True):
            shared = np.isin(particles[self.mine], particles[members])
            into, begin = self.table[begin : begin + len(members)], begin + len(members)
            self._requests.append(comm.Recv_init([into, MPI.DOUBLE], rank, tag))
            outgoing = np.empty((np.count_nonzero(shared), columns))
            self._packed.append((np.flatnonzero(shared), outgoing))
            self._requests.append(comm.Send_init([outgoing, MPI.DOUBLE], rank, tag))

    def exchange(self) -> None:
        """Send the rows of this rank; then all rows of the table are there."""
        if self._requests:
            for rows, outgoing in self._packed:
                np.take(self.table, rows, axis=0, out=outgoing, mode="clip")
            MPI.Prequest.Startall(self._requests)
            MPI.Request.Waitall(self._requests)

    def destroy(self) -> None:
        """Release the messages; none may be under way."""
        for request in self._requests:
            request.Free()
        self._requests = []
