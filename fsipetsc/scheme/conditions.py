"""Makes a work area right: halos, ghost points, outer ends, interfaces. Compiled; collective on all ranks.

Ghost points and ends are filled from the raw values, then the interfaces are projected; the two do not touch each
other's points. Every rank that has a point in its work area computes it, from the same numbers.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.operators.formulas import with_chosen
from fsipetsc.operators.kernels import INLINE, OPTIONS, U64
from fsipetsc.parallel.exchange import TRACE, exchange, unpack
from fsipetsc.parallel.pointers import rows_at
from fsipetsc.scheme.laws import LAWS, PAIRS, of_interface, of_layer
from fsipetsc.scheme.layer_ends import OLD


@njit(**OPTIONS)
def note_gradients(head, layers, memory, area):
    """Note what the gradients take at the ghost points of a work area that fulfils the conditions already."""
    for layer in layers:
        for side in range(2):
            if layer.end_kind[side] != INTERFACE_END:
                with_chosen(of_layer.note, LAWS, layer.law, head, layer, memory, area, side)


@njit(**INLINE)
def apply_conditions(head, layers, faces, memory, area):
    """Fill halos, ghost points and ends of a work area and project its interfaces; sets the frames."""
    exchange(head, layers, faces, memory, area)
    for k in range(faces.size):
        # position of the interface point of the solid
        layers[faces[k].fluid].x_interface = memory[U64(head.traces + k * head.rows * TRACE + 6)]
    for layer in layers:
        for side in range(2):
            if layer.end_kind[side] != INTERFACE_END:
                with_chosen(of_layer.end, LAWS, layer.law, head, layer, memory, area, side, OLD)
    for k in range(faces.size):
        at = head.traces + k * head.rows * TRACE
        trace = rows_at(memory, at, head.rows, TRACE)
        with_chosen(of_interface.couple, PAIRS, faces[k].pair, faces[k], head.op, trace[:, :3], trace[:, 3:])
        unpack(head, layers, faces[k], memory, area, at)
        layers[faces[k].fluid].s = trace[0, 1] / trace[0, 0]
