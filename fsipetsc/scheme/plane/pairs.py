"""What pairs of points of a layer give each other: sums of 2 Q_il F(i, l) / H_i, Q = H D, in both directions. Compiled.

Q is antisymmetric but for the ends' own terms, which are boundary fluxes and left out: each pair is evaluated once, and
what goes from the point i to the point l is

    rate_i -= 2 Q_il / H_i F(i, l),        rate_l += 2 Q_il / H_l F(i, l),        i < l

A physics says of which of its rows v a pair is made (``paired``), and has

    pair(law, c, here, there, m)    w F for the unknowns that are summed up, with m = w ({Ja_x}/2, {Ja_y}/2, -{g})

What is known of the grid (fsipetsc.scheme.plane.geometry) makes m.

Rows are met from below to above: when row j is, it has what those below it gave. What a point gets it gets in the same order,
whoever owns it.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, OPTIONS
from fsipetsc.operators.rows import fill
from fsipetsc.operators.vectors import WIDE, fma, load_wide, store
from fsipetsc.physics.plane.gas import G2, JA2_X, JA2_Y, OF_PAIRS, PAIR_ROWS
from fsipetsc.scheme.plane.geometry import weight_of_pair
from fsipetsc.scheme.plane.sums import fluxes_of, gains_of
from fsipetsc.scheme.plane.sweep import last_needed, row_of_ring
from fsipetsc.scheme.sweep import row_of


@njit(**OPTIONS)
def nothing(law, layer, op, s, place, j):
    """Of physics without such terms."""


@njit(**OPTIONS)
def pairs_across(law, layer, op, s, place, j):
    """The pairs of row j with rows above it."""
    lo, hi = layer.end_y[0], layer.end_y[1]
    for l in range(j + 1, min(last_needed(op, j, lo, hi), layer.height - 1) + 1):
        weight = weight_of_pair(op, j, l - j, lo, hi) / layer.h_y
        if weight != 0.0:
            across(law, layer, s, place, j, l, weight)


@njit(**OPTIONS)
def across(law, layer, s, place, j, l, weight):
    """Pairs between row j and row l > j; weight: Q / h."""
    c, stride, length = law.constants(law, layer), place.stride, layer.ny - 1
    x, y, g = place.lines + JA2_X * stride, place.lines + JA2_Y * stride, place.lines + G2 * stride
    zeta, zeta_l = (layer.first_y + j) / length, (layer.first_y + l) / length
    half, first, second = 0.5 * weight * (zeta + zeta_l), weight * (zeta + zeta_l), weight * (zeta * zeta + zeta_l * zeta_l)
    v, v_l = each(row_of_ring.at, law.paired, place.v, j), each(row_of_ring.at, law.paired, place.v, l)
    to, to_l = each(row_of_ring.at, law.sums, place.sums, j), each(row_of_ring.at, law.sums, place.sums, l)
    for i in range(layer.own_x[0], layer.own_x[1], WIDE):
        m = (
            fma(half, load_wide(s, x + stride + i), weight * load_wide(s, x + i)),
            fma(half, load_wide(s, y + stride + i), weight * load_wide(s, y + i)),
            -1.0
            * fma(
                second,
                load_wide(s, g + 2 * stride + i),
                fma(first, load_wide(s, g + stride + i), 2.0 * weight * load_wide(s, g + i)),
            ),
        )
        here, there = each(row_of_ring.load, v, s, i), each(row_of_ring.load, v_l, s, i)
        f = law.pair(law, c, here, there, m)
        each(of_pairs.give, to, f, s, i)
        each(of_pairs.take, to_l, f, s, i)


@njit(**OPTIONS)
def pairs_along(law, layer, op, s, place, j):
    """The pairs along row j: what its points gain."""
    a, b, lo, hi = layer.own_x[0], layer.own_x[1], layer.end_x[0], layer.end_x[1]
    for k in range(1, op.p + 1):
        at_distance(law, layer, s, place, j, k, max(a - k, lo), min(b - 1, hi - k))
    for side in range(2):
        if a <= (lo if side == 0 else hi) < b:
            first = lo if side == 0 else hi - op.rows + 1
            for k in range(op.p + 1, op.rows):
                at_distance(law, layer, s, place, j, k, first, first + op.rows - 1 - k)


@njit(**OPTIONS)
def at_distance(law, layer, s, place, j, k, first, last):
    """The pairs i, i + k for first <= i <= last."""
    c, stride, zeta = law.constants(law, layer), place.stride, (layer.first_y + j) / (layer.ny - 1)
    grid, v = place.lines + (OF_PAIRS + PAIR_ROWS * (k - 1)) * stride, each(row_of_ring.at, law.paired, place.v, j)
    f, gains = fluxes_of(law, place), gains_of(law, place)
    each(of_pairs.blank, f, s, first - k, first)
    for i in range(first, last + 1, WIDE):
        at = grid + i
        g = fma(zeta, load_wide(s, at + 3 * stride), load_wide(s, at + 2 * stride))
        here, there = each(row_of_ring.load, v, s, i), each(row_of_ring.load, v, s, i + k)
        f_k = law.pair(law, c, here, there, (load_wide(s, at), load_wide(s, at + stride), g))
        each(row_of.store, f, f_k, s, i)
    each(of_pairs.blank, f, s, last + 1, last + k + WIDE)
    for i in range(max(first, layer.own_x[0]), min(last + k + 1, layer.own_x[1]), WIDE):
        each(of_pairs.balance, gains, f, s, i, k)


# what is done to each of some rows


@njit(**FORMULA)
def _give(row, f, s, i):
    store(s, row + i, load_wide(s, row + i) - f)
    return 0


@njit(**FORMULA)
def _take(row, f, s, i):
    store(s, row + i, load_wide(s, row + i) + f)
    return 0


@njit(**FORMULA)
def _balance(gain, f, s, i, k):
    store(s, gain + i, load_wide(s, gain + i) + (load_wide(s, f + i - k) - load_wide(s, f + i)))
    return 0


@njit(**FORMULA)
def _blank(row, s, first, end):
    fill(s, row, first, end, 0.0)
    return 0


of_pairs = Formulas(
    give=_give,
    take=_take,
    balance=_balance,
    blank=_blank,
)
