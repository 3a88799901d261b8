"""The grid of a gas block: x = X + the displacements of its faces, blended (fsipetsc.blocks.hull):
Gordon and Hall, Int. J. Numer. Meth. Eng. 7 (1973) 461-477. Its velocity is the same blend of the
faces' velocities.

Around an axis (kappa = 1) or a centre (2) it is a flat grid of (z, s), s = |r|^kappa r/(kappa + 1),
as r^kappa dr = ds; r is the last coordinate. With A = |r|^kappa, the velocity v of the grid, and
D_k of summation by parts,

    b^k, J    metrics and Jacobian of (z, s): J = D s in one dimension, D_1 z D_2 s - D_1 s D_2 z
    a^k       = (b^k_1, A b^k_2), the area vectors
    J_t       = sum_k b^k . D_k w,    w = (v_1, A v_2) = d(z, s)/dt,    exactly that of J
    source S  = sum_k D_k a^k_2;  sum_k D_k a^k_1 = 0

A pressure p that is the same everywhere gives p S to the momentum along r; so much is added again
(fsipetsc.scheme.gas_sweep). J_t is what two-point fluxes let through a node that moves (radial Gas
of fsipetsc.equations.gas). Beside an axis, where A has a kink, D along r has weights of its own
(AXIS of fsipetsc.operators.sbp).
"""

from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Range
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.hull import Blend, Hull, put_on_faces
from fsipetsc.blocks.metrics import Curls, Wide
from fsipetsc.checks import Array
from fsipetsc.kernels.arrays import column, zeros
from fsipetsc.kernels.loops import each, pick
from fsipetsc.kernels.symbols import exact


class Grid(SimpleNamespace):
    """The motion of a range of N nodes of gas block k, on a line or a plane; a record for
    procedures. The W nodes of ``wide`` are those that derivatives reach.

    nodes: (M,) those on faces of the whole block whose displacement and velocity will be given.
    faces: of the range, (axis, index along it), whose turning is wanted in three dimensions.

    metrics: (d d + d, N), a^1 … a^d and the velocity of the grid; around an axis or a centre A is
    one more row. Procedures get known: (M, 2d) displacements [m] and velocities [m/s] of the given
    nodes. like: d zeros, hoops: kappa zeros. x: (d, W) places less those of linear maps, flat: what
    is differentiated; volume: (N,) det D x, by `find_volumes`.
    """

    def __init__(
        self, problem: BlockProblem, k: int, order: int, where: Range, nodes: Array, faces: Any
    ) -> None:
        block, centred, d = problem.blocks[k], problem.centred(k), problem.dimension
        self.like, self.hoops = (0.0,) * d, (0.0,) * problem.symmetry
        about = problem, k, order, where
        self.wide: Any = Curls(*about, faces=faces) if d == 3 else Wide(*about)
        self.hull = Hull(block, nodes, centred)
        self.blend = Blend(block, self.wide, self.hull.nodes, centred)
        self.x = self.flat = zeros(self.wide.y.shape)
        self.volume = np.zeros(self.wide.N)
        self.metrics = zeros((d * d + d + (problem.symmetry > 0), self.wide.N))

    def edge(self, known):
        """Find where the grid's faces are, and a^k on those at constraints, or everywhere if that
        is little work.
        """
        self.hull.fill(self.hull.moved, known, 0)
        self.place()
        self.wide.run("metrics", self.x, self.metrics, self.wide.P)

    def place(self):
        """Find where the nodes are."""
        self.blend.fill(self.hull.moved, self.x, self.blend.every, self.wide.y)

    def move(self):
        """Find where the grid is and a^k, as far as `edge` has not."""

    def swing(self, known):
        """Fill the velocity, after `edge` and `move`."""
        d = len(self.like)
        self.hull.fill(self.hull.moving, known, d)
        self.blend.fill(self.hull.moving, self.metrics[d * d :], self.blend.inner)

    def find_places(self, X, places):
        """Find where nodes are (d, N), after `move`; X: those of the reference map."""
        self.blend.fill(self.hull.moved, places, self.blend.inner, X)

    def find_volumes(self):
        """Find det D x, after `move`."""
        self.wide.run("volume", self.flat, self.volume, self.wide.P)


class Cube(Grid):
    """A grid in three dimensions. moved: (3, W), ahead, back: (9, N) a^k on faces at constraints if
    nodes go on with their velocity for 1 s, and where they were 1 s before.
    """

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.moved = zeros(self.x.shape)
        self.ahead, self.back = np.zeros((2, 9, self.wide.N))

    def edge(self, known):
        self.hull.fill(self.hull.moved, known, 0)
        self.find_faces(self.x, self.hull.moved, self.wide.y, self.metrics)

    def find_faces(self, x, values, base, areas, sign=1.0):
        """Put values of the hull, added to a base, on faces of x, and find a^k there."""
        for c in range(3):
            put_on_faces(x[c], self.blend.every.faces, values[c], base[c], sign)
        self.wide.find(x, areas, 1, self.wide.only.size)

    def move(self):
        self.place()
        self.wide.find(self.x, self.metrics, 0, 1)

    def turn(self):
        """Find ahead and back, after `swing`."""
        for sign, areas in ((1.0, self.ahead), (-1.0, self.back)):
            self.find_faces(self.moved, self.hull.moving, self.x, areas, sign)


class Radial(Grid):
    """A grid around an axis or a centre.

    inner: numbers of the range among the wide nodes. v: (d, W) velocities. area: (W,) A. flat:
    (d, W) z and s, w: their rates, through: A b^k_2 of each axis. b: (d d, W). source: (N,) S;
    turning: (d d, N) d a^k/dt in two dimensions; bounds: (d d + d + 1, N) metrics by which steps
    are bounded.
    """

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        (d, W), N = self.x.shape, self.wide.N
        self.inner, self.area = self.wide.inner(np.arange(W)), np.zeros(W)
        self.flat, self.w, self.through = (zeros((d, W)) for _ in range(3))
        self.v, self.b, self.still = np.zeros((d, W)), np.zeros((d * d, W)), np.zeros((d, d))
        self.source, self.turning, self.bounds = np.zeros(N), np.zeros((d * d, N)), 1 * self.metrics

    def edge(self, known):
        """Complete x, find A and flat, and fill a^k, A, source."""
        self.hull.fill(self.hull.moved, known, 0)
        d, kappa, area = len(self.like), len(self.hoops), self.area
        self.place()
        for n in each(area.size, vector=True):
            *z, r = column(self.like, self.x, n)
            area[n] = A = abs(r) if kappa == 1 else r * r
            self.flat[:, n] = (*z, A * r / (kappa + 1.0))
        self.wide.run("metrics", self.flat, self.b, self.wide.P, everywhere=True)
        for n in each(area.size, vector=True):
            for k in range(d):
                self.through[k, n] = area[n] * self.b[k * d + d - 1, n]
        self.wide.run("divergence", self.through, self.source, self.still)
        for i in each(self.inner.size, vector=True):
            n = self.inner[i]
            self.metrics[d * d + d, i] = area[n]
            for m in range(d * d):
                self.metrics[m, i] = self.b[m, n] * (area[n] if m % d == d - 1 else 1.0)

    def swing(self, known):
        """Velocity of the grid, and turning."""
        self.hull.fill(self.hull.moving, known, len(self.like))
        d, kappa, v, area = len(self.like), len(self.hoops), self.v, self.area
        self.blend.fill(self.hull.moving, v, self.blend.every)
        for i in each(self.inner.size, vector=True):
            self.metrics[d * d : d * d + d, i] = column(self.like, v, self.inner[i])
        if d == 1:  # area vectors do not turn
            return
        for n in each(area.size, vector=True):
            *v_z, v_r = column(self.like, v, n)
            self.w[:, n] = (*v_z, v_r * area[n])
        self.wide.run("metrics", self.w, self.turning, self.still)
        for i in each(self.inner.size, vector=True):
            n = self.inner[i]
            spread = kappa * area[n] / self.x[d - 1, n] * v[d - 1, n]
            for m in range(d - 1, d * d, d):
                self.turning[m, i] = exact(area[n] * self.turning[m, i] + spread * self.b[m, n])

    def bound(self):
        """Fill bounds: metrics, a^k times 1/2 (1 + the largest A of the node and those beside it
        along the axis k, over A).
        """
        d, area, copied, bounds = len(self.like), self.area, self.metrics.reshape(-1), self.bounds
        for m in each(copied.size, vector=True):
            bounds.reshape(-1)[m] = copied[m]
        for k in range(d):
            step, length = self.wide.sizes[0] if k else 1, self.wide.sizes[k]
            for i in each(self.inner.size, vector=True):
                n = self.inner[i]
                at, here = n // step % length, area[n]
                below = area[pick(at > 0, n - step, n)]
                above = area[pick(at < length - 1, n + step, n)]
                largest = np.maximum(np.maximum(here, below), above)
                for c in range(d):
                    bounds[k * d + c, i] *= 0.5 * (1.0 + largest / here)


def grid_of(problem: BlockProblem, *given: Any) -> Grid:
    """The `Grid` of a range of nodes of a gas block (of a rank: the ghosted)."""
    kind = Radial if problem.symmetry else Cube if problem.dimension == 3 else Grid
    return kind(problem, *given)
