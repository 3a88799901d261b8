"""The grid of a gas block: x = X + the displacements of its faces, blended.

Inside is the Boolean sum of the faces (fsipetsc.blocks.hull): Gordon and Hall, Int. J. Numer. Meth.
Eng. 7 (1973) 461-477. The velocity of the grid is the same blend of the faces' velocities. What
moves is a record for procedures (fsipetsc.kernels.procedure), one for each number of dimensions and
one around an axis or a centre; all have the methods of a LineMotion.
"""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block import Range
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.cube import Cube
from fsipetsc.blocks.hull import blend_of, end_weights, hull_of
from fsipetsc.blocks.metrics import Wide
from fsipetsc.blocks.plane_grid import plane_motion
from fsipetsc.blocks.radial_grid import radial_motion
from fsipetsc.checks import Array
from fsipetsc.kernels.loops import each, invoke
from fsipetsc.kernels.memory import zeros
from fsipetsc.kernels.procedure import Code, Procedure
from fsipetsc.kernels.symbols import exact


class LineMotion(NamedTuple):
    """A grid in one dimension; low, high: (N,) weights of the ends. hull: fsipetsc.blocks.hull.

    known: (M, 2d) displacements [m] and velocities [m/s] of the given nodes. metrics: (d d + d, N),
    a^1 … a^d and the velocity of the grid.
    """

    hull: Any
    low: Array
    high: Array

    def move(self, known, metrics):
        """Fill what constraints at faces take of where the grid is: a^k, which is 1."""
        self.hull.fill(self.hull.moved, known, 0)
        metrics[0, :] = 1.0

    def swing(self, known, metrics):
        """Fill what they take of how it moves, after `move`: its velocity."""
        self.hull.fill(self.hull.moving, known, 1)
        at_low, at_high = self.hull.ends(self.hull.moving)
        for i in each(self.low.shape[0], vector=True):
            metrics[1, i] = self.between(i, at_low, at_high)

    def between(self, i, at_low, at_high):
        """What is blended from both ends, at a node."""
        return exact(self.low[i] * at_low + self.high[i] * at_high)

    def find_places(self, X, places):
        """Where nodes are after `move` (d, N); X: those of the reference map."""
        ends = self.hull.ends(self.hull.moved)
        for i in each(self.low.shape[0], vector=True):
            places[0, i] = X[0, i] + self.between(i, *ends)

    def jacobian(self, metrics, N, node, reference):
        """det(D x) of a node, after `find_volumes`; metrics: flat; reference: that of the reference
        map.
        """
        at_low, at_high = self.hull.ends(self.hull.moved)
        return reference + (at_high - at_low)


class CubeMotion(NamedTuple):
    """A grid in three dimensions. blend: on the W wide nodes; y: (3, W), of a Wide; inner: (N,) of
    the range among the wide nodes. x, v: (3, W) places less those of linear maps, velocities,
    volume: (N,) det D x, of_faces: (9, N) a^k on faces that were named, then how they change in
    time, all of a Cube with this address.
    """

    hull: Any
    blend: Any
    inner: Array
    y: Array
    x: Array
    v: Array
    volume: Array
    of_faces: Array
    address: int

    def move(self, known, metrics):
        """Find where nodes are, and a^k on faces."""
        self.hull.fill(self.hull.moved, known, 0)
        self.blend.fill(self.hull.moved, self.x, self.y)
        invoke("cube_faces", self.address)

    def swing(self, known, metrics):
        """Find the velocities of nodes."""
        self.hull.fill(self.hull.moving, known, 3)
        self.blend.fill(self.hull.moving, self.v)

    def turn(self):
        """Let of_faces be how a^k changes, after `swing`."""
        invoke("cube_turn", self.address)

    def find_places(self, X, places):
        """Find where the nodes are."""
        for c in range(3):
            for i in each(self.inner.size, vector=True):
                n = self.inner[i]
                places[c, i] = X[c, i] + (self.x[c, n] - self.y[c, n])

    def jacobian(self, metrics, N, node, reference):
        """det(D x) of a node, after `find_volumes`."""
        return self.volume[node]


def finish(grid):
    """After `swing`, find metrics that it leaves out: in three dimensions a^k in curl form and the
    velocity of the grid, the most work, which is done when no rank waits for it.
    """
    if isinstance(grid, CubeMotion):
        invoke("cube_move", grid.address)


def find_volumes(grid):
    """After `move`, find what ``jacobian`` takes beside the metrics."""
    if isinstance(grid, CubeMotion):
        invoke("cube_volumes", grid.address)


class Known(NamedTuple):
    """What a GridMotion gives to its procedures. known: (M, 2d) as LineMotion has it; X, places:
    (d, N); reference, J: (N,) det(D X) and det(D x).
    """

    grid: Any
    known: Array
    metrics: Array
    X: Array
    places: Array
    reference: Array
    J: Array


def move(of):
    """Areas of the grid where it is now."""
    of.grid.move(of.known, of.metrics)
    finish(of.grid)


def find_places(of):
    """Find where the nodes are."""
    of.grid.find_places(of.X, of.places)


def find_jacobian(of):
    """Find det(D x) of the nodes."""
    metrics = of.metrics.reshape(-1)
    find_volumes(of.grid)
    for i in each(of.J.size, vector=True):
        of.J[i] = of.grid.jacobian(metrics, of.J.size, i, of.reference[i])


class GridMotion:
    """Positions and metrics of a range of nodes of gas block k (of a rank: the ghosted).

    nodes: numbers (M,) of those nodes on faces of the whole block whose displacement and velocity
    will be given, in any order. record: for procedures, see LineMotion. metrics: as there. Before
    the grid moves, what ``procedures`` records must be loaded.
    """

    def __init__(
        self, problem: BlockProblem, k: int, order: int, where: Range, nodes: Array
    ) -> None:
        block, d = problem.blocks[k], problem.dimension
        X, wide = problem.positions(k, where), Wide(problem, k, order, where)
        around, hull = problem.symmetry > 0, hull_of(block, nodes, problem.centred(k))
        reference = np.zeros(X.shape[1])
        self.metrics = zeros((d * d + d + around, X.shape[1]))
        self.record: Any
        if around:
            self.record = radial_motion(problem, k, wide, hull)
        elif d == 1:
            reference[:] = wide.gradients()[0, 0]
            self.record = LineMotion(hull, *end_weights(block, 0, np.arange(*where[0]))[:, 0])
        elif d == 2:
            self.record = plane_motion(block, wide, hull)
        else:
            self._cube = cube = Cube(wide, self.metrics)
            of_cube = cube.x, cube.v, cube.volume, cube.of_faces, cube.address
            blend, inner = blend_of(block, wide, hull.nodes), np.arange(wide.y.shape[1])
            self.record = CubeMotion(hull, blend, wide.inner(inner), wide.y, *of_cube)
        known, J = np.zeros((len(nodes), 2 * d)), np.zeros(X.shape[1])
        X = np.ascontiguousarray(X)
        self._known = Known(self.record, known, self.metrics, X, X.copy(), reference, J)
        self._calls = dict[Any, Procedure]()

    def procedures(self, code: Code) -> None:
        """Record what ``move``, ``positions`` and ``jacobian`` call; in three dimensions the text
        of the code must have fsipetsc/blocks/cube.c.
        """
        for function in (move, find_places, find_jacobian):
            self._calls[function] = code.procedure(
                f"grid_{function.__name__}", function, self._known
            )

    def move(self, displacement: Array) -> None:
        """Fill a^1 … a^d from the displacement (M, d) [m] of the given nodes."""
        known = self._known.known
        known[:, : known.shape[1] // 2] = displacement
        self._calls[move]()

    def name_faces(self, faces: Iterable[tuple[int, int]]) -> None:
        """Which faces of the range the record's ``turn`` takes, in three dimensions: (axis, index
        along it) each.
        """
        self._cube.name_faces(faces)

    def positions(self) -> Array:
        """x (d, N) [m] after the last `move`."""
        self._calls[find_places]()
        return self._known.places.copy()

    def jacobian(self) -> Array:
        """det(D x) (N,) after the last `move`; around an axis or a centre as in radial_grid."""
        self._calls[find_jacobian]()
        return self._known.J.copy()
