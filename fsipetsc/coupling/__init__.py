"""Interface treatments: one file each, one signature (fsipetsc.coupling.interface).

To add one, write its file and add a line to ``KINDS`` and to ``couple``.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.coupling.interface import INTERFACE, residuals
from fsipetsc.coupling.projection import projection
from fsipetsc.operators.kernels import OPTIONS

PROJECTION = 0
KINDS = {"projection": PROJECTION}


@njit(**OPTIONS)
def couple(face, op, trace_f, trace_s):
    """Apply the treatment that the interface names to its traces, in place."""
    if face.coupling == PROJECTION:
        projection(face, op, trace_f, trace_s)


__all__ = ["INTERFACE", "KINDS", "couple", "residuals"]
