"""Metrics of a moving grid in two dimensions, whose faces alone are differentiated. Compiled.

D_k of a linear function is exact, so derivatives of a blend of faces are blends of derivatives along
them. With S, N the faces along axis 1 at the low and high end of axis 2, W, E those along axis 2, and
l, h the weights of low and high ends,

    Q_ij    = l_j S_i + h_j N_i
    u_ij    = Q_ij + l_i (W_j - Q_0j) + h_i (E_j - Q_nj)
    D_1 u_ij = l_j D_1 S_i + h_j D_1 N_i + [E_j - W_j - (Q_nj - Q_0j)]
    D_2 u_ij = l_i D_2 W_j + h_i D_2 E_j + [N_i - S_i - l_i (N_0 - S_0) - h_i (N_n - S_n)]

The brackets are 0 to the bit at W and E or at S and N. Along a periodic axis there are no faces; then
the other two, l, h, and the values at vertices are 0.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.faces import face_nodes
from fsipetsc.blocks.metrics import EXACT, Wide, differentiate
from fsipetsc.checks import Array
from fsipetsc.operators.loops import CALL, add, dot, load, rows, scale, store, sub


class Lines(NamedTuple):
    """A range of nodes of a block, for compiled code; pairs are of axis 0 and 1.

    columns: the nodes of the two faces along the axis among those of the hull, (2, n) of the wide range,
    (2, 0) if there are none. S, weight: of its band. first: where the range begins in the wide one. low,
    high: weights of the ends (n,). corners: of the vertices among the hull, side of axis 0 + 2 of axis 1.
    """

    columns: tuple[Array, ...]
    S: tuple[Array, ...]
    weight: tuple[Array, ...]
    first: tuple[int, ...]
    low: tuple[Array, ...]
    high: tuple[Array, ...]
    corners: Array


def lines_of(wide: Wide, block: Block, hull: Any, end_weights: Any) -> Lines:
    """Of a block in 1-D or 2-D, where there are no faces along its axis."""
    d, columns, weights = block.dimension, [], []
    for axis, (begin, end) in enumerate(wide.wide):
        along = np.arange(begin, end) % block.shape[axis]
        faces = [face_nodes(block.shape, 1 - axis, s)[along] for s in (0, 1) if d == 2]
        if d == 1 or block.periodic[1 - axis]:
            faces = np.zeros((2, 0), int)
        columns.append(hull.columns(np.array(faces)))
        weights.append(end_weights(block, axis, np.arange(*wide.where[axis])))
    first = tuple(begin - wide_begin for (begin, _), (wide_begin, _) in zip(wide.where, wide.wide))
    corners = np.zeros(0, int)
    if d == 2 and not any(block.periodic):
        corners = np.concatenate([face_nodes(block.shape, 1, side)[[0, -1]] for side in (0, 1)])
    low, high = zip(*weights)
    return Lines(tuple(columns), wide.S, wide.weight, first, low, high, hull.columns(corners))


@njit(**CALL)
def plane_metrics(metrics, G, values, lines):
    """Fill a^1, a^2 from values (2, H) of the displacement; G: (4, N), D_1 X and D_2 X."""
    like, low, high = (0.0, 0.0), lines.low[0], lines.high[0]
    n, corners = low.size, _corners(values, lines.corners)
    f, slope = _along(values, lines, 0)
    g, rise_of = _along(values, lines, 1)
    rise = _rise(f, corners, low, high)
    for j in range(lines.low[1].size):
        l, h, a, b = lines.low[1][j], lines.high[1][j], j * n, (j + 1) * n
        start, stop = _ends(corners, l, h)
        across = sub(sub(_pair(g, 2, j), _pair(g, 0, j)), sub(stop, start))
        low_slope, high_slope = _pair(rise_of, 0, j), _pair(rise_of, 2, j)
        a1, a2 = rows(like, metrics, a, b), rows(like, metrics[2:], a, b)
        G1, G2 = rows(like, G, a, b), rows(like, G[2:], a, b)
        S, N, B = rows(like, slope, 0, n), rows(like, slope[2:], 0, n), rows(like, rise, 0, n)
        _row_of_metrics(a1, a2, G1, G2, S, N, B, low, high, l, h, across, low_slope, high_slope)


@njit(**CALL)
def plane_velocities(metrics, values, lines):
    """Fill the velocity v and J_t = a^1 . D_1 v + a^2 . D_2 v from values (2, H) of the velocity."""
    like, low, high = (0.0, 0.0), lines.low[0], lines.high[0]
    n, corners = low.size, _corners(values, lines.corners)
    f, slope = _along(values, lines, 0)
    g, rise_of = _along(values, lines, 1)
    rise = _rise(f, corners, low, high)
    for j in range(lines.low[1].size):
        l, h, a, b = lines.low[1][j], lines.high[1][j], j * n, (j + 1) * n
        (start, stop), west, east = _ends(corners, l, h), _pair(g, 0, j), _pair(g, 2, j)
        across, low_slope, high_slope = sub(sub(east, west), sub(stop, start)), _pair(rise_of, 0, j), _pair(rise_of, 2, j)
        a1, a2, v = rows(like, metrics, a, b), rows(like, metrics[2:], a, b), rows(like, metrics[4:], a, b)
        S, N, B = rows(like, slope, 0, n), rows(like, slope[2:], 0, n), rows(like, rise, 0, n)
        fS, fN = rows(like, f, 0, n), rows(like, f[2:], 0, n)
        _row_of_velocities(v, fS, fN, low, high, l, h, sub(west, start), sub(east, stop))
        _row_of_rates(metrics[6, a:b], a1, a2, S, N, B, low, high, l, h, across, low_slope, high_slope)
        if low[0] == 1.0:
            store(v, 0, west)
        if high[n - 1] == 1.0:
            store(v, n - 1, east)


@njit(**EXACT)
def _row_of_metrics(a1, a2, G1, G2, S, N, B, low, high, l, h, across, low_slope, high_slope):
    """a^1 = (D_2 y, -D_2 x), a^2 = (-D_1 y, D_1 x) of a row of nodes."""
    for i in range(low.size):
        D1 = add(add(scale(l, load(S, i)), scale(h, load(N, i))), across)
        D2 = add(add(scale(low[i], low_slope), scale(high[i], high_slope)), load(B, i))
        x1, x2 = add(load(G1, i), D1), add(load(G2, i), D2)
        store(a1, i, (x2[1], -x2[0]))
        store(a2, i, (-x1[1], x1[0]))


@njit(**EXACT)
def _row_of_velocities(v, S, N, low, high, l, h, west, east):
    """v of a row of nodes."""
    for i in range(low.size):
        Q = add(scale(l, load(S, i)), scale(h, load(N, i)))
        store(v, i, add(Q, add(scale(low[i], west), scale(high[i], east))))


@njit(**EXACT)
def _row_of_rates(J_t, a1, a2, S, N, B, low, high, l, h, across, low_slope, high_slope):
    """J_t of a row of nodes."""
    for i in range(low.size):
        D1 = add(add(scale(l, load(S, i)), scale(h, load(N, i))), across)
        D2 = add(add(scale(low[i], low_slope), scale(high[i], high_slope)), load(B, i))
        J_t[i] = dot(load(a1, i), D1) + dot(load(a2, i), D2)


@njit(**CALL)
def _along(values, lines, axis):
    """Values and derivatives along the two faces of an axis, (4, n): rows 2 side + component; or 0."""
    columns, weight, first = lines.columns[axis], lines.weight[axis], lines.first[axis]
    f, slope = np.zeros((4, weight.size)), np.zeros((4, weight.size))
    if columns.size > 0:
        for row in range(4):
            given, at, face = values[row % 2], columns[row // 2], f[row]
            for i in range(weight.size):
                face[i] = given[at[i]]
        differentiate(slope.reshape(-1), f.reshape(-1), lines.S[axis], weight, 1)
    end = first + lines.low[axis].size
    return f[:, first:end].copy(), slope[:, first:end].copy()


@njit(**CALL)
def _corners(values, columns):
    """Values (4, 2) at the vertices; 0 if there are none."""
    corners = np.zeros((4, 2))
    for k in range(columns.size):
        for c in range(2):
            corners[k, c] = values[c, columns[k]]
    return corners


@njit(**CALL)
def _pair(f, row, j):
    return f[row, j], f[row + 1, j]


@njit(**CALL)
def _ends(corners, l, h):
    """Q_0j and Q_nj."""
    start = l * corners[0, 0] + h * corners[2, 0], l * corners[0, 1] + h * corners[2, 1]
    stop = l * corners[1, 0] + h * corners[3, 0], l * corners[1, 1] + h * corners[3, 1]
    return start, stop


@njit(**CALL)
def _rise(f, corners, low, high):
    """[N_i - S_i - l_i (N_0 - S_0) - h_i (N_n - S_n)], (2, n), from values f along S and N."""
    rise = np.empty((2, low.size))
    for c in range(2):
        at_low, at_high = corners[2, c] - corners[0, c], corners[3, c] - corners[1, c]
        for i in range(low.size):
            rise[c, i] = (f[2 + c, i] - f[c, i]) - (low[i] * at_low + high[i] * at_high)
    return rise
