"""Halos of a block: each rank gets from the others the nodes beside its own.

The ghosted array has planes, a component after the other. All ranks know from the shares which
nodes each of them needs, so each can say what it sends.
"""

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI

from fsipetsc.operators.bands import Patch
from fsipetsc.parallel.block_shares import Share
from fsipetsc.parallel.exchange import Array, Exchange, Numbers

Spans = Sequence[tuple[int, int]]


class Reach:
    """Which nodes a rank needs beside its own: ``width`` along each axis, with corners or without,
    on beyond the ends of periodic axes.
    """

    def __init__(
        self, share: Share, periodic: Sequence[bool], width: int, corners: bool, centred: bool
    ) -> None:
        self.share, self.corners = share, corners
        self._periodic, self._width, self._centred = tuple(periodic), width, centred
        self._shape = tuple(cuts[-1] for cuts in share.cuts)

    def ghosted(self, rank: int) -> Spans:
        """First node and first beyond of a rank's ghosted array along each axis; images before a
        centre have numbers below 0.
        """
        found = []
        for axis, (a, b) in enumerate(self.share.part(rank)):
            first, last = a - self._width, b + self._width
            if not self._periodic[axis]:
                images = self._centred and axis == len(self._shape) - 1 and a == 0
                first, last = first if images else max(first, 0), min(last, self._shape[axis])
            found.append((first, last))
        return tuple(found)

    def needs(self, rank: int) -> tuple[Numbers, Numbers]:
        """Places in a rank's ghosted array, and numbers in the block, of the nodes that others send
        to it, or that it owns and has once more (of a periodic axis); in the order of the places.
        """
        spans, own = self.ghosted(rank), self.share.part(rank)
        index = [np.arange(a, b) for a, b in spans]
        outside = [(i < a) | (i >= b) for i, (a, b) in zip(index, own, strict=True)]
        there = [(i >= 0) | closed for i, closed in zip(index, self._periodic, strict=True)]
        how_far = sum(np.meshgrid(*(o.astype(int) for o in outside), indexing="ij", sparse=True))
        known = np.prod(np.meshgrid(*there, indexing="ij"), axis=0).astype(bool)
        wanted = known & ((how_far >= 1) if self.corners else (how_far == 1))
        wrapped = [i % n for i, n in zip(index, self._shape, strict=True)]
        places = np.meshgrid(*wrapped, indexing="ij")
        numbers = np.ravel_multi_index(places, self._shape, order="F")
        order = np.flatnonzero(wanted.ravel(order="F"))
        return order, numbers.ravel(order="F")[order]


class Halo(Exchange):
    """Fills what the ghosted array of a rank's part of a block has beside the nodes that the rank
    owns, from the world vector. Making one is on all of its ranks. inside: copies the owned nodes,
    for those who read these in the ghosted array, too.

    numbers: (M,) of the nodes that this rank owns. local: (dof, N), the ghosted array. comm, tag:
    of the messages, by the ranks of ``reach``. begin: of the block's numbers in the world vector.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        tag: int,
        reach: Reach,
        patch: Patch,
        numbers: Numbers,
        local: Array,
        begin: int,
    ) -> None:
        self.local, me, (dof, N), M = local, comm.rank, local.shape, numbers.size

        def planes(places: Numbers, size: int) -> Numbers:
            return (np.arange(dof)[:, None] * size + places).ravel()

        places, wanted = reach.needs(me)
        owners = reach.share.owners(wanted) if wanted.size else wanted
        sent, received = dict[int, Numbers](), dict[int, Numbers]()
        for rank in reach.share.ranks:
            other = reach.needs(rank)[1] if rank != me else wanted[:0]
            other = other[reach.share.owners(other) == me] if other.size else other
            if other.size:
                sent[rank] = planes(np.searchsorted(numbers, other), M)
            if rank != me and (owners == rank).any():
                received[rank] = planes(places[owners == rank], N)
        cuts = zip(patch.first, patch.own, strict=True)
        inner = np.meshgrid(*(np.arange(a, a + n) for a, n in cuts), indexing="ij")
        inside = np.ravel_multi_index(inner, patch.ghosted, order="F").ravel(order="F")
        twice = planes(np.searchsorted(numbers, wanted[owners == me]), M)
        target, of_own = local.reshape(-1), (planes(np.arange(M), M), planes(inside, N))
        own = twice, planes(places[owners == me], N)
        super().__init__(comm, tag, sent, received, own, None, target, begin)
        self.inside = Exchange(comm, tag, {}, {}, of_own, None, target, begin)
