"""Interface treatments: one file each, one signature (fsipetsc.coupling.interface).

To add one, write its file and add a line to ``KINDS`` and to ``couple``.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.coupling.energy import energy
from fsipetsc.coupling.interface import INTERFACE, residuals
from fsipetsc.coupling.projection import projection
from fsipetsc.coupling.traditional import traditional
from fsipetsc.operators.kernels import OPTIONS

PROJECTION, ENERGY, TRADITIONAL = 0, 1, 2
KINDS = {"projection": PROJECTION, "energy": ENERGY, "traditional": TRADITIONAL}


@njit(**OPTIONS)
def couple(pair, face, op, trace_f, trace_s):
    """Apply the treatment that the interface names to its traces, in place."""
    if face.coupling == PROJECTION:
        projection(pair, face, op, trace_f, trace_s)
    elif face.coupling == ENERGY:
        energy(pair, face, op, trace_f, trace_s)
    else:
        traditional(pair, face, op, trace_f, trace_s)


__all__ = ["INTERFACE", "KINDS", "couple", "residuals"]
