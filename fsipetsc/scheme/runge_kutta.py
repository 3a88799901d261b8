"""The classical Runge-Kutta method of fourth order, each stage written where the next one is read.

With the rates k of a stage

    stage = y + a k,   sum = base + b k     a = dt/2, dt/2, dt;  b = dt/6, dt/3, dt/3
    y = sum + dt/6 k                        after the last one

in one pass over memory.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.loops import LOOP

STAGES = 4


@njit(**LOOP)
def next_stage(y, k, a, b, stage, total):
    """stage = y + a k, total = y + b k."""
    for i in range(y.size):
        stage[i] = y[i] + a * k[i]
        total[i] = y[i] + b * k[i]


@njit(**LOOP)
def further_stage(y, k, a, b, stage, total):
    """stage = y + a k, total += b k."""
    for i in range(y.size):
        stage[i] = y[i] + a * k[i]
        total[i] += b * k[i]


@njit(**LOOP)
def last_stage(total, k, b, y):
    """y = total + b k."""
    for i in range(y.size):
        y[i] = total[i] + b * k[i]


def compile_stages() -> None:
    """Compile the loops, or load them."""
    y, k, stage, total = np.zeros((4, 1))
    next_stage(y, k, 0.0, 0.0, stage, total)
    further_stage(y, k, 0.0, 0.0, stage, total)
    last_stage(total, k, 0.0, y)
