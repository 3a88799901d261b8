"""The grid of a gas block: x = X + the displacements of its faces, blended.

Inside is the Boolean sum of the faces (fsipetsc.blocks.hull): Gordon and Hall, Int. J. Numer. Meth.
Eng. 7 (1973) 461-477. The velocity of the grid is the same blend of the faces' velocities. What
moves is a record for procedures (fsipetsc.kernels.procedure), one for each number of dimensions and
one around an axis or a centre; all have the methods of a LineMotion.
"""

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block import Range
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.hull import blend_of, end_weights, find_places, hull_of
from fsipetsc.blocks.metrics import Cube, Wide
from fsipetsc.blocks.plane_grid import plane_motion
from fsipetsc.blocks.radial_grid import radial_motion
from fsipetsc.checks import Array
from fsipetsc.kernels.arrays import zeros
from fsipetsc.kernels.loops import each, invoke
from fsipetsc.kernels.symbols import exact


def ends_of(values):
    """Values (1, H) at both ends of a block, 0 if it is periodic."""
    return values[0, 0], values[0, -1]


class LineMotion(NamedTuple):
    """A grid in one dimension; low, high: (N,) weights of the ends. slope: (N,) D X. hull:
    fsipetsc.blocks.hull.

    known: (M, 2d) displacements [m] and velocities [m/s] of the given nodes. metrics: (d d + d, N),
    a^1 … a^d and the velocity of the grid.
    """

    hull: Any
    low: Array
    high: Array
    slope: Array

    def move(self, known, metrics):
        """Find where the grid is, and fill a^k, which is 1."""
        self.hull.fill(self.hull.moved, known, 0)
        metrics[0, :] = 1.0

    def swing(self, known, metrics):
        """Fill the velocity, after `move`."""
        self.hull.fill(self.hull.moving, known, 1)
        ends = ends_of(self.hull.moving)
        for i in each(self.low.shape[0], vector=True):
            metrics[1, i] = self.between(i, *ends)

    def between(self, i, at_low, at_high):
        """What is blended from both ends, at a node."""
        return exact(self.low[i] * at_low + self.high[i] * at_high)

    def find_places(self, X, places):
        """Where nodes are after `move` (d, N); X: those of the reference map."""
        ends = ends_of(self.hull.moved)
        for i in each(self.low.shape[0], vector=True):
            places[0, i] = X[0, i] + self.between(i, *ends)

    def find_volumes(self):
        """Find what ``jacobian`` takes beside the metrics."""

    def jacobian(self, metrics, node):
        """det(D x) of a node, after `move` and `find_volumes`."""
        at_low, at_high = ends_of(self.hull.moved)
        return self.slope[node] + (at_high - at_low)


class CubeMotion(NamedTuple):
    """A grid in three dimensions. blend: on the W wide nodes; y: (3, W), of a Wide; inner: (N,) of
    the range among the wide nodes. x, v: (3, W) places less those of linear maps, velocities,
    volume: (N,) det D x, turning: (9, N) how a^k changes in time on faces at constraints, all of a
    Cube with this address.
    """

    hull: Any
    blend: Any
    inner: Array
    y: Array
    x: Array
    v: Array
    volume: Array
    turning: Array
    address: int

    def move(self, known, metrics):
        self.hull.fill(self.hull.moved, known, 0)
        self.blend.fill(self.hull.moved, self.x, self.y)
        invoke("cube_move", self.address)

    def swing(self, known, metrics):
        self.hull.fill(self.hull.moving, known, 3)
        self.blend.fill(self.hull.moving, self.v)
        for c in range(3):
            for i in each(self.inner.size, vector=True):
                metrics[9 + c, i] = self.v[c, self.inner[i]]

    def turn(self):
        """Find turning, after `swing`."""
        invoke("cube_turn", self.address)

    find_places = find_places

    def find_volumes(self):
        invoke("cube_volumes", self.address)

    def jacobian(self, metrics, node):
        return self.volume[node]


def motion_of(
    problem: BlockProblem, k: int, order: int, where: Range, nodes: Array, faces: Any
) -> tuple[Any, Array, Any]:
    """The motion of a range of nodes of gas block k (of a rank: the ghosted), its metrics, and what
    it keeps in memory.

    nodes: numbers (M,) of those nodes on faces of the whole block whose displacement and velocity
    will be given, in any order. faces: of the range, (axis, index along it), whose turning is
    wanted in three dimensions.
    """
    block, d = problem.blocks[k], problem.dimension
    wide, hull = Wide(problem, k, order, where), hull_of(block, nodes, problem.centred(k))
    N = wide.inner(wide.y).shape[1]
    metrics = zeros((d * d + d + (problem.symmetry > 0), N))
    if problem.symmetry:
        return radial_motion(problem, k, wide, hull), metrics, None
    if d == 1:
        weights = end_weights(block, 0, np.arange(*where[0]))[:, 0]
        slope = np.ascontiguousarray(wide.gradients()[0, 0])
        return LineMotion(hull, *weights, slope), metrics, None
    if d == 2:
        return plane_motion(block, wide, hull), metrics, None
    cube, inner = Cube(wide, metrics, faces), wide.inner(np.arange(wide.y.shape[1]))
    of_cube = cube.x, cube.v, cube.volume, cube.turning, cube.address
    blend = blend_of(block, wide, hull.nodes)
    return CubeMotion(hull, blend, inner, wide.y, *of_cube), metrics, cube
