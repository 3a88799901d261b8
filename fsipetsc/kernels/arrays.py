"""Memory for numbers of nodes; how several numbers of an array, or of a stand-in that a procedure
records, are read at once.
"""

from typing import Any

import numpy as np

from fsipetsc.checks import Array


def column(like: Any, array: Any, n: Any, first: Any = 0) -> Any:
    """Return the numbers array[first + c, n], as many as the tuple ``like`` has."""
    return tuple(array[first + c, n] for c in range(len(like)))


def row(like: Any, array: Any, n: Any, first: Any = 0) -> Any:
    """Return the numbers array[n, first + c], as many as the tuple ``like`` has."""
    return tuple(array[n, first + c] for c in range(len(like)))


def zeros(shape: Any) -> Array:
    """Return zeros of this shape. numpy asks for large pages for what it fills, not for np.zeros:
    steps on large grids take some 4 % less time with them.
    """
    return np.full(shape, 0.0)


def aligned(size: int) -> Array:
    """(size,) zeros that begin at a multiple of 64 bytes, as vector loads like it; eight numbers
    before and after them may be read.
    """
    raw = np.zeros(size + 24)
    first = 8 + -raw.ctypes.data // 8 % 8
    return raw[first : first + size]
