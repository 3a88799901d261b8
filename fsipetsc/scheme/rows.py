"""Rows of a tile, in flat arrays, by unsigned offsets.

Loops over rows get flat arrays and say where in them the numbers of a node are: component c of node
i stands at start + c step + i. That serves rows of a tile (step = ROW), arrays of a block by
components (step = the number of its nodes) and interlaced ones (step = 1, and i times the number of
components for i).

All offsets are of type U64: an index that cannot be negative needs no test, and loops become vector
code. One array in place of a view per component keeps a call short: 17 ns with a dozen components,
where views take 50.
"""

import numpy as np
from numpy.typing import NDArray

from fsipetsc.operators.loops import by_length

Array = NDArray[np.float64]

U64 = int
#: nodes of a row of a tile: MARGIN, TILE at most, MARGIN
TILE, MARGIN = 72, 24
ROW = U64(TILE + 2 * MARGIN)
ONE = U64(1)


def _start(c: int) -> str:
    return "start" + " + step" * c + " + i"


def _put(n: int) -> str:
    return "\n".join(f" array[{_start(c)}] = values[{c}]" for c in range(n)) + "\n return"


#: the numbers of node i, one for each of like
at = by_length(
    "at",
    "like, array, start, step, i",
    lambda n: " return (" + "".join(f"array[{_start(c)}]," for c in range(n)) + ")",
)
#: stores values there
put = by_length("put", "array, start, step, i, values", _put)


def moments(d: int) -> int:
    """Components of angular momentum in d dimensions."""
    return d * (d - 1) // 2


def _add_moment(d: int) -> str:
    pairs = {1: (), 2: ((0, 1),), 3: ((1, 2), (2, 0), (0, 1))}[d]
    lines = enumerate(f"c * (x[{a}] * p[{b}] - x[{b}] * p[{a}])" for a, b in pairs)
    return "\n".join([*(f" array[{_start(row)}] += {of}" for row, of in lines), " return"])


#: adds c times x cross p to the numbers of node i
add_moment = by_length("add_moment", "x, p, c, array, start, step, i", _add_moment)


def aligned(size: int) -> Array:
    """(size,) zeros that begin at a multiple of 64 bytes, as vector loads like it."""
    raw = np.zeros(size + 8)
    first = -raw.ctypes.data // 8 % 8
    return raw[first : first + size]
