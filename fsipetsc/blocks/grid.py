"""The grid of a gas block: x = X + the displacements of its faces, blended.

Inside is the Boolean sum of the faces (fsipetsc.blocks.hull): Gordon and Hall, Int. J. Numer. Meth.
Eng. 7 (1973) 461-477. The velocity of the grid is the same blend of the faces' velocities. What
moves is a record for compiled code, one for each number of dimensions and one around an axis or a
centre; all have the methods of a LineMotion.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from fsipetsc.blocks.block import Block, Range
from fsipetsc.blocks.hull import Hull, blend_of, end_weights, hull_of
from fsipetsc.blocks.metrics import Wide, curl_metrics, volume_rate
from fsipetsc.blocks.plane_grid import plane_motion
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.blocks.radial_grid import radial_motion
from fsipetsc.checks import Array
from fsipetsc.operators.loops import CALL


class LineMotion(NamedTuple):
    """A grid in one dimension; low, high: (N,) weights of the ends. hull: fsipetsc.blocks.hull.

    known: (M, 2d) displacements [m] and velocities [m/s] of the given nodes. metrics: (d d + d + 1,
    N), a^1 … a^d, the velocity of the grid, J_t = sum_k a^k . D_k v, which sum_k D_k a^k = 0 makes
    the whole of it.
    """

    hull: Any
    low: Array
    high: Array

    def move(self, known, metrics):
        """Fill a^k, which is 1."""
        self.hull.fill(self.hull.moved, known, 0)
        metrics[0, :] = 1.0

    def swing(self, known, metrics):
        """Fill the velocity of the grid and J_t, after `move`."""
        self.hull.fill(self.hull.moving, known, 1)
        at_low, at_high = self.hull.ends(self.hull.moving)
        metrics[1, :] = self.low * at_low + self.high * at_high
        metrics[2, :] = at_high - at_low

    def find_places(self, X, places):
        """Where nodes are after `move` (d, N); X: those of the reference map."""
        at_low, at_high = self.hull.ends(self.hull.moved)
        places[0, :] = X[0] + (self.low * at_low + self.high * at_high)

    def jacobian(self, metrics, N, node, reference):
        """det(D x) of a node, after `move`; metrics: flat; reference: that of the reference map."""
        at_low, at_high = self.hull.ends(self.hull.moved)
        return reference + (at_high - at_low)


class CubeMotion(NamedTuple):
    """A grid in three dimensions. blend: on the W wide nodes. y, P, S, weight: of a Wide; inner:
    (N,) of the range among the wide nodes. x, v: (3, W) places less those of linear maps,
    velocities; a, slopes: (3, 3, W), q: (4, W), room. volume: (N,) det D x.
    """

    hull: Any
    blend: Any
    inner: Array
    y: Array
    P: Array
    S: Any
    weight: Any
    x: Array
    v: Array
    a: Array
    slopes: Array
    q: Array
    volume: Array

    def move(self, known, metrics):
        """Fill a^1, a^2, a^3 in curl form, and volume."""
        self.hull.fill(self.hull.moved, known, 0)
        cube_metrics(self, metrics)

    def swing(self, known, metrics):
        """Velocity of the grid and J_t."""
        self.hull.fill(self.hull.moving, known, 3)
        self.blend.fill(self.hull.moving, self.v)
        volume_rate(self.q[0], self.a, self.v, self.S, self.weight, self.q[1])
        for i in range(self.inner.size):
            n = self.inner[i]
            metrics[12, i] = self.q[0, n]
            for c in range(3):
                metrics[9 + c, i] = self.v[c, n]

    def find_places(self, X, places):
        """X + the displacement."""
        for i in range(self.inner.size):
            for c in range(3):
                n = self.inner[i]
                places[c, i] = X[c, i] + (self.x[c, n] - self.y[c, n])

    def jacobian(self, metrics, N, node, reference):
        """det(D x) of a node."""
        return self.volume[node]

    def turning(self):
        """How a^1, a^2, a^3 (9, N) change in time after `swing`: they are bilinear in the places.
        Not for compiled code.
        """
        found = []
        for sign in (1.0, -1.0):
            a, slopes = np.empty_like(self.a), np.empty_like(self.slopes)
            y = self.x + sign * self.v
            curl_metrics(a, y, self.P, self.S, self.weight, slopes, self.q)
            found.append(a.reshape(9, -1)[:, self.inner])
        return 0.5 * (found[0] - found[1])


@njit(**CALL)
def cube_metrics(cube, metrics):
    """a^1, a^2, a^3 and det D x."""
    x, a, P, slopes = cube.x, cube.a, cube.P, cube.slopes
    cube.blend.fill(cube.hull.moved, x)
    for c in range(3):
        for n in range(x.shape[1]):
            x[c, n] += cube.y[c, n]
    curl_metrics(a, x, P, cube.S, cube.weight, slopes, cube.q)
    G = np.empty((3, 3))
    for i in range(cube.inner.size):
        n = cube.inner[i]
        for k in range(3):
            for c in range(3):
                metrics[3 * k + c, i] = a[k, c, n]
                G[k, c] = slopes[k, c, n] + P[k, c]
        first = G[0, 0] * (G[1, 1] * G[2, 2] - G[1, 2] * G[2, 1])
        second = G[0, 1] * (G[1, 2] * G[2, 0] - G[1, 0] * G[2, 2])
        cube.volume[i] = first + second + G[0, 2] * (G[1, 0] * G[2, 1] - G[1, 1] * G[2, 0])


def _cube_motion(block: Block, wide: Wide, hull: Hull) -> CubeMotion:
    N = wide.y.shape[1]
    inner = wide.inner(np.arange(N))
    of_map = wide.y, wide.P, wide.S, wide.weight
    room = *np.zeros((2, 3, N)), *np.zeros((2, 3, 3, N)), np.zeros((4, N)), np.zeros(inner.size)
    return CubeMotion(hull, blend_of(block, wide, hull.nodes), inner, *of_map, *room)


class GridMotion:
    """Positions and metrics of a range of nodes of gas block k (of a rank: the ghosted).

    nodes: numbers (M,) of those nodes on faces of the whole block whose displacement and velocity
    will be given, in any order. record: for compiled code, see LineMotion. metrics: as there.
    """

    def __init__(
        self, problem: BlockProblem, k: int, order: int, where: Range, nodes: Array
    ) -> None:
        block, d = problem.blocks[k], problem.dimension
        self._X, wide = problem.positions(k, where), Wide(problem, k, order, where)
        around, hull = problem.symmetry > 0, hull_of(block, nodes, problem.centred(k))
        self.metrics, self._reference = np.zeros((d * d + d + 1 + around, self._X.shape[1])), None
        self.record: Any
        if around:
            self.record = radial_motion(problem, k, wide, hull)
        elif d == 1:
            self._reference = wide.gradients()[0, 0]
            self.record = LineMotion(hull, *end_weights(block, 0, np.arange(*where[0]))[:, 0])
        else:
            self.record = (plane_motion if d == 2 else _cube_motion)(block, wide, hull)

    def move(self, displacement: Array) -> None:
        """Fill a^1 … a^d from the displacement (M, d) [m] of the given nodes."""
        self.record.move(displacement, self.metrics)

    def positions(self) -> Array:
        """x (d, N) [m] after the last `move`."""
        places = self._X.copy()
        self.record.find_places(self._X, places)
        return places

    def jacobian(self) -> Array:
        """det(D x) (N,) after the last `move`; around an axis or a centre as in radial_grid."""
        nodes = np.arange(self._X.shape[1])
        return self.record.jacobian(self.metrics.reshape(-1), nodes.size, nodes, self._reference)
