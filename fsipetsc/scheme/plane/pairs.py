"""What pairs of points of a layer give each other: sums of 2 Q_il F(i, l) / H_i, Q = H D, in both directions. Compiled.

Q is antisymmetric but for the ends' own terms, which are boundary fluxes and left out: each pair is evaluated once, and
what goes from the point i to the point l is

    rate_i -= 2 Q_il / H_i F(i, l),        rate_l += 2 Q_il / H_l F(i, l),        i < l

A physics says of which of its rows v a pair is made (``paired``), and has

    pair(law, c, here, there, m)    w F for the unknowns that are summed up, with m = w ({Ja_x}/2, {Ja_y}/2, -{g})

of the numbers that its ``flux`` gives as e: Ja1_x, Ja1_y, -2 g^1, Ja2_x, Ja2_y, and as first flux across rows, -g^2.

Rows are met from below to above: when row j is, it has what those below it gave. What a point gets it gets in the same order,
whoever owns it.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64
from fsipetsc.operators.rows import at, fill
from fsipetsc.operators.vectors import WIDE, load_wide, store
from fsipetsc.scheme.plane.sums import fluxes_of, gains_of
from fsipetsc.scheme.plane.sweep import DISTANCES, last_needed, row_of_ring
from fsipetsc.scheme.sweep import row_of

#: numbers of e: metrics along X, and along Y
ALONG, ACROSS = (0, 1, 2), (3, 4)


@njit(**OPTIONS)
def no_weights(law, layer, op, s, place):
    """Of physics without pairs."""


@njit(**OPTIONS)
def nothing(law, layer, op, s, place, j):
    """Of physics without such terms."""


@njit(**OPTIONS)
def weight_of_pair(op, i, k, lo, hi):
    """Q_il of the points i and l = i + k between the ends lo and hi, without h."""
    if i < lo or i + k > hi:
        return 0.0
    for near, far in ((i - lo, i + k - lo), (hi - i - k, hi - i)):
        if near < op.rows:
            return op.norm[near] * op.closure[near, far] if far < op.cols else 0.0
    return op.interior[k - 1] if k <= op.p else 0.0


@njit(**OPTIONS)
def weigh_pairs(law, layer, op, s, place):
    """Note Q / (2 h) of the pairs along the rows, a row for each distance."""
    for k in range(1, DISTANCES + 1):
        row = place.weights + (k - 1) * place.stride
        for i in range(-k, layer.width):
            s[U64(row + i)] = weight_of_pair(op, i, k, layer.end_x[0], layer.end_x[1]) * (0.5 / layer.h_x)


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
    c, half = law.constants(law, layer), 0.5 * weight
    v, v_l = each(row_of_ring.at, law.paired, place.v, j), each(row_of_ring.at, law.paired, place.v, l)
    m, m_l = each(row_of_ring.at, ACROSS, place.e, j), each(row_of_ring.at, ACROSS, place.e, l)
    g, g_l = at(place.b, 0, j), at(place.b, 0, l)
    to, to_l = each(row_of_ring.at, law.sums, place.sums, j), each(row_of_ring.at, law.sums, place.sums, l)
    for i in range(layer.own_x[0], layer.own_x[1], WIDE):
        ja = each(of_pairs.mean, m, m_l, half, s, i)
        here, there = each(of_pairs.load, v, s, i), each(of_pairs.load, v_l, s, i)
        f = law.pair(law, c, here, there, (*ja, weight * (load_wide(s, g + i) + load_wide(s, g_l + i))))
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
    c, weights = law.constants(law, layer), place.weights + (k - 1) * place.stride
    v, m = each(row_of_ring.at, law.paired, place.v, j), each(row_of_ring.at, ALONG, place.e, j)
    f, gains = fluxes_of(law, place), gains_of(law, place)
    each(of_pairs.blank, f, s, first - k, first)
    for i in range(first, last + 1, WIDE):
        weight = load_wide(s, weights + i)
        ja = each(of_pairs.mean_along, m, weight, s, i, k)
        here, there = each(of_pairs.load, v, s, i), each(of_pairs.load, v, s, i + k)
        each(row_of.store, f, law.pair(law, c, here, there, ja), s, i)
    each(of_pairs.blank, f, s, last + 1, last + k + WIDE)
    for i in range(max(first, layer.own_x[0]), min(last + k + 1, layer.own_x[1]), WIDE):
        each(of_pairs.balance, gains, f, s, i, k)


# what is done to each of some rows


@njit(**FORMULA)
def _load(row, s, i):
    return load_wide(s, row + i)


@njit(**FORMULA)
def _mean(row, other, weight, s, i):
    return weight * (load_wide(s, row + i) + load_wide(s, other + i))


@njit(**FORMULA)
def _mean_along(row, weight, s, i, k):
    return weight * (load_wide(s, row + i) + load_wide(s, row + i + k))


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
    load=_load,
    mean=_mean,
    mean_along=_mean_along,
    give=_give,
    take=_take,
    balance=_balance,
    blank=_blank,
)
