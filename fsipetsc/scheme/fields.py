"""What a frame holds of the points of a rank, from their work area. Compiled."""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import with_chosen
from fsipetsc.operators.kernels import ENTRY
from fsipetsc.parallel.exchange import work_point
from fsipetsc.scheme.laws import LAWS, of_layer
from fsipetsc.scheme.layer_fields import SAVED as SAVED
from fsipetsc.scheme.plan import WORK


@njit(**ENTRY)
def fields(heads, layers, memory, out, starts, stride):
    """Write what is saved of the owned points of all layers, from the work area, which a completed step leaves up to date.

    Fluid rho, u, T, p, x, NaN where inactive; solid u, sigma, T, x, p; x: Eulerian position. Those of the j-th owned point
    of layer k go to out[starts[k] + j stride:].
    """
    head = heads[0]
    for k in range(layers.size):
        layer = layers[k]
        if layer.present == 0:
            continue
        w = work_point(head, layer, WORK, 0)
        with_chosen(of_layer.save, LAWS, layer.law, layer, head.op, memory, w, head.scratch, out, starts[k], stride)
