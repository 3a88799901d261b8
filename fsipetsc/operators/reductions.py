"""Reductions over parts of the memory. Extrema are exact and let through what is not a number; sums may be done in any
order, and their last bits depend on how the memory is cut into parts.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS, maximum, minimum

_SUMS = {**OPTIONS, "fastmath": {"reassoc", "contract"}}


@njit(**OPTIONS)
def largest(s, at, count):
    """Maximum of s[at:at+count]."""
    result = -np.inf
    for i in range(count):
        result = maximum(result, s[at + i])
    return result


@njit(**OPTIONS)
def smallest(s, at, count):
    """Minimum of s[at:at+count]."""
    result = np.inf
    for i in range(count):
        result = minimum(result, s[at + i])
    return result


@njit(**_SUMS)
def total(s, at, count):
    """Sum of s[at:at+count]."""
    result = 0.0
    for i in range(count):
        result += s[at + i]
    return result


@njit(**_SUMS)
def total_of_squares(s, at, count):
    """Sum of the squares of s[at:at+count]."""
    result = 0.0
    for i in range(count):
        result += s[at + i] * s[at + i]
    return result
