"""The few functions of MPI and of the system that compiled code calls, by their C names.

Handles are passed as integers of pointer size, which holds the pointers of Open MPI and the ints of MPICH alike.
"""

from __future__ import annotations

import ctypes

import numpy as np
from llvmlite import binding
from mpi4py import MPI
from numba import types

_library, _system = ctypes.CDLL(MPI.__file__), ctypes.CDLL(None)
_p, _i = types.intp, types.int32


def _function(name: str, *arguments: types.Type, library: ctypes.CDLL = _library) -> types.ExternalFunction:
    binding.add_symbol(name, ctypes.cast(getattr(library, name), ctypes.c_void_p).value)
    return types.ExternalFunction(name, _i(*arguments))


mpi_allreduce = _function("MPI_Allreduce", _p, _p, _i, _p, _p, _p)
mpi_startall = _function("MPI_Startall", _i, _p)
mpi_waitall = _function("MPI_Waitall", _i, _p, _p)
mpi_iprobe = _function("MPI_Iprobe", _i, _i, _p, _p, _p)
sched_yield = _function("sched_yield", library=_system)


def handle(obj: object) -> int:
    """The value of an MPI handle as C code sees it."""
    size = MPI._sizeof(obj)
    kind = {4: ctypes.c_int32, 8: ctypes.c_int64}[size]
    return kind.from_address(MPI._addressof(obj)).value


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
