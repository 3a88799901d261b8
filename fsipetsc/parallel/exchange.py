"""Exchanges of numbers between ranks as procedures: C calls them between others, so that many steps
are one call on any number of ranks (fsipetsc.kernels.calls).

Ranks send each other one message to each neighbour an exchange, by persistent requests of MPI. Who
sends what is known before: an exchange is made of places in flat arrays.
"""

import ctypes
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fsipetsc.kernels.unit import c_source

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
_POINTER, _NUMBER = ctypes.c_void_p, ctypes.c_long
_NO = np.zeros(0, np.int64)


class _Copies(ctypes.Structure):
    _fields_ = [("runs", _POINTER), ("count", _NUMBER), ("buffer", _POINTER)]


class _Exchange(ctypes.Structure):
    _fields_ = [
        *((name, _POINTER) for name in ("start_all", "wait_all", "requests", "statuses")),
        *(("messages", _NUMBER), ("source", _POINTER), ("begin", _NUMBER), ("target", _POINTER)),
        *((name, _Copies) for name in ("sent", "received", "own")),
    ]


class _Reduction(ctypes.Structure):
    _fields_ = [
        *(("all_reduce", _POINTER), ("type", _NUMBER), ("operation", _NUMBER), ("comm", _NUMBER)),
        *(("numbers", _POINTER), ("room", _POINTER), ("count", _NUMBER)),
    ]


def exchange_text() -> str:
    """The C code of exchanges and reductions."""
    return c_source("fsipetsc.parallel", "exchange.c")


class Exchange:
    """One exchange. Making one is on all ranks that take part.

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
            first = 0
            for rank, where in places.items():
                part = buffer[first : first + where.size]
                self._requests.append(init([part, MPI.DOUBLE], rank, tag))
                first += where.size
        self._handles = np.zeros(1 + size * len(self._requests), np.uint8)
        for k, request in enumerate(self._requests):
            ctypes.memmove(self._handles.ctypes.data + k * size, MPI._addressof(request), size)
        statuses = np.zeros(1 + MPI._sizeof(MPI.Status) * len(self._requests), np.uint8)
        runs = [
            _runs(of, np.arange(of.size)),
            _runs(np.arange(to.size), to),
            _runs(*own),
        ]
        self._kept = source, target, statuses, outgoing, incoming, runs
        buffers = outgoing.ctypes.data, incoming.ctypes.data, None
        copies = [_Copies(r.ctypes.data, len(r), b) for r, b in zip(runs, buffers, strict=True)]
        self._struct = _Exchange(
            *(_of_mpi("MPI_Startall"), _of_mpi("MPI_Waitall"), self._handles.ctypes.data),
            *(statuses.ctypes.data, len(self._requests)),
            *(None if source is None else source.ctypes.data, begin, target.ctypes.data),
            *copies,
        )
        self.empty = not self._requests and not own[0].size
        self.structure = ctypes.addressof(self._struct)
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
    """Exchange of rows of a table, (rows, columns). sent, received: rank -> numbers of rows."""

    def __init__(
        self,
        comm: MPI.Comm,
        tag: int,
        sent: Mapping[int, Numbers],
        received: Mapping[int, Numbers],
        table: Array,
    ) -> None:
        places = np.arange(table.size).reshape(table.shape)
        of, to = ({r: places[rows].ravel() for r, rows in m.items()} for m in (sent, received))
        self.table, numbers = table, table.reshape(-1)
        super().__init__(comm, tag, of, to, (_NO, _NO), numbers, numbers)


class Reduction:
    """Replaces an array by the largest numbers of all ranks, one by one."""

    def __init__(self, comm: MPI.Comm, numbers: Array) -> None:
        room = np.empty_like(numbers)
        self._kept = numbers, room, comm
        handles = map(_handle, (MPI.DOUBLE, MPI.MAX, comm))
        of_numbers = numbers.ctypes.data, room.ctypes.data, numbers.size
        self._struct = _Reduction(_of_mpi("MPI_Allreduce"), *handles, *of_numbers)
        self.structure, self.vectors = ctypes.addressof(self._struct), list[str]()

    def load(self, library: ctypes.CDLL) -> None:
        """Take the function from a library with ``exchange_text``."""
        self.address = ctypes.cast(library.reduce, _POINTER).value


def _of_mpi(name: str) -> int | None:
    """The address of a function of the library that mpi4py has loaded."""
    return ctypes.cast(getattr(ctypes.CDLL(MPI.__file__), name), _POINTER).value


def _handle(of: Any) -> int:
    """What C has of an object of MPI."""
    content = ctypes.string_at(MPI._addressof(of), MPI._sizeof(type(of)))
    return int.from_bytes(content, sys.byteorder, signed=True)


def _runs(of: Numbers, to: Numbers) -> Numbers:
    """(runs, 3), from, to, count: numbers side by side in both are copied together."""
    of, to = np.asarray(of, np.int64), np.asarray(to, np.int64)
    if not of.size:
        return np.zeros((0, 3), np.int64)
    first = np.flatnonzero(np.r_[True, (np.diff(of) != 1) | (np.diff(to) != 1)])
    return np.stack([of[first], to[first], np.diff(np.r_[first, of.size])], axis=1)
