"""The grid of a gas around an axis (kappa = 1) or a centre (2), in one dimension, r, or around an
axis in two, (z, r): X + the displacements of faces, blended; r is the last coordinate.

It is a flat grid of (z, s), s = |r|^kappa r/(kappa + 1), as r^kappa dr = ds. With A = |r|^kappa,
the velocity v of the grid, and D_k of summation by parts,

    b^k, J    metrics and Jacobian of (z, s): J = D s in one dimension, D_1 z D_2 s - D_1 s D_2 z
    a^k       = (b^k_1, A b^k_2), the area vectors
    J_t       = sum_k b^k . D_k w,    w = (v_1, A v_2) = d(z, s)/dt,    exactly that of J
    source S  = sum_k D_k a^k_2;  sum_k D_k a^k_1 = 0

A pressure p that is the same everywhere gives p S to the momentum along r; so much is added again
(fsipetsc.scheme.radial). J_t is what two-point fluxes let through a node that moves (RadialGas of
fsipetsc.equations.gas). Beside an axis, where A has a kink, D along r has weights of its own (AXIS
of fsipetsc.operators.coefficients).
"""

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.hull import Hull, blend_of
from fsipetsc.blocks.metrics import Wide, differentiate
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.checks import Array
from fsipetsc.equations.tensors import cofactor, determinant, outer
from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import CALL, column, dot


class RadialMotion(NamedTuple):
    """See fsipetsc.blocks.grid.LineMotion; metrics have A as a row before J_t.

    like: d zeros, hoops: kappa zeros. blend, y, P, S, weight, inner, x, v: as of CubeMotion.
    before: nodes of faster axes between neighbours along each axis. area, slope: (W,), flat: (d, W)
    z and s, or w, b, slopes: (d d, W), room. source, volume: (N,) S and J of the range; turning:
    (d d, N) d a^k/dt in two dimensions; bounds: (d d + d + 2, N) metrics by which steps are
    bounded.
    """

    hull: Any
    like: Any
    hoops: Any
    blend: Any
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

    def move(self, known, metrics):
        """Fill a^k, A, and source, volume."""
        self.hull.fill(self.hull.moved, known, 0)
        radial_metrics(self, metrics)

    def swing(self, known, metrics):
        """Velocity of the grid and J_t, and turning."""
        self.hull.fill(self.hull.moving, known, len(self.like))
        radial_velocities(self, metrics)

    def find_places(self, X, places):
        """X + the displacement."""
        for i in range(self.inner.size):
            for c in range(len(self.like)):
                n = self.inner[i]
                places[c, i] = X[c, i] + (self.x[c, n] - self.y[c, n])

    def jacobian(self, metrics, N, node, reference):
        """J of the grid at a node."""
        return self.volume[node]

    def bound(self, metrics):
        """Fill bounds: metrics, a^k times 1/2 (1 + the largest A of the node and those beside it
        along the axis k, over A).
        """
        bound_steps(self, metrics)


def radial_motion(problem: BlockProblem, k: int, wide: Wide, hull: Hull) -> RadialMotion:
    """Of a range of nodes of block k; images before a centre have numbers below 0."""
    d, W, inner = problem.dimension, wide.y.shape[1], wide.inner(np.arange(wide.y.shape[1]))
    blend = blend_of(problem.blocks[k], wide, hull.nodes, problem.centred(k))
    of_map = wide.y, wide.P, wide.S, wide.weight, tuple((1, *wide.sizes[:-1]))
    room = *np.zeros((2, W)), *np.zeros((3, d, W)), *np.zeros((2, d * d, W))
    of_range = *np.zeros((2, inner.size)), np.zeros((d * d, inner.size))
    bounds, hoops = np.zeros((d * d + d + 2, inner.size)), (0.0,) * problem.symmetry
    return RadialMotion(hull, (0.0,) * d, hoops, blend, inner, *of_map, *room, *of_range, bounds)


@njit(**CALL)
def differentiate_flat(grid):
    """slopes: D_k of both components of flat."""
    d = len(grid.like)
    for k in range(d):
        for c in range(d):
            S, weight, before = grid.S[k], grid.weight[k], grid.before[k]
            differentiate(grid.slopes[k * d + c], grid.flat[c], S, weight, before)


@njit(**CALL)
def radial_metrics(grid, metrics):
    """See RadialMotion.move."""
    d, kappa, x, area, flat = len(grid.like), len(grid.hoops), grid.x, grid.area, grid.flat
    last, nine = d - 1, outer(grid.like, grid.like)
    grid.blend.fill(grid.hull.moved, x)
    for n in range(area.size):
        for c in range(d):
            x[c, n] += grid.y[c, n]
            flat[c, n] = x[c, n]
        r = x[last, n]
        area[n] = abs(r) if kappa == 1 else r * r
        flat[last, n] = area[n] * r / (kappa + 1)
    differentiate_flat(grid)
    for n in range(area.size):
        for k in range(d):
            for c in range(last):
                grid.slopes[k * d + c, n] += grid.P[k, c]
        b = cofactor(column(nine, grid.slopes, n))
        for m in range(d * d):
            grid.b[m, n] = b[m]
    for i in range(grid.inner.size):
        n = grid.inner[i]
        grid.source[i], grid.volume[i] = 0.0, determinant(column(nine, grid.slopes, n))
        metrics[d * d + d, i] = area[n]
        for m in range(d * d):
            metrics[m, i] = grid.b[m, n] * (area[n] if m % d == last else 1.0)
    for k in range(d):
        for n in range(area.size):
            flat[0, n] = area[n] * grid.b[k * d + last, n]
        differentiate(grid.slope, flat[0], grid.S[k], grid.weight[k], grid.before[k])
        for i in range(grid.inner.size):
            grid.source[i] += grid.slope[grid.inner[i]]


@njit(**CALL)
def radial_velocities(grid, metrics):
    """See RadialMotion.swing."""
    d, kappa, v, area, flat = len(grid.like), len(grid.hoops), grid.v, grid.area, grid.flat
    last, nine = d - 1, outer(grid.like, grid.like)
    grid.blend.fill(grid.hull.moving, v)
    for n in range(area.size):
        for c in range(d):
            flat[c, n] = v[c, n] * (area[n] if c == last else 1.0)
    differentiate_flat(grid)
    for i in range(grid.inner.size):
        n = grid.inner[i]
        slopes = column(nine, grid.slopes, n)
        metrics[d * d + d + 1, i] = dot(column(nine, grid.b, n), slopes)
        for c in range(d):
            metrics[d * d + c, i] = v[c, n]
        b, spread = cofactor(slopes), kappa * area[n] / grid.x[last, n] * v[last, n]
        for m in range(d * d if d == 2 else 0):
            grid.turning[m, i] = b[m]
            if m % d == last:
                grid.turning[m, i] = area[n] * b[m] + spread * grid.b[m, n]


@njit(**CALL)
def bound_steps(grid, metrics):
    """See RadialMotion.bound."""
    d, area = len(grid.like), grid.area
    for m in range(metrics.shape[0]):
        for i in range(grid.inner.size):
            grid.bounds[m, i] = metrics[m, i]
    for k in range(d):
        for i in range(grid.inner.size):
            n = grid.inner[i]
            here, step, length = area[n], grid.before[k], grid.weight[k].size
            at = n // step % length
            below = area[n - step] if at > 0 else here
            above = area[n + step] if at < length - 1 else here
            for c in range(d):
                grid.bounds[k * d + c, i] *= 0.5 * (1.0 + max(here, below, above) / here)
