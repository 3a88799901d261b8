"""What a case says is checked where it says it, so that the message can name the line; what its
functions return for places and times, when they are asked.
"""

from collections.abc import Callable, Mapping, Sequence
from datetime import timedelta
from functools import wraps
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.errors import InputError, call, place_of

#: what functions of a case take, and what they return for several unknowns
Array = NDArray[Any]
Fields = Sequence[Array | float]

#: cells of a layer: the unknowns of a few such layers can still be counted in 32 bits
MOST_CELLS = 50_000_000
#: what a number must be, as `within` reads it
POSITIVE, NONNEGATIVE, ANY = "above 0", "not below 0", ""
#: in the place of X for functions of time alone
NOWHERE = np.empty((0, 1))
#: what is asked of a value -> how a message says it, and whether a value is such
KINDS: Mapping[str, tuple[str, Callable[[Any], bool]]] = {
    "name": (
        "a line of text without |",
        lambda v: isinstance(v, str) and v.isprintable() and v.strip() != "" and "|" not in v,
    ),
    "cells": ("a whole number above 0", lambda v: v is None or whole(v)),
    "units": ("'SI' or 'none'", lambda v: isinstance(v, str) and v in ("SI", "none", "")),
    "function": ("a function", callable),
    "optional": ("a function or None", lambda v: v is None or callable(v)),
}


def described(value: Any) -> str:
    """A value in a message: short, and on one line."""
    if callable(value):
        return f"a function ({getattr(value, '__name__', type(value).__name__)})"
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def place_text(X: Any, letters: str = "XYZ") -> str:
    """ "X = 1", "(X, Y) = (1, 2)": a place in a message, with these letters for coordinates."""
    numbers = [f"{x:.6g}" for x in np.ravel(X)]
    name, text = ", ".join(letters[: len(numbers)]), ", ".join(numbers)
    return f"({name}) = ({text})" if len(numbers) > 1 else f"{name} = {text}"


def counted(count: int, word: str) -> str:
    """ "1 step", "2 steps"."""
    return f"{count} {word}{'s' * (count != 1)}"


def duration(seconds: float) -> str:
    """Seconds, as "4.2 s" or "1:02:33"."""
    return f"{seconds:.3g} s" if seconds < 60 else str(timedelta(seconds=int(seconds)))


def number(value: Any, what: str, bound: str = ANY, unit: str = "") -> float:
    """The value as a float; InputError if it is no finite real number or out of bound."""
    expected = f"expected a number{' ' * bool(bound)}{bound}{f' [{unit}]' if unit else ''}"
    try:
        wrong = isinstance(value, (str, bytes, bool, np.bool_)) or np.ndim(value) > 0
        found = np.nan if wrong or np.iscomplexobj(value) else float(value)
    except (TypeError, ValueError, OverflowError):
        found = np.nan
    if not isfinite(found):
        raise InputError(f"{what} is {described(value)}: {expected}")
    if not within(found, bound):
        raise InputError(f"{what} is {found:g}: {expected}")
    return found


def within(value: float, bound: str) -> bool:
    """Whether a number is what its bound says: "above …", "not below …", "" for any."""
    least = float(bound.split()[-1]) if bound else -np.inf
    return value > least or (value == least and not bound.startswith("above"))


def numbers(record: Any, owner: str, ranges: Mapping[str, str]) -> None:
    """Make attributes of a frozen dataclass floats within their ranges. InputError."""
    for name, bound in ranges.items():
        object.__setattr__(record, name, number(getattr(record, name), f"{owner}: {name}", bound))


def check(kind: str, value: Any, what: str) -> None:
    """InputError if a value is none of one of the KINDS."""
    expected, is_such = KINDS[kind]
    if not is_such(value):
        raise InputError(f"{what} is {described(value)}: expected {expected}")


def extent(X: Any, what: str) -> tuple[float, float]:
    """(left, right), left < right; InputError."""
    if not isinstance(X, (tuple, list, np.ndarray)) or len(X) != 2:
        raise InputError(f"{what}: X is {described(X)}: expected (left, right), two numbers [m]")
    left, right = (number(end, f"{what}: X") for end in X)
    if not left < right:
        raise InputError(f"{what}: X = ({left:g}, {right:g}): expected left below right")
    return left, right


def whole(value: Any) -> bool:
    """Whether it is a whole number above 0."""
    return isinstance(value, (int, np.integer)) and value is not True and int(value) > 0


def cells_of(ends: tuple[float, float], h: float, what: str) -> int:
    """Cells of about h [m] between the ends of a layer. InputError for more than MOST_CELLS."""
    width = (ends[1] - ends[0]) / h
    if not width < MOST_CELLS:
        raise InputError(f"{what} would have {width:.3g} cells; {MOST_CELLS} are too many")
    return max(1, round(width))


def names_of(kind: str, what: str, d: int) -> tuple[str, ...]:
    """What initial, exact, values, forcing, prestress of a block of a kind return, by name."""
    u, x = "uvw"[:d], "xyz"[:d]
    if what == "prestress":
        return tuple(f"S_{i}{j}" for i in x for j in x)
    if kind == "solid":
        return (*u, "T", *x)
    return ("rho", *(f"rho {c}" for c in u), "e") if what == "forcing" else ("rho", *u, "T")


def block_values(block: Any, what: str, X: Array, t: float) -> list[Array]:
    """A block's function at X (d, n) and t [s], (n,) each. InputError, maybe on this rank alone."""
    first = what in ("initial", "prestress")
    where = f"{what} of {block}" + ("" if first else f" at t = {t:.6g}")
    names = getattr(block, "unknowns", None) or names_of(block.kind, what, len(X))
    arguments, function = tuple(X) if first else (*X, t), getattr(block, what)
    if not X.size:  # no point of a layer is active here
        return [np.empty(0)] * len(names)
    return checked(function, arguments, X, names, where, what != "forcing")


def datum(condition: Any, name: str, X: Array, t: float, names: Any = None) -> Array:
    """A datum of a condition at X (n, d): (n,), or (n, len(names)) of several. InputError."""
    of = getattr(condition, name)
    if not callable(of):
        return np.broadcast_to(np.asarray(of, float), (len(X), *np.shape(of)))
    owner = getattr(of, "owner", type(condition).__name__)  # an end in one dimension says so
    where = f"{name} of {owner} at t = {t:.6g}"
    if names is not None:
        return np.stack(checked(of, (*X.T, t), X.T, names, where), axis=-1)
    return checked(wraps(of)(lambda *at: (of(*at),)), (*X.T, t), X.T, (name,), where)[0]


def checked(
    function: Callable[..., Any],
    arguments: Sequence[Any],
    X: Array,
    names: Sequence[str],
    where: str,
    physical: bool = True,
    letters: str = "XYZ",
) -> list[Array]:
    """What a function of the case's returns, (n,) for each name. X: (d, n) places, in messages with
    these letters, or NOWHERE for one number each. physical: rho and T must be above 0. InputError.
    """
    with np.errstate(all="ignore"):  # what comes of it is checked
        values = call(function, tuple(arguments), where)
    above = [physical and name in ("rho", "T") for name in names]
    try:
        if not isinstance(values, (tuple, list, np.ndarray)) or len(values) != len(names):
            found = "nothing (is its return missing?)" if values is None else described(values)
            expected = f"expected {len(names)} values ({', '.join(names)}) in a tuple"
            raise ValueError(f"returns {found}: {expected}")
        return [_array_of(*one, X, letters) for one in zip(values, names, above, strict=True)]
    except (TypeError, ValueError) as error:
        raise InputError(f"{place_of(function)}: {where}: {error}", collective=False) from None


def _array_of(value: Any, name: str, positive: bool, X: Array, letters: str) -> Array:
    """One of the values that a function has returned, for all places. ValueError."""
    size = X.shape[1]
    if type(value) is float and isfinite(value) and not positive:
        return np.full(size, value)  # of ends in one dimension, several times in each stage
    try:
        array = np.broadcast_to(np.asarray(value), (size,))
    except ValueError:
        array = np.asarray(None)
    if array.dtype.kind not in "iuf" or isinstance(value, np.ma.MaskedArray):
        wanted = "real numbers, one or as many as places" if len(X) else "a real number"
        raise ValueError(f"{name} is {described(value)}: expected {wanted}")
    array = array.astype(float, copy=False)
    good = np.isfinite(array) & ((array > 0.0) | (not positive))
    if not good.all():
        i = int(np.argmin(good))
        at = f" at {place_text(X[:, i], letters)}" if len(X) else ""
        wanted = "a number above 0" if positive else "a finite number"
        raise ValueError(f"{name} = {array[i]:.6g}{at}: expected {wanted}")
    return array
