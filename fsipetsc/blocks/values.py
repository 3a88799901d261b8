"""What the functions of a block return for places and times, checked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any

import numpy as np

from fsipetsc.blame import call, place_of
from fsipetsc.checks import Array, described
from fsipetsc.errors import InputError


def names_of(kind: str, what: str, d: int) -> tuple[str, ...]:
    """What initial, exact, values and forcing of a block of a kind return, by name."""
    u, x = "uvw"[:d], "xyz"[:d]
    if kind == "solid":
        return (*u, "T", *x)
    return ("rho", *(f"rho {c}" for c in u), "e") if what == "forcing" else ("rho", *u, "T")


def block_values(block: Any, what: str, X: Array, t: float) -> list[Array]:
    """Values of block.initial, exact or forcing at places X (d, n) at time t [s], (n,) each.

    InputError, perhaps on this rank alone; rho and T must be above 0.
    """
    where = f"{what} of block '{block.name}'" + ("" if what == "initial" else f" at t = {t:.6g}")
    arguments = tuple(X) if what == "initial" else (*X, t)
    names = names_of(block.kind, what, len(X))
    return checked(getattr(block, what), arguments, X, names, where, physical=what != "forcing")


def prestress_of(block: Any, X: Array) -> Array:
    """block.prestress (d d, n) [Pa] at places X (d, n), or (d d, 0) of a block that has none.

    InputError, perhaps on this rank alone.
    """
    d = len(X)
    if block.prestress is None:
        return np.zeros((d * d, 0))
    names = [f"S_{i}{j}" for i in "xyz"[:d] for j in "xyz"[:d]]
    where = f"prestress of block '{block.name}'"
    return np.array(checked(block.prestress, tuple(X), X, names, where))


def checked(
    function: Callable[..., Any],
    arguments: Sequence[Any],
    X: Array | None,
    names: Sequence[str],
    where: str,
    physical: bool = True,
    counted: slice = slice(None),
) -> list[Array]:
    """What a function of the case's returns, an array for each name: (n,) at places X (d, n), (1,)
    where X is None. InputError, perhaps on this rank alone.

    Values must be finite at the places that are counted. physical: and what is called rho or T
    above 0.
    """
    values = _asked(function, arguments, where)
    expected = f"expected {len(names)} values ({', '.join(names)})"
    if values is None:
        raise _fault(function, where, f"returns nothing (is its return missing?): {expected}")
    if not isinstance(values, (tuple, list, np.ndarray)) or getattr(values, "ndim", 1) == 0:
        raise _fault(function, where, f"returns {described(values)}: {expected} in a tuple")
    if len(values) != len(names):
        raise _fault(function, where, f"returns {len(values)} values: {expected}")
    pairs = zip(names, values, strict=True)
    return [_array(v, name, X, function, where, physical, counted) for name, v in pairs]


def checked_one(
    function: Callable[..., Any], arguments: Sequence[Any], X: Array | None, name: str, where: str
) -> Array:
    """The same of a function that returns one value."""
    value = _asked(function, arguments, where)
    if X is None and type(value) is float and isfinite(value) and name != "T":
        return np.float64(value)  # nearly always, and several times in each stage
    return _array(value, name, X, function, where, True)


def _asked(function: Callable[..., Any], arguments: Sequence[Any], where: str) -> Any:
    """What it returns, without numpy's warnings: what comes of it is looked at."""
    with np.errstate(all="ignore"):
        return call(function, tuple(arguments), where)


def _array(
    value: Any,
    name: str,
    X: Array | None,
    function: Callable[..., Any],
    where: str,
    physical: bool,
    counted: slice = slice(None),
) -> Array:
    """One of the values, for all places."""
    size = 1 if X is None else X.shape[1]
    try:
        array = np.asarray(value)
    except (ValueError, TypeError):  # rows of different lengths
        array = np.asarray(None)
    if array.dtype.kind not in "iuf" or np.ma.is_masked(value):
        found = "complex" if array.dtype.kind == "c" else described(value)
        raise _fault(function, where, f"{name} is {found}: expected real numbers")
    if array.shape not in ((), (1,), (size,)):
        wanted = "one number" if X is None else f"({size},), as X has, or one number"
        raise _fault(function, where, f"{name} has the shape {array.shape}: expected {wanted}")
    array = np.broadcast_to(array.astype(float, copy=False), (size,))
    positive, values = physical and name in ("rho", "T"), array[counted]
    good = np.isfinite(values) & ((values > 0.0) | (not positive))
    if not good.all():
        i = int(np.argmin(good))
        at = () if X is None else zip("XYZ", X[:, counted][:, i], strict=False)
        place = ", ".join(f"{c} = {x:.6g}" for c, x in at)
        found = f"{name} = {values[i]:.6g}{' at ' * bool(place)}{place}"
        wanted = "a number above 0" if positive else "a finite number"
        raise _fault(function, where, f"{found}: expected {wanted}")
    return array


def _fault(function: Callable[..., Any], where: str, what: str) -> InputError:
    return InputError(f"{place_of(function)}: {where}: {what}", collective=False)
