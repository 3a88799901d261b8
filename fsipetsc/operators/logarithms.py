"""The logarithm of vectors of numbers that are near 1, as ratios of volumes are: without a call for each lane. Compiled.

    ln x = d (sum_n d^2n / (2n + 1) - d sum_n d^2n / (2n + 2)),    d = x - 1

by two polynomials in d^2, side by side and without a division, where x is within 10 % of 1; by one in f^2,

    ln x = 2 artanh(f) = 2 f sum_n f^2n / (2n + 1),    f = (x - 1)/(x + 1)

where it is between 4/5 and 5/4. Other lanes have the logarithm of the library, each depending on its own x alone.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from numba import njit
from numba.extending import overload

from fsipetsc.operators.kernels import FORMULA, OPTIONS
from fsipetsc.operators.lanes import any_above, where_above
from fsipetsc.operators.means import economized
from fsipetsc.operators.vectors import VectorType, fma, logarithm

#: d^2 of x = 1.1, and f^2 of x = 5/4
NEAREST, NEAR = 0.01, 1 / 81
_EVEN = economized([Fraction(1, 2 * n + 1) for n in range(16)], 5, NEAREST)
_ODD = economized([Fraction(-1, 2 * n + 2) for n in range(16)], 5, NEAREST)
_C = economized([Fraction(2, 2 * n + 1) for n in range(16)], 6, NEAR)


def log_near_one(x: Any) -> Any:
    """ln x; not a number below 0, -inf at 0. Not for infinity."""
    return np.log(x)


@njit(**FORMULA)
def _of_vector(x):
    d = x - 1.0
    z = d * d
    (e0, e1, e2, e3, e4, e5), (o0, o1, o2, o3, o4, o5) = _EVEN, _ODD
    even = fma(fma(fma(fma(fma(e5, z, e4), z, e3), z, e2), z, e1), z, e0)
    odd = fma(fma(fma(fma(fma(o5, z, o4), z, o3), z, o2), z, o1), z, o0)
    nearest = d * fma(d, odd, even)
    if any_above(z, NEAREST):
        nearest = where_above(z, NEAREST, _farther(x), nearest)
    return nearest


@njit(**OPTIONS)
def _farther(x):
    f = (x - 1.0) / (x + 1.0)
    z = f * f
    c0, c1, c2, c3, c4, c5, c6 = _C
    near = f * fma(fma(fma(fma(fma(fma(c6, z, c5), z, c4), z, c3), z, c2), z, c1), z, c0)
    if any_above(z, NEAR):
        near = where_above(z, NEAR, _by_library(x), near)
    return near


@njit(**OPTIONS)
def _by_library(x):
    return logarithm(x)


@overload(log_near_one, jit_options={"forceinline": True, "error_model": "numpy"})
def _log_near_one(x):
    return (lambda x: _of_vector(x)) if isinstance(x, VectorType) else (lambda x: np.log(x))
