"""Ranks that own members of the same particles send each other a few numbers of each member.

A particle is the set of nodes, of several blocks, at one place. Every rank that owns one of its
members takes part in it: it gets the numbers of all members, and does the same arithmetic in the
same order as the others. So the ranks that own points of an interface exchange what the interface
needs, and no sum is made by messages.
"""

import numpy as np
from mpi4py import MPI

from fsipetsc.parallel.exchange import Exchange, Numbers


class ParticleExchange(Exchange):
    """Exchange of numbers of members with the ranks that take part in the same particles.

    particles, owners: (n,), particle and owning rank of each member of the particles in which this
    rank takes part, in an order that all ranks have in common (by particle, say, and within a
    particle by block and node). columns: numbers of a member.

    table: (n, columns): first the rows of the members of this rank, in their order, which are to be
    filled before the exchange, then those of the other ranks.
    row: (n,), the row of each member. mine: (m,), numbers of the members of this rank.
    """

    def __init__(
        self, comm: MPI.Comm, tag: int, particles: Numbers, owners: Numbers, columns: int
    ) -> None:
        particles, owners = np.asarray(particles, np.int64), np.asarray(owners, np.int64)
        self.mine = np.flatnonzero(owners == comm.rank)
        others = np.unique(owners[owners != comm.rank]).tolist()
        of_rank = {rank: np.flatnonzero(owners == rank) for rank in others}
        order = np.concatenate([self.mine, *of_rank.values()])
        self.row = np.empty(len(particles), np.int64)
        self.row[order] = np.arange(len(particles))
        self.table = np.zeros((len(particles), columns))
        shared = {
            rank: np.flatnonzero(np.isin(particles[self.mine], particles[members]))
            for rank, members in of_rank.items()
        }

        def places(rows: Numbers) -> Numbers:
            return (rows[:, None] * columns + np.arange(columns)).ravel()

        sent = {rank: places(rows) for rank, rows in shared.items()}
        received = {rank: places(self.row[members]) for rank, members in of_rank.items()}
        none = np.zeros(0, np.int64)
        numbers = self.table.reshape(-1)
        super().__init__(comm, tag, sent, received, (none, none), numbers, numbers)
