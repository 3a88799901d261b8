"""Exchanges of numbers between ranks as procedures: C calls them between others, so that many steps
are one call on any number of ranks (fsipetsc.kernels.procedure).

Ranks send each other one message to each neighbour an exchange, by persistent requests of MPI. Who
sends what is known before: an exchange is made of places in flat arrays.

Halos are the nodes beside its own that a rank gets from others. Ghosted arrays have planes, a
component after the other, and one memory, so that one message has what a rank needs of all blocks
from another one. All ranks know from the shares which nodes each of them needs.
"""

import ctypes
from collections.abc import Mapping, Sequence
from itertools import chain
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fsipetsc.kernels.procedure import Called
from fsipetsc.parallel.block_shares import Share

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
Spans = Sequence[tuple[int, int]]
_NO = np.zeros(0, np.int64)


def exchange_text() -> str:
    """The C code of exchanges and reductions."""
    return Path(__file__).with_name("exchange.c").read_text("utf-8")


class Route(NamedTuple):
    """Which numbers go where, as places in two flat arrays, the source and the target of an
    exchange. sent: rank -> places in the source, received: rank -> places in the target of what
    comes from there, in an order that both ranks have; own: places in both of what the rank copies.
    """

    sent: Mapping[int, Numbers]
    received: Mapping[int, Numbers]
    own: tuple[Numbers, Numbers] = (_NO, _NO)


class Exchange(Called):
    """One exchange, of the numbers of all routes. Making one is on all ranks that take part. It is
    loaded from a library with ``exchange_text``.

    source: None, if it is the world vector. tag: another one for each exchange. empty: this rank
    has nothing to do.
    """

    name = "exchange"

    def __init__(
        self, comm: MPI.Comm, tag: int, routes: Sequence[Route], target: Array, source: Any = None
    ) -> None:
        self._requests, size = list[MPI.Prequest](), MPI._sizeof(MPI.Request)
        ends = []  # places and buffer of what is received, and of what is sent
        for init, of_routes in (
            (comm.Recv_init, [route.received for route in routes]),
            (comm.Send_init, [route.sent for route in routes]),
        ):
            ranks = sorted({r for places in of_routes for r in places if places[r].size})
            joined = [[places[r] for places in of_routes if r in places] for r in ranks]
            counts = [sum(one.size for one in of_rank) for of_rank in joined]
            ends.append((np.concatenate([_NO, *chain(*joined)]), np.empty(sum(counts))))
            for rank, part in zip(ranks, np.split(ends[-1][1], np.cumsum(counts))):
                self._requests.append(init([part, MPI.DOUBLE], rank, tag))
        self._handles = np.zeros(1 + size * len(self._requests), np.uint8)
        for k, request in enumerate(self._requests):
            ctypes.memmove(self._handles.ctypes.data + k * size, MPI._addressof(request), size)
        statuses = np.zeros(1 + MPI._sizeof(MPI.Status) * len(self._requests), np.uint8)
        (to, incoming), (of, outgoing) = ends
        own = [np.concatenate([_NO, *(route.own[k] for route in routes)]) for k in (0, 1)]
        runs = _runs(of, np.arange(of.size)), _runs(np.arange(to.size), to), _runs(*own)
        buffers = outgoing.ctypes.data, incoming.ctypes.data, 0
        copies = ((r.ctypes.data, len(r), b) for r, b in zip(runs, buffers, strict=True))
        about = [_of_mpi("MPI_Startall"), _of_mpi("MPI_Waitall"), self._handles.ctypes.data]
        about += [statuses.ctypes.data, len(self._requests)]
        about += [0 if source is None else source.ctypes.data, target.ctypes.data]
        self._kept = np.array([*about, *chain(*copies)], np.int64), source, target, statuses, ends
        self._runs, self.structure = runs, self._kept[0].ctypes.data
        self.empty = not self._requests and not own[0].size
        self.vectors = ["y"] if source is None else []

    def destroy(self) -> None:
        """Release the messages; none may be under way."""
        size = MPI._sizeof(MPI.Request)
        for k, request in enumerate(self._requests):  # MPI may have changed its handles
            ctypes.memmove(MPI._addressof(request), self._handles.ctypes.data + k * size, size)
            request.Free()
        self._requests = []


class RowExchange(Exchange):
    """Exchange of rows of a table (rows, columns), from the ranks that own them to those that want
    them. owners: (rows,) ranks; wanted: rank -> (rows,) whether it wants them, of this one, too.

    rows: those that this rank owns.
    """

    def __init__(
        self, comm: MPI.Comm, tag: int, owners: Numbers, wanted: Mapping[int, Array], table: Array
    ) -> None:
        me, others = comm.rank, [rank for rank in wanted if rank != comm.rank]
        self.table, self.rows = table, np.flatnonzero(owners == me)
        places = np.arange(table.size).reshape(table.shape)
        sent = {r: places[(owners == me) & wanted[r]].ravel() for r in others}
        received = {r: places[(owners == r) & wanted[me]].ravel() for r in others}
        numbers = table.reshape(-1)
        super().__init__(comm, tag, [Route(sent, received)], numbers, numbers)


class Reduction(Called):
    """Replaces an array by the largest numbers of all ranks, one by one."""

    name = "reduce"

    def __init__(self, comm: MPI.Comm, numbers: Array) -> None:
        room = np.empty_like(numbers)
        handles = (ctypes.c_long(MPI._handleof(one)).value for one in (MPI.DOUBLE, MPI.MAX, comm))
        of_numbers = numbers.ctypes.data, room.ctypes.data, numbers.size
        about = np.array([_of_mpi("MPI_Allreduce"), *handles, *of_numbers], np.int64)
        self.structure, self._kept = about.ctypes.data, (about, room, numbers, comm)

    def destroy(self) -> None:
        """There is nothing to release."""


class Reach(NamedTuple):
    """Which nodes a rank needs beside its own: ``width`` along each axis, on beyond the ends of
    periodic axes; centred: and images before the first node of the last axis.
    """

    share: Share
    periodic: Sequence[bool]
    width: int
    centred: bool

    def ghosted(self, rank: int) -> Spans:
        """First node and first beyond of a rank's ghosted array along each axis; images before a
        centre have numbers below 0.
        """
        found, last = [], len(self.periodic) - 1
        for axis, (a, b) in enumerate(self.share.part(rank)):
            first, beyond = a - self.width, b + self.width
            if not self.periodic[axis]:
                images = self.centred and axis == last and a == 0
                first = first if images else max(first, 0)
                beyond = min(beyond, self.share.shape[axis])
            found.append((first, beyond))
        return tuple(found)

    def _nodes(self, rank: int) -> tuple[Numbers, Numbers, Numbers]:
        """Places in a rank's ghosted array of the nodes that it owns, and of those that others send
        to it, or that it owns and has once more (of a periodic axis); numbers of the latter.
        """
        shape, index = self.share.shape, np.indices([b - a for a, b in self.ghosted(rank)])
        index += np.reshape([a for a, _ in self.ghosted(rank)], (-1, *[1] * len(shape)))
        ends = zip(index, self.share.part(rank), strict=True)
        inside = np.all([(i >= a) & (i < b) for i, (a, b) in ends], axis=0)
        known = np.all([(i >= 0) | closed for i, closed in zip(index, self.periodic)], axis=0)
        numbers = np.ravel_multi_index(tuple(index), shape, "wrap", "F").ravel("F")
        own, order = (np.flatnonzero(of.ravel("F")) for of in (inside, known & ~inside))
        return own, order, numbers[order]

    def routes(self, me: int, dof: int, begin: int, at: int) -> tuple[Route, Route]:
        """What fills the halo of rank ``me``, and what copies the nodes that it owns to its ghosted
        array. begin: of its numbers in the world vector, planes of nodes; at: of the ghosted array,
        (dof, N), in the memory of all.
        """
        inside, places, wanted = self._nodes(me)
        numbers, N = self.share.nodes(me), prod(b - a for a, b in self.ghosted(me))

        def here(nodes: Numbers) -> Numbers:
            among = np.searchsorted(numbers, nodes)
            return (begin + np.arange(dof)[:, None] * numbers.size + among).ravel()

        def there(places: Numbers) -> Numbers:
            return (at + np.arange(dof)[:, None] * N + places).ravel()

        owners = self.share.owners(wanted)
        needs = {rank: self._nodes(rank)[2] for rank in self.share.ranks if rank != me}
        sent = {rank: here(nodes[self.share.owners(nodes) == me]) for rank, nodes in needs.items()}
        received = {rank: there(places[owners == rank]) for rank in needs}
        twice = here(wanted[owners == me]), there(places[owners == me])
        return Route(sent, received, twice), Route({}, {}, (here(numbers), there(inside)))


def _of_mpi(name: str) -> int:
    """The address of a function of the library that mpi4py has loaded."""
    function = getattr(ctypes.CDLL(MPI.__file__), name)
    return ctypes.cast(function, ctypes.c_void_p).value or 0


def _runs(of: Numbers, to: Numbers) -> Numbers:
    """(runs, 3), from, to, count: numbers side by side in both are copied together."""
    if not of.size:
        return np.zeros((0, 3), np.int64)
    first = np.flatnonzero(np.r_[True, (np.diff(of) != 1) | (np.diff(to) != 1)])
    return np.stack([of[first], to[first], np.diff(np.r_[first, of.size])], axis=1)
