"""What follows from the lines of a gas's grid, by column, once in a stage. Compiled.

The grid is straight in eta between its two lines. So Ja1 does not depend on eta; Ja2, w and g1 = Ja1 . w are linear in zeta,
g2 = Ja2 . w is of second degree: what stands here is all there is to know of them at any row, and it stays in a cache.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.operators.rows import MARGIN, along
from fsipetsc.operators.vectors import WIDE, fma, load_wide, store
from fsipetsc.physics.plane.gas import DG1, DISTANCES, G1, G2, JA1, JA2_X, JA2_Y, LINE_ROWS, OF_PAIRS, PAIR_ROWS
from fsipetsc.scheme.plane.sweep import columns


@njit(**OPTIONS)
def lay(layer, op, s, place, lines):
    """Put the lines (2, 4, width) into scratch, displacement in x, y, velocity, and what follows from them behind."""
    stride, (a, b) = place.stride, columns(layer, op)
    for side in range(2):
        row = place.lines + side * LINE_ROWS * stride
        for c in range(4):
            for i in range(layer.width):
                s[U64(row + c * stride + i)] = lines[side, c, i]
        for c in range(2):
            along(op, s, row + c * stride, row + (4 + c) * stride, a, b, layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
    metrics_of_lines(layer, s, place, a, b)
    for c in range(2):
        of_g1, to = place.lines + (G1 + c) * stride, place.lines + (DG1 + c) * stride
        along(op, s, of_g1, to, layer.own_x[0], layer.own_x[1], layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
    weigh_pairs(layer, op, s, place)


@njit(**OPTIONS)
def metrics_of_lines(layer, s, place, a, b):
    """Ja1, Ja2, g1, g2 in the columns a <= i < b."""
    stride, per_length = place.stride, 1.0 / ((layer.ny - 1) * layer.h_y)
    for i in range(a, b, WIDE):
        low, to = place.lines + i, place.lines + i
        high = low + LINE_ROWS * stride
        dx, dy = load_wide(s, high) - load_wide(s, low), load_wide(s, high + stride) - load_wide(s, low + stride)
        u, v = load_wide(s, low + 2 * stride), load_wide(s, low + 3 * stride)
        du, dv = load_wide(s, high + 2 * stride) - u, load_wide(s, high + 3 * stride) - v
        x, y = load_wide(s, low + 4 * stride) + 1.0, load_wide(s, low + 5 * stride)
        x_more, y_more = load_wide(s, high + 4 * stride) + 1.0 - x, load_wide(s, high + 5 * stride) - y
        ax, ay = dy * per_length, -1.0 * per_length * dx
        store(s, to + JA1 * stride, ax)
        store(s, to + (JA1 + 1) * stride, ay)
        store(s, to + JA2_X * stride, -1.0 * y)
        store(s, to + (JA2_X + 1) * stride, -1.0 * y_more)
        store(s, to + JA2_Y * stride, x)
        store(s, to + (JA2_Y + 1) * stride, x_more)
        store(s, to + G1 * stride, fma(ax, u, ay * v))
        store(s, to + (G1 + 1) * stride, fma(ax, du, ay * dv))
        store(s, to + G2 * stride, x * v - y * u)
        store(s, to + (G2 + 1) * stride, fma(x, dv, x_more * v) - fma(y, du, y_more * u))
        store(s, to + (G2 + 2) * stride, x_more * dv - y_more * du)


@njit(**OPTIONS)
def weigh_pairs(layer, op, s, place):
    """Q / (2 h) of the pairs i, i + k along the rows, times the sums of Ja1, and of -2 g1."""
    stride, lo, hi = place.stride, layer.end_x[0], layer.end_x[1]
    a, b = layer.own_x[0], layer.own_x[1]
    closed = (a - op.rows <= lo < b + op.rows) or (a - op.rows <= hi < b + op.rows)
    for k in range(1, (DISTANCES if closed else op.p) + 1):
        to = place.lines + (OF_PAIRS + PAIR_ROWS * (k - 1)) * stride
        for i in range(a - k, b):
            weight = weight_of_pair(op, i, k, lo, hi) * (0.5 / layer.h_x)
            if weight == 0.0:
                for c in range(PAIR_ROWS):
                    s[U64(to + c * stride + i)] = 0.0
                continue
            for c in range(PAIR_ROWS):
                row, factor = place.lines + (JA1 + c if c < 2 else G1 + c - 2) * stride, (weight if c < 2 else -2.0 * weight)
                s[U64(to + c * stride + i)] = factor * (s[U64(row + i)] + s[U64(row + i + k)])


@njit(**OPTIONS)
def weight_of_pair(op, i, k, lo, hi):
    """Q_il of the points i and l = i + k between the ends lo and hi, without h."""
    if i < lo or i + k > hi:
        return 0.0
    for near, far in ((i - lo, i + k - lo), (hi - i - k, hi - i)):
        if near < op.rows:
            return op.norm[near] * op.closure[near, far] if far < op.cols else 0.0
    return op.interior[k - 1] if k <= op.p else 0.0


@njit(**OPTIONS)
def find_normals(op, points, normals, s, stride, count, first, last, h, places):
    """N = (-y_xi, x_xi) and its rate at points of a line of ``count``, of which (x, y, u, v) are columns 5 to 8; s: 8 rows.

    places: where on the line the points are; closures stand at first and last.
    """
    for n in range(places.size):
        for c in range(4):
            s[U64(MARGIN + c * stride + places[n])] = points[n, 5 + c]
    for c in range(4):
        along(op, s, MARGIN + c * stride, MARGIN + (4 + c) * stride, 0, count, first, last, 1.0 / h)
    for n in range(places.size):
        slope = MARGIN + 4 * stride + places[n]
        normals[n, 0], normals[n, 1] = -s[U64(slope + stride)], 1.0 + s[U64(slope)]
        normals[n, 2], normals[n, 3] = -s[U64(slope + 3 * stride)], s[U64(slope + 2 * stride)]
