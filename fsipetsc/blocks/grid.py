"""The grid of a gas block: x = X + the displacements of its faces, blended (SCHEME-BLOCKS.md, 5).

Nodes of faces whose displacement is known, at solids and at walls that move, have it. A face that is
known in all its nodes is taken as it is; any other one is blended from its edges, edges are linear
between their vertices, and vertices that are not known do not move. Inside is the Boolean sum of the
faces: Gordon and Hall, Int. J. Numer. Meth. Eng. 7 (1973) 461-477. Along periodic axes there are no
faces, and nothing is blended. The velocity of the grid is the same blend of the faces' velocities.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from numba import njit

from fsipetsc.blocks.block import Block, Range, determinant, mesh
from fsipetsc.blocks.faces import face_nodes
from fsipetsc.blocks.metrics import EXACT, Wide, curl_metrics, volume_rate
from fsipetsc.blocks.plane_grid import lines_of, plane_metrics, plane_velocities
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.checks import Array
from fsipetsc.operators.loops import CALL

#: of each axis the side at which it is fixed, None where it is free: a face, an edge, a vertex
Entity = Sequence[int | None]


class GridMotion:
    """Positions, velocities and metrics of a range of nodes of gas block k (of a rank: the ghosted).

    nodes: numbers (M,) of those nodes on faces of the whole block whose displacement and velocity will
    be given, in any order. `move` and `velocities` fill metrics (d d + d + 1, N): a^1 … a^d, the
    velocity of the grid, J_t = sum_k a^k . D_k v, which sum_k D_k a^k = 0 makes the whole of it.
    """

    def __init__(
        self, problem: BlockProblem, k: int, order: int, where: Range, nodes: Array
    ) -> None:
        self.block = block = problem.blocks[k]
        self._wide, self._hull = Wide(problem, k, order, where), Hull(block, nodes)
        self._moved, self._moving = self._hull.zeros(), self._hull.zeros()
        self._X, self._where, self._blend = problem.positions(k, where), where, None
        if block.dimension == 3:
            shape = self._wide.y.shape
            self._a, self._slopes = np.zeros((3, *shape)), np.zeros((3, *shape))
            self._x, self._v, self._q = np.zeros(shape), np.zeros(shape), np.zeros((4, shape[1]))
            self._blend_wide = Blend(block, self._wide.wide, self._hull)
        else:
            self._G = np.ascontiguousarray(self._wide.gradients().reshape(-1, self._X.shape[1]))
            self._lines = lines_of(self._wide, block, self._hull, end_weights)

    def move(self, displacement: Array, metrics: Array) -> None:
        """Fill a^1 … a^d from the displacement (M, d) [m] of the given nodes."""
        d, wide = self.block.dimension, self._wide
        self._hull.fill(self._moved, displacement)
        self._metrics = metrics
        if d == 1:
            metrics[0] = 1.0
        elif d == 2:
            plane_metrics(metrics, self._G, self._moved, self._lines)
        else:
            np.add(wide.y, self._blend_wide.on_nodes(self._moved), out=self._x)
            curl_metrics(self._a, self._x, wide.P, wide.S, wide.weight, self._slopes, self._q)
            metrics[:9] = wide.inner(self._a).reshape(9, -1)

    def velocities(self, velocity: Array, metrics: Array) -> None:
        """Fill the velocity of the grid and J_t from the velocity (M, d) [m/s] of the given nodes, after
        `move`.
        """
        d, wide = self.block.dimension, self._wide
        self._hull.fill(self._moving, velocity)
        if d == 1:
            (low, high), (l, h) = self._hull.ends(self._moving), (self._lines.low[0], self._lines.high[0])
            metrics[1], metrics[2] = l * low + h * high, high - low
        elif d == 2:
            plane_velocities(metrics, self._moving, self._lines)
        else:
            self._v[:] = self._blend_wide.on_nodes(self._moving)
            J_t, scratch = self._q[:2]
            volume_rate(J_t, self._a, self._v, wide.S, wide.weight, scratch)
            metrics[9:12], metrics[12] = wide.inner(self._v), wide.inner(J_t)

    def positions(self) -> Array:
        """x (d, N) [m] after the last `move`."""
        if self._blend is None:
            self._blend = Blend(self.block, self._where, self._hull)
        return self._X + self._blend.on_nodes(self._moved)

    def jacobian(self) -> Array:
        """det(D x) (N,) after the last `move`."""
        if self.block.dimension == 3:
            return determinant(self._wide.inner(self._slopes) + self._wide.P[..., None])
        if self.block.dimension == 2:
            (a, b), (c, e) = self._metrics[:4].reshape(2, 2, -1)
            return a * e - b * c
        low, high = self._hull.ends(self._moved)
        return self._G[0] + (high - low)


class Hull:
    """The nodes of all faces of a block, numbers (H,) ascending; values at them are arrays (d, H).

    Of those that are not given, lines follow from two ends, faces from their edges and vertices.
    """

    def __init__(self, block: Block, given: Array) -> None:
        self.block, d = block, block.dimension
        sides = [(None,) if closed else (0, 1, None) for closed in block.periodic]
        faces = [face_nodes(block.shape, k, s) for k in range(d) for s in sides[k] if s is not None]
        self.nodes = np.unique(np.concatenate([np.zeros(0, int), *faces]))
        self._given = self.columns(np.asarray(given, int))
        known = np.isin(self.nodes, given)
        lines, sheets = [], []
        for entity in product(*sides):
            free = [k for k in range(d) if entity[k] is None and not block.periodic[k]]
            if entity.count(None) == d or known[self._entity(entity)[0]].all():
                continue
            if len(free) == 1:
                lines.append(self._entity(entity, free, [{free[0]: 0}, {free[0]: 1}]))
            elif len(free) == 2:
                sheets.append(self._entity(entity, free, _around(*free)))
        self._pieces = (*_together(lines, 3, 2), *_together(sheets, 9, 4))

    def zeros(self) -> Array:
        """Values 0."""
        return np.zeros((self.block.dimension, len(self.nodes)))

    def columns(self, nodes: Array) -> Array:
        """Where node numbers are among those of the hull."""
        return np.searchsorted(self.nodes, nodes)

    def fill(self, values: Array, given: Array) -> None:
        """Complete values (d, H) from those of the given nodes (M, d)."""
        given = np.ascontiguousarray(given, dtype=float)
        _fill(values, given, self._given, *self._pieces)

    def ends(self, values: Array) -> tuple[float, float]:
        """Values at both ends of a block in 1-D; 0 if it is periodic."""
        return (values[0, 0], values[0, -1]) if values.size else (0.0, 0.0)

    def _entity(
        self, entity: Entity, inner: Sequence[int] = (), sources: Sequence[dict[int, int]] = ()
    ) -> tuple[Array, Array]:
        """Columns (1 + sources, T) of the nodes of an entity, along some axes its inner ones only, and of
        those that they follow from, at ends of axes; weights (2 inner, T) of the ends.
        """
        shape, ranges = self.block.shape, []
        for k, (n, side) in enumerate(zip(shape, entity)):
            fixed = np.array([side and n - 1])
            ranges.append(fixed if side is not None else np.arange(n)[1:-1] if k in inner else np.arange(n))
        index = [i.ravel() for i in mesh(ranges)]
        columns = []
        for ends in ({}, *sources):
            at = [ends[k] * (n - 1) + 0 * i if k in ends else i for k, (n, i) in enumerate(zip(shape, index))]
            columns.append(self.columns(np.ravel_multi_index(at[::-1], shape[::-1])))
        weights = [w for k in inner for w in end_weights(self.block, k, index[k])]
        return np.array(columns), np.array(weights)


def end_weights(block: Block, axis: int, index: Array) -> tuple[Array, Array]:
    """1 - xi and xi of nodes, the same bits seen from both ends; 0 on a periodic axis."""
    if block.periodic[axis]:
        return np.zeros(len(index)), np.zeros(len(index))
    cells = block.cells[axis]
    return (cells - index) / cells, index / cells


def _around(a: int, b: int) -> list[dict[int, int]]:
    """Ends of axes: the edges low a, high a, low b, high b, then the vertices of a face."""
    edges = [{a: 0}, {a: 1}, {b: 0}, {b: 1}]
    return edges + [{a: 0, b: 0}, {a: 1, b: 1}, {a: 1, b: 0}, {a: 0, b: 1}]


def _together(pieces: list[tuple[Array, Array]], rows: int, weights: int) -> tuple[Array, Array]:
    none = np.zeros((rows, 0), int), np.zeros((weights, 0))
    return tuple(np.concatenate(parts, axis=1) for parts in zip(none, *pieces))


@njit(**CALL)
def _fill(values, given, known, lines, line_weights, sheets, sheet_weights):
    """Lines between their ends, then faces; sums do not depend on the order of ends and axes."""
    for c in range(values.shape[0]):
        f = values[c]
        for m in range(known.size):
            f[known[m]] = given[m, c]
        for t in range(lines.shape[1]):
            to, low, high = lines[:, t]
            f[to] = line_weights[0, t] * f[low] + line_weights[1, t] * f[high]
        for t in range(sheets.shape[1]):
            to, a0, a1, b0, b1, v00, v11, v10, v01 = sheets[:, t]
            la, ha, lb, hb = sheet_weights[:, t]
            edges = (la * f[a0] + ha * f[a1]) + (lb * f[b0] + hb * f[b1])
            vertices = (la * lb * f[v00] + ha * hb * f[v11]) + (ha * lb * f[v10] + la * hb * f[v01])
            f[to] = edges - vertices


class Blend:
    """The Boolean sum of faces on a range of nodes: axis after axis, what is missing at the two faces is
    added, linear between them.
    """

    def __init__(self, block: Block, where: Range, hull: Hull) -> None:
        d, self._axes = block.dimension, [k for k in range(block.dimension) if not block.periodic[k]]
        index = [np.arange(*ends) % n for ends, n in zip(where, block.shape)]
        for k in self._axes:  # both ends are taken along
            index[k] = np.concatenate([[0], index[k], [block.shape[k] - 1]])
        self._inner = tuple(slice(None) if closed else slice(1, -1) for closed in block.periodic[::-1])
        self._u = np.zeros((d, *(len(i) for i in index[::-1])))
        self._faces, self._weights = [], []
        for axis in self._axes:
            for end in (0, block.shape[axis] - 1):
                at = [np.array([end]) if k == axis else i for k, i in enumerate(index)]
                numbers = np.ravel_multi_index(mesh(at)[::-1], block.shape[::-1])
                self._faces.append(hull.columns(numbers))
            self._weights.append(end_weights(block, axis, index[axis]))

    def on_nodes(self, values: Array) -> Array:
        """(d, N) from values (d, H) of the hull; on faces theirs, to the bit."""
        u, d = self._u, len(self._u)
        u[:] = 0.0
        faces = [values[:, columns] for columns in self._faces]
        for axis, low, high, (l, h) in zip(self._axes, faces[::2], faces[1::2], self._weights):
            before = int(np.prod(u.shape[d - axis + 1 :]))
            missing = [face - np.take(u, [end], axis=d - axis) for face, end in ((low, 0), (high, -1))]
            _add_between(u.reshape(-1), *(part.reshape(-1) for part in missing), l, h, before)
        for axis, low, high, weights in zip(self._axes, faces[::2], faces[1::2], self._weights):
            for face, weight in zip((low, high), weights):
                np.moveaxis(u, d - axis, 0)[weight == 1.0] = np.moveaxis(face, d - axis, 0)
        return u[(slice(None), *self._inner)].reshape(d, -1)


@njit(**CALL)
def _add_between(u, low, high, l, h, before):
    """u += l low + h high along an axis; `before` nodes of faster axes between neighbours."""
    n = l.size
    for a in range(0, low.size, before):
        if before == 1:
            _add_row(u[a * n : (a + 1) * n], l, h, low[a], high[a])
            continue
        for i in range(n):
            b = a * n + i * before
            _add_row(u[b : b + before], low[a : a + before], high[a : a + before], l[i], h[i])


@njit(**EXACT)
def _add_row(u, low, high, l, h):
    for j in range(u.size):
        u[j] += l * low[j] + h * high[j]
