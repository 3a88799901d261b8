"""The moving grid of a gas in two dimensions, of which only the faces are differentiated.

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
from fsipetsc.blocks.hull import Hull, end_weights, nothing
from fsipetsc.blocks.metrics import Wide, slopes_along
from fsipetsc.checks import Array
from fsipetsc.equations.vectors import add, scale, sub
from fsipetsc.kernels.arrays import column, column_of
from fsipetsc.kernels.loops import each, when
from fsipetsc.kernels.symbols import exact


class Opposite(NamedTuple):
    """The two faces along an axis, if it has any: columns (2, n) of the hull, the band of the axis,
    the first node of the range, weights of the ends of the axis; values and derivatives (4, n)
    along the faces, by side and component.
    """

    columns: Array
    S: Array
    weight: Array
    first: int
    low: Array
    high: Array
    f: Array
    slope: Array


class PlaneMotion(NamedTuple):
    """See fsipetsc.blocks.grid.LineMotion. G: (4, N), D_1 X and D_2 X. along, across: faces of both
    axes. corners: columns of the four vertices, if there are any, ends: (4, 2) values there;
    rise: (2, n) the bracket of D_2 u.
    """

    hull: Any
    G: Array
    along: Opposite
    across: Opposite
    corners: Array
    ends: Array
    rise: Array

    def edge(self, known, metrics):
        """Fill a^1 = (D_2 y, -D_2 x) and a^2 = (-D_1 y, D_1 x)."""
        self.hull.fill(self.hull.moved, known, 0)
        find_faces(self, self.hull.moved)
        differentiate_faces(self)
        G, n = self.G, self.along.low.shape[0]
        for j in each(self.across.low.shape[0]):
            row = Row(self, j)
            for i in each(n, vector=True):
                at, ((x_1, y_1), (x_2, y_2)) = j * n + i, row.slopes(i)
                metrics[0, at] = G[3, at] + y_2
                metrics[1, at] = -(G[2, at] + x_2)
                metrics[2, at] = -(G[1, at] + y_1)
                metrics[3, at] = G[0, at] + x_1

    move = nothing
    find_volumes = nothing

    def swing(self, known, metrics):
        """Fill the velocity of the grid."""
        self.hull.fill(self.hull.moving, known, 2)
        blend_faces(self, self.hull.moving, metrics, 4)

    def find_places(self, X, places):
        """places = X + the displacement (2, N)."""
        blend_faces(self, self.hull.moved, places, 0)
        for c in range(2):
            for i in each(X.shape[1], vector=True):
                places[c, i] += X[c, i]

    def jacobian(self, metrics, node):
        """det(D x) of a node."""
        x, y, z, t = (metrics[k, node] for k in range(4))
        return exact(x * t - y * z)


def plane_motion(block: Block, wide: Wide, hull: Hull) -> PlaneMotion:
    """Of the range of nodes of a Wide."""
    axes, shape = [], block.shape
    for axis, ((begin, end), where) in enumerate(zip(wide.wide, wide.where)):
        index, weights = np.arange(begin, end), end_weights(block, axis, np.arange(*where))[:, 0]
        sides = () if block.periodic[1 - axis] else (0, 1)
        nodes = [block.face_nodes(1 - axis, side)[index % shape[axis]] for side in sides]
        columns = np.searchsorted(hull.nodes, np.array(nodes, int).reshape(-1, index.size))
        of_band = wide.S[axis], wide.weight[axis], where[0] - begin
        axes.append(Opposite(columns, *of_band, *weights, *np.zeros((2, 4, index.size))))
    sides = () if any(block.periodic) else (0, 1)
    vertices = [block.face_nodes(1, side)[[0, -1]] for side in sides]
    corners = np.searchsorted(hull.nodes, np.array(vertices, int).ravel())
    G = np.ascontiguousarray(wide.gradients().reshape(4, -1))
    return PlaneMotion(hull, G, *axes, corners, np.zeros((4, 2)), np.zeros((2, axes[0].low.size)))


def blend_faces(plane, values, to, first):
    """Blend values (2, H) of the hull into two rows of an array, from ``first`` on."""
    find_faces(plane, values)
    n, low, high = plane.along.low.shape[0], plane.along.low, plane.along.high
    for j in each(plane.across.low.shape[0]):
        row = Row(plane, j)
        for i in each(n, vector=True):
            to[first, j * n + i], to[first + 1, j * n + i] = row.values(i)
        for weight, at, end in (low[0], 0, row.W), (high[-1], n - 1, row.E):  # to the bit
            with when(weight == 1.0):
                for c in range(2):
                    to[first + c, j * n + at] = end[c]


def find_faces(plane, values):
    """Find values (2, H) of the hull at faces and vertices."""
    for faces in plane.along, plane.across:
        for r in each(2 * faces.columns.shape[0]):
            for i in each(faces.f.shape[1], vector=True):
                faces.f[r, i] = values[r % 2, faces.columns[r // 2, i]]
    for corner in each(plane.corners.shape[0]):
        for c in range(2):
            plane.ends[corner, c] = values[c, plane.corners[corner]]


def differentiate_faces(plane):
    """Find derivatives along faces, and the bracket of D_2 u, from what `find_faces` has found."""
    for faces in plane.along, plane.across:
        slopes_along(faces.slope.reshape(-1), faces.f.reshape(-1), faces.S, faces.weight)
    along, ends, low, high = plane.along, plane.ends, plane.along.low, plane.along.high
    for c in range(2):
        at_low, at_high = ends[2, c] - ends[0, c], ends[3, c] - ends[1, c]
        for i in each(low.shape[0], vector=True):
            between, at = low[i] * at_low + high[i] * at_high, along.first + i
            plane.rise[c, i] = exact((along.f[2 + c, at] - along.f[c, at]) - between)


def mixed(l, a, h, b):
    """l a + h b."""
    return exact(add(scale(l, a), scale(h, b)))


def pair(f, at):
    """Values at both ends, which opposite faces have of a node."""
    return column((0.0, 0.0), f, at), column_of((0.0, 0.0), f, 2, at)


class Row:
    """Row j of nodes: weights of its ends, Q_0, Q_n, W, E, and their derivatives."""

    def __init__(self, plane, j):
        ends = [tuple(plane.ends[k, c] for c in range(2)) for k in range(4)]
        across, at = plane.across, plane.across.first + j
        self.plane, self.l, self.h = plane, across.low[j], across.high[j]
        (self.W, self.E), (self.D_W, self.D_E) = pair(across.f, at), pair(across.slope, at)
        self.start, self.stop = (mixed(self.l, ends[k], self.h, ends[2 + k]) for k in (0, 1))

    def slopes(self, i):
        """D_1 u and D_2 u of node i."""
        along, (S, N) = self.plane.along, pair(self.plane.along.slope, self.plane.along.first + i)
        bracket = sub(sub(self.E, self.W), sub(self.stop, self.start))
        D_2 = mixed(along.low[i], self.D_W, along.high[i], self.D_E)
        rise = column((0.0, 0.0), self.plane.rise, i)
        return add(mixed(self.l, S, self.h, N), bracket), add(rise, D_2)

    def values(self, i):
        """u of node i."""
        along, (S, N) = self.plane.along, pair(self.plane.along.f, self.plane.along.first + i)
        W, E = sub(self.W, self.start), sub(self.E, self.stop)
        return add(mixed(self.l, S, self.h, N), mixed(along.low[i], W, along.high[i], E))
