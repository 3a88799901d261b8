"""The grid of a gas block: x = X + the displacements of its faces, blended (SCHEME-BLOCKS.md, 5).

Nodes of faces whose displacement is known, at solids and at walls that move, have it. A face that
is known in all its nodes is taken as it is; any other one is blended from its edges, edges are
linear between their vertices, and vertices that are not known do not move. Inside is the Boolean
sum of the faces: Gordon and Hall, Int. J. Numer. Meth. Eng. 7 (1973) 461-477. Along periodic axes
there are no faces, and nothing is blended. The velocity of the grid is the same blend of the faces'
velocities.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from fsipetsc.blocks.block import Block, Range, determinant, mesh
from fsipetsc.blocks.faces import face_nodes
from fsipetsc.blocks.metrics import EXACT, Wide, curl_metrics, volume_rate
from fsipetsc.blocks.plane_grid import PlaneGrid, plane_metrics, plane_places, plane_velocities
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.blocks.radial_grid import (
    RadialMotion,
    radial_grid,
    radial_metrics,
    radial_velocities,
)
from fsipetsc.checks import Array
from fsipetsc.operators.loops import CALL

#: of each axis the side at which it is fixed, None where it is free: a face, an edge, a vertex
Entity = Sequence[int | None]


class GridMotion:
    """Positions, velocities and metrics of a range of nodes of gas block k (of a rank: the
    ghosted).

    nodes: numbers (M,) of those nodes on faces of the whole block whose displacement and velocity
    will be given, in any order. `move` and `velocities` fill metrics (d d + d + 1, N): a^1 … a^d,
    the velocity of the grid, J_t = sum_k a^k . D_k v, which sum_k D_k a^k = 0 makes the whole of
    it.
    """

    def __init__(
        self, problem: BlockProblem, k: int, order: int, where: Range, nodes: Array
    ) -> None:
        self.block = block = problem.blocks[k]
        self._hull = Hull(block, nodes)
        self._moved, self._moving = self._hull.zeros(), self._hull.zeros()
        self._X, self._where, self._blend = problem.positions(k, where), where, None
        self.radial = radial_grid(problem, k, order, where) if problem.symmetry else None
        if self.radial is not None:
            return
        self._wide = Wide(problem, k, order, where)
        if block.dimension == 3:
            shape = self._wide.y.shape
            self._a, self._slopes = np.zeros((3, *shape)), np.zeros((3, *shape))
            self._x, self._v, self._q = np.zeros(shape), np.zeros(shape), np.zeros((4, shape[1]))
            self._blend_wide = Blend(block, self._wide.wide, self._hull)
        else:
            self._G = np.ascontiguousarray(self._wide.gradients().reshape(-1, self._X.shape[1]))
            pairs = (end_weights(block, axis, np.arange(*ends)) for axis, ends in enumerate(where))
            self._weights = [weight for pair in pairs for weight in pair]
            if block.dimension == 2:
                self._plane = PlaneGrid(block, self._wide, self._hull, self._weights)

    def move(self, displacement: Array, metrics: Array) -> None:
        """Fill a^1 … a^d from the displacement (M, d) [m] of the given nodes."""
        d = self.block.dimension
        self._hull.fill(self._moved, displacement)
        self._metrics = metrics
        if self.radial is not None:
            radial_metrics(self.radial, metrics, self._moved)
        elif d == 1:
            metrics[0] = 1.0
        elif d == 2:
            self._plane.metrics(metrics, self._G, self._moved)
        else:
            wide = self._wide
            np.add(wide.y, self._blend_wide.on_nodes(self._moved), out=self._x)
            curl_metrics(self._a, self._x, wide.P, wide.S, wide.weight, self._slopes, self._q)
            metrics[:9] = wide.inner(self._a).reshape(9, -1)

    def velocities(self, velocity: Array, metrics: Array) -> None:
        """Fill the velocity of the grid and J_t from the velocity (M, d) [m/s] of the given nodes,
        after `move`.
        """
        d = self.block.dimension
        self._hull.fill(self._moving, velocity)
        if self.radial is not None:
            radial_velocities(self.radial, metrics, self._moving)
        elif d == 1:
            line_velocities(metrics, self._moving, *self._weights)
        elif d == 2:
            self._plane.velocities(metrics, self._moving)
        else:
            wide = self._wide
            self._v[:] = self._blend_wide.on_nodes(self._moving)
            J_t, scratch = self._q[:2]
            volume_rate(J_t, self._a, self._v, wide.S, wide.weight, scratch)
            metrics[9:12], metrics[12] = wide.inner(self._v), wide.inner(J_t)

    def record(self) -> Any:
        """Itself for compiled code, in one and two dimensions, with methods ``move``, ``swing`` and
        ``jacobian``. `positions` and `jacobian` follow what is moved there. `move` comes first.
        """
        hull, d = self._hull, self.block.dimension
        moved = hull.given, *hull.pieces, self._moved, self._moving
        if self.radial is not None:
            return RadialMotion(*moved, self.radial)
        if d == 1:
            return LineMotion(*moved, *self._weights)
        return PlaneMotion(*moved, self._G, self._plane.record()) if d == 2 else Unmoved()

    def turning(self) -> Array:
        """How a^1, a^2, a^3 (9, N) change in time after `velocities`, in three dimensions: they are
        bilinear in the places.
        """
        wide, found = self._wide, []
        a, slopes = np.empty_like(self._a), np.empty_like(self._slopes)
        for sign in (1.0, -1.0):
            y = self._x + sign * self._v
            curl_metrics(a, y, wide.P, wide.S, wide.weight, slopes, self._q)
            found.append(wide.inner(a).reshape(9, -1).copy())
        return 0.5 * (found[0] - found[1])

    def positions(self) -> Array:
        """x (d, N) [m] after the last `move`."""
        if self.block.dimension == 3:
            return self._X + self._wide.inner(self._x - self._wide.y)
        if self.radial is not None:
            return self.radial.places()
        if self._blend is None:
            self._blend = Blend(self.block, self._where, self._hull)
        return self._X + self._blend.on_nodes(self._moved)

    def jacobian(self) -> Array:
        """det(D x) (N,) after the last `move`; around an axis or a centre as in radial_grid."""
        if self.radial is not None:
            return self.radial.volume
        if self.block.dimension == 3:
            return determinant(self._wide.inner(self._slopes) + self._wide.P[..., None])
        if self.block.dimension == 2:
            (a, b), (c, e) = self._metrics[:4].reshape(2, 2, -1)
            return a * e - b * c
        low, high = self._hull.ends(self._moved)
        return self._G[0] + (high - low)


class LineMotion(NamedTuple):
    """A grid in one dimension: see GridMotion. given, columns, weights: of Hull; moved, moving: (1,
    ends) displacements and velocities; low, high: (N,) weights of the ends.
    """

    given: Array
    columns: Array
    weights: Array
    moved: Array
    moving: Array
    low: Array
    high: Array

    def move(self, known, metrics):
        """From displacements and velocities known (M, 2d) of the given nodes."""
        fill_hull(self.moved, known, 0, self.given, self.columns, self.weights)

    def swing(self, known, metrics):
        """Velocity of the grid and J_t."""
        fill_hull(self.moving, known, 1, self.given, self.columns, self.weights)
        line_velocities(metrics, self.moving, self.low, self.high)

    def find_places(self, X, places):
        """Nobody asks for them."""
        return None

    def jacobian(self, metrics, N, node, reference):
        """det(D x) of a node with that of the reference map."""
        longer = self.moved[0, -1] - self.moved[0, 0] if self.moved.size > 0 else 0.0
        return reference + longer


class PlaneMotion(NamedTuple):
    """The same in two dimensions. G: (4, N), D_1 X and D_2 X; plane: of PlaneGrid."""

    given: Array
    columns: Array
    weights: Array
    moved: Array
    moving: Array
    G: Array
    plane: Any

    def move(self, known, metrics):
        """Fill a^1, a^2."""
        fill_hull(self.moved, known, 0, self.given, self.columns, self.weights)
        plane_metrics(self.plane, metrics, self.G, self.moved)

    def swing(self, known, metrics):
        """Velocity of the grid and J_t."""
        fill_hull(self.moving, known, 2, self.given, self.columns, self.weights)
        plane_velocities(self.plane, metrics, self.moving)

    def find_places(self, X, places):
        """Where nodes are: X and the displacement."""
        plane_places(self.plane, X, self.moved, places)

    def jacobian(self, metrics, N, node, reference):
        """det(D x): the metrics are D x."""
        n = node + N
        return metrics[node] * metrics[n + N + N] - metrics[n] * metrics[n + N]


class Unmoved(NamedTuple):
    """In three dimensions the grid is moved from Python."""

    kind: int = 0

    def move(self, known, metrics):
        """Nothing."""
        return None

    def swing(self, known, metrics):
        """Nothing."""
        return None

    def find_places(self, X, places):
        """Nothing."""
        return None

    def jacobian(self, metrics, N, node, reference):
        """Not known here."""
        return reference


@njit(**CALL)
def line_velocities(metrics, moving, low, high):
    """v and J_t = D v in 1-D, from the velocities of both ends, if there are any."""
    at_low = moving[0, 0] if moving.size > 0 else 0.0
    at_high = moving[0, -1] if moving.size > 0 else 0.0
    for i in range(low.size):
        metrics[1, i] = low[i] * at_low + high[i] * at_high
        metrics[2, i] = at_high - at_low


class Hull:
    """The nodes of all faces of a block, numbers (H,) ascending; values at them are arrays (d, H).

    Nodes of edges that are not given follow from their ends, those of faces from edges, vertices.
    """

    def __init__(self, block: Block, given: Array) -> None:
        self.block, d = block, block.dimension
        sides = [(None,) if closed else (0, 1, None) for closed in block.periodic]
        faces = [face_nodes(block.shape, k, s) for k in range(d) for s in sides[k] if s is not None]
        self.nodes = np.unique(np.concatenate([np.zeros(0, int), *faces]))
        self.given = self.columns(np.asarray(given, int))
        known, pieces = np.isin(self.nodes, given), {1: [], 2: []}
        for entity in product(*sides):
            free = [k for k in range(d) if entity[k] is None and not block.periodic[k]]
            inside = entity.count(None) == d
            if free and not inside and not known[self._columns(self._nodes_of(entity))].all():
                pieces[len(free)].append(self._follows(entity, free))
        none = np.zeros((9, 0), int), np.zeros((4, 0))
        self.pieces = [np.concatenate(p, axis=1) for p in zip(none, *pieces[1], *pieces[2])]

    def zeros(self) -> Array:
        """Values 0."""
        return np.zeros((self.block.dimension, len(self.nodes)))

    def columns(self, nodes: Array) -> Array:
        """Where node numbers are among those of the hull."""
        return np.searchsorted(self.nodes, nodes)

    def fill(self, values: Array, given: Array) -> None:
        """Complete values (d, H) from those of the given nodes (M, d)."""
        known = np.ascontiguousarray(given, dtype=float)
        fill_hull(values, known, 0, self.given, *self.pieces)

    def ends(self, values: Array) -> tuple[float, float]:
        """Values at both ends of a block in 1-D; 0 if it is periodic."""
        return (values[0, 0], values[0, -1]) if values.size else (0.0, 0.0)

    def _nodes_of(self, entity: Entity, inner: Sequence[int] = ()) -> list[Array]:
        """Indices (T,) of an entity's nodes along each axis; along some, inner ones only."""
        ranges = []
        for k, (n, side) in enumerate(zip(self.block.shape, entity)):
            whole = np.arange(n)
            free = whole[1:-1] if k in inner else whole
            ranges.append(free if side is None else whole[-1:] if side else whole[:1])
        return [index.ravel() for index in mesh(ranges)]

    def _columns(self, index: Sequence[Array]) -> Array:
        index = [i % n for i, n in zip(index, self.block.shape)]
        return self.columns(np.ravel_multi_index(index[::-1], self.block.shape[::-1]))

    def _follows(self, entity: Entity, free: Sequence[int]) -> tuple[Array, Array]:
        """Columns (9, T) of the inner nodes of an edge or a face, of its edges low a, high a, low
        b, high b, of four vertices; weights (4, T) of the edges. An edge has its ends as edges a.
        """
        index = self._nodes_of(entity, free)
        a, b = free[0], free[-1]
        edges = [{a: 0}, {a: -1}, {b: 0}, {b: -1}]
        vertices = [{a: i, b: j} for i, j in ((0, 0), (-1, -1), (-1, 0), (0, -1))]
        columns = []
        for ends in ({}, *edges, *vertices):
            at = [i if k not in ends else 0 * i + ends[k] for k, i in enumerate(index)]
            columns.append(self._columns(at))
        weights = [w for k in (a, b) for w in end_weights(self.block, k, index[k])]
        if a == b:
            weights[2:] = [0.0 * w for w in weights[2:]]
        return np.array(columns), np.array(weights)


def end_weights(block: Block, axis: int, index: Array) -> tuple[Array, Array]:
    """1 - xi and xi of nodes, the same bits seen from both ends; 0 on a periodic axis."""
    if block.periodic[axis]:
        return np.zeros(len(index)), np.zeros(len(index))
    cells = block.cells[axis]
    return (cells - index) / cells, index / cells


@njit(**CALL)
def fill_hull(values, given, first, known, columns, weights):
    """Edges between their ends, then faces; sums do not depend on the order of ends and axes. The
    given numbers are columns of ``given`` from ``first`` on.
    """
    for c in range(values.shape[0]):
        f = values[c]
        for m in range(known.size):
            f[known[m]] = given[m, first + c]
        for t in range(columns.shape[1]):
            to, a0, a1, b0, b1, v00, v11, v10, v01 = columns[:, t]
            la, ha, lb, hb = weights[:, t]
            edges = (la * f[a0] + ha * f[a1]) + (lb * f[b0] + hb * f[b1])
            equal = la * lb * f[v00] + ha * hb * f[v11]
            opposite = ha * lb * f[v10] + la * hb * f[v01]
            f[to] = edges - (equal + opposite)


class Blend:
    """The Boolean sum of faces on a range of nodes: axis after axis, what is missing at the two
    faces is added, linear between them.
    """

    def __init__(self, block: Block, where: Range, hull: Hull) -> None:
        d = block.dimension
        self._axes = [k for k in range(d) if not block.periodic[k]]
        index = [np.arange(*ends) % n for ends, n in zip(where, block.shape)]
        for k in self._axes:  # both ends are taken along
            index[k] = np.concatenate([[0], index[k], [block.shape[k] - 1]])
        within = slice(None), slice(1, -1)
        self._inner = tuple(within[not closed] for closed in block.periodic[::-1])
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
            first, last = (np.take(u, [end], axis=d - axis) for end in (0, -1))
            missing = (low - first).reshape(-1), (high - last).reshape(-1)
            _add_between(u.reshape(-1), *missing, l, h, before)
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
