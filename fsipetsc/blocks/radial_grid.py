"""The grid of a gas around an axis (kappa = 1) or a centre (2): r = X + the displacements of the
ends, linear between them; that of a centre is 0.

With the area A = |r|^kappa of a node, the velocity v of the grid, and D of summation by parts,

    J = D(A r)/(kappa + 1),    J_t = D(A v),    source S = D A.

A pressure p that is the same everywhere gives D(A p) = p S to the momentum; so much is added again
(fsipetsc.scheme.radial). J_t is what two-point fluxes let through a node that moves (RadialGas of
fsipetsc.equations.gas), and exactly that of J. Source: SCHEME-BLOCKS.md, section 6.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from fsipetsc.blocks.block import Range
from fsipetsc.blocks.hull import Hull
from fsipetsc.blocks.metrics import differentiate
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.checks import Array
from fsipetsc.operators.loops import CALL


class RadialMotion(NamedTuple):
    """See fsipetsc.blocks.grid.LineMotion. Arrays are of a range of nodes, or in wider arrays of as
    many more as differences need, where it begins at `first`.

    S, weight: of the band. X, low, high: places at rest and weights of the ends' displacements. r,
    v, area, slope, product: room. source, volume: (N,) S and J of the range; bounds: (3, N) its
    metrics with the largest area between a node and its neighbours, by which steps are bounded.
    hoops: kappa zeros.
    """

    hull: Any
    S: Array
    weight: Array
    X: Array
    low: Array
    high: Array
    first: int
    r: Array
    v: Array
    area: Array
    slope: Array
    product: Array
    source: Array
    volume: Array
    bounds: Array
    hoops: Any

    def move(self, known, metrics):
        """Fill A, and source, volume, bounds."""
        self.hull.fill(self.hull.moved, known, 0)
        radial_metrics(self, metrics, *self.hull.ends(self.hull.moved))

    def swing(self, known, metrics):
        """Velocity of the grid and J_t."""
        self.hull.fill(self.hull.moving, known, 1)
        radial_velocities(self, metrics, *self.hull.ends(self.hull.moving))

    def find_places(self, X, places):
        """r."""
        places[0, :] = self.r[self.first : self.first + self.source.size]

    def jacobian(self, metrics, N, node, reference):
        """J of the grid at a node."""
        return self.volume[node]


def radial_motion(
    problem: BlockProblem, k: int, order: int, where: Range, hull: Hull
) -> RadialMotion:
    """Of a range of nodes of block k; images before a centre have numbers below 0."""
    ((begin, end),) = where
    band, n = problem.band(k, order, 0), problem.blocks[k].shape[0]
    least = -n if problem.centred(k) else 0
    first, beyond = max(begin - band.reach, least), min(end + band.reach, n)
    i, cells = np.arange(first, beyond), n - 1
    low, high = (cells - i) / cells, i / cells
    if problem.centred(k):
        low, high = 0.0 * i, (i + 0.5) / (cells + 0.5)
    X, room = problem.positions(k, [(first, beyond)])[0], np.zeros((5, i.size))
    of_range, hoops = np.zeros((5, end - begin)), (0.0,) * problem.symmetry
    of_axis = *band.part(first, beyond), X, low, high, begin - first
    return RadialMotion(hull, *of_axis, *room, of_range[0], of_range[1], of_range[2:], hoops)


@njit(**CALL)
def radial_metrics(grid, metrics, at_low, at_high):
    """A, source, volume, bounds from the displacements of both ends."""
    kappa, r, area, first = len(grid.hoops), grid.r, grid.area, grid.first
    for i in range(r.size):
        r[i] = grid.X[i] + (grid.low[i] * at_low + grid.high[i] * at_high)
        area[i] = abs(r[i]) if kappa == 1 else r[i] * r[i]
        grid.product[i] = area[i] * r[i]
    differentiate(grid.slope, area, grid.S, grid.weight, 1)
    for i in range(grid.source.size):
        grid.source[i] = grid.slope[first + i]
    differentiate(grid.slope, grid.product, grid.S, grid.weight, 1)
    for i in range(grid.source.size):
        here = first + i
        grid.volume[i] = grid.slope[here] / (kappa + 1)
        beside = max(area[max(here - 1, 0)], area[min(here + 1, area.size - 1)])
        metrics[0, i] = area[here]
        grid.bounds[0, i] = 0.5 * (area[here] + max(beside, area[here]))


@njit(**CALL)
def radial_velocities(grid, metrics, at_low, at_high):
    """v and J_t from the velocities of both ends."""
    v = grid.v
    for i in range(grid.r.size):
        v[i] = grid.low[i] * at_low + grid.high[i] * at_high
        grid.product[i] = grid.area[i] * v[i]
    differentiate(grid.slope, grid.product, grid.S, grid.weight, 1)
    for i in range(grid.source.size):
        metrics[1, i] = grid.bounds[1, i] = v[grid.first + i]
        metrics[2, i] = grid.slope[grid.first + i]
