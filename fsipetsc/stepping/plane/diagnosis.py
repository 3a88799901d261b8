"""Where and how a state in two dimensions became unphysical, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from fsipetsc.stepping.plane.part import LayerPart
    from fsipetsc.stepping.plane.state import PlaneState

#: of what is saved of a point, columns that must be above 0, and those that must be numbers
_GAS, _SOLID = {"rho": 0, "T": 3, "J": 5}, {"T": 2}
_FINITE = {"fluid": {"u": 1, "v": 2}, "solid": {"u": 0, "v": 1, "x": 6, "y": 7}}


def describe_failure(state: PlaneState, t: float, step: int) -> str:
    """Field, layer, position, time and step of the first unphysical point. Collective."""
    found, m, s = None, state.problem.unit("m"), state.problem.unit("s")
    for part in state.path.layers:
        found = found or _first_bad(state, part)
    found = min((f for f in state.comm.allgather(found) if f), default=None)
    if found is None:
        return f"the time step is not a number at t = {t:.6g}{s}, step {step}"
    k, _, place, what = found
    name = state.problem.layers[k].name
    at = f"x = {place[0]:.6g}{m}, y = {place[1]:.6g}{m} (X = {place[2]:.6g}{m}, Y = {place[3]:.6g}{m})"
    return f"{what} in layer '{name}' at {at}, t = {t:.6g}{s}, step {step}"


def _first_bad(state: PlaneState, part: LayerPart) -> tuple[int, int, tuple[float, ...], str] | None:
    """(layer, point, (x, y, X, Y), what) of the first unphysical point on this rank."""
    layer, grid = state.problem.layers[part.k], state.layout.grids[part.k]
    columns, rows = state.layout.owned(part.k)
    with np.errstate(all="ignore"):
        saved = part.save()
        positive = dict(_GAS if layer.kind == "fluid" else _SOLID)
        values = [(name, saved[..., c], saved[..., c] > 0) for name, c in positive.items()]
        values += [(name, saved[..., c], np.isfinite(saved[..., c])) for name, c in _FINITE[layer.kind].items()]
        if layer.kind == "solid":
            J = _least_J(state, part)
            values.append(("J", J, J > 0))
    bad = [(int(np.argmin(good)), name, value) for name, value, good in values if not good.all()]
    if not bad:
        return None
    i, name, value = min(bad, key=lambda entry: entry[0])
    at = np.unravel_index(i, value.shape)
    X, Y = grid.points(columns, rows)
    what = f"{name} = {value[at]:.6g}" if np.isfinite(value[at]) else f"{name} is not a finite number"
    number = int(rows[at[0]]) * grid.nx + int(columns[at[1]])
    return part.k, number, (float(saved[at][6]), float(saved[at][7]), float(X[at]), float(Y[at])), what


def _least_J(state: PlaneState, part: LayerPart) -> np.ndarray:
    """J = det F of a solid, by differences between neighbours."""
    grid = state.layout.grids[part.k]
    F = [np.gradient(part.own[..., c], grid.h_y, grid.h_x) for c in range(2)]
    return (1 + F[0][1]) * (1 + F[1][0]) - F[0][0] * F[1][1]
