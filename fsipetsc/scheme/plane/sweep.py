"""The right-hand side of a layer in two dimensions, row by row, of whatever physics it is given. Compiled.

Every physics here has the form

    q_t = rate(v, D_x a + D_y b, e, sums),      (a, b, e) = flux(v, D_x v, D_y v),      v = prepare(q)

with the unknowns q of a point, what is derived from them there (v), fluxes a along X and b along Y, further quantities e, and
sums of what it has to do with other points, pair by pair.
The boundary fluxes are left out: the operator is *loose* at the edges, h a_0 D_00 = +1/2 instead of -1/2, so that what
comes out are the rates without traction, heat and mass through any edge (fsipetsc.scheme.plane.edges adds what there is).
Only the J of a grid keeps the whole derivative, among the further quantities.
A physics is formulas at a point, of vectors of points:

    unknowns, prepared, fluxes, extras  (0, 1, ...), a number for each of q, v, a (and b), e
    differentiated                   those of v of which D_x and D_y are wanted
    looks_ahead                      1 if rows beyond those of a flux are needed, as for derivatives
    constants(law, layer)            numbers that the formulas need
    prepare(law, c, q)               v
    lay(layer, op, s, place, lines)  puts what there is to know of the grid into scratch
    grid(s, lines, height, i)        metrics of the grid at the points i .., see ``heights``
    flux(law, c, v, metrics, D_x v, D_y v)    a, b, e
    rate(law, c, v, divergence, e, sums)
    sums                             (0, 1, ...), a number for each unknown to which pairs of points give something, beside
                                     ``paired`` and ``pair``: see fsipetsc.scheme.plane.pairs
    meet(law, layer, op, s, place, j)    what there is to do for the sums of row j
    amend(law, layer, op, s, place, lines, j)    gives the rates of row j what goes through the edges
    keep(layer, s, place, target, j)     notes what the step is to keep of row j

The layer is gone through in blocks of columns. In a block a row goes through three stages, each as far ahead of the next as
the derivatives across rows need it: v, fluxes, rates. So what lies between q and its rate is never more than a ring of rows
of a block, which stays in a cache.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, OPTIONS
from fsipetsc.operators.lanes import within
from fsipetsc.operators.memory import load_twice, load_wide, load_wide_interlaced
from fsipetsc.operators.rows import BLOCK, MARGIN, QUANTITIES, STRIDE, Ring, along, at
from fsipetsc.operators.vectors import TWICE, WIDE, on_aligned_stack, spread_twice
from fsipetsc.physics.plane.gas import GRID_ROWS
from fsipetsc.physics.plane.layer import DOF
from fsipetsc.scheme.plane.slopes import slopes_across, slopes_along, weigh_across, weigh_along
from fsipetsc.scheme.plane.targets import fetch_points, send_row, too_large
from fsipetsc.scheme.sweep import row_of

#: most quantities of each sort that a physics may have
PREPARED, FLUXES, EXTRAS, SUMS = 14, 4, 7, 4
#: number of the last of what is prepared, which is there for fsipetsc.scheme.plane.dissipation
STEEPNESS = PREPARED - 1
#: in rings: v, fluxes along and across, extras, sums over pairs
A, B, E, OF_SUMS = PREPARED, PREPARED + FLUXES, PREPARED + 2 * FLUXES, PREPARED + 2 * FLUXES + EXTRAS
#: rows of scratch beside them: of one row its slopes in both directions, derivatives of fluxes along, fluxes and sums of its
#: pairs, rates, what is known of the grid, weights of pairs with other rows and in derivatives
BESIDE = 2 * PREPARED + FLUXES + 2 * SUMS + DOF + GRID_ROWS + 2
assert OF_SUMS + SUMS == QUANTITIES


class Place(NamedTuple):
    """A block of columns first <= i < end of those that are owned, and where the rows of scratch stand: column i of a row that
    begins at r is s[r + i]. The first column stands at the beginning of a cache line.
    """

    first: int
    end: int
    v: Ring
    a: Ring
    b: Ring
    e: Ring
    sums: Ring
    slopes: int
    divergences: int
    pairs: int
    rates: int
    lines: int
    weights: int


def ring_rows(op: np.ndarray, record: np.ndarray, behind: int = 0) -> int:
    """Rows that a ring must have for a layer, a power of two: those between the first and the last that are still needed;
    behind: more than derivatives take.
    """
    (lo, hi), p, rows = record["end_y"].tolist(), int(op["p"]), int(op["rows"])

    def last(j: int) -> int:
        return lo + int(op["cols"]) - 1 if j < lo + rows else hi if j > hi - rows else j + p

    most = 1
    for j in range(*record["own_y"].tolist()):
        first = (lo if j < lo + rows else min(j - p, hi - int(op["cols"]) + 1)) - behind
        ahead = max(last(f) for f in range(max(j - p, 0), min(last(j), int(record["height"]) - 1) + 1))
        most = max(most, min(ahead, int(record["height"]) - 1) - max(first, 0) + 1)
    return 1 << (most - 1).bit_length()


def scratch(ring: int) -> np.ndarray:
    """Scratch for a block with so many rows in rings."""
    doubles = (ring * QUANTITIES + BESIDE) * STRIDE
    room = np.zeros(doubles + 8)
    begin = -(room.ctypes.data // 8) % 8
    return room[begin : begin + doubles]


@njit(**FORMULA)
def block_width(layer):
    """Columns of a block: all but the last one have as many."""
    owned = layer.own_x[1] - layer.own_x[0]
    blocks = (owned + BLOCK - 1) // BLOCK
    return ((owned + blocks - 1) // blocks + WIDE - 1) // WIDE * WIDE


@njit(**FORMULA)
def place_of(layer, first):
    """The block of a layer that begins at a column."""
    origin, mask = MARGIN - first, layer.ring - 1
    beside = origin + layer.ring * QUANTITIES * STRIDE
    divergences = beside + 2 * PREPARED * STRIDE
    pairs = divergences + FLUXES * STRIDE
    rates = pairs + 2 * SUMS * STRIDE
    lines = rates + DOF * STRIDE
    return Place(
        first,
        min(first + block_width(layer), layer.own_x[1]),
        Ring(origin, mask),
        Ring(origin + A * STRIDE, mask),
        Ring(origin + B * STRIDE, mask),
        Ring(origin + E * STRIDE, mask),
        Ring(origin + OF_SUMS * STRIDE, mask),
        beside,
        divergences,
        pairs,
        rates,
        lines,
        lines + GRID_ROWS * STRIDE,
    )


@njit(**FORMULA)
def at_ends(layer, place):
    """Whether an end in X is so near that its closure has to do with a block or what lies beside it."""
    return layer.end_x[0] > place.first - 2 * MARGIN or layer.end_x[1] < place.end + 2 * MARGIN


@njit(**FORMULA)
def columns(layer, op, place, looks_ahead):
    """(a, b): v must be known at the columns a <= i < b. a is whole vectors from the first column; below 0 there is nothing."""
    beyond = op.p + op.cols if at_ends(layer, place) else op.p * (1 + looks_ahead)
    vectors = (min(beyond, place.first) + WIDE - 1) // WIDE
    return place.first - vectors * WIDE, min(place.end + beyond, layer.width)


@njit(**FORMULA)
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


@njit(**FORMULA)
def last_needed(op, j, lo, hi):
    """The last row that the derivative across rows takes at row j."""
    if j < lo + op.rows:
        return lo + op.cols - 1
    return hi if j > hi - op.rows else j + op.p


@njit(**OPTIONS)
def sweep(law, layer, op, loose, s, y, lines, target):
    """Rates of the points that this rank owns, to where ``target`` says; y: the unknowns of all points it holds; lines: of the
    grid of a gas (fsipetsc.scheme.plane.geometry).
    """
    for first in range(layer.own_x[0], layer.own_x[1], block_width(layer)):
        place = place_of(layer, first)
        law.lay(layer, op, s, place, lines)
        sweep_block(law, layer, op, loose, s, place, y, target)


@njit(**FORMULA)
def sweep_block(law, layer, op, loose, s, place, y, target):
    """Those of a block of columns."""
    on_aligned_stack()
    lo, hi, along_x = layer.end_y[0], layer.end_y[1], weigh_along(layer, op, s, place)
    prepared, fluxed = 0, max(layer.own_y[0] - op.p, 0)
    paired = fluxed
    for j in range(layer.own_y[0], layer.own_y[1]):
        while fluxed <= min(last_needed(op, j, lo, hi), layer.height - 1):
            ahead = last_needed(op, fluxed, lo, hi) if law.looks_ahead == 1 else fluxed
            while prepared <= min(ahead, layer.height - 1):
                prepare_row(law, layer, op, s, place, y, prepared)
                prepared += 1
            flux_row(law, layer, op, s, place, along_x, fluxed)
            fluxed += 1
        while paired <= j:
            law.meet(law, layer, op, s, place, paired)
            paired += 1
        rate_row(law, layer, op, loose, s, place, along_x, j)
        law.amend(law, layer, op, s, place, place.lines, j)
        law.keep(layer, s, place, target, j)
        send_row(layer, s, place, target, j)


@njit(**FORMULA)
def prepare_row(law, layer, op, s, place, y, j):
    """v of row j."""
    c, row, (a, b) = law.constants(law, layer), j * layer.width * DOF, columns(layer, op, place, law.looks_ahead)
    v, far = each(row_of_ring.at, law.prepared, place.v, j), too_large(layer)
    for n in range(a, b, WIDE):
        i = max(n, 0)
        if far:
            fetch_points(y, row + (layer.width + i) * DOF)
        each(row_of.store, v, law.prepare(law, c, load_wide_interlaced(y, row + i * DOF, 5)), s, i)


@njit(**FORMULA)
def flux_row(law, layer, op, s, place, along_x, j):
    """Fluxes at row j. along_x: where the weights of D_x stand, see ``weigh_along``."""
    on_aligned_stack()
    near = at_ends(layer, place)
    reach = op.rows if near else op.p  # as far as closures of this block do
    a, b = place.first - WIDE, place.end + reach
    known, end = max(place.first - reach, layer.end_x[0]), min(b, layer.end_x[1] + 1)
    ends = slope_rows(law, place)
    if near:
        each(block_of.slopes, law.differentiated, ends, layer, op, s, place, j, a, b)
    across_y = weigh_across(layer, op, s, place, j, False)
    v, c = each(row_of_ring.at, law.prepared, place.v, j), law.constants(law, layer)
    to_a, to_b = each(row_of_ring.at, law.fluxes, place.a, j), each(row_of_ring.at, law.fluxes, place.b, j)
    to_e, sums = each(row_of_ring.at, law.extras, place.e, j), each(row_of_ring.at, law.sums, place.sums, j)
    height = heights(layer, op, j)
    for i in range(a, b, TWICE):
        m, here = law.grid(s, place.lines, height, i), each(row_of_ring.twice, v, s, i)
        if near:
            of_x = each(row_of_ring.twice, ends, s, i)
        else:
            of_x = slopes_along(law.differentiated, s, place.v, j, i, op.p, along_x)
        of_x = each(row_of_ring.within, of_x, i, known, end)  # where there is nothing formulas would leave their usual path
        fluxes = law.flux(law, c, here, m, of_x, slopes_across(law.differentiated, s, place.v, j, i, across_y))
        each(row_of.store, to_a, fluxes[0], s, i)
        each(row_of.store, to_b, fluxes[1], s, i)
        each(row_of.store, to_e, fluxes[2], s, i)
        each(row_of.store, sums, spread_twice(0.0), s, i)


@njit(**FORMULA)
def slope_rows(law, place):
    """Where the slopes along X of each differentiated quantity stand, if an end is near."""
    return each(row_of_ring.row, law.differentiated, place.slopes)


@njit(**OPTIONS)
def slopes(number, to, layer, op, s, place, j, a, b):
    """D_x of one quantity at row j."""
    along(op, s, at(place.v, number, j), to, a, b, layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
    return 0


@njit(**OPTIONS)
def divergence_along(number, to, layer, loose, s, place, j):
    """D_x of one flux along row j."""
    flux = at(place.a, number, j)
    along(loose, s, flux, to, place.first, place.end, layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
    return 0


@njit(**FORMULA)
def rate_row(law, layer, op, loose, s, place, along_x, j):
    """Rates at row j, to scratch. along_x: as in ``flux_row``."""
    on_aligned_stack()
    near, ends = at_ends(layer, place), each(row_of_ring.row, law.fluxes, place.divergences)
    if near:
        each(block_of.along, law.fluxes, ends, layer, loose, s, place, j)
    across_y = weigh_across(layer, op, s, place, j, True)
    c, v = law.constants(law, layer), each(row_of_ring.at, law.prepared, place.v, j)
    e, sums = each(row_of_ring.at, law.extras, place.e, j), each(row_of_ring.at, law.sums, place.sums, j)
    to = each(row_of_ring.row, law.unknowns, place.rates)
    for i in range(place.first, place.end, TWICE):
        if near:
            of_x = each(row_of_ring.twice, ends, s, i)
        else:
            of_x = slopes_along(law.fluxes, s, place.a, j, i, op.p, along_x)
        divergence = each(row_of_ring.sum, of_x, slopes_across(law.fluxes, s, place.b, j, i, across_y))
        here, extra = each(row_of_ring.twice, v, s, i), each(row_of_ring.twice, e, s, i)
        each(row_of.store, to, law.rate(law, c, here, divergence, extra, each(row_of_ring.twice, sums, s, i)), s, i)


# what is done to each of some rows


@njit(**FORMULA)
def _at(number, ring, j):
    return at(ring, number, j)


@njit(**FORMULA)
def _row(number, origin):
    return origin + number * STRIDE


@njit(**FORMULA)
def _sum(a, b):
    return a + b


@njit(**FORMULA)
def _load(row, s, i):
    return load_wide(s, row + i)


@njit(**FORMULA)
def _twice(row, s, i):
    return load_twice(s, row + i)


@njit(**FORMULA)
def _within(values, i, first, end):
    return within(values, i, first, end)


row_of_ring = Formulas(at=_at, row=_row, sum=_sum, load=_load, twice=_twice, within=_within)
block_of = Formulas(slopes=slopes, along=divergence_along)
