"""Where a right-hand side goes: into the next Runge-Kutta stage and the sum that becomes the new solution.

A physics kernel leaves the rates k of a block in rows of scratch, one per unknown; these loops interlace them:

    next = source + a k,        sum = sum + b k

One form serves all: the rates themselves are the sum of a stage with b = 1 that starts from zero.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U1, U2, U3, U4, U64


class Target(NamedTuple):
    """What to do with the rates of a layer: where its owned part begins in memory, and the factors a, b (times dt).

    forcing is -1 where there is none.
    """

    source: int
    next: int
    sum: int
    forcing: int
    a: float
    b: float


@njit(**OPTIONS)
def emit3(s, target, offset, row0, row1, row2, m):
    """Rates of m points of three unknowns, the first of them ``offset`` doubles into the owned part."""
    k0, k1, k2, m, a, b = U64(row0), U64(row1), U64(row2), U64(m), target.a, target.b
    y, n, z = U64(target.source + offset), U64(target.next + offset), U64(target.sum + offset)
    if target.forcing >= 0:
        g = U64(target.forcing + offset)
        for i in range(m):
            s[k0 + i] += s[g + U3 * i]
            s[k1 + i] += s[g + U3 * i + U1]
            s[k2 + i] += s[g + U3 * i + U2]
    for i in range(m):
        r0, r1, r2 = s[k0 + i], s[k1 + i], s[k2 + i]
        s[n + U3 * i] = s[y + U3 * i] + a * r0
        s[n + U3 * i + U1] = s[y + U3 * i + U1] + a * r1
        s[n + U3 * i + U2] = s[y + U3 * i + U2] + a * r2
        s[z + U3 * i] += b * r0
        s[z + U3 * i + U1] += b * r1
        s[z + U3 * i + U2] += b * r2


@njit(**OPTIONS)
def emit4(s, target, offset, row0, row1, row2, row3, m):
    """Rates of m points of four unknowns; otherwise as ``emit3``."""
    k0, k1, k2, k3, m, a, b = U64(row0), U64(row1), U64(row2), U64(row3), U64(m), target.a, target.b
    y, n, z = U64(target.source + offset), U64(target.next + offset), U64(target.sum + offset)
    if target.forcing >= 0:
        g = U64(target.forcing + offset)
        for i in range(m):
            s[k0 + i] += s[g + U4 * i]
            s[k1 + i] += s[g + U4 * i + U1]
            s[k2 + i] += s[g + U4 * i + U2]
            s[k3 + i] += s[g + U4 * i + U3]
    for i in range(m):
        r0, r1, r2, r3 = s[k0 + i], s[k1 + i], s[k2 + i], s[k3 + i]
        s[n + U4 * i] = s[y + U4 * i] + a * r0
        s[n + U4 * i + U1] = s[y + U4 * i + U1] + a * r1
        s[n + U4 * i + U2] = s[y + U4 * i + U2] + a * r2
        s[n + U4 * i + U3] = s[y + U4 * i + U3] + a * r3
        s[z + U4 * i] += b * r0
        s[z + U4 * i + U1] += b * r1
        s[z + U4 * i + U2] += b * r2
        s[z + U4 * i + U3] += b * r3
