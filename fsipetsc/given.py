"""The one place where users' functions are called: what they return is checked, and what they raise is explained.

A function of a layer gives one value or array per unknown. Its values count at the active points only: what it gives for
points that the grid holds in reserve may be anything of the right shape. An error may be this rank's alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.blame import call, place_of
from fsipetsc.boundaries import GIVEN_T, heat_of, in_time
from fsipetsc.checks import described
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


def fields(layer: Layer, what: str, X: np.ndarray, t: float, active: slice = slice(None)) -> list[np.ndarray]:
    """The values of layer.initial, exact or forcing at the points X at time t [s], each of X's shape. InputError.

    active: the points at which they must be finite.
    """
    function, names = getattr(layer, what), UNKNOWNS[layer.kind, what]
    where = f"{what} of layer '{layer.name}'" + ("" if what == "initial" else f" at t = {t:.6g}")
    values = _asked(function, (X,) if what == "initial" else (X, t), where)
    found = []
    for name, value in zip(names, _listed(values, names, function, where), strict=True):
        array = _real(value, X.shape, name, function, where)
        wrong = ~np.isfinite(array[active])
        if wrong.any():
            i = int(np.argmax(wrong))
            at = f"X = {X[active][i]:.6g}"
            raise _fault(function, where, f"{name} is {array[active][i]} at {at}: expected a finite number")
        found.append(array)
    return found


def initial(layer: Layer, X: np.ndarray, active: slice) -> list[np.ndarray]:
    """Initial data of a layer at the points X, physical at the active ones: rho > 0, T > 0, x rising. InputError."""
    found = fields(layer, "initial", X, 0.0, active)
    where = f"initial of layer '{layer.name}'"
    for name, array in zip(UNKNOWNS[layer.kind, "initial"], found, strict=True):
        values = array[active]
        if name in ("rho", "T") and not np.all(values > 0):
            i = int(np.argmin(values > 0))
            raise _fault(layer.initial, where, f"{name} = {values[i]:.6g} at X = {X[active][i]:.6g}: expected a number above 0")
        if name == "x" and not np.all(np.diff(values) > 0):
            i = int(np.argmin(np.diff(values) > 0))
            raise _fault(layer.initial, where, f"x does not rise with X behind X = {X[active][i]:.6g}: expected positions [m]")
    return found


def end_data(problem: Problem, side: int, t: float) -> Sequence[float]:
    """The data of the left (0) or right (1) end at time t [s]. InputError."""
    end = (problem.left, problem.right)[side]
    functions = in_time(end)
    for name in functions.keys() & {"value", "values"}:
        return at_end(functions[name], name, side, t)
    return end.data(t)


def end_heat(problem: Problem, side: int, t: float) -> float:
    """Temperature [K] or heat flux [W/m2] that is given at an end at time t [s], 0 where none is. InputError."""
    kind, value = heat_of((problem.left, problem.right)[side])
    if not callable(value):
        return value
    return at_end(value, "T" if kind == GIVEN_T else "heat_flux", side, t)[0]


def at_end(function: Callable[..., Any], name: str, side: int, t: float) -> list[float]:
    """What a function of the left (0) or right (1) end returns at time t [s]: rho, u, T if it is `values`, else one number.

    InputError, perhaps on this rank alone; rho and T must be above 0.
    """
    early = " (where it is asked for because no velocity is given)" if t < 0 and name == "x" else ""
    where = f"{name} of the {('left', 'right')[side]} end at t = {t:.6g}{early}"
    found = _asked(function, (t,), where)
    if type(found) is float and isfinite(found) and name not in ("T", "values"):
        return [found]  # nearly always, and often: several times in each stage
    names, found = (UNKNOWNS["fluid", "exact"], found) if name == "values" else ((name,), [found])
    numbers = _scalars(found, names, function, where)
    for what, value in zip(names, numbers, strict=True):
        if what in ("rho", "T") and not value > 0:
            raise _fault(function, where, f"{what} = {value:.6g}: expected a number above 0")
    return numbers


def jumps(problem: Problem, k: int, t: float) -> Sequence[float]:
    """The prescribed jumps at interface k at time t [s]. InputError."""
    where = f"jumps at interface {k} at t = {t:.6g}"
    return _scalars(_asked(problem.jumps, (k, t), where), JUMPS, problem.jumps, where)


def check_ends(problem: Problem, x: Mapping[tuple[int, int], float], h: float) -> None:
    """InputError if the outer end of a gas in a rigid frame is not where its X says, to within a cell of h [m].

    x: (solid layer, end 0 or 1) -> initial position of its end point [m].
    """
    last = len(problem.layers) - 1
    for k, side, end in ((0, 0, problem.left), (last, 1, problem.right)):
        layer = problem.layers[k]
        if layer.kind != "fluid":
            continue
        x_I, X_I = x[(1, 0) if side == 0 else (last - 1, 1)], layer.X[1 - side]
        wanted = layer.X[side] - X_I + x_I
        if abs(end.x - wanted) > h:
            raise InputError(
                f"{layer.place}layer '{layer.name}': its {type(end).__name__} stands at x = {end.x:g}, but X[{side}] = "
                f"{layer.X[side]:g} is x = {wanted:g}, as the interface X = {X_I:g} begins at x = {x_I:g}: expected "
                f"the same x, so X[{side}] = {end.x - x_I + X_I:g} or the {type(end).__name__} at x = {wanted:g}"
            )


def _asked(function: Callable[..., Any], arguments: tuple[Any, ...], where: str) -> Any:
    """What a user's function returns, without numpy's warnings: what comes of it is looked at."""
    with np.errstate(all="ignore"):
        return call(function, arguments, where)


def _scalars(values: Any, names: tuple[str, ...], function: Callable[..., Any], where: str) -> list[float]:
    found = []
    for name, value in zip(names, _listed(values, names, function, where), strict=True):
        array = _real(value, (), name, function, where)
        if not np.isfinite(array):
            raise _fault(function, where, f"{name} is {array}: expected a finite number")
        found.append(float(array))
    return found


def _listed(values: Any, names: tuple[str, ...], function: Callable[..., Any], where: str) -> Sequence[Any]:
    """The values if they are as many as the names."""
    expected = f"expected {len(names)} values ({', '.join(names)})"
    if values is None:
        raise _fault(function, where, f"returns nothing (is its return missing?): {expected}")
    if not isinstance(values, (tuple, list)) and not (isinstance(values, np.ndarray) and values.ndim > 0):
        raise _fault(function, where, f"returns {described(values)}: {expected} in a tuple")
    if len(values) != len(names):
        raise _fault(function, where, f"returns {len(values)} value{'s' * (len(values) != 1)}: {expected}")
    return values


def _real(value: Any, shape: tuple[int, ...], name: str, function: Callable[..., Any], where: str) -> np.ndarray:
    """A value as an array of real numbers of a shape."""
    if type(value) is np.ndarray and value.dtype == np.float64 and value.shape == shape:
        return value  # nearly always, and often: forcing is asked for in each stage
    try:
        array = np.asarray(value)
    except (ValueError, TypeError):  # rows of different lengths
        array = np.asarray(None)
    if array.dtype.kind not in "iuf" or np.ma.is_masked(value):
        found = described(value) if array.dtype.kind != "c" else "complex"
        raise _fault(function, where, f"{name} is {found}: expected real numbers")
    if array.shape not in ((), (1,), shape):
        wanted = f"shape {shape}, as X has, or one number" if shape else "one number"
        raise _fault(function, where, f"{name} has the shape {array.shape}: expected {wanted}")
    return np.broadcast_to(array.astype(float, copy=False), shape) if shape else array.reshape(()).astype(float)


def _fault(function: Callable[..., Any], where: str, what: str) -> InputError:
    return InputError(f"{place_of(function)}: {where}: {what}", collective=False)
