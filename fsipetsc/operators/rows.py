"""Rows of values that stand side by side, and their derivatives along the rows. Compiled.

A layer in two dimensions is gone through in blocks of columns, and each row by row. The rows that the derivatives need stand
in scratch ``s``, in a ring, so that row j takes the place of one that is done with. Everything is done to rows, eight points
at a time, and may be done to as many points beyond as fill a vector: rows have room for that. The rows of all quantities are
equally far apart, by a number that is known when this is compiled: so one register says where all quantities of a row are.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from fsipetsc.operators.kernels import (
    FORMULA,
    OPTIONS,
    closure,
    end_of,
    end_rows,
    store_lanes,
    weights_of,
)
from fsipetsc.operators.memory import load_wide, store
from fsipetsc.operators.vectors import LANES, WIDE, fma, spread_wide

#: room before the first and behind the last point of a row
MARGIN = 16
#: columns of a block: what is needed of them at a time stays in the second level of caches
BLOCK = 128
#: doubles from one row of scratch to the next: an odd number of cache lines
STRIDE = BLOCK + 2 * MARGIN + 8
#: rows of different quantities that a ring may have
QUANTITIES = 33


class Ring(NamedTuple):
    """Rows of quantities, of which each has as many as the others: row j of number k begins at
    origin + ((j & mask) QUANTITIES + k) STRIDE; the mask is one less than their number, a power of two.
    """

    origin: int
    mask: int


@njit(**FORMULA)
def at(rows, k, j):
    """Where row j of quantity number k begins."""
    return rows.origin + ((j & rows.mask) * QUANTITIES + k) * STRIDE


@njit(**OPTIONS)
def along(op, s, v, out, a, b, lo, hi, scale):
    """scale h D along a row s[v + i], to s[out + i], a <= i < b; closures stand at lo and hi, if these are among the points.

    The row must be known p points beyond a and b, or as far as the closures reach.
    """
    weights = weights_of(op, scale)
    for i in range(a, b, WIDE):
        store(s, out + i, difference(op.p, weights, s, v + i))
    for side in range(2):
        end, known = end_of(lo, hi, side, lo, hi + 1)
        if a - op.rows <= end <= b + op.rows:
            for r in range(0, op.rows, LANES):
                i, first, last = end_rows(op, lo, hi, side, r, a, b)
                if first < last:
                    store_lanes(s, out + i, scale * closure(op, s, v + end, side, known, r), first, last)


@njit(**FORMULA)
def difference(p, weights, s, at):
    """Interior formula sum_k c_k (v[i+k] - v[i-k]) at the points s[at ...]."""
    d = weights[0] * (load_wide(s, at + 1) - load_wide(s, at - 1))
    if p > 1:
        d = fma(weights[1], load_wide(s, at + 2) - load_wide(s, at - 2), d)
        if p > 2:
            d = fma(weights[2], load_wide(s, at + 3) - load_wide(s, at - 3), d)
            if p > 3:
                d = fma(weights[3], load_wide(s, at + 4) - load_wide(s, at - 4), d)
    return d


@njit(**OPTIONS)
def fill(s, out, a, b, value):
    """s[out + i] = value, a <= i < b."""
    v = spread_wide(value)
    for i in range(a, b, WIDE):
        store(s, out + i, v)
