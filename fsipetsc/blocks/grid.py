"""The grid of a gas block: x = X + the displacements of its faces, blended (fsipetsc.blocks.hull):
Gordon and Hall, Int. J. Numer. Meth. Eng. 7 (1973) 461-477. Its velocity is the same blend of the
faces' velocities. What moves is a record for procedures (fsipetsc.kernels.procedure): of a line, a
plane (fsipetsc.blocks.plane_grid), a cube, and around an axis or a centre.

Around an axis (kappa = 1) or a centre (2) it is a flat grid of (z, s), s = |r|^kappa r/(kappa + 1),
as r^kappa dr = ds; r is the last coordinate. With A = |r|^kappa, the velocity v of the grid, and
D_k of summation by parts,

    b^k, J    metrics and Jacobian of (z, s): J = D s in one dimension, D_1 z D_2 s - D_1 s D_2 z
    a^k       = (b^k_1, A b^k_2), the area vectors
    J_t       = sum_k b^k . D_k w,    w = (v_1, A v_2) = d(z, s)/dt,    exactly that of J
    source S  = sum_k D_k a^k_2;  sum_k D_k a^k_1 = 0

A pressure p that is the same everywhere gives p S to the momentum along r; so much is added again
(fsipetsc.scheme.radial). J_t is what two-point fluxes let through a node that moves (RadialGas of
fsipetsc.equations.gas). Beside an axis, where A has a kink, D along r has weights of its own (AXIS
of fsipetsc.operators.bands).
"""

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block import Block, Range, mesh
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.hull import blend_of, end_weights, hull_of, nothing
from fsipetsc.blocks.metrics import Wide, cube_of, slopes_across, slopes_along
from fsipetsc.blocks.plane_grid import plane_motion
from fsipetsc.checks import Array
from fsipetsc.equations.tensors import cofactor, determinant
from fsipetsc.kernels.arrays import column, zeros
from fsipetsc.kernels.loops import each, invoke, pick
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

    move = nothing
    find_volumes = nothing

    def swing(self, known, metrics):
        """Fill the velocity, after `edge` and `move`."""
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

    def jacobian(self, metrics, node):
        """det(D x) of a node, after `find_volumes`."""
        at_low, at_high = ends_of(self.hull.moved)
        return self.slope[node] + (at_high - at_low)


class CubeMotion(NamedTuple):
    """A grid in three dimensions. blend: on the W wide nodes; wide, range: windows of these and of
    the N nodes. y: (3, W), of a Wide; x, moved: (3, W) places less those of linear maps, volume:
    (N,) det D x. faces: (2, F) wide nodes that derivatives on faces at constraints reach, and their
    columns of the hull; ahead, back: (9, N) a^k there if nodes go on with their velocity for 1 s,
    and where they were 1 s before. address, kept: see `cube_of`.
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
    kept: Any

    def edge(self, known, metrics):
        self.hull.fill(self.hull.moved, known, 0)
        self.put_faces(self.x, self.y, 1.0, self.hull.moved)
        invoke("cube_faces", self.address, self.x, metrics)

    def move(self, metrics):
        """Find where the grid is and a^k, as far as `edge` has not."""
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
        """Find what ``jacobian`` takes."""
        invoke("cube_volumes", self.address, self.x, self.volume)

    def jacobian(self, metrics, node):
        return self.volume[node]


class RadialMotion(NamedTuple):
    """A grid around an axis or a centre; metrics have A as a row after the velocity.

    like: d zeros, hoops: kappa zeros. blend, y, P, S, weight, inner, x, v: as of CubeMotion.
    before: nodes of faster axes between neighbours along each axis. area, slope: (W,), flat: (d, W)
    z and s, or w, b, slopes: (d d, W), room. source, volume: (N,) S and J of the range; turning:
    (d d, N) d a^k/dt in two dimensions; bounds: (d d + d + 1, N) metrics by which steps are
    bounded.
    """

    hull: Any
    like: Any
    hoops: Any
    blend: Any
    wide: Any
    range: Any
    inner: Array
    y: Array
    P: Array
    S: Any
    weight: Any
    before: Any
    area: Array
    slope: Array
    x: Array
    v: Array
    flat: Array
    b: Array
    slopes: Array
    source: Array
    volume: Array
    turning: Array
    bounds: Array

    def edge(self, known, metrics):
        """Complete x, find A and flat, and fill a^k, A, source, volume."""
        self.hull.fill(self.hull.moved, known, 0)
        d, kappa, area, slopes = len(self.like), len(self.hoops), self.area, self.slopes
        last, entries, inner = d - 1, (0.0,) * d * d, self.inner
        self.blend.fill(self.hull.moved, self.x, self.wide)
        for n in each(area.size, vector=True):
            for c in range(d):
                self.x[c, n] += self.y[c, n]
                self.flat[c, n] = self.x[c, n]
            r = self.x[last, n]
            A = abs(r) if kappa == 1 else r * r
            area[n], self.flat[last, n] = A, A * r / (kappa + 1.0)
        differentiate_flat(self)
        for n in each(area.size, vector=True):
            for k in range(d):
                for c in range(last):
                    slopes[k * d + c, n] += self.P[k, c]
            for m, b in enumerate(cofactor(column(entries, slopes, n))):
                self.b[m, n] = b
        for i in each(inner.size, vector=True):
            n = inner[i]
            self.source[i] = 0.0
            self.volume[i] = exact(determinant(column(entries, slopes, n)))
            metrics[d * d + d, i] = area[n]
            for m in range(d * d):
                metrics[m, i] = self.b[m, n] * (area[n] if m % d == last else 1.0)
        for k in range(d):
            through = self.flat[0]
            for n in each(area.size, vector=True):
                through[n] = area[n] * self.b[k * d + last, n]
            differentiate(self, k, self.slope, through)
            for i in each(inner.size, vector=True):
                self.source[i] += self.slope[inner[i]]

    move = nothing
    find_volumes = nothing

    def swing(self, known, metrics):
        """Velocity of the grid, and turning."""
        self.hull.fill(self.hull.moving, known, len(self.like))
        d, kappa, v, area = len(self.like), len(self.hoops), self.v, self.area
        last, entries = d - 1, (0.0,) * d * d
        self.blend.fill(self.hull.moving, v, self.wide)
        for i in each(self.inner.size, vector=True):
            for c in range(d):
                metrics[d * d + c, i] = v[c, self.inner[i]]
        if d == 1:  # area vectors do not turn
            return
        for n in each(area.size, vector=True):
            for c in range(d):
                self.flat[c, n] = v[c, n] * (area[n] if c == last else 1.0)
        differentiate_flat(self)
        for i in each(self.inner.size, vector=True):
            n = self.inner[i]
            slopes, b = column(entries, self.slopes, n), column(entries, self.b, n)
            spread = kappa * area[n] / self.x[last, n] * v[last, n]
            for m, turned in enumerate(cofactor(slopes)):
                more = exact(area[n] * turned + spread * b[m])
                self.turning[m, i] = more if m % d == last else turned

    def find_places(self, X, places):
        self.blend.fill(self.hull.moved, places, self.range, X)

    def jacobian(self, metrics, node):
        return self.volume[node]

    def bound(self, metrics):
        """Fill bounds: metrics, a^k times 1/2 (1 + the largest A of the node and those beside it
        along the axis k, over A).
        """
        d, area, copied, bounds = len(self.like), self.area, metrics.reshape(-1), self.bounds
        for m in each(copied.size, vector=True):
            bounds.reshape(-1)[m] = copied[m]
        for k in range(d):
            step, length = 1 if k == 0 else self.before[k], self.weight[k].shape[0]
            for i in each(self.inner.size, vector=True):
                n = self.inner[i]
                at, here = n // step % length, area[n]
                below = area[pick(at > 0, n - step, n)]
                above = area[pick(at < length - 1, n + step, n)]
                largest = np.maximum(np.maximum(here, below), above)
                for c in range(d):
                    bounds[k * d + c, i] *= 0.5 * (1.0 + largest / here)


def differentiate(grid, k, out, f):
    """out = D_k f, both (W,)."""
    if k == 0:
        slopes_along(out, f, grid.S[k], grid.weight[k])
    else:
        slopes_across(out, f, grid.S[k], grid.weight[k], grid.before[k])


def differentiate_flat(grid):
    """slopes: D_k of both components of flat."""
    d = len(grid.like)
    for k in range(d):
        for c in range(d):
            differentiate(grid, k, grid.slopes[k * d + c], grid.flat[c])


def motion_of(
    problem: BlockProblem, k: int, order: int, where: Range, nodes: Array, faces: Any
) -> tuple[Any, Array]:
    """The motion of a range of nodes of gas block k (of a rank: the ghosted), and its metrics.

    nodes: numbers (M,) of those nodes on faces of the whole block whose displacement and velocity
    will be given, in any order. faces: of the range, (axis, index along it), whose turning is
    wanted in three dimensions.
    """
    block, d, centred = problem.blocks[k], problem.dimension, problem.centred(k)
    wide, hull = Wide(problem, k, order, where), hull_of(block, nodes, centred)
    W, inner = wide.y.shape[1], wide.inner(np.arange(wide.y.shape[1]))
    metrics = zeros((d * d + d + (problem.symmetry > 0), inner.size))
    if d == 2 and not problem.symmetry:
        return plane_motion(block, wide, hull), metrics
    if d == 1 and not problem.symmetry:
        weights = end_weights(block, 0, np.arange(*where[0]))[:, 0]
        return LineMotion(hull, *weights, np.ascontiguousarray(wide.gradients()[0, 0])), metrics
    windows = blend_of(block, wide, hull.nodes, centred)
    if d == 3:
        room = *zeros((2, 3, W)), np.zeros(inner.size), _on_faces(block, wide, hull, faces)
        areas = np.zeros((2, 9, inner.size))
        return CubeMotion(hull, *windows, wide.y, *room, *areas, *cube_of(wide, faces)), metrics
    of_map = wide.y, wide.P, wide.S, wide.weight, tuple((1, *wide.sizes[:-1]))
    room = *np.zeros((2, W)), *np.zeros((3, d, W)), *np.zeros((2, d * d, W))
    of_range = *np.zeros((2, inner.size)), np.zeros((d * d, inner.size)), np.zeros(metrics.shape)
    hoops = (0.0,) * problem.symmetry
    return RadialMotion(
        hull, (0.0,) * d, hoops, *windows, inner, *of_map, *room, *of_range
    ), metrics


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
