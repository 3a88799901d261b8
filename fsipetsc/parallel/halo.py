"""Halos of blocks: each rank gets from the others the nodes beside its own.

Ghosted arrays have planes, a component after the other, and one memory, so that a rank gets what it
needs of all blocks from another one in one message. All ranks know from the shares which nodes each
of them needs, so each can say what it sends.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

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


class Halo(NamedTuple):
    """What a rank's part of a block has to do with its halo: places of numbers in the world vector
    and in the memory of all ghosted arrays. sent: rank -> places in the world vector, received:
    rank -> places of what comes from there; twice: from where to where nodes go that the rank owns
    and has once more, inside: from where to where those go that it owns, where something reads
    these in the ghosted array, too.
    """

    sent: Mapping[int, Numbers]
    received: Mapping[int, Numbers]
    twice: tuple[Numbers, Numbers]
    inside: tuple[Numbers, Numbers]


def halo_of(
    reach: Reach, me: int, patch: Patch, numbers: Numbers, dof: int, begin: int, at: int
) -> Halo:
    """The halo of the part of rank ``me``. numbers: (M,) of the nodes that it owns; begin: of the
    numbers of its part in the world vector; at: of its ghosted array, (dof, N), in their memory.
    """
    M, N = numbers.size, int(np.prod(patch.ghosted))

    def here(places: Numbers) -> Numbers:
        return (begin + np.arange(dof)[:, None] * M + places).ravel()

    def there(places: Numbers) -> Numbers:
        return (at + np.arange(dof)[:, None] * N + places).ravel()

    places, wanted = reach.needs(me)
    owners = reach.share.owners(wanted) if wanted.size else wanted
    sent, received = dict[int, Numbers](), dict[int, Numbers]()
    for rank in reach.share.ranks:
        other = reach.needs(rank)[1] if rank != me else wanted[:0]
        other = other[reach.share.owners(other) == me] if other.size else other
        if other.size:
            sent[rank] = here(np.searchsorted(numbers, other))
        if rank != me and (owners == rank).any():
            received[rank] = there(places[owners == rank])
    cuts = zip(patch.first, patch.own, strict=True)
    inner = np.meshgrid(*(np.arange(a, a + n) for a, n in cuts), indexing="ij")
    inside = np.ravel_multi_index(inner, patch.ghosted, order="F").ravel(order="F")
    again = here(np.searchsorted(numbers, wanted[owners == me]))
    twice = again, there(places[owners == me])
    return Halo(sent, received, twice, (here(np.arange(M)), there(inside)))


def exchange_of(
    comm: MPI.Comm, tag: int, halos: Sequence[Halo], memory: Array, source: Array | None = None
) -> Exchange:
    """The exchange that fills halos of several blocks, which all ranks have in the same order, with
    one message to each neighbour; memory: of all ghosted arrays; source: None, if that is the
    world vector.
    """

    def joined(of_halos: Sequence[Mapping[int, Numbers]]) -> dict[int, Numbers]:
        ranks = sorted({rank for places in of_halos for rank in places})
        return {r: np.concatenate([p[r] for p in of_halos if r in p]) for r in ranks}

    none = np.zeros(0, np.int64)
    own = [np.concatenate([none, *(halo.twice[k] for halo in halos)]) for k in (0, 1)]
    sent, received = joined([h.sent for h in halos]), joined([h.received for h in halos])
    return Exchange(comm, tag, sent, received, (own[0], own[1]), source, memory)
