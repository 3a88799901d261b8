"""What a case gives in two dimensions in every stage: unknowns at edges, forcing, what interfaces supply."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc import given
from fsipetsc.boundaries import plane as edges
from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.stepping.plane.motion import MovingEdge

if TYPE_CHECKING:
    from fsipetsc.stepping.plane.path import LayerPart
    from fsipetsc.stepping.plane.watched import Probe


class EdgeData:
    """What is set at edges, and forcing: functions of the case's, asked for here, with what they mean for the unknowns.

    One for each run; ``apply`` and ``force`` are not collective, and raise InputError on this rank alone.
    """

    def __init__(self, layout: PlaneLayout, instant: Callable[[], float] = lambda: 1e-4) -> None:
        """instant: says a time [s] in which little happens, for differences in time."""
        self._layout = layout
        self._sticking: dict[int, list[Place]] = {k: [] for k in range(len(layout.grids))}
        self._moving: dict[int, list[MovingEdge]] = {k: [] for k in range(len(layout.grids))}
        self._holds: dict[int, list[Callable[[LayerPart, float], None]]] = {k: [] for k in range(len(layout.grids))}
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
                    self._note(k, end, np.full(columns.size, row), columns, 1)
                column = int(record["end_x"][side])
                if 0 <= column < record["width"]:
                    rows = np.arange(record["height"])
                    self._note(k, (layer.left, layer.right)[side], rows, np.full(rows.size, column), 0)

    def _note(self, k: int, end: edges.Edge, rows: np.ndarray, columns: np.ndarray, normal: int) -> None:
        """Remember what to set at some points of layer k; normal: 0 for an edge in X, 1 in Y."""
        if not rows.size:
            return
        X, Y = self._points(k, rows, columns)
        if end.kind == edges.NO_SLIP:
            self._sticking[k].append((rows, columns))
            self._holds[k].append(partial(_stick, self._layout.problem.layers[k], end, (rows, columns), (X, Y)))
        elif end.kind in (edges.CLAMPED, edges.ROLLER):
            held = (2, 3) if end.kind == edges.CLAMPED else (2 + normal,)
            self._holds[k].append(partial(_clamp, held, (rows, columns)))
        elif end.kind == edges.GIVEN:
            self._holds[k].append(partial(_give, self._layout.problem.layers[k], end, (rows, columns), (X, Y)))

    def _points(self, k: int, rows: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        grid, record = self._layout.grids[k], self._layout.records[k]
        return grid.x0 + (record["first_x"] + columns) * grid.h_x, grid.y0 + (record["first_y"] + rows) * grid.h_y

    def apply(self, part: LayerPart, t: float) -> None:
        """Set what is given at time t [s]."""
        for hold in self._holds[part.k]:
            hold(part, t)
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


Place, Points = tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]


def _clamp(held: tuple[int, ...], place: Place, part: LayerPart, t: float) -> None:
    """No velocity, or none in one direction."""
    for c in held:
        part.held[(*place, c)] = 0.0


def _stick(layer: Any, wall: edges.NoSlip, place: Place, points: Points, part: LayerPart, t: float) -> None:
    """No velocity at a wall, and its temperature, if it has one."""
    q = part.held
    q[(*place, 2)] = q[(*place, 3)] = 0.0
    if wall.T is not None:
        T = given.wall_temperature(layer, wall.T, *points, t) if callable(wall.T) else wall.T
        J, r = q[(*place, 0)], q[(*place, 1)]
        q[(*place, 4)] = r * layer.material.internal_energy(r / J, T)


def _give(layer: Any, end: edges.Given, place: Place, points: Points, part: LayerPart, t: float) -> None:
    """All unknowns as the case says."""
    values, q = given.edge_values(layer, end.values, *points, t), part.held
    if layer.kind == "solid":
        u, v, T, x, y = values
        for c, value in enumerate((x - points[0], y - points[1], u, v, T)):
            q[(*place, c)] = value
        return
    rho, u, v, T = values
    r = q[(*place, 0)] * rho
    e = r * (layer.material.internal_energy(rho, T) + 0.5 * (u * u + v * v))
    for c, value in enumerate((r, r * u, r * v, e)):
        q[(*place, c + 1)] = value
