"""Where a right-hand side goes: into the next Runge-Kutta stage and the sum that becomes the new solution.

    next = source + a k,        sum = base + b k

One form serves all: the rates k themselves are the next of a stage with a = 1 whose source is zero, and without a sum.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from fsipetsc.operators.kernels import FORMULA, store_lanes
from fsipetsc.operators.memory import load, store
from fsipetsc.operators.vectors import fma


class Target(NamedTuple):
    """What to do with the rates of a layer: where its point 0 would stand in each array, and the factors (times dt).

    sum and forcing are -1 where there is none. The unknowns of a layer stand ``stride`` apart in all of them.
    """

    source: int
    next: int
    base: int
    sum: int
    forcing: int
    stride: int
    a: float
    b: float
    J: float  # what forcing is multiplied with


@njit(**FORMULA)
def update_stage(s, target, unknown, i, k):
    """Send on the rates k of one unknown at the points i .. i+LANES-1."""
    at = unknown * target.stride + i
    if target.forcing >= 0:
        k = k + target.J * load(s, target.forcing + at)
    store(s, target.next + at, fma(target.a, k, load(s, target.source + at)))
    if target.sum >= 0:
        store(s, target.sum + at, fma(target.b, k, load(s, target.base + at)))


@njit(**FORMULA)
def update_stage_lanes(s, target, unknown, i, k, first, end):
    """As ``update_stage``, of the lanes first <= j < end only."""
    at = unknown * target.stride + i
    if target.forcing >= 0:
        k = k + target.J * load(s, target.forcing + at)
    store_lanes(s, target.next + at, fma(target.a, k, load(s, target.source + at)), first, end)
    if target.sum >= 0:
        store_lanes(s, target.sum + at, fma(target.b, k, load(s, target.base + at)), first, end)
