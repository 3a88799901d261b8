"""Sums of what the points of a layer give each other: to those in other rows, and along their own. Compiled.

Rows are met from below to above. What a point gets it gets in the same order, whoever owns it: from rows below, from its own as
that is met, and then from the points beside it. A physics with sums has

    dissipate_across(law, layer, op, s, place, j)    adds to the sums of row j and of rows above it, times norm
    dissipate_along(law, layer, op, s, place, j)     adds to the gains of row j, times norm
    give(law, layer, op, s, place, j)                the rest; where row j is owned, its sums are complete then
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, U64
from fsipetsc.operators.memory import load_wide, store
from fsipetsc.operators.rows import STRIDE, fill
from fsipetsc.operators.vectors import WIDE
from fsipetsc.scheme.plane.sweep import SUMS, row_of_ring


@njit(**FORMULA)
def no_sums(law, layer, op, s, place, j):
    """Of physics without them."""


@njit(**FORMULA)
def fluxes_of(law, place):
    """Rows of the fluxes of one distance."""
    return each(row_of_ring.row, law.sums, place.pairs)


@njit(**FORMULA)
def gains_of(law, place):
    """Rows of what is gained along a row."""
    return each(row_of_ring.row, law.sums, place.pairs + SUMS * STRIDE)


@njit(**FORMULA)
def meet(law, layer, op, s, place, j):
    """Row j gives and gets; then its sums are complete, if it is owned."""
    law.dissipate_across(law, layer, op, s, place, j)
    if j >= layer.own_y[0]:
        each(of_sums.clear, gains_of(law, place), s, place.first, place.end)
        law.dissipate_along(law, layer, op, s, place, j)
    law.give(law, layer, op, s, place, j)


@njit(**FORMULA)
def complete(law, layer, op, s, place, j):
    """All that is given is there: sums and gains, over the norm, together."""
    if j < layer.own_y[0]:
        return
    a, b = place.first, place.end
    sums, gains = each(row_of_ring.at, law.sums, place.sums, j), gains_of(law, place)
    for side in range(2):
        if layer.end_x[side] - op.rows < b and a < layer.end_x[side] + op.rows:
            for r in range(op.rows):
                i = layer.end_x[side] + (1 - 2 * side) * r
                if a <= i < b:
                    each(of_sums.divide, gains, op.norm[r], s, i)
    scale = 1.0 / norm_at(op, j, layer.end_y[0], layer.end_y[1])
    for i in range(a, b, WIDE):
        each(of_sums.complete, sums, gains, scale, s, i)


@njit(**FORMULA)
def norm_at(op, n, first, last):
    """Weight of the norm at point n between the ends first and last, without h."""
    r = min(n - first, last - n)
    return op.norm[r] if r < op.rows else 1.0


@njit(**FORMULA)
def _complete(total, gain, scale, s, i):
    store(s, total + i, scale * load_wide(s, total + i) + load_wide(s, gain + i))
    return 0


@njit(**FORMULA)
def _clear(row, s, first, end):
    fill(s, row, first, end, 0.0)
    return 0


@njit(**FORMULA)
def _divide(row, number, s, i):
    s[U64(row + i)] /= number
    return 0


of_sums = Formulas(complete=_complete, clear=_clear, divide=_divide)
