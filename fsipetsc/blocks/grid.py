"""The grid of a gas block: x = X + the displacements of its faces, blended (SCHEME-BLOCKS.md, section 5).

Nodes of faces whose displacement is known, at solids and at walls that move, have it. A face that is
known in all its nodes is taken as it is; any other one is blended from its edges, edges are linear
between their vertices, and vertices that are not known do not move. Inside is the Boolean sum of the
faces (Gordon and Hall, Int. J. Numer. Meth. Eng. 7 (1973) 461-477). Along periodic axes there are no
faces, and nothing is blended. The velocity of the grid is the same blend of the faces' velocities.

In one and two dimensions derivatives of the blend are blends of derivatives along the faces, as D_k of
a linear function is exact: with l and h the weights of the low and the high end, in two dimensions

    u   = l_j S_i + h_j N_i + l_i (W_j - Q_0j) + h_i (E_j - Q_nj),   Q_ij = l_j S_i + h_j N_i
    D_1 u = l_j D_1 S_i + h_j D_1 N_i + [E_j - W_j - (Q_nj - Q_0j)]
    D_2 u = l_i D_2 W_j + h_i D_2 E_j + [N_i - S_i - l_i (N_0 - S_0) - h_i (N_n - S_n)]
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numba import njit

from fsipetsc.blocks.block import Block, Range, determinant, mesh
from fsipetsc.blocks.faces import face_nodes
from fsipetsc.blocks.metrics import EXACT, Wide, curl_metrics, differentiate, gradients
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.checks import Array
from fsipetsc.operators.loops import CALL, add, dot, load, rows, scale, store, sub


class GridMotion:
    """Positions, velocities and metrics of a range of nodes of gas block k (of a rank: its ghosted ones).

    nodes: numbers (M,) of those nodes on faces of the whole block whose displacement and velocity will
    be given, in any order. `move` and `velocities` fill metrics (d d + d + 1, N): a^1 … a^d, the
    velocity of the grid, J_t.
    """

    def __init__(
        self, problem: BlockProblem, k: int, order: int, where: Range, nodes: Array
    ) -> None:
        self.block, self.where = problem.blocks[k], where
        wide = self._wide = Wide(self.block, order, where)
        self._hull = Hull(self.block, nodes)
        self._blend = _Blend(self.block, wide.wide, self._hull)
        self._lines = _lines(wide, self._hull) if self.block.dimension == 2 else None
        self._weights = [_weights(self.block, axis, np.arange(*where[axis])) for axis in (0,)]
        self._X = problem.positions(k, where)
        self._y = wide.periodic_part(problem, k)
        G = wide.inner(gradients(wide, self._y))
        self._G = np.ascontiguousarray(G.reshape(-1, G.shape[-1]))
        self._moved, self._moving = self._hull.zeros(), self._hull.zeros()

    def move(self, displacement: Array, metrics: Array) -> None:
        """Fill a^1 … a^d from the displacement (M, d) [m] of the given nodes."""
        d = self.block.dimension
        self._hull.fill(self._moved, displacement)
        if d == 1:
            metrics[0] = 1.0
        elif d == 2:
            _plane_metrics(metrics, self._G, self._moved, self._lines)
        else:
            y = self._y + self._blend.on_nodes(self._moved)
            metrics[:9] = curl_metrics(self._wide, y).reshape(9, -1)

    def velocities(self, velocity: Array, metrics: Array) -> None:
        """Fill the velocity of the grid and J_t = sum_k a^k . D_k v, from the velocity (M, d) [m/s] of the
        given nodes and from a^k.
        """
        d = self.block.dimension
        self._hull.fill(self._moving, velocity)
        if d == 1:
            low, high = self._hull.ends(self._moving)
            (l, h), = self._weights
            metrics[1], metrics[2] = l * low + h * high, high - low
        elif d == 2:
            _plane_velocities(metrics, self._moving, self._lines)
        else:
            v = self._blend.on_nodes(self._moving)
            metrics[9:12], metrics[12] = self._wide.inner(v), 0.0
            for k in range(3):
                slope = self._wide.inner(self._wide.derivative(k, v))
                metrics[12] += (metrics[3 * k : 3 * k + 3] * slope).sum(axis=0)

    def positions(self) -> Array:
        """x (d, N) [m] after the last `move`."""
        return self._X + self._wide.inner(self._blend.on_nodes(self._moved))

    def determinant(self, metrics: Array) -> Array:
        """det(D x) (N,) after the last `move`, which filled metrics."""
        if self.block.dimension == 1:
            low, high = self._hull.ends(self._moved)
            return self._G[0] + (high - low)
        if self.block.dimension == 2:
            return metrics[0] * metrics[3] - metrics[1] * metrics[2]
        G = gradients(self._wide, self._y + self._blend.on_nodes(self._moved))
        return determinant(self._wide.inner(G))


class Hull:
    """The nodes of all faces of a block, numbers (H,) ascending, and how those follow that are not given.

    Values at them are arrays (d, H).
    """

    def __init__(self, block: Block, given: Array) -> None:
        self.block = block
        faces = [axis for axis, closed in enumerate(block.periodic) if not closed]
        found = [face_nodes(block.shape, axis, side) for axis in faces for side in (0, 1)]
        self.nodes = np.unique(np.concatenate([np.zeros(0, int), *found]))
        self._given = self.columns(np.asarray(given, int))
        known = np.isin(self.nodes, given)
        lines, sheets = [_no_piece(3)], [_no_piece(9)]
        for fixed in product((0, 1, None), repeat=block.dimension):
            within = any(side is not None and block.periodic[k] for k, side in enumerate(fixed))
            if within or all(side is None for side in fixed):
                continue
            if not known[self._numbers(fixed, {})].all():
                free = [k for k in faces if fixed[k] is None]
                if len(free) == 1:
                    lines.append(self._piece(fixed, free, [{free[0]: 0}, {free[0]: 1}]))
                elif len(free) == 2:
                    sheets.append(self._piece(fixed, free, _around(*free)))
        self._pieces = tuple(np.concatenate(part, axis=1) for kind in (lines, sheets) for part in zip(*kind))

    def zeros(self) -> Array:
        """Values 0."""
        return np.zeros((self.block.dimension, len(self.nodes)))

    def columns(self, nodes: Array) -> Array:
        """Where node numbers are among those of the hull."""
        return np.searchsorted(self.nodes, nodes)

    def fill(self, values: Array, given: Array) -> None:
        """Complete values (d, H) from those of the given nodes (M, d)."""
        _fill(values, np.ascontiguousarray(given, dtype=float), self._given, *self._pieces)

    def ends(self, values: Array) -> Sequence[float]:
        """The values at both ends of a block in 1-D; 0 if it is periodic."""
        return values[0] if values.size else (0.0, 0.0)

    def _numbers(self, fixed: Sequence[int | None], ends: dict[int, int], inner: Sequence[int] = ()) -> Array:
        """Columns of the nodes of a face, edge or vertex: sides of the axes that are fixed, None for the
        others; of these further ones at ends, and inner nodes only along some.
        """
        index = []
        for k, n in enumerate(self.block.shape):
            side = ends.get(k, fixed[k])
            if side is None:
                index.append(np.arange(1, n - 1) if k in inner else np.arange(n))
            else:
                index.append(np.full(n - 2 if k in ends else 1, n - 1 if side else 0))
        return self.columns(np.ravel_multi_index(mesh(index)[::-1], self.block.shape[::-1]).ravel())

    def _piece(
        self, fixed: Sequence[int | None], free: Sequence[int], sources: list[dict[int, int]]
    ) -> tuple[Array, Array]:
        """Columns (1 + sources, T): of inner nodes along the free axes, and of what they follow from at ends
        of these; weights (2 free, T) of the low and high end.
        """
        columns = [self._numbers(fixed, ends, free) for ends in [{}, *sources]]
        index = [np.arange(1, n - 1) if k in free else np.arange(n if fixed[k] is None else 1)
                 for k, n in enumerate(self.block.shape)]
        weights = [w[i.ravel()] for k, i in enumerate(mesh(index)) if k in free
                   for w in _weights(self.block, k, np.arange(self.block.shape[k]))]
        return np.array(columns), np.array(weights)


def _no_piece(count: int) -> tuple[Array, Array]:
    return np.zeros((count, 0), int), np.zeros((2 if count == 3 else 4, 0))


def _around(a: int, b: int) -> list[dict[int, int]]:
    """Edges and vertices of a face with axes a and b: low a, high a, low b, high b, then four vertices."""
    edges = [{a: 0}, {a: 1}, {b: 0}, {b: 1}]
    return edges + [{a: 0, b: 0}, {a: 1, b: 1}, {a: 1, b: 0}, {a: 0, b: 1}]


def _weights(block: Block, axis: int, index: Array) -> tuple[Array, Array]:
    """1 - xi and xi, to the bit the same from both ends; 0 on a periodic axis."""
    if block.periodic[axis]:
        return np.zeros(len(index)), np.zeros(len(index))
    cells = block.cells[axis]
    return (cells - index) / cells, index / cells


@njit(**CALL)
def _fill(values, given, known, lines, line_weights, sheets, sheet_weights):
    """Edges between their ends; faces from their edges. The sums are the same from whichever end or axis."""
    for c in range(values.shape[0]):
        f = values[c]
        for m in range(known.size):
            f[known[m]] = given[m, c]
        for t in range(lines.shape[1]):
            to, a, b = lines[:, t]
            f[to] = line_weights[0, t] * f[a] + line_weights[1, t] * f[b]
        for t in range(sheets.shape[1]):
            to, a0, a1, b0, b1, v00, v11, v10, v01 = sheets[:, t]
            l, h, low, high = sheet_weights[:, t]
            edges = (l * f[a0] + h * f[a1]) + (low * f[b0] + high * f[b1])
            same, other = l * low * f[v00] + h * high * f[v11], h * low * f[v10] + l * high * f[v01]
            f[to] = edges - (same + other)


class _Blend:
    """The Boolean sum of faces on a range of nodes, axis after axis: what is missing at its two faces is added,
    linear between them.
    """

    def __init__(self, block: Block, where: Range, hull: Hull) -> None:
        self.block = block
        d, self.axes = block.dimension, [k for k in range(block.dimension) if not block.periodic[k]]
        index = [np.arange(*ends) % n for ends, n in zip(where, block.shape)]
        # both ends of each axis are taken along
        around = [i if closed else np.concatenate([[0], i, [n - 1]])
                  for i, n, closed in zip(index, block.shape, block.periodic)]
        self.shape = tuple(map(len, around))
        self.inner = tuple(slice(None) if closed else slice(1, -1) for closed in block.periodic[::-1])
        self.faces, self.weights, self.at_end = [], [], []
        for axis in self.axes:
            columns = []
            for side in (0, 1):
                at = [np.array([side * (n - 1)]) if k == axis else i
                      for k, (i, n) in enumerate(zip(around, block.shape))]
                numbers = np.ravel_multi_index(mesh(at)[::-1], block.shape[::-1])
                columns.append(hull.columns(numbers))
            along = [-1 if k == axis else 1 for k in range(d)][::-1]
            self.faces.append(columns)
            self.weights.append([w.reshape(along) for w in _weights(block, axis, around[axis])])

    def on_nodes(self, values: Array) -> Array:
        """(d, N) from values (d, H) of the hull; on faces theirs, to the bit."""
        d = self.block.dimension
        u = np.zeros((d, *self.shape[::-1]))
        for axis, (low, high), (l, h) in zip(self.axes, self.faces, self.weights):
            first, last = (np.take(u, [i], axis=d - axis) for i in (0, -1))
            u = u + (l * (values[:, low] - first) + h * (values[:, high] - last))
        for axis, columns, (l, h) in zip(self.axes, self.faces, self.weights):
            for column, weight in zip(columns, (l, h)):
                there = np.flatnonzero(weight.ravel() == 1.0)
                np.moveaxis(u, d - axis, 0)[there] = np.moveaxis(values[:, column], d - axis, 0)
        return u[(slice(None), *self.inner)].reshape(d, -1)


class _Lines(NamedTuple):
    """A range of nodes of a block in 2-D, for compiled code. Of each axis: the columns (2, n) of the two faces
    along it, of the wide range, none where there are none; S and weight of its band; where the range
    begins in the wide one; weights of the low and the high end. corners: columns, side of axis 0 + 2 of 1.
    """

    columns: tuple[Array, Array]
    S: tuple[Array, Array]
    weight: tuple[Array, Array]
    first: tuple[int, int]
    low: tuple[Array, Array]
    high: tuple[Array, Array]
    corners: Array


def _lines(wide: Wide, hull: Hull) -> _Lines:
    block, columns = wide.block, []
    for axis, (begin, end) in enumerate(wide.wide):
        index, other = np.arange(begin, end) % block.shape[axis], 1 - axis
        faces = [face_nodes(block.shape, other, side)[index] for side in (0, 1)]
        columns.append(hull.columns(np.array(faces)[:, : 0 if block.periodic[other] else None]))
    (n, m), (low, high) = block.shape, zip(*(
        _weights(block, axis, np.arange(*ends)) for axis, ends in enumerate(wide.where)))
    corners = [] if any(block.periodic) else [0, n - 1, n * (m - 1), n * m - 1]
    return _Lines(
        tuple(columns), tuple(b.S for b in wide.bands), tuple(b.weight for b in wide.bands),
        tuple(a - c for (a, _), (c, _) in zip(wide.where, wide.wide)), low, high,
        hull.columns(np.array(corners, int)))


@njit(**CALL)
def _along(values, columns, S, weight, first, n):
    """Values and derivatives (4, n) along two faces, rows 2 side + component; 0 where there are none."""
    f, slope = np.zeros((4, weight.size)), np.zeros((4, weight.size))
    if columns.size > 0:
        for row in range(4):
            for i in range(weight.size):
                f[row, i] = values[row % 2, columns[row // 2, i]]
            differentiate(slope[row], f[row], S, weight, 1)
    return f[:, first : first + n].copy(), slope[:, first : first + n].copy()


@njit(**CALL)
def _corners(values, columns):
    """Of the faces low and high along axis 0 their values at low and high xi_0, four pairs."""
    if columns.size == 0:
        zero = (0.0, 0.0)
        return zero, zero, zero, zero
    f, g, a = values[0], values[1], columns
    return (f[a[0]], g[a[0]]), (f[a[1]], g[a[1]]), (f[a[2]], g[a[2]]), (f[a[3]], g[a[3]])


@njit(**CALL)
def _rise(f, corners, low, high):
    """[N_i - S_i - l_i (N_0 - S_0) - h_i (N_n - S_n)], (2, n), from the values f along the faces S and N."""
    at_low, at_high = sub(corners[2], corners[0]), sub(corners[3], corners[1])
    rise = np.empty((2, low.size))
    for c in range(2):
        for i in range(low.size):
            rise[c, i] = (f[2 + c, i] - f[c, i]) - (low[i] * at_low[c] + high[i] * at_high[c])
    return rise


@njit(**EXACT)
def _row_metrics(a, b, G, H, south, north, rise, low, high, l, h, across, west, east):
    """a^1 = (D_2 y, -D_2 x), a^2 = (-D_1 y, D_1 x) of a row of nodes."""
    for i in range(low.size):
        D1 = add(load(G, i), add(add(scale(l, load(south, i)), scale(h, load(north, i))), across))
        D2 = add(load(H, i), add(add(scale(low[i], west), scale(high[i], east)), load(rise, i)))
        store(a, i, (D2[1], -D2[0]))
        store(b, i, (-D1[1], D1[0]))


@njit(**EXACT)
def _row_velocities(
    v, J_t, a, b, f, g, south, north, rise, low, high, l, h, across, west, east, at_low, at_high
):
    """v and J_t = a^1 . D_1 v + a^2 . D_2 v of a row of nodes."""
    for i in range(low.size):
        face = add(scale(l, load(f, i)), scale(h, load(g, i)))
        store(v, i, add(face, add(scale(low[i], at_low), scale(high[i], at_high))))
        D1 = add(add(scale(l, load(south, i)), scale(h, load(north, i))), across)
        D2 = add(add(scale(low[i], west), scale(high[i], east)), load(rise, i))
        J_t[i] = dot(load(a, i), D1) + dot(load(b, i), D2)


@njit(**CALL)
def _plane_metrics(metrics, G, values, lines):
    """Fill a^1, a^2 from values (2, H) of the displacement; G (4, N): D_1 X, D_2 X."""
    two, (low, low_y), (high, high_y) = (0.0, 0.0), lines.low, lines.high
    n, m = low.size, low_y.size
    f, slope = _along(values, lines.columns[0], lines.S[0], lines.weight[0], lines.first[0], n)
    g, slope_y = _along(values, lines.columns[1], lines.S[1], lines.weight[1], lines.first[1], m)
    corners = _corners(values, lines.corners)
    rise = _rise(f, corners, low, high)
    for j in range(m):
        l, h, p, q = low_y[j], high_y[j], j * n, (j + 1) * n
        ends = (add(scale(l, corners[0]), scale(h, corners[2])), add(scale(l, corners[1]), scale(h, corners[3])))
        across = sub(sub((g[2, j], g[3, j]), (g[0, j], g[1, j])), sub(ends[1], ends[0]))
        _row_metrics(
            rows(two, metrics, p, q), rows(two, metrics[2:], p, q), rows(two, G, p, q), rows(two, G[2:], p, q),
            rows(two, slope, 0, n), rows(two, slope[2:], 0, n), rows(two, rise, 0, n), low, high, l, h,
            across, (slope_y[0, j], slope_y[1, j]), (slope_y[2, j], slope_y[3, j]))


@njit(**CALL)
def _plane_velocities(metrics, values, lines):
    """Fill the velocity and J_t from values (2, H) of the velocity."""
    two, (low, low_y), (high, high_y) = (0.0, 0.0), lines.low, lines.high
    n, m = low.size, low_y.size
    f, slope = _along(values, lines.columns[0], lines.S[0], lines.weight[0], lines.first[0], n)
    g, slope_y = _along(values, lines.columns[1], lines.S[1], lines.weight[1], lines.first[1], m)
    corners = _corners(values, lines.corners)
    rise = _rise(f, corners, low, high)
    for j in range(m):
        l, h, p, q = low_y[j], high_y[j], j * n, (j + 1) * n
        ends = (add(scale(l, corners[0]), scale(h, corners[2])), add(scale(l, corners[1]), scale(h, corners[3])))
        west, east = (g[0, j], g[1, j]), (g[2, j], g[3, j])
        v = rows(two, metrics[4:], p, q)
        _row_velocities(
            v, metrics[6, p:q], rows(two, metrics, p, q), rows(two, metrics[2:], p, q),
            rows(two, f, 0, n), rows(two, f[2:], 0, n), rows(two, slope, 0, n), rows(two, slope[2:], 0, n),
            rows(two, rise, 0, n), low, high, l, h, sub(sub(east, west), sub(ends[1], ends[0])),
            (slope_y[0, j], slope_y[1, j]), (slope_y[2, j], slope_y[3, j]), sub(west, ends[0]), sub(east, ends[1]))
        if low[0] == 1.0:
            store(v, 0, west)
        if high[n - 1] == 1.0:
            store(v, n - 1, east)
