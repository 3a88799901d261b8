"""Memory for rows of nodes."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def aligned(size: int) -> Array:
    """(size,) zeros that begin at a multiple of 64 bytes, as vector loads like it."""
    raw = np.zeros(size + 8)
    first = -raw.ctypes.data // 8 % 8
    return raw[first : first + size]
