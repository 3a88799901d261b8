"""The right-hand side of a layer in two dimensions, row by row, of whatever physics it is given. Compiled.

Every physics here has the form

    q_t = rate(v, D_x a + D_y b, e, sums),      (a, b, e) = flux(v, D_x v, D_y v),      v = prepare(q)

with the unknowns q of a point, what is derived from them there (v), fluxes a along X and b along Y, further quantities e, and
sums of what it has to do with other points, pair by pair.
The boundary fluxes are left out: the operator is *loose* at the edges, h a_0 D_00 = +1/2 instead of -1/2, so that what
comes out are the rates without traction, heat and mass through any edge (fsipetsc.scheme.plane.edges adds what there is).
Only the J of a grid keeps the whole derivative. A physics is formulas at a point, of vectors of points:

    unknowns, prepared, fluxes, extras  (0, 1, ...), a number for each of q, v, a (and b), e
    differentiated                   those of v of which D_x and D_y are wanted
    looks_ahead                      1 if rows beyond those of a flux are needed, as for derivatives
    loose                            for each flux 1, or 0 for the whole derivative
    constants(law, layer)            numbers that the formulas need
    prepare(law, c, q)               v
    grid(s, lines, stride, height, i)    metrics of the grid at the points i .., see ``heights``
    flux(law, c, v, metrics, D_x v, D_y v)    a, b, e
    rate(law, c, v, divergence, e, sums)
    sums                             (0, 1, ...), a number for each unknown to which pairs of points give something, beside
                                     ``paired`` and ``pair``: see fsipetsc.scheme.plane.pairs
    meet(law, layer, op, s, place, j)    what there is to do for the sums of row j
    amend(law, layer, op, s, place, lines, j)    gives the rates of row j what goes through the edges

A row goes through three stages, each as far ahead of the next as the derivatives across rows need it: v, fluxes, rates. So
what lies between q and its rate is never more than a ring of rows, which stays in a cache.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, OPTIONS
from fsipetsc.operators.rows import MARGIN, Ring, across, along, at
from fsipetsc.operators.vectors import LANES, WIDE, load_interlaced, load_wide, spread_wide
from fsipetsc.physics.plane.gas import GRID_ROWS
from fsipetsc.physics.plane.layer import DOF
from fsipetsc.scheme.plane.targets import send_row
from fsipetsc.scheme.sweep import row_of

#: most quantities of each sort that a physics may have
PREPARED, FLUXES, EXTRAS, SUMS = 14, 4, 7, 4
#: number of the last of what is prepared, which is there for fsipetsc.scheme.plane.dissipation
STEEPNESS = PREPARED - 1
#: rows of scratch: v, fluxes across, derivatives of those along, extras, sums over pairs, each in a ring; and of one row its
#: slopes in both directions, fluxes along, fluxes and sums of its pairs, rates, what is known of the grid, rates together again
IN_RINGS = PREPARED + 2 * FLUXES + EXTRAS + SUMS
BESIDE = 2 * PREPARED + 2 * FLUXES + 2 * SUMS + DOF + GRID_ROWS + DOF


class Places(NamedTuple):
    """Where the rows of scratch stand."""

    v: Ring
    b: Ring
    d: Ring
    e: Ring
    sums: Ring
    slopes: int
    a: int
    pairs: int
    rates: int
    lines: int
    sent: int
    stride: int


def scratch_stride(width: int) -> int:
    """Doubles from one row of scratch to the next: an odd number of cache lines."""
    lines = (width + 2 * MARGIN + 7) // 8
    return 8 * (lines + 1 - lines % 2)


def ring_rows(op: np.ndarray, record: np.ndarray) -> int:
    """Rows that a ring must have for a layer, a power of two: those between the first and the last that are still needed."""
    (lo, hi), p, rows = record["end_y"].tolist(), int(op["p"]), int(op["rows"])

    def last(j: int) -> int:
        return lo + int(op["cols"]) - 1 if j < lo + rows else hi if j > hi - rows else j + p

    most = 1
    for j in range(*record["own_y"].tolist()):
        first = (lo if j < lo + rows else min(j - p, hi - int(op["cols"]) + 1)) - 1  # one more for dissipation's sensor
        ahead = max(last(f) for f in range(max(j - p, 0), min(last(j), int(record["height"]) - 1) + 1))
        most = max(most, min(ahead, int(record["height"]) - 1) - max(first, 0) + 1)
    return 1 << (most - 1).bit_length()


def scratch(stride: int, first: int, ring: int) -> np.ndarray:
    """Scratch for rows so far apart, whose columns from number ``first`` on begin with a cache line."""
    doubles = (ring * IN_RINGS + BESIDE) * stride + 4 * MARGIN
    room = np.zeros(doubles + 8)
    begin = -(room.ctypes.data // 8 + MARGIN + first) % 8
    return room[begin : begin + doubles]


@njit(**OPTIONS)
def places(layer, stride):
    """Of a layer whose rows are this far apart."""
    apart, mask = layer.ring * stride, layer.ring - 1
    v = Ring(MARGIN, apart, stride, mask)
    b = Ring(v.origin + PREPARED * apart, apart, stride, mask)
    d = Ring(b.origin + FLUXES * apart, apart, stride, mask)
    e = Ring(d.origin + FLUXES * apart, apart, stride, mask)
    sums = Ring(e.origin + EXTRAS * apart, apart, stride, mask)
    slopes = sums.origin + SUMS * apart
    a = slopes + 2 * PREPARED * stride
    pairs = a + 2 * FLUXES * stride
    rates = pairs + 2 * SUMS * stride
    lines = rates + DOF * stride
    return Places(v, b, d, e, sums, slopes, a, pairs, rates, lines, lines + GRID_ROWS * stride, stride)


@njit(**OPTIONS)
def heights(layer, op, j):
    """zeta at row j, from 0 at the lower to 1 at the upper edge, and D_y of zeta and of zeta^2 there."""
    lo, hi, per_length = layer.end_y[0], layer.end_y[1], 1.0 / (layer.ny - 1)
    zeta, of_first, of_second = (layer.first_y + j) * per_length, 0.0, 0.0
    if lo + op.rows <= j <= hi - op.rows:
        for k in range(1, op.p + 1):
            of_first += op.interior[k - 1] * (2 * k * per_length)
        of_second = 2.0 * zeta * of_first
    else:
        end, step, r = (lo, 1, j - lo) if j < lo + op.rows else (hi, -1, hi - j)
        for c in range(op.cols):
            weight, there = step * op.closure[r, c], (layer.first_y + end + step * c) * per_length
            of_first += weight * there
            of_second += weight * (there * there)
    return zeta, of_first / layer.h_y, of_second / layer.h_y


@njit(**OPTIONS)
def last_needed(op, j, lo, hi):
    """The last row that the derivative across rows takes at row j."""
    if j < lo + op.rows:
        return lo + op.cols - 1
    return hi if j > hi - op.rows else j + op.p


@njit(**OPTIONS)
def sweep(law, layer, op, loose, s, place, y, target):
    """Rates of the points that this rank owns, to where ``target`` says; y: the unknowns of all points it holds."""
    lo, hi = layer.end_y[0], layer.end_y[1]
    prepared, fluxed = 0, max(layer.own_y[0] - op.p, 0)
    paired = fluxed
    for j in range(layer.own_y[0], layer.own_y[1]):
        while fluxed <= min(last_needed(op, j, lo, hi), layer.height - 1):
            ahead = last_needed(op, fluxed, lo, hi) if law.looks_ahead == 1 else fluxed
            while prepared <= min(ahead, layer.height - 1):
                prepare_row(law, layer, s, place, y, prepared)
                prepared += 1
            flux_row(law, layer, op, loose, s, place, fluxed)
            fluxed += 1
        while paired <= j:
            law.meet(law, layer, op, s, place, paired)
            paired += 1
        rate_row(law, layer, op, loose, s, place, j)
        law.amend(law, layer, op, s, place, place.lines, j)
        send_row(layer, s, place, target, j)


@njit(**OPTIONS)
def prepare_row(law, layer, s, place, y, j):
    """v of row j."""
    c, first = law.constants(law, layer), j * layer.width * DOF
    v = each(row_of_ring.at, law.prepared, place.v, j)
    for i in range(0, layer.width, LANES):
        each(row_of.store, v, law.prepare(law, c, load_interlaced(y, first + i * DOF, 5)), s, i)


@njit(**OPTIONS)
def columns(layer, op):
    """(a, b): fluxes are needed at the columns a <= i < b."""
    return max(layer.own_x[0] - op.p, 0), min(layer.own_x[1] + op.p, layer.width)


@njit(**OPTIONS)
def flux_row(law, layer, op, loose, s, place, j):
    """Fluxes at row j; of those along it the derivative."""
    a, b = columns(layer, op)
    along_x = slope_rows(law, place)
    each(block_of.slopes, law.differentiated, along_x, layer, op, s, place, j, a, b)
    across_y = each(row_of_ring.second, along_x, place.stride)
    v, c = each(row_of_ring.at, law.prepared, place.v, j), law.constants(law, layer)
    to_a = each(row_of_ring.row, law.fluxes, place.a, place.stride)
    to_b, to_e = each(row_of_ring.at, law.fluxes, place.b, j), each(row_of_ring.at, law.extras, place.e, j)
    sums = each(row_of_ring.at, law.sums, place.sums, j)
    height = heights(layer, op, j)
    for i in range(a, b, WIDE):
        m, here = law.grid(s, place.lines, place.stride, height, i), each(row_of_ring.load, v, s, i)
        fluxes = law.flux(law, c, here, m, each(row_of_ring.load, along_x, s, i), each(row_of_ring.load, across_y, s, i))
        each(row_of.store, to_a, fluxes[0], s, i)
        each(row_of.store, to_b, fluxes[1], s, i)
        each(row_of.store, to_e, fluxes[2], s, i)
        each(row_of.store, sums, spread_wide(0.0), s, i)
    each(block_of.along, law.fluxes, to_a, law.loose, layer, op, loose, s, place, j)


@njit(**FORMULA)
def slope_rows(law, place):
    """Where the slopes along X of each differentiated quantity stand."""
    return each(row_of_ring.slope, law.differentiated, place.slopes, place.stride)


@njit(**OPTIONS)
def slopes(number, to, layer, op, s, place, j, a, b):
    """D_x and D_y of one quantity at row j."""
    along(op, s, at(place.v, number, j), to, a, b, layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
    across(op, s, place.v, number, j, to + place.stride, a, b, layer.end_y[0], layer.end_y[1], 1.0 / layer.h_y)
    return 0


@njit(**OPTIONS)
def divergence_along(number, flux, is_loose, layer, op, loose, s, place, j):
    """D_x of a flux along row j, to its ring."""
    chosen = loose if is_loose == 1 else op
    to = at(place.d, number, j)
    along(chosen, s, flux, to, layer.own_x[0], layer.own_x[1], layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
    return 0


@njit(**OPTIONS)
def divergence_across(number, to, is_loose, layer, op, loose, s, place, j):
    """D_y of a flux across rows at row j."""
    chosen = loose if is_loose == 1 else op
    across(chosen, s, place.b, number, j, to, layer.own_x[0], layer.own_x[1], layer.end_y[0], layer.end_y[1], 1.0 / layer.h_y)
    return 0


@njit(**OPTIONS)
def rate_row(law, layer, op, loose, s, place, j):
    """Rates at row j, to scratch."""
    across_y = each(row_of_ring.row, law.fluxes, place.a + len(law.fluxes) * place.stride, place.stride)
    each(block_of.across, law.fluxes, across_y, law.loose, layer, op, loose, s, place, j)
    c, along_x = law.constants(law, layer), each(row_of_ring.at, law.fluxes, place.d, j)
    v = each(row_of_ring.at, law.prepared, place.v, j)
    e, sums = each(row_of_ring.at, law.extras, place.e, j), each(row_of_ring.at, law.sums, place.sums, j)
    to = each(row_of_ring.row, law.unknowns, place.rates, place.stride)
    for i in range(layer.own_x[0], layer.own_x[1], WIDE):
        divergence, here = each(row_of_ring.sum, along_x, across_y, s, i), each(row_of_ring.load, v, s, i)
        others = each(row_of_ring.load, e, s, i), each(row_of_ring.load, sums, s, i)
        each(row_of.store, to, law.rate(law, c, here, divergence, *others), s, i)


# what is done to each of some rows


@njit(**FORMULA)
def _at(number, ring, j):
    return at(ring, number, j)


@njit(**FORMULA)
def _row(number, origin, stride):
    return origin + number * stride


@njit(**FORMULA)
def _slope(number, origin, stride):
    return origin + 2 * number * stride


@njit(**FORMULA)
def _second(row, stride):
    return row + stride


@njit(**FORMULA)
def _sum(a, b, s, i):
    return load_wide(s, a + i) + load_wide(s, b + i)


@njit(**FORMULA)
def _load(row, s, i):
    return load_wide(s, row + i)


row_of_ring = Formulas(at=_at, row=_row, slope=_slope, second=_second, sum=_sum, load=_load)
block_of = Formulas(slopes=slopes, along=divergence_along, across=divergence_across)
