"""The grid of a gas block: x = X + the displacements of its faces, blended.

Inside is the Boolean sum of the faces (fsipetsc.blocks.hull): Gordon and Hall, Int. J. Numer. Meth.
Eng. 7 (1973) 461-477. The velocity of the grid is the same blend of the faces' velocities. What
moves is a record for procedures (fsipetsc.kernels.procedure), one for each number of dimensions and
one around an axis or a centre; all have the methods of a LineMotion.
"""

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block import Block, Range, mesh
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.hull import blend_of, end_weights, hull_of
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

    def edge(self, known, metrics):
        """Find where the grid's faces are, and a^k on those at constraints, or everywhere if that
        is little work.
        """
        self.hull.fill(self.hull.moved, known, 0)
        metrics[0, :] = 1.0

    def move(self, metrics):
        """Find where the grid is and a^k, as far as `edge` has not."""

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
    """A grid in three dimensions. blend: on the W wide nodes; wide, range: windows of these and of
    the N nodes. y: (3, W), of a Wide; x, moved: (3, W) places less those of linear maps, volume:
    (N,) det D x. faces: (2, F) wide nodes that derivatives on faces at constraints reach, and their
    columns of the hull; ahead, back: (9, N) a^k there if nodes go on with their velocity for 1 s,
    and where they were 1 s before. address: of a Cube.
    """

    hull: Any
    blend: Any
    wide: Any
    range: Any
    y: Array
    x: Array
    moved: Array
    volume: Array
    faces: Array
    ahead: Array
    back: Array
    address: int

    def edge(self, known, metrics):
        self.hull.fill(self.hull.moved, known, 0)
        self.put_faces(self.x, self.y, 1.0, self.hull.moved)
        invoke("cube_faces", self.address, self.x, metrics)

    def move(self, metrics):
        self.blend.fill(self.hull.moved, self.x, self.wide, self.y)
        invoke("cube_areas", self.address, self.x, metrics)

    def swing(self, known, metrics):
        self.hull.fill(self.hull.moving, known, 3)
        self.blend.fill(self.hull.moving, metrics[9:], self.range)

    def turn(self):
        """Find ahead and back, after `swing`."""
        for sign, areas in ((1.0, self.ahead), (-1.0, self.back)):
            self.put_faces(self.moved, self.x, sign, self.hull.moving)
            invoke("cube_faces", self.address, self.moved, areas)

    def put_faces(self, out, base, sign, values):
        """out = base + sign values, of the hull, on faces at constraints."""
        for c in each(3):
            for i in each(self.faces.shape[1]):
                n = self.faces[0, i]
                out[c, n] = base[c, n] + sign * values[c, self.faces[1, i]]

    def find_places(self, X, places):
        self.blend.fill(self.hull.moved, places, self.range, X)

    def find_volumes(self):
        invoke("cube_volumes", self.address, self.x, self.volume)

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
    cube, reached = Cube(wide, faces), _on_faces(block, wide, hull, faces)
    room = *zeros((2, 3, wide.y.shape[1])), np.zeros(N), reached, *np.zeros((2, 9, N))
    windows = blend_of(block, wide, hull.nodes)
    return CubeMotion(hull, *windows, wide.y, *room, cube.address), metrics, cube


def _on_faces(block: Block, wide: Wide, hull: Any, faces: Any) -> Array:
    """(2, F) wide nodes on faces of a range, (axis, index along it), and their columns."""
    index = mesh([np.arange(*ends) for ends in wide.wide])
    at = np.any(
        [np.zeros_like(index[0], bool), *(index[a] == wide.where[a][0] + i for a, i in faces)],
        axis=0,
    )
    numbers = np.ravel_multi_index(
        [(i % n)[at] for i, n in zip(index, block.shape)], block.shape, order="F"
    )
    return np.stack([np.flatnonzero(at), np.searchsorted(hull.nodes, numbers)])
