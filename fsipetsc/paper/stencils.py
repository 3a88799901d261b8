"""The SBP first derivative on rows of values, and narrow second derivatives.

Rows hold the points of a layer. The closures stand at the first and the last active point, A and B.
A span (a, b, A, B) is of the points a .. b-1.

D acts twice on u and T, with b = mu', kappa or kappa_e / x_X between. That leaves the shortest wave
alone, (-1)^i being in the null space of the interior formula. With the norm H of D (h = 1), B =
diag(b) and E the difference of the two ends,

    H D B D   = -D^T H B D + E B D                     wide: D twice
    H D2(b)   = -(D^T H B D + R(b)) + E B D            narrow: D2(b) = D B D - H^-1 R(b)

    R(b) = sum_q  Delta_q^T  diag(mean_q b)  Delta_q  +  terms at the ends,     q = p+1 .. 2p

Delta_q are the undivided differences of order q, at i of the values at i .. i+q, and mean_q b is a
sum of b at the 2p - q + 1 points in the middle of a difference, with the weights that make the
interior formula of D2 one of 2p + 1 points. At either end the differences that begin at the first T
points are left out, and the first T of order p+1 have a term of their own instead, with b at T:

    b_T  Delta_{p+1}^T  c L L^T  Delta_{p+1},             c the sum of the weights of mean_{p+1}

Whatever L is, R is symmetric, for b >= 0 positive semidefinite, and 0 on polynomials up to degree
p. A flux that is imposed by the closure row of D makes an error phi h^p u^(p+1), which the L of
_ENDS make 0 for 2/1, 4/2 and 6/3; without them phi is 1/2, -1/3, 0.31, -0.38.

Sources: K. Mattsson, J. Sci. Comput. 51 (2012), 650-682; B. Sjögreen and N. A. Petersson, J. Sci.
Comput. 52 (2012), 17-48.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from fsipetsc.kernels.loops import each, variable, when
from fsipetsc.operators.sbp import SBPOperator, fractions, undivided

#: As STIFFNESS_OF_WIDE, by interior order: D2(1) has spectral radii of 4.0, 5.3, 6.0 and 7.1 at
#: most with a ghost point at any place.
STIFFNESS = {2: 2.0, 4: 2.2, 6: 2.5, 8: 2.9}
_MEANS = {
    2: ("1/4",),
    4: ("1/36 1/36", "1/144"),
    6: ("1/240 1/240 1/240", "1/1200 1/1200", "1/3600"),
    8: ("1/1400 1/1400 1/1400 1/1400", "1/8400 1/6300 1/8400", "1/29400 1/29400", "1/78400"),
}
#: weights of mean_q, q = p+1 .. 2p, by interior order
MEANS = {order: tuple(map(fractions, rows)) for order, rows in _MEANS.items()}
_ENDS: dict[int, tuple[str, ...]] = {
    2: ("0",),
    4: ("0.57 0", "0.51 0.8275808859653828", "-0.64 0.67"),
    6: ("0.51 0 0", "0.9 0.86 0", "-0.18 1.5909323365068795 0.02", "0.17 0.85 -1.12"),
    8: (),
}


def end_term(order: int) -> list[list[Any]]:
    """c L L^T, (T, T), of fractions, of the operator of an interior order."""
    rows, c = [np.array(fractions(row)) for row in _ENDS[order]], sum(MEANS[order][0])
    return [[c * (a @ b) for b in rows] for a in rows]


def halo_of_rates(op: SBPOperator) -> int:
    """Points of other ranks that rates and ends need: D acts twice."""
    return max(2 * op.reach, 6)


def near_ends(op: SBPOperator, span: Any) -> Iterator[tuple[Any, Any, Any, int]]:
    """Yield (r, i, end, step): points i of a span, number r from an end, A or B; step: inwards."""
    a, b, A, B = span
    for end, step in ((A, 1), (B, -1)):
        for r in each(op.rows):
            i = end + step * r
            with when((a <= i) & (i < b)):
                yield r, i, end, step


def derivatives(layer, rows, span, scale):
    """(i, near, [scale h D q for q in rows]) at each point i of a span. near: (r, end) for point
    number r from an end, A or B, or None. Rows are known where D reaches from the span, or to A, B.
    """
    op, (a, b, A, B) = layer.op, span
    first, beyond = np.maximum(a, A + op.rows), np.minimum(b, B + 1 - op.rows)
    weights = [(k, scale * float(weight)) for k, weight in enumerate(op.interior, 1)]
    for i in each(first, beyond, vector=True):
        yield i, None, [sum(v * (q[i + k] - q[i - k]) for k, v in weights) for q in rows]
    for r, i, end, step in near_ends(op, span):
        sums = [variable(0.0) for _ in rows]
        for k in each(op.rows + op.p):
            weight, j = layer.closure[r, 1 + k], end + step * k
            with when(weight != 0.0):  # what D does not reach may be no number
                for q, total in zip(rows, sums, strict=True):
                    total.value = total.value + weight * q[j]
        yield i, (r, end), [step * scale * total.value for total in sums]


def add_remainder(layer, scale, b, y, scratch, out, span):
    """out[i] += scale H^-1 R(b) y at the points of a span; scratch: two rows, with 2p more."""
    op, (begin, end, A, B), (g, sums) = layer.op, span, scratch
    g = g[2 * op.p :]  # some differences begin before the first point
    means, T = MEANS[op.order], len(_ENDS[op.order])
    sums[begin:end] = 0.0
    for q, of_mean in enumerate(means, op.p + 1):
        skipped, weights = (q + 1 - len(of_mean)) // 2, undivided(q)
        g[begin - q : end] = 0.0
        first, last = np.maximum(begin - q, A + T), np.minimum(end, B + 1 - T - q)
        for i in each(first, last, vector=True):
            mean = sum(float(v) * b[i + skipped + k] for k, v in enumerate(of_mean))
            g[i] = mean * sum(v * y[i + k] for k, v in enumerate(weights))
        if q == op.p + 1:
            add_end_terms(op, b, y, g, span)
        for i in each(begin, end, vector=True):
            sums[i] += sum(v * g[i - k] for k, v in enumerate(weights))
    for r, i, _, _ in near_ends(op, span):
        sums[i] *= 1.0 / layer.closure[r, 0]
    for i in each(begin, end, vector=True):
        out[i] += scale * sums[i]


def add_end_terms(op, b, y, g, span):
    """Add b_T c L L^T Delta_{p+1} y to the differences g at both ends."""
    (begin, end, A, B), term = span, end_term(op.order)
    T, q, weights = len(term), op.p + 1, undivided(op.p + 1)
    for edge, step, inside in ((A, 1, A + T), (B - q, -1, B - T)):
        for t, row in enumerate(term):
            at = edge + step * t
            with when((begin - q <= at) & (at < end)):
                differences = (
                    sum(v * y[edge + step * k + j] for j, v in enumerate(weights)) for k in range(T)
                )
                total = sum(float(v) * one for v, one in zip(row, differences, strict=True))
                g[at] += b[inside] * total
