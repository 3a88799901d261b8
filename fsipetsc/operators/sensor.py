"""Where rows of values are steeper than a grid resolves: a number from 0 to 1 between each two neighbours. Compiled.

    alpha_{i+1/2} = min(1, 2 max_{i-p < j <= i+p} s_j)            p: half the width of the stencil of D
    s_j = |d_+ - d_-| / (|d_+| + |d_-| + e (|a_j+1| + 2 |a_j| + |a_j-1|) + least)
    d_+ = a_j+1 - a_j,  d_- = a_j - a_j-1

of the row a that has the largest s. Where a is smooth alpha falls with h^2, as the sum with e is what counts. At a jump that is
large beside e a it is 1 between all points whose derivatives see the jump, on either side. An end point has no s of its own.

Source of the form of s, total variation and values in one sum: R. C. Swanson and E. Turkel, J. Comput. Phys. 101 (1992),
292-306; the constants are those with which strong shocks keep their plateaus and stay positive, of all orders.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64
from fsipetsc.operators.lanes import masked
from fsipetsc.operators.memory import load, store
from fsipetsc.operators.vectors import LANES, magnitude, maximum, minimum, spread

#: e
SMALL = 0.05


@njit(**OPTIONS)
def sense(s, lo, hi, p, a, b, least, steepness, to, i0, i1):
    """alpha of the rows a and b at to + i, between the points i and i+1 of lo .. hi, for i = i0-p .. i1+p-2.

    s: the memory; least: of a and of b; steepness: a free row. a and b must be known from i0-2p to i1+2p-1.
    """
    for i in range(i0 - 2 * p - LANES, i1 + 2 * p + LANES, LANES):
        store(s, steepness + i, spread(0.0))
    end = min(hi, i1 + 2 * p - 1)
    for i in range(max(lo + 1, i0 - 2 * p + 1), end, LANES):
        found = maximum(steepness_of(s, a + i, least), steepness_of(s, b + i, least))
        store(s, steepness + i, masked(found, end - i, 0.0))
    for i in range(max(lo, i0 - p), min(hi, i1 + p - 1), LANES):
        found = load(s, steepness + i)
        for j in range(1 - p, p + 1):
            found = maximum(found, load(s, steepness + i + j))
        store(s, to + i, minimum(2.0 * found, spread(1.0)))


@njit(**FORMULA)
def steepness_of(s, at, least):
    """s_j of the row with the point j at s[at]."""
    below, here, above = load(s, at - 1), load(s, at), load(s, at + 1)
    rise, fall = above - here, here - below
    values = magnitude(above) + 2.0 * magnitude(here) + magnitude(below)
    return magnitude(rise - fall) / (magnitude(rise) + magnitude(fall) + SMALL * values + least)


@njit(**OPTIONS)
def largest_within(s, row, to, count, begin, end):
    """At to + i the largest of row at i .. i+count-1, i = begin .. end-1."""
    for i in range(begin, end, LANES):
        found = load(s, row + i)
        for j in range(1, count):
            found = maximum(found, load(s, row + i + j))
        store(s, to + i, found)


@njit(**OPTIONS)
def weigh_ends(s, row, weights, rows, order, lo, hi, i0, i1):
    """Multiply what stands at differences of an order with their weights at either end of lo .. hi, of the first ``rows``.

    As far as they reach the points i0 .. i1-1.
    """
    for r in range(rows):
        for i in (lo + r, hi - order - r):
            if i0 - order <= i < i1:
                s[U64(row + i)] *= weights[r]
