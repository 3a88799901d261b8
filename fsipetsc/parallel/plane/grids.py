"""Grids of the layers of a problem in two dimensions, and how ranks share them: plain integers, no communication."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import SBPOperator
from fsipetsc.parallel.partition import apportion, by_physics
from fsipetsc.plane import PlaneProblem

#: points of a rank from which it weighs more that all have the same to do than that they send each other more
BALANCED_FROM = 8192


@dataclass(frozen=True)
class PlaneGrid:
    """nx by ny points from (x0, y0), h_x and h_y apart; column: number of its first one among the problem's columns."""

    nx: int
    ny: int
    x0: float
    y0: float
    h_x: float
    h_y: float
    column: int
    periodic: bool

    def points(self, columns: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(X, Y) [m], each of shape (rows, columns), of points by number."""
        return tuple(np.meshgrid(self.x0 + columns * self.h_x, self.y0 + rows * self.h_y))


def make_grids(problem: PlaneProblem, op: SBPOperator, h: float) -> list[PlaneGrid]:
    """Grids of all layers; InputError where a layer is too thin for the operator or a solid misses the columns of the gas."""
    width = problem.X[1] - problem.X[0]
    cells = max(1, round(width / h))
    h_x = width / cells
    grids = []
    for k, layer in enumerate(problem.layers):
        left, right = problem.span(k)
        first, last = (left - problem.X[0]) / h_x, (right - problem.X[0]) / h_x
        missed = max(abs(first - round(first)), abs(last - round(last))) > 1e-6 * cells
        if missed or not 0 <= round(first) < round(last) <= cells:
            raise InputError(
                f"-fsi_h {h:g} misses an end of layer '{layer.name}' between X = {left:g} and {right:g}: columns are "
                f"{h_x:.6g} apart from X = {problem.X[0]:g} on"
            )
        height = layer.Y[1] - layer.Y[0]
        rows = (layer.cells or max(round(height / h), op.min_points - 1)) + 1
        columns = round(last) - round(first) + (0 if problem.periodic else 1)
        for count, least, what in ((rows, op.min_points, "across"), (columns, op.min_points, "along X")):
            if count < least:
                needed = f"the {op.name} operator needs at least {least}"
                few = ", by its cells" if what == "across" and layer.cells else ""
                raise InputError(f"layer '{layer.name}' has {count} points {what}{few}; {needed}")
        grids.append(PlaneGrid(columns, rows, left, layer.Y[0], h_x, height / (rows - 1), round(first), problem.periodic))
    return grids


@dataclass(frozen=True)
class Share:
    """The ranks of a layer, row by row of blocks, and where columns and rows are cut: blocks go from cut to cut."""

    ranks: tuple[int, ...]
    columns: tuple[int, ...]
    rows: tuple[int, ...]

    def block(self, rank: int) -> tuple[int, int, int, int]:
        """(first column, first column beyond, first row, first row beyond) of a rank."""
        across, along = divmod(self.ranks.index(rank), len(self.columns) - 1)
        return *self.columns[along : along + 2], *self.rows[across : across + 2]

    def owners(self, columns: np.ndarray, row: int) -> np.ndarray:
        """Ranks that own the points of a row."""
        across = int(np.searchsorted(self.rows, row, "right")) - 1
        along = np.searchsorted(self.columns, columns, "right") - 1
        return np.array(self.ranks)[across * (len(self.columns) - 1) + along]


def share_out(
    grids: Sequence[PlaneGrid], kinds: Sequence[str], op: SBPOperator, size: int, mode: str = "auto"
) -> list[Share]:
    """Shares of each layer for ``size`` ranks; InputError, naming the largest number of ranks that would work.

    One rank has all. balanced: each rank a block of each layer. physics: fewer ranks than layers: gases on the lower half of
    the ranks, solids on the upper; else ranks in proportion to points, one layer each, in blocks with short edges. auto:
    balanced where ranks have BALANCED_FROM points and more, and that is possible, else physics.
    """
    caps = [_most(grid, op) for grid in grids]
    even = all(_blocks(grid, op, size) for grid in grids)
    if mode == "balanced" and not even:
        most = next(n for n in range(size, 0, -1) if all(_blocks(grid, op, n) for grid in grids))
        raise InputError(
            f"-fsi_partition balanced: {size} ranks are more than each layer of this grid can feed: with at least "
            f"{_least(op)} by {_least(op)} points on a rank {most} is the largest number that works"
        )
    if mode == "balanced" or (mode == "auto" and even and sum(g.nx * g.ny for g in grids) >= BALANCED_FROM * size):
        return [_cut(grid, op, range(size)) for grid in grids]
    if size < len(grids) or size == 1:
        groups = [[0]] * len(grids) if size == 1 else [[rank] for rank in by_physics(kinds, size)]
    elif size > sum(caps):
        raise InputError(
            f"{size} ranks are more than this grid can feed: with at least {_least(op)} by {_least(op)} points on a rank "
            f"{sum(caps)} is the largest number that works"
        )
    else:
        counts = apportion([grid.nx * grid.ny for grid in grids], caps, size)
        starts = np.cumsum([0, *counts])
        groups = [list(range(a, b)) for a, b in zip(starts[:-1], starts[1:], strict=True)]
        groups = [group[: _feasible(grid, op, len(group))] for grid, group in zip(grids, groups, strict=True)]
    return [_cut(grid, op, group) for grid, group in zip(grids, groups, strict=True)]


def _least(op: SBPOperator) -> int:
    """Points of a block in each direction: halos lie with one neighbour, and closures with the rank that has the end."""
    return op.rows + op.p


def _blocks(grid: PlaneGrid, op: SBPOperator, count: int) -> tuple[int, int] | None:
    """(blocks along X, across) with the shortest cuts, if there are any."""
    most = max(1, grid.nx // _least(op)), max(1, grid.ny // _least(op))
    fits = [(a, count // a) for a in range(1, count + 1) if count % a == 0 and a <= most[0] and count // a <= most[1]]
    return min(fits, key=lambda blocks: (blocks[0] - 1) * grid.ny + (blocks[1] - 1) * grid.nx, default=None)


def _feasible(grid: PlaneGrid, op: SBPOperator, count: int) -> int:
    """The largest number of blocks up to ``count`` that there can be."""
    return next(n for n in range(count, 0, -1) if _blocks(grid, op, n))


def _most(grid: PlaneGrid, op: SBPOperator) -> int:
    return max(1, grid.nx // _least(op)) * max(1, grid.ny // _least(op))


def _cut(grid: PlaneGrid, op: SBPOperator, ranks: Sequence[int]) -> Share:
    """Cut a layer into blocks."""
    along, across = _blocks(grid, op, len(ranks)) or (1, 1)
    cuts = [tuple(round(n * k / parts) for k in range(parts + 1)) for n, parts in ((grid.nx, along), (grid.ny, across))]
    return Share(tuple(ranks), *cuts)
