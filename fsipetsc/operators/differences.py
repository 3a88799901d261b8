"""Undivided differences of rows of values and what belongs to them, a vector of points at a time. Compiled.

Delta_k of order k at point i takes the values at i .. i+k; it stands at i. Means are those of the points in its middle.
"""

from __future__ import annotations

from math import comb
from typing import NamedTuple

import numpy as np
from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64
from fsipetsc.operators.memory import load
from fsipetsc.operators.narrow import difference
from fsipetsc.operators.vectors import fma

#: weights of the differences up to the order 8, by order
_DIFFERENCE = np.array([difference(order) + [0] * (8 - order) for order in range(9)], dtype=float)
#: ``Pairs`` by order
_PAIRS = np.array(
    [[(-1) ** k, *((-1) ** j * comb(k, j) / (2 if 2 * j == k else 1) * (2 * j <= k) for j in range(1, 5))] for k in range(9)]
)


class Pairs(NamedTuple):
    """Weights of a difference: of the first point, 1 or -1, the last having 1, and of those 1, 2, 3, 4 away from the last.

    Points as far from either end are taken together; a middle point is met twice so, and counts half.
    """

    sign: float
    first: float
    second: float
    third: float
    fourth: float


class Weights(NamedTuple):
    """Of the points that have a say in a mean."""

    a: float
    b: float
    c: float
    d: float


@njit(**FORMULA)
def pairs_of(order):
    """Of a difference of this order."""
    p = U64(order)
    return Pairs(_PAIRS[p, 0], _PAIRS[p, 1], _PAIRS[p, 2], _PAIRS[p, 3], _PAIRS[p, 4])


@njit(**FORMULA)
def weights_of_mean(levels, k):
    """Of order number k."""
    w = levels.weights
    return Weights(w[k, 0], w[k, 1], w[k, 2], w[k, 3])


@njit(**FORMULA)
def weight_of(order, j):
    """Of point number j in a difference of this order."""
    return _DIFFERENCE[U64(order), U64(j)]


@njit(**FORMULA)
def mean_of(begin, s, i, order, count, weights):
    """Of the coefficient in the differences that begin at i .. i+3."""
    at = begin + i + (order + 1 - count) // 2
    return mean(count, weights, load(s, at), load(s, at + 1), load(s, at + 2), load(s, at + 3))


@njit(**FORMULA)
def difference_of(begin, s, i, order, pairs):
    """Those that begin at i .. i+3."""
    at, to = begin + i, begin + i + order
    ends, others = (load(s, at), load(s, to)), (load(s, at + 1), load(s, to - 1))
    second, third = (load(s, at + 2), load(s, to - 2)), (load(s, at + 3), load(s, to - 3))
    return paired(order, pairs, ends, others, second, third, (load(s, at + 4), load(s, to - 4)))


# these take vectors, not the array: a choice in a function that has it makes numba count who refers to it, at each point


@njit(**FORMULA)
def mean(count, weights, a, b, c, d):
    """Weighted sum of the first ``count``."""
    result = weights.a * a
    if count > 1:
        result = fma(weights.b, b, result)
        if count > 2:
            result = fma(weights.c, c, result)
            if count > 3:
                result = fma(weights.d, d, result)
    return result


@njit(**FORMULA)
def paired(order, pairs, ends, first, second, third, fourth):
    """Differences of this order, from 2 to 8, from their ends and the points 1, 2, 3, 4 away from them, where there are any."""
    sign = pairs.sign
    d = fma(pairs.first, fma(sign, first[0], first[1]), fma(sign, ends[0], ends[1]))
    if order > 3:
        d = fma(pairs.second, fma(sign, second[0], second[1]), d)
        if order > 5:
            d = fma(pairs.third, fma(sign, third[0], third[1]), d)
            if order > 7:
                d = fma(pairs.fourth, fma(sign, fourth[0], fourth[1]), d)
    return d


@njit(**FORMULA)
def _alternating(order):
    """The sign that ``difference_of`` leaves out of the transposed one."""
    return 1.0 - 2.0 * (order % 2)


@njit(**FORMULA)
def _from_middles(begin, s, at, order, pairs):
    """From the differences in the middle of which a point stands; two share the points if the order is odd."""
    near = begin + at + order // 2
    return 0.5 * (load(s, near) + load(s, near + order % 2))


@njit(**FORMULA)
def _one(order):
    return 1.0


@njit(**OPTIONS)
def no_look(layer, op, s, places, i0, i1):
    """Of a term whose differences have no numbers of their own."""


#: what a point takes from the differences around it: their transposed, which conserves, or what stands in their middle
DIFFERENCE = Formulas(gather=difference_of, sign=_alternating)
MIDDLE = Formulas(gather=_from_middles, sign=_one)
