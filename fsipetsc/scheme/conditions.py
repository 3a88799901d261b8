"""Makes a work area right: halos, ghost points, outer ends, interfaces. Compiled; collective on all ranks.

Ghost points and ends are filled from the raw values, then the interfaces are projected; the two do not touch each
other's points. Every rank that has a point in its work area computes it, from the same numbers. The grids of the gases follow
from the interfaces: where these are before, how fast they are after the projection.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.operators.formulas import with_chosen
from fsipetsc.operators.kernels import OPTIONS, U64
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


@njit(**OPTIONS)
def place_interface(layers, face, x):
    """An interface stands at x, where the end point of the solid is."""
    layers[face.fluid].x_interface = x
    layers[face.fluid].end_x[0 if face.normal > 0.0 else 1] = x


@njit(**OPTIONS)
def place_points(layers, faces):
    """The points of stretched layers are as far apart as their ends, which have been placed, have it."""
    for layer in layers:
        if layer.stretched != 0:
            layer.J = (layer.end_x[1] - layer.end_x[0]) / ((layer.n - 1) * layer.h)
    for k in range(faces.size):
        face = faces[k]
        face.J = layers[face.fluid].J
        face.spacing = face.h_gas * face.J
        face.ratio = face.spacing / face.h


@njit(**OPTIONS)
def move_interface(layers, face, u):
    """The gas at an interface, and the grid there with it, has the velocity u."""
    layer = layers[face.fluid]
    layer.end_v[0 if face.normal > 0.0 else 1] = u
    if layer.stretched == 0:
        layer.s = u


@njit(**OPTIONS)
def move_points(layers):
    """The points of stretched layers move as their ends, whose velocities are known, have it."""
    for layer in layers:
        if layer.stretched != 0:
            layer.s, layer.spread = layer.end_v[0], (layer.end_v[1] - layer.end_v[0]) / (layer.n - 1)


@njit(**OPTIONS)
def apply_conditions(head, layers, faces, memory, area):
    """Fill halos, ghost points and ends of a work area and project its interfaces; sets the frames."""
    exchange(head, layers, faces, memory, area)
    for k in range(faces.size):
        place_interface(layers, faces[k], memory[U64(head.traces + k * head.rows * TRACE + 6)])
    place_points(layers, faces)
    for layer in layers:
        for side in range(2):
            if layer.end_kind[side] != INTERFACE_END:
                with_chosen(of_layer.end, LAWS, layer.law, head, layer, memory, area, side, OLD)
    for k in range(faces.size):
        at = head.traces + k * head.rows * TRACE
        trace = rows_at(memory, at, head.rows, TRACE)
        with_chosen(of_interface.couple, PAIRS, faces[k].pair, faces[k], head.op, trace[:, :3], trace[:, 3:])
        unpack(head, layers, faces[k], memory, area, at)
        move_interface(layers, faces[k], trace[0, 1] / trace[0, 0])
    move_points(layers)
