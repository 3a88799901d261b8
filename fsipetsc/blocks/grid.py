"""The grid of a gas block: x = X + the displacements of its faces, blended.

Inside is the Boolean sum of the faces (fsipetsc.blocks.hull): Gordon and Hall, Int. J. Numer. Meth.
Eng. 7 (1973) 461-477. The velocity of the grid is the same blend of the faces' velocities. What
moves is a record for compiled code, one for each number of dimensions and one around an axis or a
centre; all have the methods of a LineMotion.
"""

import ctypes
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block import Range
from fsipetsc.blocks.cube import Cube, faces_turning
from fsipetsc.blocks.hull import blend_of, end_weights, hull_of
from fsipetsc.blocks.metrics import Wide
from fsipetsc.blocks.plane_grid import plane_motion
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.blocks.radial_grid import radial_motion
from fsipetsc.checks import Array
from fsipetsc.operators.compiled import CompiledFunction
from fsipetsc.operators.loops import njit
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
    """A grid in three dimensions. blend: on the W wide nodes; y: (3, W), of a Wide; inner: (N,) of
    the range among the wide nodes. x, v: (3, W) places less those of linear maps, velocities,
    volume: (N,) det D x, areas, velocities: functions of fsipetsc/blocks/cube.c, all of a Cube with
    this address.
    """

    hull: Any
    blend: Any
    inner: Array
    y: Array
    x: Array
    v: Array
    volume: Array
    areas: Any
    velocities: Any
    address: int

    def move(self, known, metrics):
        """Fill a^1, a^2, a^3 in curl form, and volume."""
        self.hull.fill(self.hull.moved, known, 0)
        self.blend.fill(self.hull.moved, self.x)
        add_to(self.x, self.y)
        self.areas(self.address)

    def swing(self, known, metrics):
        """Velocity of the grid and J_t."""
        self.hull.fill(self.hull.moving, known, 3)
        self.blend.fill(self.hull.moving, self.v)
        self.velocities(self.address)

    def find_places(self, X, places):
        """X + the displacement."""
        for i in range(self.inner.size):
            for c in range(3):
                n = self.inner[i]
                places[c, i] = X[c, i] + (self.x[c, n] - self.y[c, n])

    def jacobian(self, metrics, N, node, reference):
        """det(D x) of a node."""
        return self.volume[node]


@njit(**CALL)
def add_to(x, y):
    """x += y."""
    for c in range(x.shape[0]):
        for n in range(x.shape[1]):
            x[c, n] += y[c, n]


class GridMotion:
    """Positions and metrics of a range of nodes of gas block k (of a rank: the ghosted).

    nodes: numbers (M,) of those nodes on faces of the whole block whose displacement and velocity
    will be given, in any order. library: has the functions of fsipetsc/blocks/cube.c, in three
    dimensions. record: for compiled code, see LineMotion. metrics: as there.
    """

    def __init__(
        self,
        problem: BlockProblem,
        k: int,
        order: int,
        where: Range,
        nodes: Array,
        library: ctypes.CDLL,
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
        elif d == 2:
            self.record = plane_motion(block, wide, hull)
        else:
            self._cube = cube = Cube(library, wide, self.metrics)
            self._turning, inner = np.zeros((9, self._X.shape[1])), np.arange(wide.y.shape[1])
            of_cube = cube.x, cube.v, cube.volume
            calls = (CompiledFunction(library, name, 0) for name in ("cube_move", "cube_swing"))
            blend = blend_of(block, wide, hull.nodes)
            self.record = CubeMotion(
                hull, blend, wide.inner(inner), wide.y, *of_cube, *calls, cube.address
            )

    def move(self, displacement: Array) -> None:
        """Fill a^1 … a^d from the displacement (M, d) [m] of the given nodes."""
        self.record.move(displacement, self.metrics)

    def turning(self, faces: Iterable[tuple[int, int]]) -> Array:
        """How a^1, a^2, a^3 (9, N) change in time after `swing` in three dimensions, on faces of
        the range: (axis, index along it) each; elsewhere 0.
        """
        faces_turning(self._cube, faces, self._turning)
        return self._turning

    def positions(self) -> Array:
        """x (d, N) [m] after the last `move`."""
        places = self._X.copy()
        self.record.find_places(self._X, places)
        return places

    def jacobian(self) -> Array:
        """det(D x) (N,) after the last `move`; around an axis or a centre as in radial_grid."""
        nodes = np.arange(self._X.shape[1])
        return self.record.jacobian(self.metrics.reshape(-1), nodes.size, nodes, self._reference)
