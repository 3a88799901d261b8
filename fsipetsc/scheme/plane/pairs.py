"""What pairs of points of a layer give each other: sums of 2 Q_il F(i, l) / H_i, Q = H D, in both directions. Compiled.

Q is antisymmetric but for the ends' own terms, which are boundary fluxes and left out: each pair is evaluated once, and
what goes from the point i to the point l is

    rate_i -= 2 Q_il / H_i F(i, l),        rate_l += 2 Q_il / H_l F(i, l),        i < l

A physics says of which of its rows v a pair is made (``paired``), and has

    pair(law, c, here, there, m)    w F for the unknowns that are summed up, with m = w ({Ja_x}/2, {Ja_y}/2, -{g})

What is known of the grid (fsipetsc.scheme.plane.geometry) makes m.

Rows are met from below to above: when row j is, it has what those below it gave. What a point gets it gets in the same order,
whoever owns it. Along a row a vector of points keeps what it gives to the next one, k points on, until that is met.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64
from fsipetsc.operators.lanes import joined, within
from fsipetsc.operators.memory import load_wide, store
from fsipetsc.operators.rows import STRIDE, at, fill
from fsipetsc.operators.vectors import WIDE, fma, on_aligned_stack, spread_wide
from fsipetsc.physics.plane.gas import G2, JA2_X, JA2_Y, OF_PAIRS, PAIR_ROWS
from fsipetsc.scheme.plane.geometry import weight_of_pair
from fsipetsc.scheme.plane.sums import complete, fluxes_of, gains_of, norm_at
from fsipetsc.scheme.plane.sweep import at_ends, last_needed, row_of_ring
from fsipetsc.scheme.sweep import row_of

#: numbers of a pair of rows: see ``weigh_rows``
_NUMBERS = 5


@njit(**FORMULA)
def give_pairs(law, layer, op, s, place, j):
    """The pairs of row j with rows above it and, where it is owned, those along it; its sums are complete then."""
    on_aligned_stack()
    c, a, b = law.constants(law, layer), place.first, place.end
    owned, near, count = j >= layer.own_y[0], at_ends(layer, place), weigh_rows(layer, op, s, place, j)
    if owned and near:
        pairs_of_closures(law, layer, op, s, place, j)
    v, sums = each(row_of_ring.at, law.paired, place.v, j), each(row_of_ring.at, law.sums, place.sums, j)
    gains, nothing = gains_of(law, place), each(of_pairs.nothing, law.sums)
    zeta, p = (layer.first_y + j) / (layer.ny - 1), op.p
    scale, lo, end = 1.0 / norm_at(op, j, layer.end_y[0], layer.end_y[1]), layer.end_x[0], layer.end_x[1] + 1
    before_1, before_2, more = nothing, nothing, near or p > 2
    for i in range(a - WIDE if owned else a, b, WIDE):
        here = each(row_of_ring.load, v, s, i)
        if i >= a:
            across(law, c, s, place, j, count, i, here, sums)
        if owned:
            gain = each(row_of_ring.load, gains, s, i)
            f = pair_along(law, c, s, place, v, here, zeta, i, 1, near, lo, end)
            gain, before_1 = each(of_pairs.balance_1, gain, before_1, f), f
            if p > 1:
                f = pair_along(law, c, s, place, v, here, zeta, i, 2, near, lo, end)
                gain, before_2 = each(of_pairs.balance_2, gain, before_2, f), f
            if i >= a:
                if more:
                    each(row_of.store, gains, gain, s, i)
                else:
                    each(of_pairs.complete, sums, gain, scale, s, i)
    if owned and p > 2:  # by themselves: what no register holds costs more than to go along the row again
        before_1, before_2 = nothing, nothing
        for i in range(a - WIDE, b, WIDE):
            here, gain = each(row_of_ring.load, v, s, i), each(row_of_ring.load, gains, s, i)
            f = pair_along(law, c, s, place, v, here, zeta, i, 3, near, lo, end)
            gain, before_1 = each(of_pairs.balance_3, gain, before_1, f), f
            if p > 3:
                f = pair_along(law, c, s, place, v, here, zeta, i, 4, near, lo, end)
                gain, before_2 = each(of_pairs.balance_4, gain, before_2, f), f
            if i >= a:
                if near:
                    each(row_of.store, gains, gain, s, i)
                else:
                    each(of_pairs.complete, sums, gain, scale, s, i)
    if near:
        complete(law, layer, op, s, place, j)


@njit(**FORMULA)
def weigh_rows(layer, op, s, place, j):
    """Number of rows above row j that may have pairs with it; of each the powers of zeta in what makes m of the grid, times
    Q / h, to scratch.
    """
    lo, hi, length = layer.end_y[0], layer.end_y[1], layer.ny - 1
    zeta, count = (layer.first_y + j) / length, min(last_needed(op, j, lo, hi), layer.height - 1) - j
    for n in range(count):
        l, to = j + 1 + n, place.weights + place.first + n * _NUMBERS
        weight, zeta_l = weight_of_pair(op, j, l - j, lo, hi) / layer.h_y, (layer.first_y + l) / length
        s[U64(to)] = weight
        s[U64(to + 1)] = 0.5 * weight * (zeta + zeta_l)
        s[U64(to + 2)] = -2.0 * weight
        s[U64(to + 3)] = -weight * (zeta + zeta_l)
        s[U64(to + 4)] = -weight * (zeta * zeta + zeta_l * zeta_l)
    return count


@njit(**FORMULA)
def across(law, c, s, place, j, count, i, here, sums):
    """The pairs of a vector of points of row j with rows above it."""
    own, grid = each(row_of_ring.load, sums, s, i), place.lines + i
    x, x_more = load_wide(s, grid + JA2_X * STRIDE), load_wide(s, grid + (JA2_X + 1) * STRIDE)
    y, y_more = load_wide(s, grid + JA2_Y * STRIDE), load_wide(s, grid + (JA2_Y + 1) * STRIDE)
    g, more = load_wide(s, grid + G2 * STRIDE), load_wide(s, grid + (G2 + 1) * STRIDE)
    most = load_wide(s, grid + (G2 + 2) * STRIDE)
    for n in range(count):
        weights = place.weights + place.first + n * _NUMBERS
        weight, half, twice = s[U64(weights)], s[U64(weights + 1)], s[U64(weights + 2)]
        if weight != 0.0:
            m = (
                fma(half, x_more, weight * x),
                fma(half, y_more, weight * y),
                fma(s[U64(weights + 4)], most, fma(s[U64(weights + 3)], more, twice * g)),
            )
            v, to = each(of_pairs.at, law.paired, place.v, j + 1 + n, i), each(of_pairs.at, law.sums, place.sums, j + 1 + n, i)
            f = law.pair(law, c, here, each(of_pairs.number, v, s), m)
            own = each(of_pairs.less, own, f)
            each(of_pairs.take, to, f, s)
    each(row_of.store, sums, own, s, i)


@njit(**FORMULA)
def pair_along(law, c, s, place, v, here, zeta, i, k, near, lo, end):
    """F of the points i .. and those k further on, nothing where one of them is not between the ends."""
    grid = place.lines + (OF_PAIRS + PAIR_ROWS * (k - 1)) * STRIDE + i
    g = fma(zeta, load_wide(s, grid + 3 * STRIDE), load_wide(s, grid + 2 * STRIDE))
    f = law.pair(law, c, here, each(row_of_ring.load, v, s, i + k), (load_wide(s, grid), load_wide(s, grid + STRIDE), g))
    return each(of_pairs.within, f, i, lo, end - k) if near else f


@njit(**OPTIONS)
def pairs_of_closures(law, layer, op, s, place, j):
    """Those that only closures have, along row j: what its points gain."""
    for side in range(2):
        first = layer.end_x[0] if side == 0 else layer.end_x[1] - op.rows + 1
        if first < place.end and first + op.rows > place.first:
            for k in range(op.p + 1, op.rows):
                at_distance(law, layer, s, place, j, k, first, first + op.rows - 1 - k)


@njit(**OPTIONS)
def at_distance(law, layer, s, place, j, k, first, last):
    """The pairs i, i + k for first <= i <= last."""
    c, zeta, nowhere = law.constants(law, layer), (layer.first_y + j) / (layer.ny - 1), 0
    v, f, gains = each(row_of_ring.at, law.paired, place.v, j), fluxes_of(law, place), gains_of(law, place)
    each(of_pairs.blank, f, s, first - k, first)
    for i in range(first, last + 1, WIDE):
        here = each(row_of_ring.load, v, s, i)
        each(row_of.store, f, pair_along(law, c, s, place, v, here, zeta, i, k, False, nowhere, nowhere), s, i)
    each(of_pairs.blank, f, s, last + 1, last + k + WIDE)
    for i in range(max(first, place.first), min(last + k + 1, place.end)):
        each(of_pairs.shift, gains, f, s, i, k)


# what is done to each of some rows


@njit(**FORMULA)
def _nothing(number):
    return spread_wide(0.0)


@njit(**FORMULA)
def _at(number, ring, j, i):
    return at(ring, number, j) + i


@njit(**FORMULA)
def _number(at, s):
    return load_wide(s, at)


@njit(**FORMULA)
def _less(own, f):
    return own - f


@njit(**FORMULA)
def _take(to, f, s):
    store(s, to, load_wide(s, to) + f)
    return 0


def _balance(k: int) -> Any:
    """What the points of a vector gain from pairs k apart; before: F of the vector before."""

    @njit(**FORMULA)
    def balance(gain, before, f):
        return gain + (joined(before, f, k) - f)

    return balance


@njit(**FORMULA)
def _within(f, i, lo, end):
    return within(f, i, lo, end)


@njit(**FORMULA)
def _complete(total, gain, scale, s, i):
    store(s, total + i, scale * load_wide(s, total + i) + gain)
    return 0


@njit(**FORMULA)
def _shift(gain, f, s, i, k):
    s[U64(gain + i)] += s[U64(f + i - k)] - s[U64(f + i)]
    return 0


@njit(**FORMULA)
def _blank(row, s, first, end):
    fill(s, row, first, end, 0.0)
    return 0


of_pairs = Formulas(
    nothing=_nothing,
    at=_at,
    number=_number,
    less=_less,
    take=_take,
    balance_1=_balance(1),
    balance_2=_balance(2),
    balance_3=_balance(3),
    balance_4=_balance(4),
    within=_within,
    complete=_complete,
    shift=_shift,
    blank=_blank,
)
