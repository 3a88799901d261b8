"""Where the rates of a row go: together again, point by point, to the next Runge-Kutta stage or as they are. Compiled.

    onward = source + a k,        total = base + b k

as fsipetsc.scheme.stage_update has it in one dimension. At interfaces the two sides may have to be told a traction first
(fsipetsc.coupling.plane, ``slide``): rows there are kept as rates, and sent on by ``advance`` when that is done.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64
from fsipetsc.operators.vectors import LANES, WIDE, fma, load, load_wide, store, store_interlaced
from fsipetsc.physics.plane.layer import DOF


class Target(NamedTuple):
    """rates: of the points that are owned; the others: of all that are held, empty where rates are all that is wanted,
    total where no sum is.
    """

    rates: np.ndarray
    source: np.ndarray
    onward: np.ndarray
    a: float
    base: np.ndarray
    total: np.ndarray
    b: float


@njit(**FORMULA)
def at_interface(layer, j):
    """Whether row j meets another layer."""
    low = j == layer.end_y[0] and layer.edge_y[0] == INTERFACE_END
    return low or (j == layer.end_y[1] and layer.edge_y[1] == INTERFACE_END)


@njit(**OPTIONS)
def send_row(layer, s, place, target, j):
    """The rates of row j, from scratch."""
    first, count = layer.own_x[0], (layer.own_x[1] - layer.own_x[0]) * DOF
    if target.onward.size == 0 or at_interface(layer, j):
        interlace(layer, s, place, target.rates, (j - layer.own_y[0]) * count - first * DOF)
        return
    interlace(layer, s, place, s, place.sent)
    send_on(s, place.sent + first * DOF, target, (j * layer.width + first) * DOF, count)


@njit(**OPTIONS)
def advance(layer, target):
    """Send on the rows at interfaces."""
    first, count = layer.own_x[0], (layer.own_x[1] - layer.own_x[0]) * DOF
    for j in (layer.own_y[0], layer.own_y[1] - 1):
        if at_interface(layer, j):
            rates = (j - layer.own_y[0]) * count
            send_on(target.rates, rates, target, (j * layer.width + first) * DOF, count)


@njit(**OPTIONS)
def interlace(layer, s, place, to, begin):
    """Put the rates of a row together again, those of column i to to[begin + i DOF]."""
    first, end, stride, r = layer.own_x[0], layer.own_x[1], place.stride, place.rates
    whole = first + (end - first) // LANES * LANES
    for i in range(first, whole, LANES):
        values = (
            load(s, r + i),
            load(s, r + stride + i),
            load(s, r + 2 * stride + i),
            load(s, r + 3 * stride + i),
            load(s, r + 4 * stride + i),
        )
        store_interlaced(to, begin + i * DOF, values)
    for i in range(whole, end):
        for c in range(DOF):
            to[U64(begin + i * DOF + c)] = s[U64(r + c * stride + i)]


@njit(**OPTIONS)
def send_on(rates, k, target, at, count):
    """Use ``count`` rates that begin at rates[k] for the points that begin at ``at``."""
    add(rates, k, target.source, target.onward, at, count, target.a)
    if target.total.size > 0:
        add(rates, k, target.base, target.total, at, count, target.b)


@njit(**OPTIONS)
def add(rates, k, source, to, at, count, a):
    """to = source + a k, of so many numbers."""
    whole = count - count % WIDE
    for i in range(0, whole, WIDE):
        store(to, at + i, fma(a, load_wide(rates, k + i), load_wide(source, at + i)))
    for i in range(whole, count):
        to[U64(at + i)] = fma(a, rates[U64(k + i)], source[U64(at + i)])
