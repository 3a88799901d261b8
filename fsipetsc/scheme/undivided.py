"""Terms of the rates that are made of undivided differences. Compiled.

    q_t += scale H^-1 sum_k  Delta_k^T  flux(mean_k c, Delta_k y),          k = first .. last

y are rows of values, c coefficients at the points, both of a physics; mean_k c is a weighted sum of c at the points in the
middle of a difference, Delta_k the undivided difference of order k, taken where all of its points are active, and H the norm;
at the ends there are terms of their own, as fsipetsc.operators.narrow has them.
As the columns of Delta_k add up to nothing, such terms take nothing away from the integral of any unknown. A term is

    unknowns                                those whose rates it belongs to
    levels(op)                              first, last and the weights of the means (LEVELS of fsipetsc.operators.sbp)
    coefficients, sums                      (0, 1, ...), a number for each of c, and further ones, for each of the unknowns
    constants(law, layer)                   numbers that the formulas need
    weigh(law, constants, q, v, f)          c at a point
    rows(q, v)                              where the rows y begin
    flux(means, differences)                for each of the unknowns
    scale(layer)                            factor
    at_wall(velocity, changes)              of the rates at an end point that a moving wall gives its momentum

for a law whose ``undivided`` has it; q, v and f as in fsipetsc.scheme.sweep. A term reaches ``last`` points, and may go as far
as D twice does.

Sums over k are made from the last one down: Delta_{k+1}^T g = Delta_k^T (what is g at the difference before less what it is
at this one), so that one row takes up all orders, and Delta_first^T is applied once.
"""

from __future__ import annotations

from math import comb
from typing import NamedTuple

import numpy as np
from numba import njit

from fsipetsc.boundaries import WALL
from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, OPTIONS, ROW, U64, store_lanes, whole_vectors
from fsipetsc.operators.narrow import difference
from fsipetsc.operators.vectors import LANES, fma, load, masked, spread, store
from fsipetsc.physics.layer import LOADED
from fsipetsc.scheme.sweep import row_of

#: first row of scratch that is used here, and how many are
FIRST, ROWS = 5, 5
#: weights of the differences up to the order 8, by order
_DIFFERENCE = np.array([difference(order) + [0] * (8 - order) for order in range(9)], dtype=float)
#: ``Pairs`` by order
_PAIRS = np.array([[(-1) ** k, *((-1) ** j * comb(k, j) / (2 if 2 * j == k else 1) for j in range(1, 5))] for k in range(9)])


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


@njit(**OPTIONS)
def nothing(law, layer, op, s, w, v, f, target, i0, i1):
    """Of physics without such terms."""


@njit(**OPTIONS)
def add_undivided(law, layer, op, s, w, v, f, target, i0, i1):
    """Add the terms to the rates that went to ``target``, at the active points i0 .. i1-1.

    v, f: where what is prepared and the fluxes begin in scratch; they are known up to 2 op.reach and op.reach points beyond.
    """
    each(undivided_of.add, law.undivided, law, layer, op, s, w, v, f, target, i0, i1)


@njit(**OPTIONS)
def _add(term, law, layer, op, s, w, v, f, target, i0, i1):
    """One of the terms."""
    levels, free = term.levels(op), v + FIRST * ROW
    c, sums = each(row_of.place, term.coefficients, free, ROW), each(row_of.place, term.sums, free, ROW)
    q, v = each(row_of.place, law.unknowns, w, layer.stride), each(row_of.place, law.prepared, v, ROW)
    f, y, numbers = each(row_of.place, law.fluxes, f, ROW), term.rows(q, v), term.constants(law, layer)
    for i in range(max(layer.lo, i0 - op.reach), min(layer.hi + 1, i1 + op.reach), LANES):
        here = each(row_of.load, q, s, i), each(row_of.load, v, s, i), each(row_of.load, f, s, i)
        each(row_of.store, c, term.weigh(law, numbers, here[0], here[1], here[2]), s, i)
    sum_up(term, layer, levels, s, c, y, sums, i0, i1)
    sum_up_ends(term, layer, levels, s, c, y, sums, i0, i1)
    send(term, layer, op, levels, s, sums, target, i0, i1)
    return 0


@njit(**OPTIONS)
def sum_up(term, layer, levels, s, c, y, sums, i0, i1):
    """The sums over k but for the ends: that of the difference which begins at i stands at i + levels.first - levels.last."""
    lo, hi, last = layer.lo + levels.skipped, layer.hi - levels.skipped, levels.last
    for i in range(i0 - last - LANES, i1 + LANES, LANES):
        each(undivided_of.clear, sums, s, i)
    # what is stored here begins each time a point earlier, and overwrites what has been used
    for order in range(last, levels.first - 1, -1):
        k, pairs, end = order - levels.first, pairs_of(order), min(i1, hi + 1 - order)
        count, weights = levels.counts[k], weights_of_mean(levels, k)
        for i in range(max(lo, i0 - order), end, LANES):
            means = each(undivided_of.mean, c, s, i, order, count, weights)
            differences = each(undivided_of.difference, y, s, i, order, pairs)
            each(undivided_of.add_up, sums, term.flux(means, differences), s, i + order - last, end - i)


@njit(**OPTIONS)
def sum_up_ends(term, layer, levels, s, c, y, sums, i0, i1):
    """The terms of the ends, to the same sums."""
    for side in range(2):
        end, step = (layer.lo, 1) if side == 0 else (layer.hi - levels.first, -1)
        inside = (layer.lo if side == 0 else layer.hi) + step * levels.skipped
        for t in range(levels.ends):
            at = end + step * t
            if i0 - levels.first <= at < i1:
                differences = each(undivided_of.end_difference, y, s, end, step, t, levels)
                fluxes = term.flux(each(undivided_of.at, c, s, inside), differences)
                each(undivided_of.add_at, sums, fluxes, s, at + levels.first - levels.last)


@njit(**OPTIONS)
def send(term, layer, op, levels, s, sums, target, i0, i1):
    """To the rates what the sums say; in place as above."""
    pairs, last, whole = pairs_of(levels.first), levels.last, whole_vectors(i0, i1)
    for i in range(i0, i1, LANES):
        each(undivided_of.apply_transposed, sums, s, i - last, levels.first, pairs)
    for r in range(op.rows):
        for i in (layer.lo + r, layer.hi - r):
            if i0 <= i < i1:
                each(undivided_of.divide, sums, s, i - last, op.norm[r])
    for side in range(2):
        end = layer.lo if side == 0 else layer.hi
        if i0 <= end < i1 and layer.unloaded[side] != LOADED and layer.end_kind[side] == WALL:
            changes = term.at_wall(layer.end_v[side], each(undivided_of.at, sums, s, end - last))
            each(undivided_of.put, sums, changes, s, end - last)
    scale = term.scale(layer) * (1.0 - 2.0 * (levels.first % 2))
    for i in range(i0, whole, LANES):
        each(undivided_of.add_to_rates, term.unknowns, sums, s, i - last, scale, target, i)
    if whole < i1:
        each(undivided_of.add_lanes_to_rates, term.unknowns, sums, s, whole - last, scale, target, whole, i1 - whole)


# what is done to each of some rows


@njit(**FORMULA)
def _clear(begin, s, i):
    store(s, begin + i, spread(0.0))
    return 0


@njit(**FORMULA)
def _mean(begin, s, i, order, count, weights):
    """Of the coefficient in the differences that begin at i .. i+3."""
    at = begin + i + (order + 1 - count) // 2
    return mean(count, weights, load(s, at), load(s, at + 1), load(s, at + 2), load(s, at + 3))


@njit(**FORMULA)
def _difference(begin, s, i, order, pairs):
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
def _add_up(begin, flux, s, at, n):
    """The first n lanes of a flux, and what comes down from the sums of the order above."""
    above = load(s, begin + at) - load(s, begin + at + 1)
    store(s, begin + at, masked(flux, n, 0.0) + above)
    return 0


@njit(**FORMULA)
def _at(begin, s, i):
    return s[U64(begin + i)]


@njit(**FORMULA)
def _put(begin, value, s, i):
    s[U64(begin + i)] = value
    return 0


@njit(**FORMULA)
def _end_difference(begin, s, end, step, t, levels):
    """What the term of the end takes for difference t there: a sum of the first ones."""
    result = 0.0
    for k in range(levels.ends):
        difference = 0.0
        for j in range(levels.first + 1):
            difference += _DIFFERENCE[levels.first, j] * s[U64(begin + end + step * k + j)]
        result += levels.end[t, k] * difference
    return result


@njit(**FORMULA)
def _add_at(begin, flux, s, at):
    s[U64(begin + at)] += flux
    return 0


@njit(**FORMULA)
def _apply_transposed(begin, s, at, order, pairs):
    """The transposed difference, but for its sign if the order is odd, at points whose own sums stand ``order`` further on."""
    store(s, begin + at, _difference(begin, s, at, order, pairs))
    return 0


@njit(**FORMULA)
def _divide(begin, s, at, weight):
    s[U64(begin + at)] /= weight
    return 0


@njit(**FORMULA)
def _add_to_rates(unknown, begin, s, at, scale, target, i):
    to, change = unknown * target.stride + i, scale * load(s, begin + at)
    store(s, target.next + to, fma(target.a, change, load(s, target.next + to)))
    if target.sum >= 0:
        store(s, target.sum + to, fma(target.b, change, load(s, target.sum + to)))
    return 0


@njit(**FORMULA)
def _add_lanes_to_rates(unknown, begin, s, at, scale, target, i, n):
    """The first n lanes."""
    to, change = unknown * target.stride + i, scale * load(s, begin + at)
    store_lanes(s, target.next + to, fma(target.a, change, load(s, target.next + to)), 0, n)
    if target.sum >= 0:
        store_lanes(s, target.sum + to, fma(target.b, change, load(s, target.sum + to)), 0, n)
    return 0


undivided_of = Formulas(
    add=_add,
    clear=_clear,
    mean=_mean,
    difference=_difference,
    add_up=_add_up,
    apply_transposed=_apply_transposed,
    at=_at,
    put=_put,
    end_difference=_end_difference,
    add_at=_add_at,
    divide=_divide,
    add_to_rates=_add_to_rates,
    add_lanes_to_rates=_add_lanes_to_rates,
)
