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
from fsipetsc.blocks.metrics import differentiate
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.checks import Array
from fsipetsc.operators.loops import CALL


class RadialGrid(NamedTuple):
    """Of a range of nodes, and in wider arrays of as many more as differences need.

    S, weight: of the band. X, low, high: places at rest and weights of the ends' displacements.
    first: where the range begins. r, v, area, slope, product: room. source, volume: (N,) S and J of
    the range; bounds: (3, N) its metrics with the largest area between a node and its neighbours,
    by which steps are bounded. hoops: kappa zeros.
    """

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

    def places(self) -> Array:
        """r (1, N) after the last `move`."""
        return self.r[None, self.first : self.first + self.source.size]


def radial_grid(problem: BlockProblem, k: int, order: int, where: Range) -> RadialGrid:
    """Of a range of nodes of block k; images before a centre have numbers below 0."""
    ((begin, end),) = where
    band, n = problem.band(k, order, 0), problem.blocks[k].shape[0]
    least = -n if problem.centred(k) else 0
    first, beyond = max(begin - band.reach, least), min(end + band.reach, n)
    i, cells = np.arange(first, beyond), n - 1
    low, high = (cells - i) / cells, i / cells
    if problem.centred(k):
        low, high = 0.0 * i, (i + 0.5) / (cells + 0.5)
    X = problem.positions(k, [(first, beyond)])[0]
    room = [np.zeros(i.size) for _ in range(5)]
    of_range = [np.zeros(end - begin) for _ in range(2)]
    cut, hoops = band.part(first, beyond), (0.0,) * problem.symmetry
    bounds = np.zeros((3, end - begin))
    return RadialGrid(*cut, X, low, high, begin - first, *room, *of_range, bounds, hoops)


@njit(**CALL)
def radial_metrics(grid, metrics, moved):
    """Fill A, and source, volume, bounds; moved: (1, ends) displacements."""
    at_low = moved[0, 0] if moved.size > 0 else 0.0
    at_high = moved[0, -1] if moved.size > 0 else 0.0
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
def radial_velocities(grid, metrics, moving):
    """Fill v and J_t from the velocities (1, ends)."""
    at_low = moving[0, 0] if moving.size > 0 else 0.0
    at_high = moving[0, -1] if moving.size > 0 else 0.0
    v = grid.v
    for i in range(grid.r.size):
        v[i] = grid.low[i] * at_low + grid.high[i] * at_high
        grid.product[i] = grid.area[i] * v[i]
    differentiate(grid.slope, grid.product, grid.S, grid.weight, 1)
    for i in range(grid.source.size):
        metrics[1, i] = grid.bounds[1, i] = v[grid.first + i]
        metrics[2, i] = grid.slope[grid.first + i]


class RadialMotion(NamedTuple):
    """The same for compiled code: see fsipetsc.blocks.grid.LineMotion."""

    given: Array
    columns: Array
    weights: Array
    moved: Array
    moving: Array
    grid: RadialGrid

    def move(self, known, metrics):
        """Fill A from displacements and velocities known (M, 2) of the given nodes."""
        from_hull(self, known, 0, self.moved)
        radial_metrics(self.grid, metrics, self.moved)

    def swing(self, known, metrics):
        """Velocity of the grid and J_t."""
        from_hull(self, known, 1, self.moving)
        radial_velocities(self.grid, metrics, self.moving)

    def find_places(self, X, places):
        """Nobody asks for them."""
        return None

    def jacobian(self, metrics, N, node, reference):
        """J of the grid at a node."""
        return self.grid.volume[node]


@njit(**CALL)
def from_hull(motion, known, first, values):
    """values (1, ends) from known (M, 2)."""
    for m in range(motion.given.size):
        values[0, motion.given[m]] = known[m, first]
