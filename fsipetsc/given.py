"""What users' functions of layers in one dimension return, checked; what they raise is explained.

A function of a layer gives one value or array per unknown. Its values count at the active points
only: what it gives for points that the grid holds in reserve may be anything of the right shape.
An error may be this rank's alone.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from fsipetsc.blame import place_of
from fsipetsc.blocks.values import NOWHERE, block_values, checked, checked_one, names_of
from fsipetsc.boundaries import GIVEN_T, Dirichlet, Open, heat_of
from fsipetsc.errors import InputError
from fsipetsc.problem import Layer, Problem


def fields(
    layer: Layer, what: str, X: np.ndarray, t: float, active: slice = slice(None)
) -> list[np.ndarray]:
    """The values of layer.initial, exact or forcing at the points X; see block_values."""
    return block_values(layer, what, X[None], t, active)


def initial(layer: Layer, X: np.ndarray, active: slice) -> list[np.ndarray]:
    """Initial data of a layer at the points X; x of a solid must rise. InputError."""
    found = fields(layer, "initial", X, 0.0, active)
    if layer.kind == "solid" and not np.all(rises := np.diff(found[3][active]) > 0):
        at = f"after X = {X[active][np.argmin(rises)]:.6g}: expected positions [m]"
        where = f"{place_of(layer.initial)}: initial of {layer}"
        raise InputError(f"{where}: x does not rise with X {at}", collective=False)
    return found


def end_data(problem: Problem, side: int, t: float) -> Sequence[float]:
    """The data of the left (0) or right (1) end at time t [s]. InputError."""
    end = (problem.left, problem.right)[side]
    if isinstance(end, Open):
        return end.p0, end.T0, end.u0, float(end.order)
    name = "values" if isinstance(end, Dirichlet) else "value"
    found = getattr(end, name, ())  # a wall has none
    return at_end(found, name, side, t) if callable(found) else np.ravel(found)


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
        return _numbers(function, (t,), names_of("fluid", name, 1), where)
    return [float(checked_one(function, (t,), NOWHERE, name, where)[0])]


def jumps(problem: Problem, k: int, t: float) -> Sequence[float]:
    """The prescribed jumps at interface k at time t [s]. InputError."""
    names = "g_u", "g_stress", "g_T", "g_flux"
    return _numbers(problem.jumps, (k, t), names, f"jumps at interface {k} at t = {t:.6g}")


def _numbers(
    function: Callable[..., Any], arguments: tuple[Any, ...], names: tuple[str, ...], where: str
) -> list[float]:
    found = checked(function, arguments, NOWHERE, names, where)
    return [float(value[0]) for value in found]


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
                f"{layer.place}{layer}: its {kind} stands at x = {end.x:g}, but "
                f"X[{side}] = {layer.X[side]:g} is x = {wanted:g}, as the interface X = {X_I:g} "
                f"begins at x = {x_I:g}: expected the same x, so X[{side}] = "
                f"{end.x - x_I + X_I:g} or the {kind} at x = {wanted:g}"
            )
