"""Memory for numbers of nodes; how to read several numbers of an array, or of a stand-in that a
procedure records, at once.
"""

import ctypes
import mmap
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def column(like: Any, array: Any, n: Any, first: Any = 0) -> Any:
    """Return the numbers array[first + c, n], as many as the tuple ``like`` has."""
    return tuple(array[first + c, n] for c in range(len(like)))


def row(like: Any, array: Any, n: Any, first: Any = 0) -> Any:
    """Return the numbers array[n, first + c], as many as the tuple ``like`` has."""
    return tuple(array[n, first + c] for c in range(len(like)))


def zeros(shape: Any) -> Array:
    """Return zeros of this shape. Large arrays get large pages where the system has them: the
    processor need not look up so many, and steps on large grids take some 4 % less time.
    """
    found = np.zeros(shape)
    if found.nbytes >= 2 << 20:  # bytes of a large page
        first = -(-found.ctypes.data // mmap.PAGESIZE) * mmap.PAGESIZE
        size = (found.ctypes.data + found.nbytes - first) // mmap.PAGESIZE * mmap.PAGESIZE
        given = ctypes.c_void_p(first), ctypes.c_size_t(size), mmap.MADV_HUGEPAGE
        ctypes.CDLL(None).madvise(*given)
    return found


def aligned(size: int) -> Array:
    """(size,) zeros that begin at a multiple of 64 bytes, as vector loads like it."""
    raw = np.zeros(size + 8)
    first = -raw.ctypes.data // 8 % 8
    return raw[first : first + size]
