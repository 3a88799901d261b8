"""Metrics of a moving grid in two dimensions, of which only the faces are differentiated. Compiled.

D_k of a linear function is exact, so derivatives of a blend of faces are blends of derivatives
along them. With S, N the faces along axis 1 at the low and high end of axis 2, W, E those along
axis 2, and l, h the weights of low and high ends,

    Q_ij     = l_j S_i + h_j N_i
    u_ij     = Q_ij + l_i (W_j - Q_0j) + h_i (E_j - Q_nj)
    D_1 u_ij = l_j D_1 S_i + h_j D_1 N_i + [E_j - W_j - (Q_nj - Q_0j)]
    D_2 u_ij = l_i D_2 W_j + h_i D_2 E_j + [N_i - S_i - l_i (N_0 - S_0) - h_i (N_n - S_n)]

The brackets are 0 to the bit at S and N, or W and E. Along a periodic axis there are no faces
across it; then their values, those at vertices, l and h are 0.
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


class PlaneGrid:
    """The faces of a range of nodes of a block, of which values (2, H) at the hull are given.

    weights: of the low and high ends of each axis, on the range.
    """

    def __init__(self, block: Block, wide: Wide, hull: Any, weights: list[Array]) -> None:
        self._axes, self._faces = [], []
        for axis, (begin, end) in enumerate(wide.wide):
            index, n = np.arange(begin, end) % block.shape[axis], weights[2 * axis].size
            faces = [face_nodes(block.shape, 1 - axis, side)[index] for side in (0, 1)]
            columns = hull.columns(np.array(faces)[:, : 0 if block.periodic[1 - axis] else None])
            first = wide.where[axis][0] - begin
            f, slope, scratch = np.zeros((4, n)), np.zeros((4, n)), np.zeros((2, end - begin))
            S, weight = wide.S[axis], wide.weight[axis]
            self._axes.append(Faces(columns, S, weight, first, f, slope, scratch))
        corners = np.zeros((2, 0), int)
        if not any(block.periodic):
            corners = np.array([face_nodes(block.shape, 1, side)[[0, -1]] for side in (0, 1)])
        self._corners, self._ends = hull.columns(corners), np.zeros((4, 2))
        rise = np.zeros((2, weights[0].size))
        self._rise, self._weights = rise, weights

    def record(self) -> Plane:
        """For compiled code."""
        return Plane(*self._axes, self._corners, self._ends, self._rise, *self._weights)

    def metrics(self, metrics: Array, G: Array, displacement: Array) -> None:
        """Fill a^1, a^2; G: (4, N), D_1 X and D_2 X."""
        plane_metrics(self.record(), metrics, G, displacement)

    def velocities(self, metrics: Array, velocity: Array) -> None:
        """Fill the velocity v and J_t = a^1 . D_1 v + a^2 . D_2 v."""
        plane_velocities(self.record(), metrics, velocity)


class Faces(NamedTuple):
    """The two faces along an axis: columns (2, n) of the hull, the band of the axis, the first node
    of the range; values and derivatives (4, n) along them, and memory.
    """

    columns: Array
    S: Array
    weight: Array
    first: int
    f: Array
    slope: Array
    scratch: Array


class Plane(NamedTuple):
    """What compiled code knows of a PlaneGrid."""

    along: Faces
    across: Faces
    corners: Array
    ends: Array
    rise: Array
    low: Array
    high: Array
    low_y: Array
    high_y: Array


@njit(**CALL)
def differentiate_faces(plane, values):
    """Values (2, H) of the hull at faces and vertices, and derivatives along faces."""
    _along(values, plane.along)
    _along(values, plane.across)
    _across(values, plane.corners, plane.ends, plane.along.f, plane.rise, plane.low, plane.high)


@njit(**CALL)
def plane_metrics(plane, metrics, G, displacement):
    """a^1, a^2."""
    differentiate_faces(plane, displacement)
    slope, f = plane.along.slope, plane.across.f
    S, N = (slope[0], slope[1]), (slope[2], slope[3])
    rise, weights = (plane.rise[0], plane.rise[1]), (plane.low, plane.high)
    more = plane.low_y, plane.high_y, f, plane.across.slope, plane.ends
    _plane_metrics(metrics, G, S, N, rise, *weights, *more)


@njit(**CALL)
def plane_velocities(plane, metrics, velocity):
    """v and J_t."""
    differentiate_faces(plane, velocity)
    f, slope = plane.along.f, plane.along.slope
    values, S, N = ((f[0], f[1]), (f[2], f[3])), (slope[0], slope[1]), (slope[2], slope[3])
    rise, weights = (plane.rise[0], plane.rise[1]), (plane.low, plane.high)
    more = plane.low_y, plane.high_y, plane.across.f, plane.across.slope, plane.ends
    _plane_rates(metrics, S, N, rise, *weights, *more)
    _plane_values(metrics[4:6], *values, *weights, *more)


@njit(**CALL)
def plane_places(plane, X, displacement, places):
    """places = X + the displacement of the hull, blended (2, N)."""
    differentiate_faces(plane, displacement)
    f, more = plane.along.f, (plane.across.f, plane.across.slope, plane.ends)
    weights = plane.low, plane.high, plane.low_y, plane.high_y
    _plane_values(places, (f[0], f[1]), (f[2], f[3]), *weights, *more)
    for c in range(2):
        for i in range(X.shape[1]):
            places[c, i] += X[c, i]


@njit(**CALL)
def _along(values, faces):
    """Values and derivatives along the two faces of an axis, (4, n): rows 2 side + component."""
    columns, f, slope, scratch = faces.columns, faces.f, faces.slope, faces.scratch
    if columns.size == 0:
        return
    n = f.shape[1]
    given, derivative = scratch[0], scratch[1]
    for row in range(4):
        side, c = row // 2, row % 2
        for i in range(given.size):
            given[i] = values[c, columns[side, i]]
        differentiate(derivative, given, faces.S, faces.weight, 1)
        for i in range(n):
            f[row, i] = given[faces.first + i]
            slope[row, i] = derivative[faces.first + i]


@njit(**CALL)
def _across(values, corners, ends, f, rise, low, high):
    """Values at the four vertices, (4, 2), and [N_i - S_i - l_i (N_0 - S_0) - h_i (N_n - S_n)]."""
    for c in range(2):
        for end in range(corners.shape[1]):
            ends[end, c] = values[c, corners[0, end]]
            ends[2 + end, c] = values[c, corners[1, end]]
        at_low, at_high = ends[2, c] - ends[0, c], ends[3, c] - ends[1, c]
        for i in range(low.size):
            rise[c, i] = (f[2 + c, i] - f[c, i]) - (low[i] * at_low + high[i] * at_high)


@njit(**CALL)
def _row(ends, g, steep, l, h, j):
    """Of row j: Q_0, Q_n, W, E, D_2 W, D_2 E."""
    start = l * ends[0, 0] + h * ends[2, 0], l * ends[0, 1] + h * ends[2, 1]
    stop = l * ends[1, 0] + h * ends[3, 0], l * ends[1, 1] + h * ends[3, 1]
    values = (g[0, j], g[1, j]), (g[2, j], g[3, j])
    return start, stop, *values, (steep[0, j], steep[1, j]), (steep[2, j], steep[3, j])


@njit(**CALL)
def _plane_metrics(metrics, G, S, N, rise, low, high, low_y, high_y, g, steep, ends):
    like, n = (0.0, 0.0), low.size
    for j in range(low_y.size):
        l, h, a, b = low_y[j], high_y[j], j * n, (j + 1) * n
        start, stop, west, east, west_slope, east_slope = _row(ends, g, steep, l, h, j)
        across = sub(sub(east, west), sub(stop, start))
        a1, a2 = rows(like, metrics, a, b), rows(like, metrics[2:], a, b)
        G1, G2 = rows(like, G, a, b), rows(like, G[2:], a, b)
        of_row = l, h, across, west_slope, east_slope
        _row_of_metrics(a1, a2, G1, G2, S, N, rise, low, high, of_row)


@njit(**CALL)
def _plane_rates(metrics, S, N, rise, low, high, low_y, high_y, g, steep, ends):
    like, n = (0.0, 0.0), low.size
    for j in range(low_y.size):
        l, h, a, b = low_y[j], high_y[j], j * n, (j + 1) * n
        start, stop, west, east, west_slope, east_slope = _row(ends, g, steep, l, h, j)
        across = sub(sub(east, west), sub(stop, start))
        a1, a2 = rows(like, metrics, a, b), rows(like, metrics[2:], a, b)
        of_row = l, h, across, west_slope, east_slope
        _row_of_rates(metrics[6, a:b], a1, a2, S, N, rise, low, high, of_row)


@njit(**CALL)
def _plane_values(values, fS, fN, low, high, low_y, high_y, g, steep, ends):
    like, n = (0.0, 0.0), low.size
    for j in range(low_y.size):
        l, h = low_y[j], high_y[j]
        start, stop, west, east, _, _ = _row(ends, g, steep, l, h, j)
        v = rows(like, values, j * n, (j + 1) * n)
        _row_of_values(v, fS, fN, low, high, l, h, sub(west, start), sub(east, stop))
        if low[0] == 1.0:
            store(v, 0, west)
        if high[n - 1] == 1.0:
            store(v, n - 1, east)


@njit(**EXACT)
def _row_of_metrics(a1, a2, G1, G2, S, N, rise, low, high, of_row):
    """a^1 = (D_2 y, -D_2 x), a^2 = (-D_1 y, D_1 x) of a row of nodes."""
    l, h, across, west, east = of_row
    for i in range(low.size):
        D1 = add(add(scale(l, load(S, i)), scale(h, load(N, i))), across)
        D2 = add(add(scale(low[i], west), scale(high[i], east)), load(rise, i))
        x1, x2 = add(load(G1, i), D1), add(load(G2, i), D2)
        store(a1, i, (x2[1], -x2[0]))
        store(a2, i, (-x1[1], x1[0]))


@njit(**EXACT)
def _row_of_rates(J_t, a1, a2, S, N, rise, low, high, of_row):
    """J_t of a row of nodes."""
    l, h, across, west, east = of_row
    for i in range(low.size):
        D1 = add(add(scale(l, load(S, i)), scale(h, load(N, i))), across)
        D2 = add(add(scale(low[i], west), scale(high[i], east)), load(rise, i))
        J_t[i] = dot(load(a1, i), D1) + dot(load(a2, i), D2)


@njit(**EXACT)
def _row_of_values(v, S, N, low, high, l, h, west, east):
    """Values of a row of nodes; west, east: what Q misses there."""
    for i in range(low.size):
        Q = add(scale(l, load(S, i)), scale(h, load(N, i)))
        store(v, i, add(Q, add(scale(low[i], west), scale(high[i], east))))
