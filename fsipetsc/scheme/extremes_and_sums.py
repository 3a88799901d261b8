"""The survey of a layer: extremes that bound the time step and sums for the ledgers, from one look at each point.

Words of a survey, gathered from as many parts of a layer as one likes. Extremes are exact and let through what is not a
number; the last bits of sums depend on the parts.

    fluid   SPEED largest |u-s| + c; LEAST_RHO, LEAST_T;                  SUMS of rho, rho u, e
    solid   LEAST_STRAIN x_X, LEAST_SIGMA, LEAST_T, GREATEST_T;           SUMS of u, u^2, T
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.operators.vectors import lane, maximum, minimum
from fsipetsc.physics.layer import FLUID

SPEED, LEAST_RHO, LEAST_T = 0, 1, 2
LEAST_STRAIN, LEAST_SIGMA, GREATEST_T = 0, 1, 3
SUMS = 4
#: words of a survey
SIZE = 8


@njit(**OPTIONS)
def begin_survey(layer, s, at):
    """Nothing has been seen yet. A survey of s[at:]."""
    for k in range(SUMS):
        s[U64(at + k)] = np.inf
    s[U64(at + (SPEED if layer.kind == FLUID else GREATEST_T))] = -np.inf
    for k in range(SUMS, SIZE):
        s[U64(at + k)] = 0.0


@njit(**OPTIONS)
def note_largest(s, at, v):
    """The lanes of v count for the maximum at s[at]."""
    v = maximum(maximum(lane(v, 0), lane(v, 1)), maximum(lane(v, 2), lane(v, 3)))
    s[U64(at)] = maximum(s[U64(at)], v)


@njit(**OPTIONS)
def note_smallest(s, at, v):
    """The lanes of v count for the minimum at s[at]."""
    v = minimum(minimum(lane(v, 0), lane(v, 1)), minimum(lane(v, 2), lane(v, 3)))
    s[U64(at)] = minimum(s[U64(at)], v)


@njit(**OPTIONS)
def note_sum(s, at, v):
    """The lanes of v count for the sum at s[at]."""
    s[U64(at)] += (lane(v, 0) + lane(v, 1)) + (lane(v, 2) + lane(v, 3))
