"""The few MPI functions that compiled code calls, by their C names.

Handles are passed as integers of pointer size, which holds the pointers of Open MPI and the ints of MPICH alike.
"""

from __future__ import annotations

import ctypes

import numpy as np
from llvmlite import binding
from mpi4py import MPI
from numba import types

_library = ctypes.CDLL(MPI.__file__)
_p, _i = types.intp, types.int32


def _function(name: str, *arguments: types.Type) -> types.ExternalFunction:
    binding.add_symbol(name, ctypes.cast(getattr(_library, name), ctypes.c_void_p).value)
    return types.ExternalFunction(name, _i(*arguments))


mpi_allreduce = _function("MPI_Allreduce", _p, _p, _i, _p, _p, _p)
mpi_startall = _function("MPI_Startall", _i, _p)
mpi_waitall = _function("MPI_Waitall", _i, _p, _p)

WORLD = np.dtype([("comm", np.int64), ("size", np.int64), ("word", np.int64), ("max", np.int64)])


def handle(obj: object) -> int:
    """The value of an MPI handle as C code sees it."""
    size = MPI._sizeof(obj)
    kind = {4: ctypes.c_int32, 8: ctypes.c_int64}[size]
    return kind.from_address(MPI._addressof(obj)).value


def world_record(comm: MPI.Comm) -> np.ndarray:
    """What compiled code needs for a maximum over all ranks of 64-bit words."""
    record = np.zeros(1, WORLD)
    record["comm"], record["size"] = handle(comm), comm.size
    record["word"], record["max"] = handle(MPI.UINT64_T), handle(MPI.MAX)
    return record


class Requests:
    """Persistent requests that are started and waited for together, with their handles as an array."""

    def __init__(self, requests: list[MPI.Prequest]) -> None:
        self._requests = requests
        kind = np.int64 if MPI._sizeof(MPI.Request) == 8 else np.int32
        self.handles = np.array([handle(r) for r in requests], kind)
        self.statuses = np.zeros(max(1, len(requests)) * MPI._sizeof(MPI.Status), np.uint8)

    def free(self) -> None:
        """Release the requests; none may be under way."""
        for request in self._requests:
            request.Free()
        self._requests = []
