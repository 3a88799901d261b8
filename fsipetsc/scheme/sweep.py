"""The right-hand side of a layer, block by block, of whatever physics it is given. Compiled.

Every physics here has the form

    q_t = rate(q, f, D b),      f = flux(q, v, D a),      v = prepare(q)

with the unknowns q of a point, what is derived from them there (v), rows a of q and v, rows b of q and f, and the SBP
operator D. D acts twice, so that a rate needs values within twice the reach of D. A physics is formulas at a point, of
vectors of points:

    unknowns, prepared, fluxes       (0, 1, ...), a number for each of q, v, f
    constants(law, layer)            numbers that the formulas need: read once, because a record would be read at each point
    prepare(law, constants, q)       v
    prescribe(layer, s, v, a, b)     changes v at ghost points among a .. b-1 where a boundary wants them to be others
    first(law, layer, q, v)          where the rows of a begin, and the factor of the derivative of each
    flux(law, constants, i, q, v, D a)   f at the points i ...
    rates                            one or more of formulas: the unknowns that they are for, and
        second(law, layer, q, f)         where the rows of b begin, and their factors
        rate(law, constants, q, f, D b)  the rates of these unknowns
    amend(law, layer, op, s, w, v, f, target, side)    changes the rates of an end point, where the physics wants others there
    add(law, layer, op, s, w, v, f, target, i0, i1)    adds other terms to the rates of some points (fsipetsc.scheme.undivided)
    settle(layer, s, w, target, i0, i1)    what a time step needs besides when all rates are there (fsipetsc.scheme.kinetic)
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import (
    BLOCK,
    FORMULA,
    OPTIONS,
    ROW,
    closure,
    end_of,
    end_rows,
    grid_start,
    interior_stencil,
    row,
    store_lanes,
    weights_of,
    whole_vectors,
)
from fsipetsc.operators.memory import load, store
from fsipetsc.operators.vectors import LANES
from fsipetsc.scheme.stage_update import update_stage, update_stage_lanes

#: first row of scratch of the fluxes; those before are for what is prepared
FLUXES = 2


@njit(**OPTIONS)
def sweep(law, layer, op, s, w, scratch, target, begin, end):
    """Time derivative of the unknowns at the active points begin .. end-1 of a layer, to where ``target`` says.

    s: the memory, in which the points of each unknown stand from w on, counted from the layer's first, and
    ``layer.stride`` apart; scratch rows from ``scratch`` on. The values must reach 2 op.reach points beyond the range,
    or to lo, hi. Other points do not change.
    """
    for i0 in range(max(begin, layer.lo), min(end, layer.hi + 1), BLOCK):
        i1 = min(i0 + BLOCK, min(end, layer.hi + 1))
        a, b = max(i0, layer.lo + op.rows), min(i1, layer.hi + 1 - op.rows)
        # all rows of scratch lie on one grid of vectors, so that what has just been stored is loaded as a whole
        origin = a if a < b else i0
        v, f = scratch + row(0) - origin, scratch + row(FLUXES) - origin
        prepare(law, layer, op, s, w, v, origin, i0, i1)
        fluxes(law, layer, op, s, w, v, f, origin, i0, i1)
        each(block_of.rates, law.rates, law, layer, op, s, w, f, target, i0, a, b, i1)
        for side in range(2):
            if i0 <= (layer.lo if side == 0 else layer.hi) < i1:
                law.amend(law, layer, op, s, w, v, f, target, side)
        law.add(law, layer, op, s, w, v, f, target, i0, i1)
        law.settle(layer, s, w, target, i0, i1)


@njit(**OPTIONS)
def prepare(law, layer, op, s, w, v, origin, i0, i1):
    """v where the double derivative reaches from i0 .. i1-1."""
    q, v = each(row_of.place, law.unknowns, w, layer.stride), each(row_of.place, law.prepared, v, ROW)
    constants = law.constants(law, layer)
    first, end = grid_start(origin, max(layer.lo, i0 - 2 * op.reach)), min(layer.hi + 1, i1 + 2 * op.reach)
    for i in range(first, end, LANES):
        each(row_of.store, v, law.prepare(law, constants, each(row_of.load, q, s, i)), s, i)
    law.prescribe(layer, s, v, first, end)


@njit(**OPTIONS)
def fluxes(law, layer, op, s, w, v, f, origin, i0, i1):
    """f where one derivative reaches from i0 .. i1-1."""
    lo, hi, p, reach = layer.lo, layer.hi, op.p, op.reach
    q, v = each(row_of.place, law.unknowns, w, layer.stride), each(row_of.place, law.prepared, v, ROW)
    f, constants = each(row_of.place, law.fluxes, f, ROW), law.constants(law, layer)
    rows, scales = law.first(law, layer, q, v)
    weights = each(row_of.weights, scales, op)
    d0, d1 = max(lo, i0 - reach), min(hi + 1, i1 + reach)
    first = grid_start(origin, min(origin, max(d0, lo + op.rows)))
    before, here = each(row_of.load, rows, s, first - LANES), each(row_of.load, rows, s, first)
    for i in range(first, min(d1, hi + 1 - op.rows), LANES):
        after = each(row_of.load, rows, s, i + LANES)
        derivatives = each(row_of.stencil, weights, before, here, after, p)
        values = law.flux(law, constants, i, each(row_of.load, q, s, i), each(row_of.load, v, s, i), derivatives)
        each(row_of.store, f, values, s, i)
        before, here = here, after
    for side in range(2):
        end, known = end_of(lo, hi, side, i0 - 2 * reach, i1 + 2 * reach)
        for r in range(0, op.rows, LANES):
            i, a, b = end_rows(op, lo, hi, side, r, d0, d1)
            if a < b:
                derivatives = each(row_of.closure, rows, scales, op, s, end, side, known, r)
                here = each(row_of.load, q, s, i)  # and v anew: at a ghost point its rows may hold something else
                values = law.flux(law, constants, i, here, law.prepare(law, constants, here), derivatives)
                each(row_of.store_lanes, f, values, s, i, a, b)


@njit(**OPTIONS)
def rates(part, law, layer, op, s, w, f, target, i0, a, b, i1):
    """Send on the rates of some unknowns at the points i0 .. i1-1, of which a .. b-1 are away from the closures."""
    lo, hi, p = layer.lo, layer.hi, op.p
    q, f = each(row_of.place, law.unknowns, w, layer.stride), each(row_of.place, law.fluxes, f, ROW)
    constants = law.constants(law, layer)
    rows, scales = part.second(law, layer, q, f)
    weights, whole = each(row_of.weights, scales, op), whole_vectors(a, b)
    before, here = each(row_of.load, rows, s, a - LANES), each(row_of.load, rows, s, a)
    for i in range(a, b, LANES):
        after = each(row_of.load, rows, s, i + LANES)
        derivatives = each(row_of.stencil, weights, before, here, after, p)
        k = part.rate(law, constants, each(row_of.load, q, s, i), each(row_of.load, f, s, i), derivatives)
        if i == whole:
            each(row_of.update_lanes, part.unknowns, k, s, target, i, 0, b - i)
        else:
            each(row_of.update, part.unknowns, k, s, target, i)
        before, here = here, after
    for side in range(2):
        end, known = end_of(lo, hi, side, i0 - op.reach, i1 + op.reach)
        for r in range(0, op.rows, LANES):
            i, first, last = end_rows(op, lo, hi, side, r, i0, i1)
            if first < last:
                derivatives = each(row_of.closure, rows, scales, op, s, end, side, known, r)
                k = part.rate(law, constants, each(row_of.load, q, s, i), each(row_of.load, f, s, i), derivatives)
                each(row_of.update_lanes, part.unknowns, k, s, target, i, first, last)
    return 0


# what is done to each of some rows


@njit(**FORMULA)
def _place(number, begin, distance):
    return begin + number * distance


@njit(**FORMULA)
def _load(begin, s, i):
    return load(s, begin + i)


@njit(**FORMULA)
def _store(begin, value, s, i):
    store(s, begin + i, value)
    return 0


@njit(**FORMULA)
def _store_lanes(begin, value, s, i, a, b):
    store_lanes(s, begin + i, value, a, b)
    return 0


@njit(**FORMULA)
def _weights(scale, op):
    return weights_of(op, scale)


@njit(**FORMULA)
def _stencil(weights, before, here, after, p):
    return interior_stencil(p, weights, before, here, after)


@njit(**FORMULA)
def _closure(begin, scale, op, s, end, side, known, r):
    return scale * closure(op, s, begin + end, side, known, r)


@njit(**FORMULA)
def _update(unknown, k, s, target, i):
    update_stage(s, target, unknown, i, k)
    return 0


@njit(**FORMULA)
def _update_lanes(unknown, k, s, target, i, a, b):
    update_stage_lanes(s, target, unknown, i, k, a, b)
    return 0


row_of = Formulas(
    place=_place,
    load=_load,
    store=_store,
    store_lanes=_store_lanes,
    weights=_weights,
    stencil=_stencil,
    closure=_closure,
    update=_update,
    update_lanes=_update_lanes,
)
block_of = Formulas(rates=rates)
