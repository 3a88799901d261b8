"""Halos of a block: each rank gets from the others the nodes beside its own.

The ghosted array has planes, a component after the other. Ranks send each other one message an
exchange, with all nodes that one has and the other needs: all ranks know these from the shares.
"""

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fsipetsc.operators.bands import Patch
from fsipetsc.parallel.block_shares import Share

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
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


class Halo:
    """Fills the ghosted array of a rank's part of a block. Making one is on all of its ranks.

    numbers: (M,) of the nodes that this rank owns. local: (dof, N), the ghosted array. comm, tag:
    of the messages, by the ranks of ``reach``.
    """

    def __init__(
        self, comm: MPI.Comm, reach: Reach, patch: Patch, numbers: Numbers, local: Array, tag: int
    ) -> None:
        me, dof = comm.rank, len(local)
        self.local = local
        cuts = zip(patch.first, patch.own, strict=True)
        inner = tuple(slice(first, first + own) for first, own in list(cuts)[::-1])
        self._inner = local.reshape(dof, *patch.ghosted[::-1])[(slice(None), *inner)]
        places, wanted = reach.needs(me)
        owners = reach.share.owners(wanted) if wanted.size else wanted
        mine = owners == me
        self._twice = places[mine], np.searchsorted(numbers, wanted[mine])
        self._sent: list[tuple[Numbers, Array]] = []
        self._received: list[tuple[Numbers, Array]] = []
        self._requests: list[MPI.Prequest] = []
        for rank in reach.share.ranks:
            if rank == me:
                continue
            if (owners == rank).any():
                into = np.empty((dof, int((owners == rank).sum())))
                self._received.append((places[owners == rank], into))
                self._requests.append(comm.Recv_init([into, MPI.DOUBLE], rank, tag))
            other = reach.needs(rank)[1]
            other = other[reach.share.owners(other) == me] if other.size else other
            if other.size:
                out = np.empty((dof, other.size))
                self._sent.append((np.searchsorted(numbers, other), out))
                self._requests.append(comm.Send_init([out, MPI.DOUBLE], rank, tag))

    def begin(self, own: Array) -> None:
        """Start to send this rank's numbers (dof, M), and copy them; they may change after this."""
        for rows, out in self._sent:
            np.take(own, rows, axis=1, out=out, mode="clip")
        if self._requests:
            MPI.Prequest.Startall(self._requests)
        self._inner[:] = own.reshape(self._inner.shape)
        places, rows = self._twice
        if places.size:
            self.local[:, places] = own[:, rows]

    def end(self) -> None:
        """Wait for the numbers of others, and put them into the ghosted array."""
        if self._requests:
            MPI.Request.Waitall(self._requests)
            for places, into in self._received:
                self.local[:, places] = into

    def destroy(self) -> None:
        """Release the messages; none may be under way."""
        for request in self._requests:
            request.Free()
        self._requests = []
