"""Vectors as tuples of numbers, of any length.

Equations and laws are NamedTuple classes whose methods are scalar formulas, as
``gas.pressure(rho, T)``. The same source runs on floats, on numpy arrays, and on the symbols of
fsipetsc.kernels. Here are the functions of tuples of which they are made.
"""

from collections.abc import Iterable
from functools import reduce
from operator import add as plus
from typing import Any

import numpy as np

Vector = tuple[Any, ...]


def total(a: Iterable[Any]) -> Any:
    return reduce(plus, a)


def dot(a: Vector, b: Vector) -> Any:
    return total(p * q for p, q in zip(a, b, strict=True))


def add(a: Vector, b: Vector) -> Vector:
    return tuple(p + q for p, q in zip(a, b, strict=True))


def sub(a: Vector, b: Vector) -> Vector:
    return tuple(p - q for p, q in zip(a, b, strict=True))


def scale(c: Any, a: Vector) -> Vector:
    return tuple(c * p for p in a)


def per(a: Vector, c: Any) -> Vector:
    return tuple(p / c for p in a)


def mean(a: Vector, b: Vector) -> Vector:
    return tuple(0.5 * (p + q) for p, q in zip(a, b, strict=True))


def cross(a: Vector, b: Vector) -> Vector:
    return tuple(a[i] * b[j] - a[j] * b[i] for i, j in ((1, 2), (2, 0), (0, 1)))


def along(a: Vector, c: Any, b: Vector) -> Vector:
    return tuple(p + c * q for p, q in zip(a, b, strict=True))


def last_times(c: Any, a: Vector) -> Vector:
    return (*a[:-1], c * a[-1])


def choose(condition: Any, a: Vector, b: Vector) -> Vector:
    return tuple(np.where(condition, p, q) for p, q in zip(a, b, strict=True))
