"""Makes a work area right: halos, ghost points, outer ends, interfaces. Compiled; collective on all ranks.

Ghost points and ends are filled from the raw values, then the interfaces are projected; the two do not touch each
other's points. Every rank that has a point in its work area computes it, from the same numbers.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.boundaries import INTERFACE_END, NODES, close_solid, fill_ghost, note_gradient
from fsipetsc.coupling import couple
from fsipetsc.operators.kernels import INLINE, OPTIONS, U64
from fsipetsc.parallel.exchange import TRACE, exchange, holds, unpack, work_point
from fsipetsc.parallel.pointers import rows_at
from fsipetsc.physics.layer import FLUID

#: whether a ghost point has values already
OLD, NEW = np.bool_(False), np.bool_(True)


@njit(**OPTIONS)
def boundary_distance(layer, side):
    """Distance between interface and embedded boundary in cells, from the position of the frame (not by (4.25))."""
    return abs(layer.end_x[side] - layer.x_interface) / layer.h


@njit(**OPTIONS)
def ghost_of(head, layer, side):
    """(ghost point of an embedded boundary, step inwards, most points inside of it that a formula takes, has this rank all)."""
    G, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
    # one less than the halo, so that who owns the next point to come in knows the ghost point before it, too
    depth = min(NODES - 1, head.halo - 1, layer.hi - layer.lo)
    return G, step, depth, holds(layer, G) and holds(layer, G + step * depth)


@njit(**OPTIONS)
def fetch_nodes(head, layer, memory, area, side, first):
    """(rho, u, T) of the ghost point (0) and those inside of it from number ``first`` on, as ``fill_ghost`` takes them."""
    nodes, (G, step, depth, _) = rows_at(memory, head.nodes, 5, NODES), ghost_of(head, layer, side)
    for k in range(first, depth + 1):
        w = work_point(head, layer, area, G + step * k)
        rho = memory[U64(w)]
        u = memory[U64(w + layer.stride)] / rho
        nodes[0, k], nodes[1, k] = rho, u
        nodes[2, k] = (memory[U64(w + 2 * layer.stride)] / rho - 0.5 * u * u) / layer.cv
    return nodes


@njit(**OPTIONS)
def fill_embedded(head, layer, memory, area, side, new):
    """Give the ghost point of a fluid layer its values, where this rank has the points that this takes.

    new: the point has no values yet.
    """
    G, _, _, here = ghost_of(head, layer, side)
    if not here:
        return
    nodes = fetch_nodes(head, layer, memory, area, side, 1 if new else 0)
    fill_ghost(layer, head.op, side, layer.hi - layer.lo - boundary_distance(layer, side), nodes, new)
    w, rho, u, T = work_point(head, layer, area, G), nodes[0, 0], nodes[1, 0], nodes[2, 0]
    memory[U64(w)], memory[U64(w + layer.stride)] = rho, rho * u
    memory[U64(w + 2 * layer.stride)] = rho * (layer.cv * T + 0.5 * u * u)


@njit(**OPTIONS)
def note_gradients(head, layers, memory, area):
    """Note what the gradients take at the ghost points of a work area that fulfils the conditions already."""
    for layer in layers:
        for side in range(2):
            if layer.kind == FLUID and layer.end_kind[side] != INTERFACE_END and ghost_of(head, layer, side)[3]:
                nodes = fetch_nodes(head, layer, memory, area, side, 0)
                note_gradient(layer, side, layer.hi - layer.lo - boundary_distance(layer, side), nodes)


@njit(**OPTIONS)
def close_end(head, layer, memory, area, side):
    """Apply the condition at the outer end of a solid, where this rank has the rows that this takes."""
    point, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
    if not (holds(layer, point) and holds(layer, point + step * (head.rows - 1))):
        return
    trace = rows_at(memory, head.scratch, head.rows, 4)
    for j in range(head.rows):
        w = work_point(head, layer, area, point + step * j)
        for c in range(4):
            trace[j, c] = memory[U64(w + c * layer.stride)]
    close_solid(layer, head.op, side, trace)
    w = work_point(head, layer, area, point)
    for c in range(4):
        memory[U64(w + c * layer.stride)] = trace[0, c]


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
                if layer.kind == FLUID:
                    fill_embedded(head, layer, memory, area, side, OLD)
                else:
                    close_end(head, layer, memory, area, side)
    for k in range(faces.size):
        at = head.traces + k * head.rows * TRACE
        trace = rows_at(memory, at, head.rows, TRACE)
        couple(faces[k], head.op, trace[:, :3], trace[:, 3:])
        unpack(head, layers, faces[k], memory, area, at)
        layers[faces[k].fluid].s = trace[0, 1] / trace[0, 0]
