"""After a step: flags and the bound on the next step. Compiled."""

import numpy as np
from numba import njit

from fsipetsc.operators.loops import MERGED_CALL
from fsipetsc.scheme.block_monitor import MONITORED
from fsipetsc.scheme.plan import BAD, RATE, STOP


@njit(**MERGED_CALL)
def note_extremes(extremes, rates, results, latest):
    """Put the extremes of all ranks where they belong.

    extremes: (1 + MONITORED blocks,), what a rank says of stopping, and those of each block. rates:
    (blocks, 2). latest: begins with the least J and the departure of J of each block. The bound on
    the step is the 4-norm of both rates.
    """
    blocks = rates.shape[0]
    convection, diffusion, bad = 0.0, 0.0, 0.0
    for k in range(blocks):
        at = 1 + MONITORED * k
        bad = max(bad, extremes[at])
        rates[k, 0], rates[k, 1] = extremes[at + 1], extremes[at + 2]
        latest[k], latest[blocks + k] = -extremes[at + 3], extremes[at + 4]
        convection = np.maximum(convection, extremes[at + 1])  # what is no number stays one
        diffusion = np.maximum(diffusion, extremes[at + 2])
    results[RATE] = np.sqrt(np.sqrt(convection**4 + diffusion**4))
    results[BAD], results[STOP] = bad, extremes[0]


@njit(**MERGED_CALL)
def note_gained(latest, auxiliary):
    """Put what came in, the auxiliary unknowns, into the last columns of ``latest``.

    The monitor leaves minus the energy E of solids where what they lost of it will be. So E stays
    in an auxiliary unknown, which after the next step is W + E, W the work: W + E - E' is lost.
    """
    first = latest.size - auxiliary.size
    for c in range(auxiliary.size):
        latest[first + c] += auxiliary[c]
        auxiliary[c] -= latest[first + c]
