"""Where and how a state in two dimensions became unphysical, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.stepping.diagnosis import Failure, Seen, described

if TYPE_CHECKING:
    from fsipetsc.stepping.plane.part import LayerPart
    from fsipetsc.stepping.plane.state import PlaneState

#: columns of what is saved of a point, those first of which others are made
_COLUMNS = {"fluid": {"J": 5, "rho": 0, "u": 1, "v": 2, "T": 3}, "solid": {"x": 6, "y": 7, "u": 0, "v": 1, "T": 2}}
_POSITIVE = {"fluid": frozenset(("J", "rho", "T")), "solid": frozenset(("J", "T"))}


def describe_failure(state: PlaneState, t: float, step: int) -> Failure:
    """Field, layer, position, time and step of the first unphysical point. Collective."""
    return described(state, (_seen(state, part) for part in state.path.layers), t, step)


def _seen(state: PlaneState, part: LayerPart) -> Seen:
    kind, grid, m = state.problem.layers[part.k].kind, state.layout.grids[part.k], state.problem.unit("m")
    columns, rows = state.layout.owned(part.k)
    X, Y = (places.reshape(-1) for places in grid.points(columns, rows))
    saved = part.save()
    saved = saved.reshape(-1, saved.shape[-1])
    values = {name: saved[:, c] for name, c in _COLUMNS[kind].items()}
    if kind == "solid":
        values = {"x": values.pop("x"), "y": values.pop("y"), "J": _least_J(state, part), **values}
    x, y = saved[:, 6], saved[:, 7]

    def place(i: int) -> str:
        return f"x = {x[i]:.6g}{m}, y = {y[i]:.6g}{m} (X = {X[i]:.6g}{m}, Y = {Y[i]:.6g}{m})"

    numbers = (rows[:, None] * grid.nx + columns[None, :]).reshape(-1)
    return Seen(part.k, numbers, values, _POSITIVE[kind], place)


def _least_J(state: PlaneState, part: LayerPart) -> np.ndarray:
    """J = det F of a solid, by differences between neighbours, point by point."""
    grid = state.layout.grids[part.k]
    F = [np.gradient(part.own[..., c], grid.h_y, grid.h_x) for c in range(2)]
    return ((1 + F[0][1]) * (1 + F[1][0]) - F[0][0] * F[1][1]).reshape(-1)
