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
of fsipetsc.operators.bands).
"""

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.hull import Hull, blend_of
from fsipetsc.blocks.metrics import Wide, slopes_across, slopes_along
from fsipetsc.checks import Array
from fsipetsc.equations.tensors import cofactor, determinant
from fsipetsc.kernels.arrays import column
from fsipetsc.kernels.loops import each, pick
from fsipetsc.kernels.symbols import exact


class RadialMotion(NamedTuple):
    """See fsipetsc.blocks.grid.LineMotion; metrics have A as a row after the velocity.

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
        """Fill a^k, A, and source, volume."""
        self.hull.fill(self.hull.moved, known, 0)
        d, area, slopes, inner = len(self.like), self.area, self.slopes, self.inner
        last, entries = d - 1, (0.0,) * d * d
        self.blend.fill(self.hull.moved, self.x, self.wide)
        find_flat(self)
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

    def move(self, metrics):
        """`edge` has found all."""

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
        """Where nodes are after `move` (d, N); X: those of the reference map."""
        self.blend.fill(self.hull.moved, places, self.range, X)

    def find_volumes(self):
        """`edge` has found them."""

    def jacobian(self, metrics, node):
        """J of the grid at a node."""
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


def radial_motion(problem: BlockProblem, k: int, wide: Wide, hull: Hull) -> RadialMotion:
    """Of a range of nodes of block k; images before a centre have numbers below 0."""
    d, W, inner = problem.dimension, wide.y.shape[1], wide.inner(np.arange(wide.y.shape[1]))
    blend = blend_of(problem.blocks[k], wide, hull.nodes, problem.centred(k))
    of_map = wide.y, wide.P, wide.S, wide.weight, tuple((1, *wide.sizes[:-1]))
    room = *np.zeros((2, W)), *np.zeros((3, d, W)), *np.zeros((2, d * d, W))
    of_range = *np.zeros((2, inner.size)), np.zeros((d * d, inner.size))
    bounds, hoops = np.zeros((d * d + d + 1, inner.size)), (0.0,) * problem.symmetry
    return RadialMotion(hull, (0.0,) * d, hoops, *blend, inner, *of_map, *room, *of_range, bounds)


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


def find_flat(grid):
    """Complete x, and find A and flat, (z, s)."""
    d, kappa, x = len(grid.like), len(grid.hoops), grid.x
    for n in each(grid.area.size, vector=True):
        for c in range(d):
            x[c, n] += grid.y[c, n]
            grid.flat[c, n] = x[c, n]
        r = x[d - 1, n]
        area = abs(r) if kappa == 1 else r * r
        grid.area[n], grid.flat[d - 1, n] = area, area * r / (kappa + 1.0)
