"""Terms of the rates that are made of undivided differences. Compiled.

    q_t += scale H^-1 sum_k  Delta_k^T  flux(mean_k c, b, Delta_k y),          k = first .. last

y are rows of values, c coefficients at the points, both of a physics; mean_k c is a weighted sum of c at the points in the
middle of a difference, Delta_k the undivided difference of order k, taken where all of its points are active, b numbers of the
difference itself, and H the norm; at the ends there are terms of their own, as fsipetsc.operators.narrow has them.
As the columns of Delta_k add up to nothing, such terms take nothing away from the integral of any unknown. What a difference
takes from one unknown may go to another one at the points in its middle instead (``MIDDLE``). A term is

    unknowns                                those whose rates it belongs to
    levels(op)                              first, last and the weights of the means (LEVELS of fsipetsc.operators.sbp)
    coefficients, own, sums                 (0, 1, ...), a number for each of c, and further ones, for each of b and unknowns
    constants(law, layer)                   numbers that the formulas need
    reach(op)                               how far from a point c is needed there
    weigh(law, constants, i, q, v, f)       c at the points i ...
    look(layer, op, s, places, i0, i1)      makes b, and notes what a later term needs, from rows at these places: those of
                                            q, c, b and what is free
    averaged(q, c), rows(q, v, c)           where the rows begin whose means are taken, and the rows y
    flux(law, constants, means, b, differences)    for each of the unknowns
    gather                                  DIFFERENCE or MIDDLE for each of them
    scale(layer, first)                     and a factor
    at_wall(velocity, changes)              of the rates at an end point that a moving wall gives its momentum
    kinetic                                 1 if the first unknown is the velocity of a solid, else 0

for a law whose ``undivided`` has it; q, v and f as in fsipetsc.scheme.sweep. A term reaches ``last`` points, and may go as far
as D twice does: c, b and what they are made of may, too; f is known only as far as D reaches.

Sums over k are made from the last one down: Delta_{k+1}^T g = Delta_k^T (what is g at the difference before less what it is
at this one), so that one row takes up all orders, and Delta_first^T is applied once.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.boundaries import INTERFACE_END, WALL
from fsipetsc.operators.differences import difference_of, mean_of, pairs_of, weight_of, weights_of_mean
from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, OPTIONS, ROW, U64, store_lanes, whole_vectors
from fsipetsc.operators.lanes import masked
from fsipetsc.operators.memory import load, store
from fsipetsc.operators.vectors import LANES, fma, spread
from fsipetsc.parallel.exchange import kinetic_energy_of
from fsipetsc.physics.layer import LOADED
from fsipetsc.scheme.end_rates import add_to_rate
from fsipetsc.scheme.sweep import row_of

#: first row of scratch that is used here
FIRST = 5
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
    """One of the terms."""
    levels, free, reach = term.levels(op), v + FIRST * ROW, term.reach(op)
    c, b = each(row_of.place, term.coefficients, free, ROW), each(row_of.place, term.own, free, ROW)
    sums = each(row_of.place, term.sums, free, ROW)
    q, v = each(row_of.place, law.unknowns, w, layer.stride), each(row_of.place, law.prepared, v, ROW)
    f, numbers = each(row_of.place, law.fluxes, f, ROW), term.constants(law, layer)
    for i in range(max(layer.lo, i0 - reach), min(layer.hi + 1, i1 + reach), LANES):
        here = each(row_of.load, q, s, i), each(row_of.load, v, s, i), each(row_of.load, f, s, i)
        each(row_of.store, c, term.weigh(law, numbers, i, here[0], here[1], here[2]), s, i)
    term.look(layer, op, s, (q, c, b, free), i0, i1)
    rows = term.averaged(q, c), b, term.rows(q, v, c)
    sum_up(term, law, layer, levels, numbers, s, rows, sums, i0, i1)
    sum_up_ends(term, law, layer, levels, numbers, s, rows, sums, i0, i1)
    send(term, layer, op, levels, s, w, sums, target, i0, i1)
    return 0


@njit(**OPTIONS)
def sum_up(term, law, layer, levels, numbers, s, rows, sums, i0, i1):
    """The sums over k but for the ends: that of the difference which begins at i stands at i + levels.first - levels.last."""
    lo, hi, last = layer.lo + levels.skipped, layer.hi - levels.skipped, levels.last
    c, b, y = rows
    for i in range(i0 - last - LANES, i1 + LANES, LANES):
        each(undivided_of.clear, sums, s, i)
    # what is stored here begins each time a point earlier, and overwrites what has been used
    for order in range(last, levels.first - 1, -1):
        k, pairs, end = order - levels.first, pairs_of(order), min(i1, hi + 1 - order)
        count, weights = levels.counts[k], weights_of_mean(levels, k)
        for i in range(max(lo, i0 - order), end, LANES):
            means = each(undivided_of.mean, c, s, i, order, count, weights)
            differences = each(undivided_of.difference, y, s, i, order, pairs)
            fluxes = term.flux(law, numbers, means, each(row_of.load, b, s, i), differences)
            each(undivided_of.add_up, sums, fluxes, s, i + order - last, end - i)


@njit(**OPTIONS)
def sum_up_ends(term, law, layer, levels, numbers, s, rows, sums, i0, i1):
    """The terms of the ends, to the same sums."""
    c, b, y = rows
    for side in range(2):
        end, step = (layer.lo, 1) if side == 0 else (layer.hi - levels.first, -1)
        inside = (layer.lo if side == 0 else layer.hi) + step * levels.skipped
        for t in range(levels.ends):
            at = end + step * t
            if i0 - levels.first <= at < i1:
                differences = each(undivided_of.end_difference, y, s, end, step, t, levels)
                own = each(undivided_of.at, b, s, inside)
                fluxes = term.flux(law, numbers, each(undivided_of.at, c, s, inside), own, differences)
                each(undivided_of.add_at, sums, fluxes, s, at + levels.first - levels.last)


@njit(**OPTIONS)
def send(term, layer, op, levels, s, w, sums, target, i0, i1):
    """To the rates what the sums say; in place as above."""
    pairs, last, whole = pairs_of(levels.first), levels.last, whole_vectors(i0, i1)
    for i in range(i0, i1, LANES):
        each(undivided_of.gather, term.gather, sums, s, i - last, levels.first, pairs)
    for r in range(op.rows):
        for i in (layer.lo + r, layer.hi - r):
            if i0 <= i < i1:
                each(undivided_of.divide, sums, s, i - last, op.norm[r])
    scales = each(undivided_of.scale, term.gather, term.scale(layer, levels.first), levels.first)
    for side in range(2):
        end = layer.lo if side == 0 else layer.hi
        if i0 <= end < i1 and layer.unloaded[side] != LOADED:
            changes = each(undivided_of.at, sums, s, end - last)
            if layer.end_kind[side] == WALL:
                each(undivided_of.put, sums, term.at_wall(layer.end_v[side], changes), s, end - last)
            elif term.kinetic != 0 and layer.end_kind[side] == INTERFACE_END:
                power = layer.m0 * s[U64(w + end)] * (scales[0] * changes[0])
                add_to_rate(s, target, 0, kinetic_energy_of(layer, side), power)
    for i in range(i0, whole, LANES):
        each(undivided_of.add_to_rates, term.unknowns, sums, s, i - last, scales, target, i)
    if whole < i1:
        each(undivided_of.add_lanes_to_rates, term.unknowns, sums, s, whole - last, scales, target, whole, i1 - whole)


# what is done to each of some rows


@njit(**FORMULA)
def _clear(begin, s, i):
    store(s, begin + i, spread(0.0))
    return 0


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
def _put(begin, value, s, i):
    s[U64(begin + i)] = value
    return 0


@njit(**FORMULA)
def _end_difference(begin, s, end, step, t, levels):
    """What the term of the end takes for difference t there: a sum of the first ones."""
    result = 0.0
    for k in range(levels.ends):
        difference = 0.0
        for j in range(levels.first + 1):
            difference += weight_of(levels.first, j) * s[U64(begin + end + step * k + j)]
        result += levels.end[t, k] * difference
    return result


@njit(**FORMULA)
def _add_at(begin, flux, s, at):
    s[U64(begin + at)] += flux
    return 0


@njit(**FORMULA)
def _gather(how, begin, s, at, order, pairs):
    """What the points take from differences of this order, whose own sums stand ``order`` further on."""
    store(s, begin + at, how.gather(begin, s, at, order, pairs))
    return 0


@njit(**FORMULA)
def _scale(how, scale, order):
    return scale * how.sign(order)


@njit(**FORMULA)
def _divide(begin, s, at, weight):
    s[U64(begin + at)] /= weight
    return 0


@njit(**FORMULA)
def _add_to_rates(unknown, begin, s, at, scale, target, i):
    to, change = unknown * target.stride + i, scale * load(s, begin + at)
    store(s, target.next + to, fma(target.a, change, load(s, target.next + to)))
    if target.sum >= 0:
        store(s, target.sum + to, fma(target.b, change, load(s, target.sum + to)))
    return 0


@njit(**FORMULA)
def _add_lanes_to_rates(unknown, begin, s, at, scale, target, i, n):
    """The first n lanes."""
    to, change = unknown * target.stride + i, scale * load(s, begin + at)
    store_lanes(s, target.next + to, fma(target.a, change, load(s, target.next + to)), 0, n)
    if target.sum >= 0:
        store_lanes(s, target.sum + to, fma(target.b, change, load(s, target.sum + to)), 0, n)
    return 0


undivided_of = Formulas(
    add=_add,
    clear=_clear,
    mean=mean_of,
    difference=difference_of,
    add_up=_add_up,
    gather=_gather,
    scale=_scale,
    at=_at,
    put=_put,
    end_difference=_end_difference,
    add_at=_add_at,
    divide=_divide,
    add_to_rates=_add_to_rates,
    add_lanes_to_rates=_add_lanes_to_rates,
)
