"""The lower or upper edge of a problem that moves as its case says, over a gas: the line of the grid, what sticks to it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc import given
from fsipetsc.boundaries.plane import NO_SLIP
from fsipetsc.parallel.plane.layout import PlaneLayout

if TYPE_CHECKING:
    from fsipetsc.boundaries.plane import Edge
    from fsipetsc.stepping.plane.part import LayerPart


class MovingEdge:
    """The edge ``end`` of layer k at its lower (0) or upper side, for all columns that this rank holds.

    instant: a time [s] in which little happens. Not collective; ``lay`` raises InputError on this rank alone.
    """

    def __init__(self, layout: PlaneLayout, k: int, side: int, end: Edge, instant: Callable[[], float]) -> None:
        grid, record = layout.grids[k], layout.records[k]
        columns = layout.held(k)[0]
        columns = columns % grid.nx if grid.periodic else columns
        self._X, self._layer = grid.x0 + columns * grid.h_x, layout.problem.layers[k]
        self._side, self._end, self._instant = side, end, instant
        self._row = int(record["end_y"][side])
        self._held, own = 0 <= self._row < record["height"], record["own_y"]
        self._owned = own[0] <= self._row < own[1]
        self._across = self._row - int(own[0])
        self._along = slice(*record["own_x"])
        self._motion = np.zeros((6, self._X.size))

    def lay(self, part: LayerPart, t: float) -> None:
        """Let the line of the grid be where the edge is at time t [s], and the gas stick to it, if it does."""
        self._motion[:] = given.plane_motion(self._layer, self._end, self._X, t, self._instant())
        line, (x, y, u, v, _, _) = part.line(self._side), self._motion
        line[0], line[1], line[2], line[3] = x - self._X, y, u, v
        if self._held and self._end.kind == NO_SLIP:
            q = part.held[self._row]
            q[:, 2], q[:, 3] = q[:, 1] * u, q[:, 1] * v
            if self._end.T is not None:  # its internal energy is there
                q[:, 4] += 0.5 * q[:, 1] * (u * u + v * v)

    def push(self, part: LayerPart, rates: np.ndarray) -> None:
        """Let the gas that sticks to it be accelerated with it: what that takes acts on its momentum and does work."""
        if not (self._owned and self._end.kind == NO_SLIP):
            return
        q, f = part.own[self._across], rates.reshape(part.own.shape)[self._across]
        _, _, u, v, a_x, a_y = self._motion[:, self._along]
        x, y = q[:, 1] * a_x + u * f[:, 1] - f[:, 2], q[:, 1] * a_y + v * f[:, 1] - f[:, 3]
        f[:, 2] += x
        f[:, 3] += y
        f[:, 4] += u * x + v * y
        part.gain(np.arange(*part.record["own_x"]), x, y, u * x + v * y)
