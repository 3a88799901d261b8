"""Where a right-hand side goes: into the next Runge-Kutta stage and the sum that becomes the new solution.

    next = source + a k,        sum = base + b k

One form serves all: the rates k themselves are the sum of a stage with b = 1 whose base is zero.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64


class Target(NamedTuple):
    """What to do with the rates of a layer: where its owned part begins in each array, and the factors (times dt).

    forcing is -1 where there is none. The unknowns of a layer stand ``stride`` apart in all of them.
    """

    source: int
    next: int
    base: int
    sum: int
    forcing: int
    stride: int
    a: float
    b: float


@njit(**OPTIONS)
def emit(s, target, unknown, row, first, count):
    """Send on the rates s[row:] of one unknown at ``count`` points, the first of them number ``first`` of the owned."""
    at, k, m = unknown * target.stride + first, U64(row), U64(count)
    y, n = U64(target.source + at), U64(target.next + at)
    x, z, a, b = U64(target.base + at), U64(target.sum + at), target.a, target.b
    if target.forcing >= 0:
        g = U64(target.forcing + at)
        for i in range(m):
            s[k + i] += s[g + i]
    for i in range(m):
        s[n + i] = s[y + i] + a * s[k + i]
    if x == z:  # said apart, because parts of the memory that coincide keep a loop from being vectorised
        for i in range(m):
            s[z + i] += b * s[k + i]
    else:
        for i in range(m):
            s[z + i] = s[x + i] + b * s[k + i]
