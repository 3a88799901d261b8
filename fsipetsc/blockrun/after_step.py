"""After a step: flags and the bound on the next step, its record, and the next step of a burst.

Compiled.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.loops import CALL
from fsipetsc.scheme.burst import (
    ALLOWED,
    COURANT,
    DT,
    FIRST,
    FIXED,
    LONGEST,
    MADE,
    NEXT,
    SHORTEST,
    TARGET,
    TIME,
)
from fsipetsc.scheme.plan import BAD, RATE, STOP
from fsipetsc.scheme.time_step import longest_step, next_step

#: of each block: 1 if a state is unphysical, largest rates of convection and of diffusion [1/s],
#: minus the least J, largest |J - det D x| / J
WORDS = 5

_longest_step, _next_step = njit(**CALL)(longest_step), njit(**CALL)(next_step)


@njit(**CALL)
def note_extremes(extremes, rates, results, latest):
    """Put the extremes of all ranks where they belong.

    extremes: (1 + WORDS blocks,), what a rank says of stopping, and the words of each block. rates:
    (blocks, 2). latest: begins with the least J and the departure of J of each block. The bound on
    the step is the 4-norm of both rates.
    """
    blocks = rates.shape[0]
    convection, diffusion, bad = 0.0, 0.0, 0.0
    for k in range(blocks):
        at = 1 + WORDS * k
        bad = max(bad, extremes[at])
        rates[k, 0], rates[k, 1] = extremes[at + 1], extremes[at + 2]
        latest[k], latest[blocks + k] = -extremes[at + 3], extremes[at + 4]
        convection = np.maximum(convection, extremes[at + 1])  # what is no number stays one
        diffusion = np.maximum(diffusion, extremes[at + 2])
    results[RATE] = np.sqrt(np.sqrt(convection**4 + diffusion**4))
    results[BAD], results[STOP] = bad, extremes[0]


@njit(**CALL)
def plan_next(burst, results, journal, latest):
    """Note the step just made in burst and journal, plan the next one; False if none follows.

    The same on all ranks. burst: see fsipetsc.scheme.burst; one that has ended, or was never
    planned, allows no steps. journal: (rows, columns), each row time, step, and what is in latest.
    """
    allowed, burst[ALLOWED] = burst[ALLOWED], 0.0
    if allowed == 0.0:
        return False
    t, dt, made = burst[NEXT], burst[DT], burst[MADE]
    row = int(burst[FIRST] + made)
    journal[row, 0], journal[row, 1] = t, dt
    for c in range(latest.size):  # an assignment of arrays compiles for seconds
        journal[row, 2 + c] = latest[c]
    burst[TIME], burst[MADE] = t, made + 1
    burst[SHORTEST], burst[LONGEST] = min(burst[SHORTEST], dt), max(burst[LONGEST], dt)
    rate = results[RATE]
    ends = results[BAD] != 0.0 or results[STOP] != 0.0 or not 0.0 < rate < 1e300
    if ends or t >= burst[TARGET] or made + 1 >= allowed:
        return False
    bound = _longest_step(burst[COURANT], burst[FIXED], rate)
    burst[DT], burst[NEXT] = _next_step(t, burst[TARGET], bound)
    burst[ALLOWED] = allowed
    return True
