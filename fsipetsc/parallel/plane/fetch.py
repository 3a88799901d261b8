"""How a rank gets numbers that others have: messages that are made once and started again and again.

Halos of layers (fsipetsc.parallel.plane.halos) and points of interfaces go together: all messages of a stage are under way at
once, and what the rank has itself is copied in the meantime. The copying and waiting is compiled.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI
from numba import njit

from fsipetsc.operators.kernels import ENTRY, U64
from fsipetsc.operators.prepared import Prepared
from fsipetsc.parallel.mpi import Requests, mpi_startall, mpi_waitall
from fsipetsc.parallel.plane.halos import RECTANGLE, Halos
from fsipetsc.parallel.plane.layout import PlaneLayout

#: of the messages; others on a world's communicator have smaller ones
_TAG = 96


@njit(**ENTRY)
def exchange(source, begin, copies, given, sent, handles, statuses, taken, received, into, rectangles):
    """into[copies[:, 0]] = source[begin + copies[:, 1]], and into[taken] is what others send.

    given: those of source[begin:] that go to others, by way of ``sent``; what comes is in ``received`` first. handles: of all
    messages, those of halos too. rectangles: of source[begin:], that are copied within it, see fsipetsc.parallel.plane.halos.
    """
    for n in range(given.size):
        sent[n] = source[U64(begin + given[n])]
    if handles.size > 0:
        mpi_startall(handles.size, handles.ctypes.data)
    for n in range(rectangles.shape[0]):
        to, start, rows, count, stride = rectangles[n]
        for j in range(rows):
            for i in range(count):
                source[U64(begin + to + j * stride + i)] = source[U64(begin + start + j * stride + i)]
    for n in range(copies.shape[0]):
        into[U64(copies[n, 0])] = source[U64(begin + copies[n, 1])]
    if handles.size > 0:
        mpi_waitall(handles.size, handles.ctypes.data, statuses.ctypes.data)
    for n in range(taken.size):
        into[U64(taken[n])] = received[n]


class Fetch:
    """Numbers of a world vector, ``wanted`` on this rank, to the doubles ``into``, from where ranks keep their parts of it.

    places: (local_size,), where this rank's numbers stand in what is kept. Collective on the layout's communicator.
    """

    def __init__(self, layout: PlaneLayout, wanted: np.ndarray, places: np.ndarray, into: np.ndarray) -> None:
        comm, self._into = layout.comm, into
        owners = np.searchsorted(layout.offsets, wanted, side="right") - 1
        slots = [np.flatnonzero(owners == rank) for rank in range(comm.size)]
        told = comm.alltoall([wanted[at] - layout.offsets[rank] for rank, at in enumerate(slots)])
        mine = slots[comm.rank]
        self._copies = np.stack([mine, places[told[comm.rank]]], axis=1)
        slots[comm.rank] = told[comm.rank] = np.empty(0, np.int64)
        self._given, self._taken = places[np.concatenate(told)], np.concatenate(slots)
        self._sent, self._received = np.zeros(self._given.size), np.zeros(self._taken.size)
        self._messages: list[MPI.Prequest] = []
        for make, buffer, parts in ((comm.Recv_init, self._received, slots), (comm.Send_init, self._sent, told)):
            ends = np.cumsum([0, *(part.size for part in parts)])
            self._messages += [make(buffer[ends[r] : ends[r + 1]], r, _TAG) for r in range(comm.size) if parts[r].size]

    def prepared(self, source: np.ndarray, begin: int = 0, halos: Sequence[Halos] = ()) -> Prepared:
        """The call that fetches from what is kept at source[begin:], and fills halos there. Collective, as its calls are."""
        requests = Requests(self._messages + [request for halo in halos for request in halo.requests])
        rectangles = np.concatenate([np.empty((0, RECTANGLE), np.int64), *(halo.rectangles for halo in halos)])
        arrays = self._copies, self._given, self._sent, requests.handles, requests.statuses, self._taken, self._received
        return Prepared(exchange, source, begin, *arrays, self._into, rectangles)

    def free(self) -> None:
        """Release the messages."""
        for message in self._messages:
            message.Free()
        self._messages = []
