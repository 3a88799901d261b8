"""Exchanges of numbers between ranks as procedures: C calls them between others, so that many steps
are one call on any number of ranks (fsipetsc.kernels.procedure).

Ranks send each other one message to each neighbour an exchange, by persistent requests of MPI. Who
sends what is known before: an exchange is made of places in flat arrays.
"""

import ctypes
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fsipetsc.kernels.procedure import Called

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
_NO = np.zeros(0, np.int64)
#: the C code of exchanges and reductions
EXCHANGES = Path(__file__).with_name("exchange.c").read_text("utf-8")


class Route(NamedTuple):
    """Which numbers go where, as places in two flat arrays, the source and the target of an
    exchange. sent: rank -> places in the source, received: rank -> places in the target of what
    comes from there, in an order that both ranks have; own: places in both of what the rank copies.
    """

    sent: Mapping[int, Numbers]
    received: Mapping[int, Numbers]
    own: tuple[Numbers, Numbers] = (_NO, _NO)


class Exchange(Called):
    """One exchange, of the numbers of all routes, from a library with EXCHANGES; made on all ranks.

    source: None, if it is the world vector. tag: another one for each. empty: nothing is to do.
    """

    name = "exchange"

    def __init__(
        self, comm: MPI.Comm, tag: int, routes: Sequence[Route], target: Array, source: Any = None
    ) -> None:
        self._requests, size = list[MPI.Prequest](), MPI._sizeof(MPI.Request)
        ends = []  # places and buffer of what is received, and of what is sent
        of_all = [route.received for route in routes], [route.sent for route in routes]
        for init, of_routes in zip((comm.Recv_init, comm.Send_init), of_all):
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
        about = [_of_mpi("MPI_Startall"), _of_mpi("MPI_Testall"), self._handles.ctypes.data]
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


def _of_mpi(name: str) -> int:
    """The address of a function of the library that mpi4py has loaded."""
    return ctypes.cast(getattr(ctypes.CDLL(MPI.__file__), name), ctypes.c_void_p).value or 0


def _runs(of: Numbers, to: Numbers) -> Numbers:
    """(runs, 3), from, to, count: numbers side by side in both are copied together."""
    if not of.size:
        return np.zeros((0, 3), np.int64)
    first = np.flatnonzero(np.r_[True, (np.diff(of) != 1) | (np.diff(to) != 1)])
    return np.stack([of[first], to[first], np.diff(np.r_[first, of.size])], axis=1)
