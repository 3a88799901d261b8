"""Undivided differences of order q in both directions, sums += -Delta_q^T F: see fsipetsc.physics.plane.dissipation. Compiled.

A physics has

    differenced, averaged, watched     which of its rows v are differenced, of which the mean in the middle of a difference is
                                       wanted, and which tell a shock
    dissipation(law, c, mean, differences, m, strength)    F for each of the sums, m as in fsipetsc.scheme.plane.pairs
    gather                             for each of the sums, DIFFERENCE or MIDDLE: whether the points get F by the weights of
                                       the difference or those in its middle do
    steepness(law, c, below, here, above)    s, of what is watched at three points in a row

Columns of Delta add up to nothing: what is summed up stays. Next to ends a difference counts as much as the least weight of the
norm of its points, or it would be as much stiffer there as that is small.
"""

from __future__ import annotations

from math import comb

import numpy as np
from numba import njit

from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64
from fsipetsc.operators.memory import load, store
from fsipetsc.operators.rows import at, fill
from fsipetsc.operators.vectors import LANES, fma, maximum, spread
from fsipetsc.physics.plane.dissipation import MIDDLE, alpha
from fsipetsc.scheme.plane.sums import fluxes_of, gains_of, norm_at
from fsipetsc.scheme.plane.sweep import STEEPNESS, row_of_ring
from fsipetsc.scheme.sweep import row_of

#: by q and point: weights of the difference, and of what its points in the middle get
_DIFFERENCE = np.array([[(-1) ** (q - m) * comb(q, m) if m <= q else 0 for m in range(5)] for q in range(5)], float)
_MIDDLE = np.array([[0.5 * ((m == q // 2) + (m == (q + 1) // 2)) for m in range(5)] for q in range(5)])


@njit(**OPTIONS)
def dissipate_across(law, layer, op, s, place, j):
    """The differences that begin at row j and go up."""
    if layer.shocks > 0.0:
        q = op.p if layer.dissipation > 0.0 else 1
        first = j if j == max(layer.own_y[0] - op.p, 0) else j + q
        for k in range(first, min(j + q, layer.height - 1) + 1):
            look_across(law, layer, s, place, k)
    if layer.dissipation > 0.0:
        _across(law, layer, op, s, place, j, op.p, layer.dissipation, False)
    if layer.shocks > 0.0:
        _across(law, layer, op, s, place, j, 1, layer.shocks, True)


@njit(**OPTIONS)
def dissipate_along(law, layer, op, s, place, j):
    """Those along row j."""
    if layer.shocks > 0.0:
        look_along(law, layer, s, place, j, op.p if layer.dissipation > 0.0 else 1)
    if layer.dissipation > 0.0:
        _along(law, layer, op, s, place, j, op.p, layer.dissipation, False)
    if layer.shocks > 0.0:
        _along(law, layer, op, s, place, j, 1, layer.shocks, True)


@njit(**OPTIONS)
def _across(law, layer, op, s, place, j, q, strength, at_shocks):
    lo, hi = layer.end_y[0], layer.end_y[1]
    if j < lo or j + q > min(hi, layer.height - 1):
        return
    strength *= least_norm(op, j, q, lo, hi) / layer.h_y
    a, b, f = place.first, place.end, fluxes_of(law, place)
    fluxes(law, layer, s, place, j, a, b, 1, q, strength, at_shocks)
    for m in range(q + 1):
        sums = each(row_of_ring.at, law.sums, place.sums, j + m)
        for i in range(a, b, LANES):
            each(of_differences.give, law.gather, sums, f, s, i, i, q, m)


@njit(**OPTIONS)
def _along(law, layer, op, s, place, j, q, strength, at_shocks):
    a, b, lo, hi = place.first, place.end, layer.end_x[0], layer.end_x[1]
    first, last, f, gains = max(a - q, lo), min(b - 1, hi - q), fluxes_of(law, place), gains_of(law, place)
    fluxes(law, layer, s, place, j, first, last + 1, 0, q, strength / layer.h_x, at_shocks)
    for i in range(first, last + 1):
        if i < lo + op.rows or i + q > hi - op.rows:
            each(of_differences.scale, f, least_norm(op, i, q, lo, hi), s, i)
    each(of_differences.blank, f, s, first - q, first)
    each(of_differences.blank, f, s, last + 1, last + 1 + q)
    for m in range(q + 1):
        for i in range(a, b, LANES):
            each(of_differences.give, law.gather, gains, f, s, i, i - m, q, m)


@njit(**OPTIONS)
def least_norm(op, i, q, lo, hi):
    """The least weight of the norm of the points of a difference between the ends lo and hi, no more than inside."""
    least = 1.0
    for m in range(q + 1):
        least = min(least, norm_at(op, i + m, lo, hi))
    return least


@njit(**OPTIONS)
def fluxes(law, layer, s, place, j, first, end, up, q, strength, at_shocks):
    """F of the differences that begin at the points first .. end-1 of row j, and go along the row (up = 0) or up (1)."""
    c, to = law.constants(law, layer), fluxes_of(law, place)
    for i in range(first, end, LANES):
        differences = each(of_differences.difference, law.differenced, s, place, j, i, up, q)
        mean = each(of_differences.mean, law.averaged, place.v, s, j, i, up, q)
        if up == 1:
            ja = each(of_differences.mean, (3, 4), place.e, s, j, i, up, q)
            g = middle(5, place.e, s, j, i, up, q)
        else:
            ja = each(of_differences.mean, (0, 1), place.e, s, j, i, up, q)
            g = 0.5 * middle(2, place.e, s, j, i, up, q)
        rate = spread(strength)
        if layer.shocks > 0.0:
            found = alpha(steepest(s, place, j, i, up, q))
            rate = strength * (found if at_shocks else 1.0 - found)
        each(row_of.store, to, law.dissipation(law, c, mean, differences, (*ja, g), rate), s, i)


@njit(**OPTIONS)
def look_across(law, layer, s, place, j):
    """s of row j from the rows beside it, none at an end."""
    to, c = at(place.v, STEEPNESS, j), law.constants(law, layer)
    if j == layer.end_y[0] or j == layer.end_y[1]:
        fill(s, to, place.first, place.end, 0.0)
        return
    below, above = each(row_of_ring.at, law.watched, place.v, j - 1), each(row_of_ring.at, law.watched, place.v, j + 1)
    here = each(row_of_ring.at, law.watched, place.v, j)
    for i in range(place.first, place.end, LANES):
        three = each(row_of.load, below, s, i), each(row_of.load, here, s, i), each(row_of.load, above, s, i)
        store(s, to + i, law.steepness(law, c, *three))


@njit(**OPTIONS)
def look_along(law, layer, s, place, j, q):
    """s along row j, as far as differences of order q that reach its own points take it."""
    lo, hi = layer.end_x[0], layer.end_x[1]
    rows, c = each(row_of_ring.at, law.watched, place.v, j), law.constants(law, layer)
    for i in range(max(place.first - q, lo), min(place.end - 1 + q, hi) + 1, LANES):
        three = each(row_of.load, rows, s, i - 1), each(row_of.load, rows, s, i), each(row_of.load, rows, s, i + 1)
        store(s, place.slopes + i, law.steepness(law, c, *three))
    for end in (lo, hi):
        if place.first - q <= end < place.end + q:
            s[U64(place.slopes + end)] = 0.0


@njit(**FORMULA)
def steepest(s, place, j, i, up, q):
    """The largest s of the points of a difference of order q."""
    found = spread(0.0)
    for m in range(q + 1):
        row = at(place.v, STEEPNESS, j + m) if up == 1 else place.slopes + m
        found = maximum(found, load(s, row + i))
    return found


@njit(**FORMULA)
def middle(number, ring, s, j, i, up, q):
    """Mean of the two points, or value at the one, in the middle of a difference."""
    m, n = q // 2, (q + 1) // 2
    m_row, n_row = at(ring, number, j + m * up), at(ring, number, j + n * up)
    return 0.5 * (load(s, m_row + i + m * (1 - up)) + load(s, n_row + i + n * (1 - up)))


# what is done to each of some rows


@njit(**FORMULA)
def _difference(number, s, place, j, i, up, q):
    d = spread(0.0)
    for m in range(q + 1):
        d = fma(_DIFFERENCE[q, m], load(s, at(place.v, number, j + m * up) + i + m * (1 - up)), d)
    return d


@njit(**FORMULA)
def _give(gather, to, f, s, i, from_i, q, m):
    weight = _MIDDLE[q, m] if gather == MIDDLE else _DIFFERENCE[q, m]
    store(s, to + i, load(s, to + i) - weight * load(s, f + from_i))
    return 0


@njit(**FORMULA)
def _scale(row, number, s, i):
    s[U64(row + i)] *= number
    return 0


@njit(**FORMULA)
def _blank(row, s, first, end):
    for i in range(first, end):
        s[U64(row + i)] = 0.0
    return 0


of_differences = Formulas(difference=_difference, mean=middle, give=_give, scale=_scale, blank=_blank)
