"""Where the rates of a row go: together again, point by point, to the next Runge-Kutta stage or as they are. Compiled.

    onward = source + a k,        total = base + b k

as fsipetsc.scheme.stage_update has it in one dimension, but totals are kept of points at edges alone, whose unknowns are
changed between two stages. What the others have been in the stages y0, y1, y2, y3 tells their rates, so that the last one makes

    onward = y0 + ((y1 - y0) + 2 (y2 - y0) + (y3 - y0))/3 + a k

of them, and a third of what goes through memory does not. At interfaces the two sides may have to be told a traction first
(fsipetsc.coupling.plane, ``slide``): rows there are kept as rates, and sent on by ``advance`` when that is done.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64
from fsipetsc.operators.lanes import interlaced
from fsipetsc.operators.memory import fetch, load_wide, store
from fsipetsc.operators.rows import STRIDE
from fsipetsc.operators.vectors import WIDE, fma
from fsipetsc.physics.plane.layer import DOF

#: those that the rates of a vector of points make
_VECTORS = tuple(range(DOF))
_THIRD = 1.0 / 3.0
#: doubles of a cache line
LINE = 8
#: points of a layer whose stages stay in a second cache of 1 to 2 MB
SMALL = 8192


class Target(NamedTuple):
    """rates: of the points that are owned; the others: of all that are held, empty where rates are all that is wanted,
    total in the last stage, stages in all others: there they are y1, y2, y3, and y0 stands in ``onward``. kept: see
    fsipetsc.scheme.plane.kinetic, empty where that is not wanted.
    """

    rates: np.ndarray
    source: np.ndarray
    onward: np.ndarray
    a: float
    base: np.ndarray
    total: np.ndarray
    b: float
    stages: tuple[np.ndarray, np.ndarray, np.ndarray]
    kept: np.ndarray


@njit(**FORMULA)
def at_interface(layer, j):
    """Whether row j meets another layer."""
    low = j == layer.end_y[0] and layer.edge_y[0] == INTERFACE_END
    return low or (j == layer.end_y[1] and layer.edge_y[1] == INTERFACE_END)


@njit(**FORMULA)
def too_large(layer):
    """Whether the stages of a layer do not stay in the second cache from one to the next."""
    return layer.height * layer.width > SMALL


@njit(**FORMULA)
def fetch_points(unknowns, n):
    """Have those of WIDE points, which begin at number n, brought near."""
    for k in range(0, WIDE * DOF, LINE):
        fetch(unknowns, n + k)


@njit(**FORMULA)
def fetch_next(layer, target, n, ends):
    """Have what ``send_row`` takes and makes in the next row brought near, beyond points whose unknowns begin at number n."""
    n = n + layer.width * DOF
    fetch_points(target.onward, n)
    if ends:
        each(of_parts.fetch, target.stages, n)
    else:
        fetch_points(target.source, n)


@njit(**FORMULA)
def send_row(layer, s, place, target, j):
    """The rates of row j of a block, from scratch."""
    as_they_are, width = target.onward.size == 0 or at_interface(layer, j), layer.own_x[1] - layer.own_x[0]
    k = ((j - layer.own_y[0]) * width - layer.own_x[0]) * DOF
    n, whole = j * layer.width * DOF, place.first + (place.end - place.first) // WIDE * WIDE
    at_edge, ends = j == layer.end_y[0] or j == layer.end_y[1], target.stages[0].size > 0
    far = too_large(layer) and not as_they_are
    for i in range(place.first, whole, WIDE):
        if far:
            fetch_next(layer, target, n + i * DOF, ends)
        values = interlaced(each(of_parts.rate, _VECTORS, place, s, i))
        if as_they_are:
            each(of_parts.put, values, _VECTORS, target.rates, k + i * DOF)
        elif ends:
            each(of_parts.end, values, _VECTORS, target, n + i * DOF)
        else:
            each(of_parts.send, values, _VECTORS, target, n + i * DOF)
    for i in range(whole, place.end):
        for c in range(DOF):
            rate = s[U64(place.rates + c * STRIDE + i)]
            if as_they_are:
                target.rates[U64(k + i * DOF + c)] = rate
            elif ends:
                end_number(rate, target, n + i * DOF + c)
            else:
                send_number(rate, target, n + i * DOF + c)
    if at_edge and not as_they_are:
        send_totals(s, place, target, n, place.first, place.end)
    elif not as_they_are:
        for end in layer.end_x:
            send_totals(s, place, target, n, max(place.first, end), min(place.end, end + 1))


@njit(**OPTIONS)
def advance(layer, target):
    """Send on the rows at interfaces."""
    first, count = layer.own_x[0], (layer.own_x[1] - layer.own_x[0]) * DOF
    for j in (layer.own_y[0], layer.own_y[1] - 1):
        if at_interface(layer, j):
            k, n = (j - layer.own_y[0]) * count, (j * layer.width + first) * DOF
            for i in range(count):
                send_total(target.rates[U64(k + i)], target, n + i)


@njit(**FORMULA)
def send_number(rate, target, n):
    """Use a rate of number n of the unknowns."""
    target.onward[U64(n)] = fma(target.a, rate, target.source[U64(n)])


@njit(**OPTIONS)
def send_totals(s, place, target, n, first, end):
    """Those of points at edges, of some columns of a row whose unknowns begin at n."""
    for i in range(first, end):
        for c in range(DOF):
            send_total(s[U64(place.rates + c * STRIDE + i)], target, n + i * DOF + c)


@njit(**FORMULA)
def end_number(rate, target, n):
    """Likewise in the last stage."""
    first, second, third = target.stages
    start = target.onward[U64(n)]
    target.onward[U64(n)] = combined(rate, target.a, start, first[U64(n)], second[U64(n)], third[U64(n)])


@njit(**FORMULA)
def send_total(rate, target, n):
    """Use a rate of number n of the unknowns, of a point at an edge."""
    send_number(rate, target, n)
    if target.total.size > 0:
        target.total[U64(n)] = fma(target.b, rate, target.base[U64(n)])


@njit(**FORMULA)
def combined(rate, a, start, first, second, third):
    """The end of a step."""
    rest = second - start
    return fma(a, rate, start + _THIRD * ((first - start) + (third - start) + (rest + rest)))


# what is done with a vector of rates, of unknowns that stand together


@njit(**FORMULA)
def _send(rates, number, target, n):
    i = n + WIDE * number
    store(target.onward, i, fma(target.a, rates, load_wide(target.source, i)))
    return 0


@njit(**FORMULA)
def _end(rates, number, target, n):
    i = n + WIDE * number
    start, (first, second, third) = load_wide(target.onward, i), target.stages
    first, second, third = load_wide(first, i), load_wide(second, i), load_wide(third, i)
    store(target.onward, i, combined(rates, target.a, start, first, second, third))
    return 0


@njit(**FORMULA)
def _fetch(stage, n):
    fetch_points(stage, n)
    return 0


@njit(**FORMULA)
def _put(rates, number, to, k):
    store(to, k + WIDE * number, rates)
    return 0


@njit(**FORMULA)
def _rate(number, place, s, i):
    return load_wide(s, place.rates + number * STRIDE + i)


of_parts = Formulas(rate=_rate, send=_send, end=_end, put=_put, fetch=_fetch)
