"""What a frame holds of the points of a rank, from their work area. Compiled."""

from __future__ import annotations

from numba import njit

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.operators.kernels import ENTRY
from fsipetsc.parallel.exchange import work_point
from fsipetsc.parallel.plan import WORK
from fsipetsc.physics.fluid import fluid_fields
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.solid import solid_fields

#: numbers that are saved of a point, in either kind of layer
SAVED = 5


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
        if layer.kind == FLUID:
            interface = layer.lo if layer.end_kind[0] == INTERFACE_END else layer.hi
            fluid_fields(layer, memory, w, interface, out, starts[k], stride)
        else:
            solid_fields(layer, head.op, memory, w, head.scratch, out, starts[k], stride)
