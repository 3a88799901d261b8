"""The moving grid of a gas in two dimensions, of which only the faces are differentiated. Compiled.

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

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.faces import face_nodes
from fsipetsc.blocks.hull import Hull, end_weights
from fsipetsc.blocks.metrics import EXACT, Wide, differentiate
from fsipetsc.checks import Array
from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import CALL, INNER_CALL, add, dot, load, rows, scale, store, sub


class Faces(NamedTuple):
    """The two faces along an axis: columns (2, n) of the hull, the band of the axis, the first node
    of the range, weights of the ends of the axis; values and derivatives (4, n) along the faces, by
    side and component, and memory.
    """

    columns: Array
    S: Array
    weight: Array
    first: int
    low: Array
    high: Array
    f: Array
    slope: Array
    scratch: Array


class PlaneMotion(NamedTuple):
    """See fsipetsc.blocks.grid.LineMotion. G: (4, N), D_1 X and D_2 X. along, across: the Faces of
    both axes. corners: columns (2, 2) of the vertices, ends: (4, 2) the values there; rise: (2, n)
    the bracket of D_2 u; row: (4, n) D_1 u and D_2 u of a row of nodes.
    """

    hull: Any
    G: Array
    along: Faces
    across: Faces
    corners: Array
    ends: Array
    rise: Array
    row: Array

    def move(self, known, metrics):
        """Fill a^1, a^2."""
        self.hull.fill(self.hull.moved, known, 0)
        plane_metrics(self, metrics)

    def swing(self, known, metrics):
        """Velocity of the grid and J_t = a^1 . D_1 v + a^2 . D_2 v."""
        self.hull.fill(self.hull.moving, known, 2)
        plane_velocities(self, metrics)

    def find_places(self, X, places):
        """places = X + the displacement (2, N)."""
        plane_places(self, X, places)

    def jacobian(self, metrics, N, node, reference):
        """det(D x): the metrics are D x."""
        n = node + N
        return metrics[node] * metrics[n + N + N] - metrics[n] * metrics[n + N]


def plane_motion(block: Block, wide: Wide, hull: Hull) -> PlaneMotion:
    """Of the range of nodes of a Wide."""
    axes = []
    for axis, ((begin, end), where) in enumerate(zip(wide.wide, wide.where)):
        index, weights = np.arange(begin, end), end_weights(block, axis, np.arange(*where))[:, 0]
        faces = [face_nodes(block.shape, 1 - axis, s)[index % block.shape[axis]] for s in (0, 1)]
        there = np.array(faces)[:, : 0 if block.periodic[1 - axis] else None]
        memory = *np.zeros((2, 4, weights[0].size)), np.zeros((2, end - begin))
        of_band = wide.S[axis], wide.weight[axis], where[0] - begin
        axes.append(Faces(np.searchsorted(hull.nodes, there), *of_band, *weights, *memory))
    corners = np.zeros((2, 0), int)
    if not any(block.periodic):
        corners = np.array([face_nodes(block.shape, 1, side)[[0, -1]] for side in (0, 1)])
    n, at = axes[0].low.size, np.searchsorted(hull.nodes, corners)
    G = np.ascontiguousarray(wide.gradients().reshape(4, -1))
    return PlaneMotion(hull, G, *axes, at, np.zeros((4, 2)), np.zeros((2, n)), np.zeros((4, n)))


@njit(**CALL)
def plane_metrics(plane, metrics):
    """a^1 = (D_2 y, -D_2 x), a^2 = (-D_1 y, D_1 x)."""
    differentiate_faces(plane, plane.hull.moved)
    G, row, n = plane.G, plane.row, plane.along.low.size
    for j in range(plane.across.low.size):
        blend_slopes(plane, j)
        a, b = j * n, (j + 1) * n
        _add(metrics[0, a:b], G[3, a:b], row[3], 1.0)
        _add(metrics[1, a:b], G[2, a:b], row[2], -1.0)
        _add(metrics[2, a:b], G[1, a:b], row[1], -1.0)
        _add(metrics[3, a:b], G[0, a:b], row[0], 1.0)


@njit(**CALL)
def plane_velocities(plane, metrics):
    """v and J_t."""
    differentiate_faces(plane, plane.hull.moving)
    row, n = plane.row, plane.along.low.size
    for j in range(plane.across.low.size):
        blend_slopes(plane, j)
        a, b, like = j * n, (j + 1) * n, (0.0, 0.0)
        a1, a2 = rows(like, metrics, a, b), rows(like, metrics[2:], a, b)
        _rate(metrics[6, a:b], a1, a2, (row[0], row[1]), (row[2], row[3]))
        blend_values(plane, j, rows(like, metrics[4:], a, b))


@njit(**CALL)
def plane_places(plane, X, places):
    """X + the displacement."""
    differentiate_faces(plane, plane.hull.moved)
    n = plane.along.low.size
    for j in range(plane.across.low.size):
        blend_values(plane, j, rows((0.0, 0.0), places, j * n, (j + 1) * n))
    for c in range(2):
        for i in range(X.shape[1]):
            places[c, i] += X[c, i]


@njit(**INNER_CALL)
def differentiate_faces(plane, values):
    """Values (2, H) of the hull at faces and vertices, and derivatives along faces."""
    for faces in (plane.along, plane.across):
        given, slope = faces.scratch[0], faces.scratch[1]
        for r in range(4 if faces.columns.size > 0 else 0):
            for i in range(given.size):
                given[i] = values[r % 2, faces.columns[r // 2, i]]
            differentiate(slope, given, faces.S, faces.weight, 1)
            for i in range(faces.f.shape[1]):
                faces.f[r, i] = given[faces.first + i]
                faces.slope[r, i] = slope[faces.first + i]
    f, ends, low, high = plane.along.f, plane.ends, plane.along.low, plane.along.high
    for c in range(2):
        for end in range(plane.corners.shape[1]):
            ends[end, c] = values[c, plane.corners[0, end]]
            ends[2 + end, c] = values[c, plane.corners[1, end]]
        at_low, at_high = ends[2, c] - ends[0, c], ends[3, c] - ends[1, c]
        for i in range(low.size):
            plane.rise[c, i] = (f[2 + c, i] - f[c, i]) - (low[i] * at_low + high[i] * at_high)


@njit(**INNER_CALL)
def _row(plane, j):
    """Of row j: weights of its ends, Q_0, Q_n, W, E."""
    ends, g, l, h = plane.ends, plane.across.f, plane.across.low[j], plane.across.high[j]
    start = l * ends[0, 0] + h * ends[2, 0], l * ends[0, 1] + h * ends[2, 1]
    stop = l * ends[1, 0] + h * ends[3, 0], l * ends[1, 1] + h * ends[3, 1]
    return l, h, start, stop, (g[0, j], g[1, j]), (g[2, j], g[3, j])


@njit(**INNER_CALL)
def blend_slopes(plane, j):
    """D_1 u and D_2 u of row j."""
    slope, steep, rise, row = plane.along.slope, plane.across.slope, plane.rise, plane.row
    l, h, start, stop, west, east = _row(plane, j)
    S, N, across = (slope[0], slope[1]), (slope[2], slope[3]), sub(east, west)
    _between((row[0], row[1]), S, N, l, h, sub(across, sub(stop, start)))
    W, E = (steep[0, j], steep[1, j]), (steep[2, j], steep[3, j])
    _along((row[2], row[3]), (rise[0], rise[1]), plane.along.low, plane.along.high, W, E)


@njit(**INNER_CALL)
def blend_values(plane, j, u):
    """u of row j."""
    f, low, high = plane.along.f, plane.along.low, plane.along.high
    l, h, start, stop, west, east = _row(plane, j)
    S, N, from_low, from_high = (f[0], f[1]), (f[2], f[3]), sub(west, start), sub(east, stop)
    _blend(u, S, N, l, h, low, high, from_low, from_high)
    if low[0] == 1.0:
        store(u, 0, west)
    if high[low.size - 1] == 1.0:
        store(u, low.size - 1, east)


@njit(**EXACT)
def _blend(u, S, N, l, h, low, high, west, east):
    """(l S + h N) + (low west + high east)."""
    for i in range(low.size):
        Q = add(scale(l, load(S, i)), scale(h, load(N, i)))
        store(u, i, add(Q, add(scale(low[i], west), scale(high[i], east))))


@njit(**EXACT)
def _between(u, S, N, l, h, more):
    """l S + h N + more."""
    for i in range(u[0].size):
        store(u, i, add(add(scale(l, load(S, i)), scale(h, load(N, i))), more))


@njit(**EXACT)
def _along(u, f, low, high, west, east):
    """f + (low west + high east)."""
    for i in range(low.size):
        store(u, i, add(load(f, i), add(scale(low[i], west), scale(high[i], east))))


@njit(**EXACT)
def _add(out, f, g, sign):
    for i in range(out.size):
        out[i] = sign * (f[i] + g[i])


@njit(**EXACT)
def _rate(J_t, a1, a2, D1, D2):
    """a^1 . D_1 v + a^2 . D_2 v."""
    for i in range(J_t.size):
        J_t[i] = dot(load(a1, i), load(D1, i)) + dot(load(a2, i), load(D2, i))
