"""What the functions of a block return for places and times, checked."""

from collections.abc import Callable, Sequence
from functools import wraps
from math import isfinite
from typing import Any

import numpy as np

from fsipetsc.blocks.maps import place_text
from fsipetsc.checks import Array, described
from fsipetsc.errors import InputError, call, place_of

#: in the place of X for functions of time alone
NOWHERE = np.empty((0, 1))


def names_of(kind: str, what: str, d: int) -> tuple[str, ...]:
    """What initial, exact, values, forcing, prestress of a block of a kind return, by name."""
    u, x = "uvw"[:d], "xyz"[:d]
    if what == "prestress":
        return tuple(f"S_{i}{j}" for i in x for j in x)
    if kind == "solid":
        return (*u, "T", *x)
    return ("rho", *(f"rho {c}" for c in u), "e") if what == "forcing" else ("rho", *u, "T")


def block_values(
    block: Any, what: str, X: Array, t: float, active: slice = slice(None)
) -> list[Array]:
    """Values of initial, exact or forcing of a block or a layer at places X (d, n) at time t [s],
    (n,) each. active: the places at which they count.

    InputError, perhaps on this rank alone; rho and T must be above 0.
    """
    first = what in ("initial", "prestress")
    where = f"{what} of {block}" + ("" if first else f" at t = {t:.6g}")
    names = getattr(block, "unknowns", None) or names_of(block.kind, what, len(X))
    arguments, function = tuple(X) if first else (*X, t), getattr(block, what)
    return checked(function, arguments, X, names, where, what != "forcing", active)


def datum(
    condition: Any, name: str, X: Array, t: float, names: Sequence[str] | None = None
) -> Array:
    """A datum of a condition, a number or a function of (*X, t); X: (n, d). InputError.

    (n,), or (n, len(names)) of a function that returns several values.
    """
    of = getattr(condition, name)
    if not callable(of):
        return np.broadcast_to(np.asarray(of, float), (len(X), *np.shape(of)))
    owner = getattr(of, "owner", type(condition).__name__)  # an end in one dimension says so
    where = f"{name} of {owner} at t = {t:.6g}"
    if names is not None:
        return np.stack(checked(of, (*X.T, t), X.T, names, where), axis=-1)
    alone = wraps(of)(lambda *at: (of(*at),))
    return checked(alone, (*X.T, t), X.T, (name,), where)[0]


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
    try:
        several = isinstance(values, (tuple, list, np.ndarray)) and getattr(values, "ndim", 1) > 0
        if not several or len(values) != len(names):
            found = "nothing (is its return missing?)" if values is None else described(values)
            expected = f"expected {len(names)} values ({', '.join(names)}) in a tuple"
            raise ValueError(f"returns {found}: {expected}")
        above = [physical and name in ("rho", "T") for name in names]
        return [_array_of(*one, X, active) for one in zip(values, names, above, strict=True)]
    except ValueError as error:
        raise InputError(f"{place_of(function)}: {where}: {error}", collective=False) from None


def _array_of(value: Any, name: str, positive: bool, X: Array, active: slice) -> Array:
    """One of the values that a function has returned, for all places. ValueError."""
    size = X.shape[1]
    if type(value) is float and isfinite(value) and not positive:
        return np.full(size, value)  # of ends in one dimension, several times in each stage
    try:
        array = np.asarray(value)
    except (ValueError, TypeError):  # rows of different lengths
        array = np.asarray(None)
    if array.dtype.kind not in "iuf" or np.ma.is_masked(value):
        raise ValueError(f"{name} is {described(value)}: expected real numbers")
    if array.shape not in ((), (1,), (size,)):
        wanted = f"({size},), as X has, or " if len(X) else ""
        raise ValueError(f"{name} has the shape {array.shape}: expected {wanted}one number")
    array = np.broadcast_to(array.astype(float, copy=False), (size,))
    good = np.isfinite(array) & ((array > 0.0) | (not positive))
    if not good[active].all():
        i = (active.start or 0) + int(np.argmin(good[active]))
        at = f" at {place_text(X[:, i])}" if len(X) else ""
        wanted = "a number above 0" if positive else "a finite number"
        raise ValueError(f"{name} = {array[i]:.6g}{at}: expected {wanted}")
    return array
