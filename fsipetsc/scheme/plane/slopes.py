"""Derivatives of several quantities at once, of a vector of points: sums of weighted differences between two of them. Compiled.

    interior formula      sum_k c_k (v_j+k - v_j-k)
    row of a closure      sum_c d_c (v_c - v_j) + of_own v_j

The weights of a row of a closure add up to nothing, of_own = 0, but for the operator that is loose at its ends, at an end.
Rows differ in their terms only, so that one loop serves all of them. In X, where points rather than rows have closures, it
serves blocks of columns from which no end is reached.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, U64
from fsipetsc.operators.memory import load_twice
from fsipetsc.operators.rows import STRIDE, at
from fsipetsc.operators.vectors import fma

#: where weights stand among numbers of a block: along, across
_ALONG, _ACROSS = 64, 72


class Terms(NamedTuple):
    """Those of D_y at a row: number n < count has the weight s[weights + n] and goes from row down + n by_down to up + n by_up.
    """

    count: int
    weights: int
    up: int
    by_up: int
    down: int
    by_down: int
    of_own: float


@njit(**FORMULA)
def weigh_along(layer, op, s, place):
    """Where the weights of D_x stand, by distance, where no end is reached."""
    to = place.weights + place.first + _ALONG
    for k in range(op.p):
        s[U64(to + k)] = (1.0 / layer.h_x) * op.interior[k]  # as fsipetsc.operators.rows.along has it, next to ends
    return to


@njit(**FORMULA)
def weigh_across(layer, op, s, place, j, loose):
    """Terms of D_y at row j; loose: without the boundary flux."""
    lo, hi, to = layer.end_y[0], layer.end_y[1], place.weights + place.first + _ACROSS
    if lo + op.rows <= j <= hi - op.rows:
        for k in range(op.p):
            s[U64(to + k)] = (1.0 / layer.h_y) * op.interior[k]
        return Terms(op.p, to, j + 1, 1, j - 1, -1, 0.0)
    end, step, r = (lo, 1, j - lo) if j < lo + op.rows else (hi, -1, hi - j)
    for c in range(op.cols):
        s[U64(to + c)] = step * op.closure[r, c] / layer.h_y
    of_own = step / (op.norm[0] * layer.h_y) if loose and r == 0 else 0.0
    return Terms(op.cols, to, end, step, j, 0, of_own)


@njit(**FORMULA)
def slopes_along(numbers, s, ring, j, i, count, weights):
    """D_x of quantities in a ring at the points i .. of row j, where no end is reached."""
    here = at(ring, 0, j) + i
    found = each(of_quantities.first, numbers, s, here + 1, here - 1, s[U64(weights)])
    for k in range(1, count):
        found = each(of_quantities.more, found, numbers, s, here + (k + 1), here - (k + 1), s[U64(weights + k)])
    return found


@njit(**FORMULA)
def slopes_across(numbers, s, ring, j, i, terms):
    """D_y of quantities in a ring at the points i .. of row j."""
    found = each(of_quantities.own, numbers, s, at(ring, 0, j) + i, terms.of_own)
    for n in range(terms.count):
        up, down = at(ring, 0, terms.up + n * terms.by_up) + i, at(ring, 0, terms.down + n * terms.by_down) + i
        found = each(of_quantities.more, found, numbers, s, up, down, s[U64(terms.weights + n)])
    return found


@njit(**FORMULA)
def _own(number, s, at, weight):
    return weight * load_twice(s, at + number * STRIDE)


@njit(**FORMULA)
def _more(found, number, s, up, down, weight):
    return fma(weight, load_twice(s, up + number * STRIDE) - load_twice(s, down + number * STRIDE), found)


@njit(**FORMULA)
def _first(number, s, up, down, weight):
    return weight * (load_twice(s, up + number * STRIDE) - load_twice(s, down + number * STRIDE))


of_quantities = Formulas(own=_own, first=_first, more=_more)
