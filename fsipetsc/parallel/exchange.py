"""Exchanges of numbers between ranks as procedures: C calls them between others, so that many steps
are one call on any number of ranks (fsipetsc.kernels.calls).

Ranks send each other one message to each neighbour an exchange, by persistent requests of MPI. Who
sends what is known before: an exchange is made of places in flat arrays.

Halos are the nodes beside its own that a rank gets from others. Ghosted arrays have planes, a
component after the other, and one memory, so that one message has what a rank needs of all blocks
from another one. All ranks know from the shares which nodes each of them needs.
"""

import ctypes
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fsipetsc.kernels.kernel import c_source
from fsipetsc.operators.bands import Patch
from fsipetsc.parallel.block_shares import Share

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
Spans = Sequence[tuple[int, int]]
_POINTER, _NUMBER = ctypes.c_void_p, ctypes.c_long
_NO = np.zeros(0, np.int64)


def exchange_text() -> str:
    """The C code of exchanges and reductions."""
    return c_source("fsipetsc.parallel", "exchange.c")


class Exchange:
    """One exchange. Making one is on all ranks that take part. structure: the address of its struct
    in C, which has whole numbers and pointers alone.

    sent, received: rank -> places of the numbers in source and target, in an order that both ranks
    have; own: (places in the source, in the target) of what this rank copies. source: None, if it
    is the world vector from the number ``begin`` on. tag: another one for each exchange. empty:
    this rank has nothing to do.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        tag: int,
        sent: Mapping[int, Numbers],
        received: Mapping[int, Numbers],
        own: tuple[Numbers, Numbers],
        source: Array | None,
        target: Array,
        begin: int = 0,
    ) -> None:
        self._requests, size = list[MPI.Prequest](), MPI._sizeof(MPI.Request)
        of, to = (np.concatenate([_NO, *places.values()]) for places in (sent, received))
        outgoing, incoming = np.empty(of.size), np.empty(to.size)
        for init, places, buffer in (
            (comm.Recv_init, received, incoming),
            (comm.Send_init, sent, outgoing),
        ):
            parts = np.split(buffer, np.cumsum([where.size for where in places.values()]))
            for rank, part in zip(places, parts):
                self._requests.append(init([part, MPI.DOUBLE], rank, tag))
        self._handles = np.zeros(1 + size * len(self._requests), np.uint8)
        for k, request in enumerate(self._requests):
            ctypes.memmove(self._handles.ctypes.data + k * size, MPI._addressof(request), size)
        statuses = np.zeros(1 + MPI._sizeof(MPI.Status) * len(self._requests), np.uint8)
        runs = _runs(of, np.arange(of.size)), _runs(np.arange(to.size), to), _runs(*own)
        buffers = outgoing.ctypes.data, incoming.ctypes.data, 0
        copies = ((r.ctypes.data, len(r), b) for r, b in zip(runs, buffers, strict=True))
        of_source = 0 if source is None else source.ctypes.data
        about = [_of_mpi("MPI_Startall"), _of_mpi("MPI_Waitall"), self._handles.ctypes.data]
        about += [statuses.ctypes.data, len(self._requests), of_source, begin, target.ctypes.data]
        self._struct = np.array([*about, *chain(*copies)], np.int64)
        self._kept = source, target, statuses, outgoing, incoming, runs
        self.empty = not self._requests and not own[0].size
        self.structure = self._struct.ctypes.data
        self.vectors = ["y"] if source is None else []

    def load(self, library: ctypes.CDLL) -> None:
        """Take the function from a library with ``exchange_text``."""
        self._function = library.exchange
        self.address = ctypes.cast(library.exchange, _POINTER).value

    def __call__(self, *vectors: Array) -> None:
        """Exchange; vectors: the world vector, if that is the source."""
        of = (_POINTER(vectors[0].ctypes.data), _NUMBER(vectors[0].size)) if vectors else ()
        given = (_POINTER(self.structure), *(of or (None, _NUMBER(0))), None, _NUMBER(0))
        self._function(*given)

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
        self, comm: MPI.Comm, tag: int, owners: Numbers, wanted: Mapping[int, Array], columns: int
    ) -> None:
        me, others = comm.rank, [rank for rank in wanted if rank != comm.rank]
        self.table, self.rows = np.zeros((owners.size, columns)), np.flatnonzero(owners == me)
        places = np.arange(self.table.size).reshape(self.table.shape)
        sent = {r: places[(owners == me) & wanted[r]].ravel() for r in others}
        received = {r: places[(owners == r) & wanted[me]].ravel() for r in others}
        sent, received = ({r: p for r, p in of.items() if p.size} for of in (sent, received))
        numbers = self.table.reshape(-1)
        super().__init__(comm, tag, sent, received, (_NO, _NO), numbers, numbers)


class Reduction:
    """Replaces an array by the largest numbers of all ranks, one by one."""

    def __init__(self, comm: MPI.Comm, numbers: Array) -> None:
        room = np.empty_like(numbers)
        self._kept = numbers, room, comm
        handles = (_NUMBER(MPI._handleof(one)).value for one in (MPI.DOUBLE, MPI.MAX, comm))
        of_numbers = numbers.ctypes.data, room.ctypes.data, numbers.size
        self._struct = np.array([_of_mpi("MPI_Allreduce"), *handles, *of_numbers], np.int64)
        self.structure, self.vectors = self._struct.ctypes.data, list[str]()

    def load(self, library: ctypes.CDLL) -> None:
        """Take the function from a library with ``exchange_text``."""
        self.address = ctypes.cast(library.reduce, _POINTER).value


class Reach(NamedTuple):
    """Which nodes a rank needs beside its own: ``width`` along each axis, with corners or without,
    on beyond the ends of periodic axes; centred: and images before the first node of the last axis.
    """

    share: Share
    periodic: Sequence[bool]
    width: int
    corners: bool
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

    def needs(self, rank: int) -> tuple[Numbers, Numbers]:
        """Places in a rank's ghosted array, and numbers in the block, of the nodes that others send
        to it, or that it owns and has once more (of a periodic axis); in the order of the places.
        """
        own, shape, ends = self.share.part(rank), self.share.shape, self.ghosted(rank)
        index = np.meshgrid(*(np.arange(a, b) for a, b in ends), indexing="ij")
        far = sum(((i < a) | (i >= b)).astype(int) for i, (a, b) in zip(index, own, strict=True))
        known = np.all([(i >= 0) | closed for i, closed in zip(index, self.periodic)], axis=0)
        wanted = known & ((far >= 1) if self.corners else (far == 1))
        places = [i % n for i, n in zip(index, shape, strict=True)]
        numbers = np.ravel_multi_index(places, shape, order="F")
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
    owners = reach.share.owners(wanted)
    sent, received = dict[int, Numbers](), dict[int, Numbers]()
    for rank in reach.share.ranks:
        if rank != me:
            other = reach.needs(rank)[1]
            if (mine := reach.share.owners(other) == me).any():
                sent[rank] = here(np.searchsorted(numbers, other[mine]))
            if (owners == rank).any():
                received[rank] = there(places[owners == rank])
    own = np.arange(M)
    again = here(np.searchsorted(numbers, wanted[owners == me])), there(places[owners == me])
    return Halo(sent, received, again, (here(own), there(patch.ghosted_rows(own))))


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

    own = [np.concatenate([_NO, *(halo.twice[k] for halo in halos)]) for k in (0, 1)]
    sent, received = joined([h.sent for h in halos]), joined([h.received for h in halos])
    return Exchange(comm, tag, sent, received, (own[0], own[1]), source, memory)


def _of_mpi(name: str) -> int:
    """The address of a function of the library that mpi4py has loaded."""
    return ctypes.cast(getattr(ctypes.CDLL(MPI.__file__), name), _POINTER).value or 0


def _runs(of: Numbers, to: Numbers) -> Numbers:
    """(runs, 3), from, to, count: numbers side by side in both are copied together."""
    of, to = np.asarray(of, np.int64), np.asarray(to, np.int64)
    if not of.size:
        return np.zeros((0, 3), np.int64)
    first = np.flatnonzero(np.r_[True, (np.diff(of) != 1) | (np.diff(to) != 1)])
    return np.stack([of[first], to[first], np.diff(np.r_[first, of.size])], axis=1)
