"""Compiled application of a summation-by-parts operator and the formulas at an embedded boundary.

Everything here is a loop over plain arrays. A derivative is taken on the *active* points ``lo..hi`` of a
layer: the closure rows stand at both of these ends, wherever the ends lie in memory. A row of values holds
the points from ``first`` on, so point ``i`` is at ``row[i - first]``; the same formula is evaluated in the same
order for a point whoever owns it, which is what makes results independent of the number of ranks.
"""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from fsipetsc.operators.cache import FOLDER as CACHE_FOLDER  # first: kernels are cached where this says

#: Points that a kernel treats at once: its scratch rows stay in the first-level cache.
BLOCK = 512
#: Scratch beyond a block on either side: twice the largest closure reach, rounded up.
MARGIN = 16

#: No "contract": the compiler forms different fused operations in the vector and the scalar version of a loop, and a
#: point's result would depend on where a rank's part begins. Where fusing pays, ``fma`` says so explicitly.
OPTIONS = {"cache": True, "error_model": "numpy", "nogil": True}


@intrinsic
def fma(typingctx, a, b, c):
    """a * b + c, rounded once."""
    double = types.float64

    def codegen(context, builder, signature, args):
        kind = ir.FunctionType(ir.DoubleType(), [ir.DoubleType()] * 3)
        function = builder.module.declare_intrinsic("llvm.fma", [ir.DoubleType()], kind)
        return builder.call(function, args)

    return double(double, double, double), codegen


@njit(**OPTIONS)
def stencil(op, v, v0, out, out0, i0, i1, scale):
    """Interior formula: out_i = scale * sum_k c_k (v_{i+k} - v_{i-k}) for i0 <= i < i1."""
    m = i1 - i0
    if m <= 0:
        return
    a = i0 - v0
    o = out[i0 - out0 : i1 - out0]
    c1 = scale * op.interior[0]
    e1, w1 = v[a + 1 : a + 1 + m], v[a - 1 : a - 1 + m]
    if op.p == 1:
        for i in range(m):
            o[i] = c1 * (e1[i] - w1[i])
        return
    c2 = scale * op.interior[1]
    e2, w2 = v[a + 2 : a + 2 + m], v[a - 2 : a - 2 + m]
    if op.p == 2:
        for i in range(m):
            o[i] = fma(c2, e2[i] - w2[i], c1 * (e1[i] - w1[i]))
        return
    c3 = scale * op.interior[2]
    e3, w3 = v[a + 3 : a + 3 + m], v[a - 3 : a - 3 + m]
    if op.p == 3:
        for i in range(m):
            o[i] = fma(c3, e3[i] - w3[i], fma(c2, e2[i] - w2[i], c1 * (e1[i] - w1[i])))
        return
    c4 = scale * op.interior[3]
    e4, w4 = v[a + 4 : a + 4 + m], v[a - 4 : a - 4 + m]
    for i in range(m):
        o[i] = fma(c4, e4[i] - w4[i], fma(c3, e3[i] - w3[i], fma(c2, e2[i] - w2[i], c1 * (e1[i] - w1[i]))))


@njit(**OPTIONS)
def derivative(op, v, v0, out, out0, i0, i1, lo, hi, scale):
    """out = scale * h D v at the points i0 <= i < i1 of the active range lo..hi.

    v holds the points from v0 on and must reach ``op.reach`` points beyond i0 and i1 (or to lo, hi).
    """
    for i in range(i0, min(i1, lo + op.rows)):
        r = i - lo
        s = 0.0
        for c in range(min(op.cols, r + op.reach + 1)):
            s += op.closure[r, c] * v[lo + c - v0]
        out[i - out0] = scale * s
    stencil(op, v, v0, out, out0, max(i0, lo + op.rows), min(i1, hi + 1 - op.rows), scale)
    for i in range(max(i0, hi + 1 - op.rows), i1):
        r = hi - i
        s = 0.0
        for c in range(min(op.cols, r + op.reach + 1)):
            s += op.closure[r, c] * v[hi - c - v0]
        out[i - out0] = -scale * s


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


def scratch_rows(count: int) -> np.ndarray:
    """Scratch for the kernels: ``count`` rows of ``BLOCK + 2 MARGIN`` doubles, staggered against cache aliasing."""
    return np.zeros((count, BLOCK + 2 * MARGIN + 8))
