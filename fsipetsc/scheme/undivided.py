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

for a law whose ``undivided`` has it; q, v and f as in fsipetsc.scheme.sweep. A term reaches ``last`` points, and may go as far
as D twice does.

Sums over k are made from the last one down: Delta_{k+1}^T g = Delta_k^T (what is g at the difference before less what it is
at this one), so that one row takes up all orders, and Delta_first^T is applied once.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, OPTIONS, ROW, U64, store_lanes
from fsipetsc.operators.narrow import difference
from fsipetsc.operators.vectors import LANES, fma, load, masked, spread, store
from fsipetsc.scheme.sweep import row_of

#: first row of scratch that is used here, and how many are
FIRST, ROWS = 5, 5
#: weights of the differences up to the order 8, by order
_DIFFERENCE = np.array([difference(order) + [0] * (8 - order) for order in range(9)], dtype=float)


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
    lo, hi, levels, last, free = layer.lo, layer.hi, term.levels(op), term.levels(op).last, v + FIRST * ROW
    q, v = each(row_of.place, law.unknowns, w, layer.stride), each(row_of.place, law.prepared, v, ROW)
    f, c = each(row_of.place, law.fluxes, f, ROW), each(row_of.place, term.coefficients, free, ROW)
    y, sums, numbers = term.rows(q, v), each(row_of.place, term.sums, free, ROW), term.constants(law, layer)
    for i in range(max(lo, i0 - op.reach), min(hi + 1, i1 + op.reach), LANES):
        here = each(row_of.load, q, s, i), each(row_of.load, v, s, i), each(row_of.load, f, s, i)
        each(row_of.store, c, term.weigh(law, numbers, here[0], here[1], here[2]), s, i)
    for i in range(i0 - last - LANES, i1 + LANES, LANES):
        each(undivided_of.clear, sums, s, i)
    # what is stored below begins each time a point earlier, and overwrites what has been used
    for order in range(last, levels.first - 1, -1):
        end = min(i1, hi + 1 - levels.skipped - order)
        for i in range(max(lo + levels.skipped, i0 - order), end, LANES):
            fluxes = term.flux(each(undivided_of.mean, c, s, i, order, levels), each(undivided_of.difference, y, s, i, order))
            each(undivided_of.add_up, sums, fluxes, s, i + order - last, end - i)
    for side in range(2):
        end, step = (lo, 1) if side == 0 else (hi - levels.first, -1)
        for t in range(levels.ends):
            at = end + step * t
            if i0 - levels.first <= at < i1:
                inside = (lo if side == 0 else hi) + step * levels.skipped
                means = each(undivided_of.at, c, s, inside)
                fluxes = term.flux(means, each(undivided_of.end_difference, y, s, end, step, t, levels))
                each(undivided_of.add_at, sums, fluxes, s, at + levels.first - last)
    for i in range(i0, i1, LANES):
        each(undivided_of.apply_transposed, sums, s, i - last, levels.first)
    for r in range(op.rows):
        for i in (lo + r, hi - r):
            if i0 <= i < i1:
                each(undivided_of.divide, sums, s, i - last, op.norm[r])
    scale = term.scale(layer)
    for i in range(i0, i1, LANES):
        each(undivided_of.add_to_rates, term.unknowns, sums, s, i - last, scale, target, i, i1 - i)
    return 0


# what is done to each of some rows


@njit(**FORMULA)
def _clear(begin, s, i):
    store(s, begin + i, spread(0.0))
    return 0


@njit(**FORMULA)
def _mean(begin, s, i, order, levels):
    """Of the coefficient in the differences that begin at i .. i+3."""
    k = order - levels.first
    count = levels.counts[k]
    at, mean = begin + i + (order + 1 - count) // 2, spread(0.0)
    for j in range(count):
        mean = fma(load(s, at + j), levels.weights[k, j], mean)
    return mean


@njit(**FORMULA)
def _difference(begin, s, i, order):
    """Those that begin at i .. i+3."""
    result = load(s, begin + i + order)
    for j in range(order):
        result = fma(load(s, begin + i + j), _DIFFERENCE[order, j], result)
    return result


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
def _apply_transposed(begin, s, at, order):
    """The transposed difference of this order at points whose own sums stand ``order`` further on, to where ``at`` is."""
    result = load(s, begin + at)
    for j in range(1, order + 1):
        result = fma(load(s, begin + at + j), _DIFFERENCE[order, order - j], result)
    store(s, begin + at, result)
    return 0


@njit(**FORMULA)
def _divide(begin, s, at, weight):
    s[U64(begin + at)] /= weight
    return 0


@njit(**FORMULA)
def _add_to_rates(unknown, begin, s, at, scale, target, i, n):
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
    end_difference=_end_difference,
    add_at=_add_at,
    divide=_divide,
    add_to_rates=_add_to_rates,
)
