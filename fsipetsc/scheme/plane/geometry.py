"""What follows from the lines of a gas's grid, by column, once in a stage. Compiled.

The grid is straight in eta between its two lines. So Ja1 does not depend on eta; Ja2, w and g1 = Ja1 . w are linear in zeta,
g2 = Ja2 . w is of second degree: what stands here is all there is to know of them at any row, and it stays in a cache.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64
from fsipetsc.operators.memory import load_wide, store
from fsipetsc.operators.rows import MARGIN, STRIDE, along
from fsipetsc.operators.vectors import WIDE, fma
from fsipetsc.physics.plane.gas import DG1, DISTANCES, G1, G2, JA1, JA2_X, JA2_Y, LINE_ROWS, OF_PAIRS, PAIR_ROWS
from fsipetsc.scheme.plane.sweep import at_ends, columns


@njit(**OPTIONS)
def lay(layer, op, s, place, lines):
    """Put the lines (2, 4, width), displacement in x, y, velocity, and what follows from them into scratch, for a block."""
    a, b = columns(layer, op, place, 1)
    first, last = max(a, 0), min(b + WIDE, layer.width)
    beyond = 2 * WIDE if at_ends(layer, place) else WIDE
    a, b = place.first - beyond, place.end + beyond
    for side in range(2):
        row = place.lines + side * LINE_ROWS * STRIDE
        for c in range(4):
            for i in range(first, last):
                s[U64(row + c * STRIDE + i)] = lines[side, c, i]
        for c in range(2):
            slope, to = row + c * STRIDE, row + (4 + c) * STRIDE
            along(op, s, slope, to, a, b, layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
    metrics_of_lines(layer, s, place, a, b)
    for c in range(2):
        of_g1, to = place.lines + (G1 + c) * STRIDE, place.lines + (DG1 + c) * STRIDE
        along(op, s, of_g1, to, place.first, place.end, layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
    weigh_pairs(layer, op, s, place)


@njit(**OPTIONS)
def no_grid(layer, op, s, place, lines):
    """Of solids."""


@njit(**OPTIONS)
def metrics_of_lines(layer, s, place, a, b):
    """Ja1, Ja2, g1, g2 in the columns a <= i < b."""
    per_length = 1.0 / ((layer.ny - 1) * layer.h_y)
    for i in range(a, b, WIDE):
        low, to = place.lines + i, place.lines + i
        high = low + LINE_ROWS * STRIDE
        dx, dy = load_wide(s, high) - load_wide(s, low), load_wide(s, high + STRIDE) - load_wide(s, low + STRIDE)
        u, v = load_wide(s, low + 2 * STRIDE), load_wide(s, low + 3 * STRIDE)
        du, dv = load_wide(s, high + 2 * STRIDE) - u, load_wide(s, high + 3 * STRIDE) - v
        x, y = load_wide(s, low + 4 * STRIDE) + 1.0, load_wide(s, low + 5 * STRIDE)
        x_more, y_more = load_wide(s, high + 4 * STRIDE) + 1.0 - x, load_wide(s, high + 5 * STRIDE) - y
        ax, ay = dy * per_length, -1.0 * per_length * dx
        store(s, to + JA1 * STRIDE, ax)
        store(s, to + (JA1 + 1) * STRIDE, ay)
        store(s, to + JA2_X * STRIDE, -1.0 * y)
        store(s, to + (JA2_X + 1) * STRIDE, -1.0 * y_more)
        store(s, to + JA2_Y * STRIDE, x)
        store(s, to + (JA2_Y + 1) * STRIDE, x_more)
        store(s, to + G1 * STRIDE, fma(ax, u, ay * v))
        store(s, to + (G1 + 1) * STRIDE, fma(ax, du, ay * dv))
        store(s, to + G2 * STRIDE, x * v - y * u)
        store(s, to + (G2 + 1) * STRIDE, fma(x, dv, x_more * v) - fma(y, du, y_more * u))
        store(s, to + (G2 + 2) * STRIDE, x_more * dv - y_more * du)


@njit(**OPTIONS)
def jacobian(layer, s, place, J):
    """x_xi y_eta - x_eta y_xi in the columns of a block, to J[row, column], of the points that are owned."""
    low, height = place.lines, (layer.ny - 1) * layer.h_y
    high = low + LINE_ROWS * STRIDE
    for j in range(J.shape[0]):
        zeta = (layer.first_y + layer.own_y[0] + j) / (layer.ny - 1)
        for i in range(place.first, place.end):
            x_xi, y_xi = 1.0 + blended(s, low, high, 4 * STRIDE + i, zeta), blended(s, low, high, 5 * STRIDE + i, zeta)
            x_eta = (s[U64(high + i)] - s[U64(low + i)]) / height
            y_eta = (s[U64(high + STRIDE + i)] - s[U64(low + STRIDE + i)]) / height
            J[j, i - layer.own_x[0]] = x_xi * y_eta - x_eta * y_xi


@njit(**OPTIONS)
def blended(s, low, high, row, zeta):
    """Of a quantity of the lines, between them."""
    return s[U64(low + row)] + zeta * (s[U64(high + row)] - s[U64(low + row)])


@njit(**OPTIONS)
def weigh_pairs(layer, op, s, place):
    """Q / (2 h) of the pairs i, i + k along the rows, times the sums of Ja1, and of -2 g1."""
    lo, hi = layer.end_x[0], layer.end_x[1]
    for k in range(1, op.p + 1):
        weight = op.interior[k - 1] * (0.5 / layer.h_x)
        for c in range(PAIR_ROWS):
            row, to, factor = rows_of_pairs(place, k, c, weight)
            for i in range(place.first - WIDE, place.end, WIDE):
                store(s, to + i, factor * (load_wide(s, row + i) + load_wide(s, row + i + k)))
    if at_ends(layer, place):
        for k in range(1, DISTANCES + 1):
            for i in range(max(place.first - WIDE, lo), min(place.end, hi - k + 1)):
                if i < lo + op.rows or i + k > hi - op.rows:
                    weight = weight_of_pair(op, i, k, lo, hi) * (0.5 / layer.h_x)
                    for c in range(PAIR_ROWS):
                        row, to, factor = rows_of_pairs(place, k, c, weight)
                        s[U64(to + i)] = factor * (s[U64(row + i)] + s[U64(row + i + k)])


@njit(**FORMULA)
def rows_of_pairs(place, k, c, weight):
    """(row of Ja1, g1, where it goes, its factor)."""
    row = place.lines + (JA1 + c if c < 2 else G1 + c - 2) * STRIDE
    return row, place.lines + (OF_PAIRS + PAIR_ROWS * (k - 1) + c) * STRIDE, weight if c < 2 else -2.0 * weight


@njit(**FORMULA)
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
