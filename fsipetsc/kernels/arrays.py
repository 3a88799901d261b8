"""Memory for numbers of nodes; how several numbers of an array, or of a stand-in that a procedure
records, are read at once.
"""

from itertools import count
from typing import Any

import numpy as np

from fsipetsc.checks import Array

_made = count()  # arrays of `zeros` so far


def column(count: int, array: Any, n: Any, first: Any = 0) -> Any:
    """Return so many numbers array[first + c, n]."""
    return tuple(array[first + c, n] for c in range(count))


def row(count: int, array: Any, n: Any, first: Any = 0) -> Any:
    """Return so many numbers array[n, first + c]."""
    return tuple(array[n, first + c] for c in range(count))


def zeros(shape: Any) -> Array:
    """Return zeros of this shape, from a multiple of 64 bytes on, as vector loads like it; eight
    numbers before and after them may be read. Each array begins at another place in a page, so that
    what several have of a node does not compete for the same lines of a cache. numpy asks for large
    pages for what it fills, not for np.zeros: steps on large grids take some 4 % less time.
    """
    size = int(np.prod(shape))
    raw = np.full(size + 512, 0.0)
    first = 8 + -(raw.ctypes.data // 8) % 8 + 64 * (next(_made) % 7)
    return raw[first : first + size].reshape(shape)
