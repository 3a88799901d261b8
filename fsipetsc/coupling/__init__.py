"""Interface treatments: one file each, one signature (fsipetsc.coupling.interface).

To add one, write its file and add a line to ``KINDS`` and to ``couple``.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.coupling.conservative import conservative
from fsipetsc.coupling.energy import energy
from fsipetsc.coupling.interface import INTERFACE, residuals
from fsipetsc.coupling.projection import projection
from fsipetsc.coupling.traditional import traditional
from fsipetsc.operators.kernels import OPTIONS

PROJECTION, ENERGY, TRADITIONAL, CONSERVATIVE = 0, 1, 2, 3
KINDS = {"projection": PROJECTION, "energy": ENERGY, "traditional": TRADITIONAL, "conservative": CONSERVATIVE}


@njit(**OPTIONS)
def couple(pair, face, op, trace_f, trace_s):
    """Apply the treatment that the interface names to its traces, in place.

    trace_f: J (rho, rho u, e); trace_s: (u, sigma, T, x, m0 u^2/2), the last one in the first row.
    """
    if face.coupling == CONSERVATIVE:
        conservative(pair, face, op, trace_f, trace_s)
        return
    if face.J != 1.0:
        scale(trace_f, 1.0 / face.J)
    if face.coupling == PROJECTION:
        projection(pair, face, op, trace_f, trace_s)
    elif face.coupling == ENERGY:
        energy(pair, face, op, trace_f, trace_s)
    else:
        traditional(pair, face, op, trace_f, trace_s)
    if face.J != 1.0:
        scale(trace_f, face.J)


@njit(**OPTIONS)
def scale(trace_f, factor):
    """Multiply the rows of a gas, in place."""
    for j in range(len(trace_f)):
        for c in range(3):
            trace_f[j, c] *= factor


__all__ = ["CONSERVATIVE", "INTERFACE", "KINDS", "couple", "residuals", "scale"]
