"""Compiled application of a summation-by-parts operator and the formulas at an embedded boundary.

A derivative is taken on the *active* points ``lo..hi`` of a layer: the closure rows stand at both of these ends,
wherever the ends lie in memory. The same formula is evaluated in the same order for a point whoever owns it, which is
what makes results independent of the number of ranks.

Rows of values live in one flat scratch array and are named by where they begin: a slice costs as much as fifty points.
Kernels go over them a vector at a time and may compute a vector's lanes beyond a range from whatever stands there; such
lanes are never stored where anything else stands, and no lane depends on another but through the stencil.
"""

from __future__ import annotations

import numpy as np
from numba import njit

import fsipetsc.operators.ufuncs  # noqa: F401  for formulas that name what numpy has
from fsipetsc.operators import sbp
from fsipetsc.operators.cache import use_cache_folder
from fsipetsc.operators.lanes import centred_difference, lane, mirrored
from fsipetsc.operators.memory import load
from fsipetsc.operators.parts import PART, Whole
from fsipetsc.operators.vectors import LANES, fma, spread

#: Points that a kernel treats at once: its scratch rows stay in the first-level cache.
BLOCK = 512
#: Scratch beyond a block on either side: twice the largest closure reach, and vectors that begin or end beyond.
MARGIN = 32
#: Distance of the rows of scratch: odd in cache lines, so that rows do not evict each other.
ROW = BLOCK + 2 * MARGIN + 8

_KEPT = use_cache_folder() is not None  # before the first kernel is defined

U64 = np.uint64
#: Of functions that Python calls. No "contract": the compiler forms different fused operations in the vector and the
#: scalar version of a formula, and a point's result would depend on where a rank's part begins. Where fusing pays,
#: ``fma`` says so explicitly.
ENTRY = {"pipeline_class": Whole, "cache": _KEPT, "error_model": "numpy", "nogil": True}
#: Of functions that only compiled code calls: not kept on disk for themselves, nothing made to call them from Python, and
#: no count kept of who refers to an array: that takes as long as some points, and all arrays outlive the call. What a
#: formula calls becomes part of it, too, whatever its size: numba hands that down. (Ends and couplings as functions of their
#: own compile in 1.5 s less, and take a step of 484 points 4 % longer.)
OPTIONS = {**PART, "error_model": "numpy", "nogil": True}
#: Of those that return an array that they have not been given.
ARRAYS = {**OPTIONS, "_nrt": True}
#: Of formulas at a point: always part of their caller, so that vectors stay in registers.
FORMULA = {**OPTIONS, "forceinline": True}


@njit(**FORMULA)
def weights_of(op, scale):
    """Weights c_1 .. c_4 of the interior formula, those that it does not have zero, times a scale."""
    c = op.interior
    return scale * c[0], scale * c[1], scale * c[2], scale * c[3]


@njit(**FORMULA)
def interior_stencil(p, weights, before, v, after):
    """Interior formula sum_k c_k (v[i+k] - v[i-k]) at the points of the vector v between its neighbours; p of weights."""
    d = weights[0] * centred_difference(before, v, after, 1)
    if p > 1:
        d = fma(weights[1], centred_difference(before, v, after, 2), d)
        if p > 2:
            d = fma(weights[2], centred_difference(before, v, after, 3), d)
            if p > 3:
                d = fma(weights[3], centred_difference(before, v, after, 4), d)
    return d


@njit(**FORMULA)
def closure(op, s, at, side, known, r):
    """Closure rows r .. r+3 of h D at the left (side 0) or right end of the row of values whose end is s[at].

    As the points lie in memory: at the left end row r comes first, at the right end last. Only the ``known`` values next
    to the end are read; rows that use more come out wrong. (Beyond a row's own columns the weights are zero.)
    """
    step, d = 1 - 2 * side, spread(0.0)
    for c in range(min(op.cols, known)):
        d = fma(load(op.columns, 8 * c + r), s[U64(at + step * c)], d)
    return d if side == 0 else -1.0 * mirrored(d)


#: number of points that the closure row at an end reaches
row_length = njit(**OPTIONS)(sbp.row_length)


@njit(**FORMULA)
def end_of(lo, hi, side, begin, end):
    """(end point, number of values known next to it) of the active range lo..hi, if those at begin .. end-1 are known."""
    return (lo, min(hi + 1, end) - lo) if side == 0 else (hi, hi + 1 - max(lo, begin))


@njit(**FORMULA)
def end_rows(op, lo, hi, side, r, begin, end):
    """(i, a, b): closure rows r .. r+3 stand at the points i .. i+3; lanes a <= j < b are rows and in begin .. end-1."""
    count = min(op.rows - r, LANES)
    i, a, b = (lo + r, 0, count) if side == 0 else (hi - r - LANES + 1, LANES - count, LANES)
    return i, max(a, begin - i), min(b, end - i)


@njit(**FORMULA)
def store_lanes(s, i, v, a, b):
    """s[i+j] = v[j] for the lanes a <= j < b."""
    if a <= 0 < b:
        s[U64(i)] = lane(v, 0)
    if a <= 1 < b:
        s[U64(i + 1)] = lane(v, 1)
    if a <= 2 < b:
        s[U64(i + 2)] = lane(v, 2)
    if a <= 3 < b:
        s[U64(i + 3)] = lane(v, 3)


@njit(**FORMULA)
def grid_start(origin, first):
    """The last point of the grid origin + k LANES that is not beyond the point ``first`` <= origin."""
    return origin - (origin - first + LANES - 1) // LANES * LANES


@njit(**FORMULA)
def whole_vectors(first, end):
    """The point that is reached by whole vectors from ``first``, not beyond ``end``."""
    return first + max(end - first, 0) // LANES * LANES


@njit(**ENTRY)
def derivative(op, s, v, v0, out, out0, i0, i1, lo, hi, scale):
    """scale * h D of one row into another, at the points i0 <= i < i1 of the active range lo..hi.

    Point i stands at s[v + i - v0] and its derivative at s[out + i - out0]. The input must reach ``op.reach`` points
    beyond i0 and i1 (or to lo, hi).
    """
    weights, v, out = weights_of(op, scale), v - v0, out - out0
    a, b = max(i0, lo + op.rows), min(i1, hi + 1 - op.rows)
    for i in range(a, b, LANES):
        d = interior_stencil(op.p, weights, load(s, v + i - LANES), load(s, v + i), load(s, v + i + LANES))
        store_lanes(s, out + i, d, 0, b - i)
    for side in range(2):
        end, known = end_of(lo, hi, side, i0 - op.reach, i1 + op.reach)
        for r in range(0, op.rows, LANES):
            i, first, last = end_rows(op, lo, hi, side, r, i0, i1)
            if first < last:
                store_lanes(s, out + i, scale * closure(op, s, v + end, side, known, r), first, last)


@njit(**OPTIONS)
def lagrange(delta, degree, weights, slopes):
    """Lagrange weights and their derivatives at delta for the nodes 0, 1, ..., degree.

    Node 0 is the ghost point and the boundary lies delta cells inside of it; (4.26) is degree 2, with the
    sign of its third weight corrected so that the weights sum to one.
    """
    for k in range(degree + 1):
        value, denominator, slope = 1.0, 1.0, 0.0
        for m in range(degree + 1):
            if m == k:
                continue
            slope = slope * (delta - m) + value
            value *= delta - m
            denominator *= k - m
        weights[k] = value / denominator
        slopes[k] = slope / denominator


@njit(**OPTIONS)
def dirichlet_ghost(g, v, weights, degree):
    """``bounded_ghost`` with the usual bound, 1/4."""
    return bounded_ghost(g, v, weights, degree, 0.25)


@njit(**OPTIONS)
def bounded_ghost(g, v, weights, degree, least):
    """Value of the ghost point (node 0) so that the interpolant takes the value g at the boundary.

    v[1..degree] are the nodes inside. The q-th difference is added with eta = max(0, least - L_0): the formula
    of Kreiss & Petersson (2006) as in (4.26), but with an eta that vanishes where L_0 is large enough, because
    a constant one spoils the accuracy when the boundary is close to the ghost point.
    """
    eta = max(0.0, least - weights[0])
    s = g
    binomial = 1.0
    for k in range(1, degree + 1):
        binomial *= -(degree + 1.0 - k) / k
        s -= (weights[k] + eta * binomial) * v[k]
    return s / (weights[0] + eta)


@njit(**OPTIONS)
def neumann_ghost(v, slopes, degree):
    """Value of the ghost point so that the interpolant has zero slope at the boundary (Kreiss et al. 2004)."""
    s = 0.0
    for k in range(1, degree + 1):
        s -= slopes[k] * v[k]
    return s / slopes[0]


@njit(**OPTIONS)
def extrapolate(v, degree):
    """Polynomial extrapolation to node 0 from the nodes 1 .. degree + 1."""
    s = 0.0
    binomial = 1.0
    for k in range(1, degree + 2):
        binomial *= -(degree + 2.0 - k) / k
        s -= binomial * v[k]
    return s


def scratch_size(count: int) -> int:
    """Doubles of scratch for ``count`` rows."""
    return count * ROW + 2 * MARGIN


@njit(**FORMULA)
def row(r):
    """Where row r of the scratch begins."""
    return MARGIN + r * ROW


@njit(**OPTIONS)
def copy(s, a, b, count):
    """s[b:b+count] = s[a:a+count]."""
    a, b = U64(a), U64(b)
    for i in range(U64(count)):
        s[b + i] = s[a + i]
