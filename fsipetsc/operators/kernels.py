"""Compiled application of a summation-by-parts operator and the formulas at an embedded boundary.

A derivative is taken on the *active* points ``lo..hi`` of a layer: the closure rows stand at both of these ends,
wherever the ends lie in memory. The same formula is evaluated in the same order for a point whoever owns it, which is
what makes results independent of the number of ranks.

Rows of values live in one flat scratch array and are named by where they begin; indices in hot loops are unsigned.
Both are for speed: a slice costs as much as fifty points, and signed indices may wrap around, which stops
vectorisation.
"""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from fsipetsc.operators.cache import use_cache_folder

#: Points that a kernel treats at once: its scratch rows stay in the first-level cache.
BLOCK = 512
#: Scratch beyond a block on either side: twice the largest closure reach and the rows that a closure writes too many.
MARGIN = 24
#: Distance of the rows of scratch: odd in cache lines, so that rows do not evict each other.
ROW = BLOCK + 2 * MARGIN + 8

use_cache_folder()  # before the first kernel is defined

U64 = np.uint64
U0, U1, U2, U3, U4, U5, U6, U7 = (np.uint64(k) for k in range(8))
#: No "contract": the compiler forms different fused operations in the vector and the scalar version of a loop, and a
#: point's result would depend on where a rank's part begins. Where fusing pays, ``fma`` says so explicitly.
OPTIONS = {"cache": True, "error_model": "numpy", "nogil": True}


def _llvm(name, arguments):
    """Type and code of one of LLVM's own functions of doubles."""
    signature = types.float64(*[types.float64] * arguments)

    def codegen(context, builder, signature, args):
        kind = ir.FunctionType(ir.DoubleType(), [ir.DoubleType()] * arguments)
        return builder.call(builder.module.declare_intrinsic(name, [ir.DoubleType()], kind), args)

    return signature, codegen


@intrinsic
def fma(typingctx, a, b, c):
    """a * b + c, rounded once."""
    return _llvm("llvm.fma", 3)


@intrinsic
def maximum(typingctx, a, b):
    """The larger one; not a number if one of them is not. Unlike max(), a loop over it is vectorised."""
    return _llvm("llvm.maximum", 2)


@intrinsic
def minimum(typingctx, a, b):
    """The smaller one; not a number if one of them is not."""
    return _llvm("llvm.minimum", 2)


@njit(**OPTIONS)
def stencil(op, s, v, out, m, scale):
    """Interior formula: s[out+i] = scale * sum_k c_k (s[v+i+k] - s[v+i-k]) for 0 <= i < m."""
    m, v, out = U64(max(m, 0)), U64(v), U64(out)
    c1, c2 = scale * op.interior[0], scale * op.interior[1]
    c3, c4 = scale * op.interior[2], scale * op.interior[3]
    if op.p == 1:
        for i in range(m):
            s[out + i] = c1 * (s[v + i + U1] - s[v + i - U1])
    elif op.p == 2:
        for i in range(m):
            s[out + i] = fma(c2, s[v + i + U2] - s[v + i - U2], c1 * (s[v + i + U1] - s[v + i - U1]))
    elif op.p == 3:
        for i in range(m):
            inner = fma(c2, s[v + i + U2] - s[v + i - U2], c1 * (s[v + i + U1] - s[v + i - U1]))
            s[out + i] = fma(c3, s[v + i + U3] - s[v + i - U3], inner)
    else:
        for i in range(m):
            inner = fma(c2, s[v + i + U2] - s[v + i - U2], c1 * (s[v + i + U1] - s[v + i - U1]))
            s[out + i] = fma(c4, s[v + i + U4] - s[v + i - U4], fma(c3, s[v + i + U3] - s[v + i - U3], inner))


@njit(**OPTIONS)
def closure(op, s, v, step, out, scale):
    """Closure rows at an end: s[out + step*r] = scale * sum_c closure[r, c] s[v + step*c] for r < 8.

    All rows at once, a column at a time, so that the sums run side by side. Eight rows are written, whatever the
    operator: the interior formula overwrites those that it does not have. Where a rank's part ends inside the
    closure, columns beyond it are multiplied by zero.
    """
    a0 = a1 = a2 = a3 = a4 = a5 = a6 = a7 = 0.0
    for c in range(op.cols):
        x, k = s[U64(v + step * c)], U64(c)
        a0 = fma(op.columns[k, U0], x, a0)
        a1 = fma(op.columns[k, U1], x, a1)
        a2 = fma(op.columns[k, U2], x, a2)
        a3 = fma(op.columns[k, U3], x, a3)
        if op.rows > 4:
            a4 = fma(op.columns[k, U4], x, a4)
            a5 = fma(op.columns[k, U5], x, a5)
            a6 = fma(op.columns[k, U6], x, a6)
            a7 = fma(op.columns[k, U7], x, a7)
    s[U64(out)] = scale * a0
    s[U64(out + step)] = scale * a1
    s[U64(out + 2 * step)] = scale * a2
    s[U64(out + 3 * step)] = scale * a3
    if op.rows > 4:
        s[U64(out + 4 * step)] = scale * a4
        s[U64(out + 5 * step)] = scale * a5
        s[U64(out + 6 * step)] = scale * a6
        s[U64(out + 7 * step)] = scale * a7


@njit(**OPTIONS)
def short_closure(op, s, v, step, out, scale):
    """As ``closure``, for a layer in which the ends meet: rows that the operator does not have are not written."""
    for r in range(op.rows):
        a = 0.0
        for c in range(op.cols):
            a = fma(op.columns[c, r], s[v + step * c], a)
        s[out + step * r] = scale * a


@njit(**OPTIONS)
def derivative(op, s, v, v0, out, out0, i0, i1, lo, hi, scale):
    """scale * h D of one scratch row into another, at the points i0 <= i < i1 of the active range lo..hi.

    Point i stands at s[v + i - v0] and its derivative at s[out + i - out0]. The input must reach ``op.reach`` points
    beyond i0 and i1 (or to lo, hi).
    """
    short = hi - lo + 1 < 16  # the eight rows of one end would reach into those of the other
    if i0 < lo + op.rows:
        at, to = v + lo - v0, out + lo - out0
        if short:
            short_closure(op, s, at, 1, to, scale)
        else:
            closure(op, s, at, 1, to, scale)
    if i1 > hi + 1 - op.rows:
        at, to = v + hi - v0, out + hi - out0
        if short:
            short_closure(op, s, at, -1, to, -scale)
        else:
            closure(op, s, at, -1, to, -scale)
    a, b = max(i0, lo + op.rows), min(i1, hi + 1 - op.rows)
    stencil(op, s, v + a - v0, out + a - out0, b - a, scale)


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
    """Value of the ghost point (node 0) so that the interpolant takes the value g at the boundary.

    v[1..degree] are the nodes inside. The q-th difference is added with eta = max(0, 1/4 - L_0): the formula
    of Kreiss & Petersson (2006) as in (4.26), but with an eta that vanishes where L_0 is large enough, because
    a constant one spoils the accuracy when the boundary is close to the ghost point.
    """
    eta = max(0.0, 0.25 - weights[0])
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


@njit(**OPTIONS)
def row(r):
    """Where row r of the scratch begins."""
    return MARGIN + r * ROW


@njit(**OPTIONS)
def copy(s, a, b, count):
    """s[b:b+count] = s[a:a+count]."""
    a, b = U64(a), U64(b)
    for i in range(U64(count)):
        s[b + i] = s[a + i]
