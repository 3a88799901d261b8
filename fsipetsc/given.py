"""What the functions of layers, ends and interfaces in one dimension return, checked.

A function of a layer gives one value or array per unknown. Its values count at the active points
only: what it gives for points that the grid holds in reserve may be anything of the right shape.
An error may be this rank's alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.blame import place_of
from fsipetsc.blocks.values import checked, checked_one
from fsipetsc.boundaries import GIVEN_T, heat_of, in_time
from fsipetsc.errors import InputError

if TYPE_CHECKING:
    from fsipetsc.problem import Layer, Problem

#: (kind of layer, function) -> what it returns
UNKNOWNS = {
    **{("fluid", what): ("rho", "u", "T") for what in ("initial", "exact")},
    **{("solid", what): ("u", "sigma", "T", "x") for what in ("initial", "exact", "forcing")},
    ("fluid", "forcing"): ("rho", "rho u", "e"),
}
JUMPS = ("g_u", "g_stress", "g_T", "g_flux")


def fields(
    layer: Layer, what: str, X: np.ndarray, t: float, active: slice = slice(None)
) -> list[np.ndarray]:
    """The values of layer.initial, exact or forcing at the points X at time t [s], each of X's
    shape. InputError.

    active: the points at which they must be finite.
    """
    where = f"{what} of layer '{layer.name}'" + ("" if what == "initial" else f" at t = {t:.6g}")
    arguments, names = ((X,) if what == "initial" else (X, t)), UNKNOWNS[layer.kind, what]
    physical = what == "initial"
    return checked(getattr(layer, what), arguments, X[None], names, where, physical, active)


def initial(layer: Layer, X: np.ndarray, active: slice) -> list[np.ndarray]:
    """Initial data of a layer at the points X, physical at the active ones: rho > 0, T > 0, x
    rising. InputError.
    """
    found = fields(layer, "initial", X, 0.0, active)
    if layer.kind == "solid" and not np.all(np.diff(found[-1][active]) > 0):
        i = int(np.argmin(np.diff(found[-1][active]) > 0))
        where = f"{place_of(layer.initial)}: initial of layer '{layer.name}'"
        wrong = f"x does not rise with X behind X = {X[active][i]:.6g}: expected positions [m]"
        raise InputError(f"{where}: {wrong}", collective=False)
    return found


def end_data(problem: Problem, side: int, t: float) -> Sequence[float]:
    """The data of the left (0) or right (1) end at time t [s]. InputError."""
    end = (problem.left, problem.right)[side]
    functions = in_time(end)
    for name in functions.keys() & {"value", "values"}:
        return at_end(functions[name], name, side, t)
    return end.data(t)


def end_heat(problem: Problem, side: int, t: float) -> float:
    """Temperature [K] or heat flux [W/m2] that is given at an end at time t [s], 0 where none
    is. InputError.
    """
    kind, value = heat_of((problem.left, problem.right)[side])
    if not callable(value):
        return value
    return at_end(value, "T" if kind == GIVEN_T else "heat_flux", side, t)[0]


def at_end(function: Callable[..., Any], name: str, side: int, t: float) -> list[float]:
    """What a function of the left (0) or right (1) end returns at time t [s]: rho, u, T if it is
    `values`, else one number.

    InputError, perhaps on this rank alone; rho and T must be above 0.
    """
    early = " (where it is asked for because no velocity is given)" if t < 0 and name == "x" else ""
    where = f"{name} of the {('left', 'right')[side]} end at t = {t:.6g}{early}"
    if name == "values":
        return _numbers(checked(function, (t,), None, UNKNOWNS["fluid", "exact"], where))
    return _numbers([checked_one(function, (t,), None, name, where)])


def jumps(problem: Problem, k: int, t: float) -> Sequence[float]:
    """The prescribed jumps at interface k at time t [s]. InputError."""
    where = f"jumps at interface {k} at t = {t:.6g}"
    return _numbers(checked(problem.jumps, (k, t), None, JUMPS, where))


def _numbers(arrays: Sequence[np.ndarray]) -> list[float]:
    return [array.item() for array in arrays]


def check_ends(problem: Problem, x: Mapping[tuple[int, int], float], h: float) -> None:
    """InputError if the outer end of a gas in a rigid frame is not where its X says, to within a
    cell of h [m].

    x: (solid layer, end 0 or 1) -> initial position of its end point [m].
    """
    last = len(problem.layers) - 1
    for k, side, end in ((0, 0, problem.left), (last, 1, problem.right)):
        layer = problem.layers[k]
        if layer.kind != "fluid":
            continue
        x_I, X_I = x[(1, 0) if side == 0 else (last - 1, 1)], layer.X[1 - side]
        wanted, kind = layer.X[side] - X_I + x_I, type(end).__name__
        if abs(end.x - wanted) > h:
            raise InputError(
                f"{layer.place}layer '{layer.name}': its {kind} stands at x = {end.x:g}, but "
                f"X[{side}] = {layer.X[side]:g} is x = {wanted:g}, as the interface X = {X_I:g} "
                f"begins at x = {x_I:g}: expected the same x, so X[{side}] = "
                f"{end.x - x_I + X_I:g} or the {kind} at x = {wanted:g}"
            )

