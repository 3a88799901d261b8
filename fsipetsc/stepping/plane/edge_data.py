"""What a case gives in two dimensions in every stage: unknowns at edges, forcing, what interfaces supply."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc import given
from fsipetsc.boundaries import plane as edges
from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.physics.plane.layer import DOF
from fsipetsc.scheme.plane.joints import NUMBERS, SET, STILL_X, STILL_Y, WARM
from fsipetsc.stepping.plane.motion import MovingEdge

if TYPE_CHECKING:
    from fsipetsc.stepping.plane.part import LayerPart
    from fsipetsc.stepping.plane.watched import Probe


@dataclass(frozen=True)
class Hold:
    """What an edge does to some points: where their unknowns begin among all, what holds them and the numbers for that, as
    fsipetsc.scheme.plane.joints has them. numbers: of time [s]; timed: whether they depend on it.
    """

    places: np.ndarray
    what: int
    numbers: Callable[[float], tuple] | None = None
    timed: bool = False


class EdgeData:
    """What is set at edges, and forcing: functions of the case's, asked for here, with what they mean for the unknowns.

    One for each run; ``refresh``, ``lay`` and ``force`` are not collective, and raise InputError on this rank alone.
    """

    def __init__(self, layout: PlaneLayout, instant: Callable[[], float] = lambda: 1e-4) -> None:
        """instant: says a time [s] in which little happens, for differences in time."""
        self._layout = layout
        self._sticking: dict[int, list[Place]] = {k: [] for k in range(len(layout.grids))}
        self._moving: dict[int, list[MovingEdge]] = {k: [] for k in range(len(layout.grids))}
        holds: list[list[Hold]] = [[] for _ in layout.grids]
        for k, layer in enumerate(layout.problem.layers):
            if layout.dms[k] is None:
                continue
            record, problem = layout.records[k], layout.problem
            for side in range(2):
                row = int(record["end_y"][side])
                end = problem.edge(k, side) or getattr(layer, "beside", None)
                if edges.moves(end):
                    self._moving[k].append(MovingEdge(layout, k, side, end, instant))
                if 0 <= row < record["height"] and end is not None:
                    columns = np.arange(record["width"])
                    if record["edge_y"][side] < 0:  # beside an interface
                        a, b = record["face"][side]
                        columns = columns[(columns < a) | (columns >= b)]
                    holds[k] += self._holds(k, end, np.full(columns.size, row), columns, 1)
                column = int(record["end_x"][side])
                if 0 <= column < record["width"]:
                    rows = np.arange(record["height"])
                    holds[k] += self._holds(k, (layer.left, layer.right)[side], rows, np.full(rows.size, column), 0)
        #: of each layer (n, 2), where the unknowns of a point begin, what holds it; and (n, NUMBERS)
        self.held = [_together(of_layer) for of_layer in holds]
        self._timed = [_timed(of_layer, numbers) for of_layer, (_, numbers) in zip(holds, self.held, strict=True)]

    def _holds(self, k: int, end: edges.Edge, rows: np.ndarray, columns: np.ndarray, normal: int) -> list[Hold]:
        """What an edge does to some points of layer k; normal: 0 for an edge in X, 1 in Y."""
        layer, record, grid = self._layout.problem.layers[k], self._layout.records[k], self._layout.grids[k]
        places = (rows * int(record["width"]) + columns) * DOF
        X, Y = grid.x0 + (record["first_x"] + columns) * grid.h_x, grid.y0 + (record["first_y"] + rows) * grid.h_y
        if not rows.size:
            return []
        if end.kind == edges.CLAMPED:
            return [Hold(places, STILL_X | STILL_Y)]
        if end.kind == edges.ROLLER:
            return [Hold(places, STILL_Y if normal == 1 else STILL_X)]
        if end.kind == edges.GIVEN:
            return [Hold(places, SET, partial(_given, layer, end, X, Y), True)]
        if end.kind != edges.NO_SLIP:
            return []
        self._sticking[k].append((rows, columns))
        if end.T is None:
            return [Hold(places, STILL_X | STILL_Y)]
        if callable(end.T):
            return [Hold(places, STILL_X | STILL_Y | WARM, partial(_wall_temperature, layer, end.T, X, Y), True)]
        return [Hold(places, STILL_X | STILL_Y | WARM, lambda t: (end.T,))]

    def refresh(self, k: int, t: float) -> None:
        """Let ``held`` of layer k be that at time t [s]."""
        for numbers, of_time in self._timed[k]:
            _set(numbers, of_time(t))

    def moves(self, k: int) -> bool:
        """Whether an edge of layer k moves by itself."""
        return bool(self._moving[k])

    def lay(self, part: LayerPart, t: float) -> None:
        """Let edges that move be where they are at time t [s], and the gas that sticks to them move with them."""
        for edge in self._moving[part.k]:
            edge.lay(part, t)

    def begin(self, part: LayerPart, q: np.ndarray) -> None:
        """Let initial data of a gas, (rows, columns, DOF) of the points that are owned, have the velocity of walls that it
        sticks to, as the part holds it, at the temperature that is given for it.
        """
        (bottom, top), (left, right) = part.record["own_y"], part.record["own_x"]
        for rows, columns in self._sticking[part.k]:
            mine = (rows >= bottom) & (rows < top) & (columns >= left) & (columns < right)
            at = rows[mine] - bottom, columns[mine] - left
            stuck, old = part.own[at], q[at]
            change = np.sum(stuck[:, 2:4] ** 2 - old[:, 2:4] ** 2, axis=1) / (2.0 * old[:, 1])
            q[(*at, 2)], q[(*at, 3)], q[(*at, 4)] = stuck[:, 2], stuck[:, 3], old[:, 4] + change

    def push(self, part: LayerPart, rates: np.ndarray) -> None:
        """Add to the rates of the points that are owned what moving walls do to the gas that sticks to them."""
        for edge in self._moving[part.k]:
            edge.push(part, rates)

    def force(self, part: LayerPart | Probe, t: float, rates: np.ndarray) -> None:
        """Add forcing to the rates of the points that are owned, or of those of a probe."""
        layer, jumps = self._layout.problem.layers[part.k], self._layout.problem.jumps
        if jumps is not None and layer.kind == "solid":
            self._supply(part, t, rates.reshape(part.own.shape))
        if layer.forcing is None:
            return
        X, Y = self._layout.grids[part.k].points(part.columns, part.rows)
        f = rates.reshape(part.own.shape)
        values = given.plane_fields(layer, "forcing", X, Y, t)
        if layer.kind == "fluid":
            for c, value in enumerate(values):
                f[..., c + 1] += part.own[..., 0] * value
        else:
            for c, value in zip((2, 3, 4, 0, 1), values, strict=True):
                f[..., c] += value

    def _supply(self, part: LayerPart | Probe, t: float, f: np.ndarray) -> None:
        """What interfaces supply from outside, to the end points of the solid."""
        record, grid = part.record, self._layout.grids[part.k]
        for number, side in part.sides():
            row = int(record["end_y"][side] - record["own_y"][0])
            if 0 <= row < len(f):
                x, y, heat = given.supplied(self._layout.problem, number, grid.x0 + part.columns * grid.h_x, t)
                per_mass = 1.0 / (part.end_weight * record["h_y"] * record["m0"])
                f[row, :, 2] += per_mass * x
                f[row, :, 3] += per_mass * y
                f[row, :, 4] += per_mass * heat / record["alpha"]


Place = tuple[np.ndarray, np.ndarray]


def _together(holds: list[Hold]) -> tuple[np.ndarray, np.ndarray]:
    """(n, 2) and (n, NUMBERS), the points of several edges one after another; numbers that depend on time are not there yet."""
    held = [np.stack([hold.places, np.full(hold.places.size, hold.what)], axis=1) for hold in holds]
    numbers = np.zeros((sum(len(points) for points in held), NUMBERS))
    at = 0
    for hold in holds:
        if hold.numbers is not None and not hold.timed:
            _set(numbers[at : at + hold.places.size], hold.numbers(0.0))
        at += hold.places.size
    return np.concatenate([np.empty((0, 2), np.int64), *held]), numbers


def _timed(holds: list[Hold], numbers: np.ndarray) -> list[tuple[np.ndarray, Callable[[float], tuple]]]:
    """Of those among ``_together`` that depend on time, the numbers' place and what knows them."""
    ends = np.cumsum([0, *(hold.places.size for hold in holds)])
    return [(numbers[a:b], hold.numbers) for hold, a, b in zip(holds, ends[:-1], ends[1:], strict=True) if hold.timed]


def _set(numbers: np.ndarray, columns: tuple) -> None:
    for c, column in enumerate(columns):
        numbers[:, c] = column


def _wall_temperature(layer: Any, T: Callable, X: np.ndarray, Y: np.ndarray, t: float) -> tuple:
    """(T,) of a wall."""
    return (given.wall_temperature(layer, T, X, Y, t),)


def _given(layer: Any, end: edges.Given, X: np.ndarray, Y: np.ndarray, t: float) -> tuple:
    """What the case says of all unknowns: (x, y, u, v, T) of a solid, displacements; (rho, u, v, e / rho) of a gas."""
    values = given.edge_values(layer, end.values, X, Y, t)
    if layer.kind == "solid":
        u, v, T, x, y = values
        return x - X, y - Y, u, v, T
    rho, u, v, T = values
    return rho, u, v, layer.material.internal_energy(rho, T) + 0.5 * (u * u + v * v)
