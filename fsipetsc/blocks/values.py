"""What the functions of a block return for places and times, checked."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from fsipetsc.blame import call, place_of
from fsipetsc.checks import Array, counted, described
from fsipetsc.errors import InputError

#: in the place of X for functions of time alone
NOWHERE = np.empty((0, 1))


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
    X: Array,
    names: Sequence[str],
    where: str,
    physical: bool = True,
    active: slice = slice(None),
) -> list[Array]:
    """What a function of the case's returns, an array of (n,) for each name. InputError.

    X: (d, n) places, or NOWHERE for one number each. physical: what is called rho or T must be
    above 0. active: the places at which values count.
    """
    with np.errstate(all="ignore"):  # what comes of it is checked
        values = call(function, tuple(arguments), where)
    expected = f"expected {len(names)} values ({', '.join(names)})"
    if values is None:
        raise _fault(function, where, f"returns nothing (is its return missing?): {expected}")
    if not isinstance(values, (tuple, list, np.ndarray)) or getattr(values, "ndim", 1) == 0:
        raise _fault(function, where, f"returns {described(values)}: {expected} in a tuple")
    if len(values) != len(names):
        count = counted(len(values), "value")
        raise _fault(function, where, f"returns {count}: {expected}")
    pairs = zip(names, values, strict=True)
    return [array_of(value, name, X, function, where, physical, active) for name, value in pairs]


def checked_one(
    function: Callable[..., Any], arguments: Sequence[Any], X: Array, name: str, where: str
) -> Array:
    """The same of a function that returns one value."""
    with np.errstate(all="ignore"):
        value = call(function, tuple(arguments), where)
    return array_of(value, name, X, function, where)


def datum(condition: Any, name: str, X: Array, t: float) -> Array:
    """(n,) a datum of a condition, a number or a function of (*X, t); X: (n, d). InputError."""
    of = getattr(condition, name)
    if not callable(of):
        return np.full(len(X), float(of))
    if hasattr(of, "of_time"):  # of an end in one dimension
        return np.full(len(X), of.of_time(t))
    where = f"{name} of {type(condition).__name__} at t = {t:.6g}"
    return checked_one(of, (*X.T, t), X.T, name, where)


def data(condition: Any, name: str, X: Array, t: float, names: Sequence[str]) -> Array:
    """(n, len(names)) what a condition's function of (*X, t) returns. InputError."""
    of = getattr(condition, name)
    if hasattr(of, "of_time"):
        return np.full((len(X), len(names)), of.of_time(t))
    where = f"{name} of {type(condition).__name__} at t = {t:.6g}"
    return np.stack(checked(of, (*X.T, t), X.T, names, where), axis=-1)


def array_of(
    value: Any,
    name: str,
    X: Array,
    function: Callable[..., Any],
    where: str,
    physical: bool = True,
    active: slice = slice(None),
) -> Array:
    """One of the values that a function has returned, for all places. InputError."""
    size = X.shape[1]
    try:
        array = np.asarray(value)
    except (ValueError, TypeError):  # rows of different lengths
        array = np.asarray(None)
    if array.dtype.kind not in "iuf" or np.ma.is_masked(value):
        found = "complex" if array.dtype.kind == "c" else described(value)
        raise _fault(function, where, f"{name} is {found}: expected real numbers")
    if array.shape not in ((), (1,), (size,)):
        wanted = f"({size},), as X has, or " if len(X) else ""
        shape = f"{name} has the shape {array.shape}: expected {wanted}one number"
        raise _fault(function, where, shape)
    array = np.broadcast_to(array.astype(float, copy=False), (size,))
    positive = physical and name in ("rho", "T")
    good = np.isfinite(array) & ((array > 0.0) | (not positive))
    if not good[active].all():
        i = (active.start or 0) + int(np.argmin(good[active]))
        places = (f"{c} = {x:.6g}" for c, x in zip("XYZ", X[:, i], strict=False))
        at = f" at {', '.join(places)}" if len(X) else ""
        wanted = "a number above 0" if positive else "a finite number"
        raise _fault(function, where, f"{name} = {array[i]:.6g}{at}: expected {wanted}")
    return array


def _fault(function: Callable[..., Any], where: str, what: str) -> InputError:
    return InputError(f"{place_of(function)}: {where}: {what}", collective=False)
