"""Convection in two-point form, -2 sum_l D_il F(i, l), for the rates; see fsipetsc.physics.two_point. Compiled.

In the interior D_il = c_k / h with l = i + k, and F is symmetric: the sum is that of c_k (F_k(i) - F_k(i-k)), F_k(i) the flux
of the points i and i+k, k = 1 .. p, each computed once. At the ends the rows of the closure take F of each of their points with
each column.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, OPTIONS, ROW, U64, end_of, end_rows, row_length, store_lanes, whole_vectors
from fsipetsc.operators.lanes import lane, mirrored
from fsipetsc.operators.memory import load, store
from fsipetsc.operators.vectors import LANES, fma, numbers_from, spread
from fsipetsc.scheme.end_rates import end_slopes
from fsipetsc.scheme.sweep import row_of
from fsipetsc.scheme.undivided import add_undivided, undivided_of


@njit(**OPTIONS)
def add_pairs(law, layer, op, s, w, v, f, target, i0, i1):
    """Add convection to the rates at the active points i0 .. i1-1; and then the terms of undivided differences."""
    q, v_rows = each(row_of.place, law.unknowns, w, layer.stride), each(row_of.place, law.prepared, v, ROW)
    fluxes, sums = each(row_of.place, law.flux_of_pairs, f, ROW), each(row_of.place, law.sums_of_pairs, f, ROW)
    rows, constants = law.state_rows(q, v_rows), law.constants(law, layer)
    a, b = max(i0, layer.lo + op.rows), min(i1, layer.hi + 1 - op.rows)
    for i in range(a, b, LANES):
        each(undivided_of.clear, sums, s, i)
    for k in range(1, op.p + 1):
        for i in range(a - k, b, LANES):
            w_mean = fma(constants[3], numbers_from(i) + 0.5 * k, constants[2])
            one, other = each(row_of.load, rows, s, i), each(row_of.load, rows, s, i + k)
            each(row_of.store, fluxes, law.pair_flux(constants, one, other, w_mean), s, i)
        weight = 2.0 * op.interior[k - 1]
        for i in range(a, b, LANES):
            each(pairs_of.add_difference, sums, fluxes, s, i, k, weight)
    for side in range(2):
        end, known = end_of(layer.lo, layer.hi, side, i0 - 2 * op.reach, i1 + 2 * op.reach)
        for r in range(0, op.rows, LANES):
            i, first, last = end_rows(op, layer.lo, layer.hi, side, r, i0, i1)
            if first < last:
                close(law, op, constants, s, rows, sums, end, side, known, r, i, first, last)
    whole, scale = whole_vectors(i0, i1), -1.0 / layer.h
    for i in range(i0, whole, LANES):
        each(undivided_of.add_to_rates, law.unknowns, sums, s, i, scale, target, i)
    if whole < i1:
        each(undivided_of.add_lanes_to_rates, law.unknowns, sums, s, whole, scale, target, whole, i1 - whole)
    add_undivided(law, layer, op, s, w, v, f, target, i0, i1)


@njit(**OPTIONS)
def close(law, op, constants, s, rows, sums, end, side, known, r, i, first, last):
    """Rows r .. r+3 of the closure, which stand at the points i .. i+3, to the lanes first .. last-1 of the sums."""
    step = 1 - 2 * side
    one, places = each(row_of.load, rows, s, i), numbers_from(i)
    if side == 1:
        one, places = each(pairs_of.mirror, one), mirrored(places)
    found = each(pairs_of.nothing, sums)
    for c in range(min(op.cols, known)):
        at = end + step * c
        other = each(pairs_of.spread_at, rows, s, at)
        w_mean = fma(0.5 * constants[3], places + 1.0 * at, constants[2])
        flux = law.pair_flux(constants, one, other, w_mean)
        found = each(pairs_of.add_weighted, found, flux, 2.0 * load(op.columns, 8 * c + r))
    if side == 1:
        found = each(pairs_of.mirror, found)
    each(pairs_of.store_signed, sums, found, s, i, first, last, 1.0 * step)


@njit(**OPTIONS)
def flux_through_end(law, layer, s, w, v, f, end):
    """(rho, rho u, e): convection and what is viscous."""
    rows, constants = rows_and_constants(law, layer, w, v)
    flux = pair_at(law, constants, s, rows, end, end)
    return s[U64(f + end)] + flux[0], s[U64(f + ROW + end)] + flux[1], s[U64(f + 2 * ROW + end)] + flux[2]


@njit(**OPTIONS)
def slopes_at_end(law, layer, op, s, w, v, f, side):
    """h D of both at the end point: the first row of the closure."""
    rows, constants = rows_and_constants(law, layer, w, v)
    end, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
    rho, m, e = end_slopes(law, layer, op, s, w, v, f, side)
    for c in range(row_length(op)):
        flux, weight = pair_at(law, constants, s, rows, end, end + step * c), 2.0 * step * op.closure[0, c]
        rho, m, e = rho + weight * flux[0], m + weight * flux[1], e + weight * flux[2]
    return rho, m, e


@njit(**FORMULA)
def rows_and_constants(law, layer, w, v):
    """What ``pair_at`` takes."""
    q, v_rows = each(row_of.place, law.unknowns, w, layer.stride), each(row_of.place, law.prepared, v, ROW)
    return law.state_rows(q, v_rows), law.constants(law, layer)


@njit(**OPTIONS)
def pair_at(law, constants, s, rows, i, j):
    """F(i, j), three numbers."""
    w_mean = spread(constants[2] + 0.5 * constants[3] * (i + j))
    flux = law.pair_flux(constants, each(pairs_of.spread_at, rows, s, i), each(pairs_of.spread_at, rows, s, j), w_mean)
    return lane(flux[0], 0), lane(flux[1], 0), lane(flux[2], 0)


# what is done to each of some rows or values


@njit(**FORMULA)
def _add_difference(begin, flux, s, i, k, weight):
    store(s, begin + i, fma(weight, load(s, flux + i) - load(s, flux + i - k), load(s, begin + i)))
    return 0


@njit(**FORMULA)
def _mirror(value):
    return mirrored(value)


@njit(**FORMULA)
def _nothing(begin):
    return spread(0.0)


@njit(**FORMULA)
def _spread_at(begin, s, i):
    return spread(s[U64(begin + i)])


@njit(**FORMULA)
def _add_weighted(found, flux, weight):
    return fma(weight, flux, found)


@njit(**FORMULA)
def _store_signed(begin, value, s, i, first, last, sign):
    store_lanes(s, begin + i, sign * value, first, last)
    return 0


pairs_of = Formulas(
    add_difference=_add_difference,
    mirror=_mirror,
    nothing=_nothing,
    spread_at=_spread_at,
    add_weighted=_add_weighted,
    store_signed=_store_signed,
)
