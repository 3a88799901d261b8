"""Derivatives of rows of values that stand side by side: along the rows, and across them. Compiled.

A layer in two dimensions is gone through row by row. The rows that the derivatives need stand in scratch ``s``, those of a
quantity ``stride`` apart in a ring of ``ring`` rows, so that row j takes the place of row j - ring. Everything is done to
rows, four points at a time, and may be done to as many points beyond as fill a vector: rows have room for that.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from fsipetsc.operators.kernels import (
    FORMULA,
    OPTIONS,
    U64,
    closure,
    end_of,
    end_rows,
    interior_stencil,
    store_lanes,
    weights_of,
)
from fsipetsc.operators.vectors import LANES, fma, load, spread, store

#: room before the first and behind the last point of a row
MARGIN = 16


class Ring(NamedTuple):
    """Rows of scratch: number k's row j begins at origin + (k ring + j mod ring) stride; ring is a power of two."""

    origin: int
    stride: int
    ring: int


@njit(**FORMULA)
def at(rows, k, j):
    """Where row j of quantity number k begins."""
    return rows.origin + (k * rows.ring + (j & (rows.ring - 1))) * rows.stride


@njit(**OPTIONS)
def along(op, s, v, out, a, b, lo, hi, scale):
    """scale h D along a row s[v + i], to s[out + i], a <= i < b; closures stand at lo and hi, if these are among the points.

    The row must be known p points beyond a and b, or as far as the closures reach.
    """
    weights = weights_of(op, scale)
    for i in range(a, b, LANES):
        d = interior_stencil(op.p, weights, load(s, v + i - LANES), load(s, v + i), load(s, v + i + LANES))
        store(s, out + i, d)
    for side in range(2):
        end, known = end_of(lo, hi, side, lo, hi + 1)
        if a - op.rows <= end <= b + op.rows:
            for r in range(0, op.rows, LANES):
                i, first, last = end_rows(op, lo, hi, side, r, a, b)
                if first < last:
                    store_lanes(s, out + i, scale * closure(op, s, v + end, side, known, r), first, last)


@njit(**OPTIONS)
def across(op, s, rows, k, j, out, a, b, lo, hi, scale):
    """scale h D across the rows of quantity k at row j, to s[out + i], a <= i < b; closures stand at the rows lo and hi."""
    if lo + op.rows <= j <= hi - op.rows:
        across_inside(op, s, rows, k, j, out, a, b, scale)
        return
    side = 0 if j < lo + op.rows else 1
    end, step, r = (lo, 1, j - lo) if side == 0 else (hi, -1, hi - j)
    for c in range(op.cols):
        weight, row = step * scale * op.closure[r, c], at(rows, k, end + step * c)
        if c == 0:
            for i in range(a, b, LANES):
                store(s, out + i, weight * load(s, row + i))
        elif weight != 0.0:
            for i in range(a, b, LANES):
                store(s, out + i, fma(weight, load(s, row + i), load(s, out + i)))


@njit(**OPTIONS)
def across_inside(op, s, rows, k, j, out, a, b, scale):
    """The same where the interior formula holds."""
    c1, c2, c3, c4 = weights_of(op, scale)
    u1, d1, u2, d2 = at(rows, k, j + 1), at(rows, k, j - 1), at(rows, k, j + 2), at(rows, k, j - 2)
    u3, d3, u4, d4 = at(rows, k, j + 3), at(rows, k, j - 3), at(rows, k, j + 4), at(rows, k, j - 4)
    for i in range(a, b, LANES):
        d = c1 * (load(s, u1 + i) - load(s, d1 + i))
        if op.p > 1:
            d = fma(c2, load(s, u2 + i) - load(s, d2 + i), d)
            if op.p > 2:
                d = fma(c3, load(s, u3 + i) - load(s, d3 + i), d)
                if op.p > 3:
                    d = fma(c4, load(s, u4 + i) - load(s, d4 + i), d)
        store(s, out + i, d)


@njit(**OPTIONS)
def fill(s, out, a, b, value):
    """s[out + i] = value, a <= i < b."""
    v = spread(value)
    for i in range(a, b, LANES):
        store(s, out + i, v)


@njit(**FORMULA)
def number(s, i):
    """s[i]."""
    return s[U64(i)]
