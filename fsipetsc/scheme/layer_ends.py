"""The outer end of a layer in a work area: its condition is applied to the points there. Compiled.

The formulas are those of fsipetsc.boundaries; here they are given the values of the points that this rank has.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.boundaries import CLAMPED, INTERFACE_END, NODES, WALL, close_solid, fill_ghost, note_gradient
from fsipetsc.operators.kernels import ARRAYS, OPTIONS, U64
from fsipetsc.parallel.exchange import holds, work_point
from fsipetsc.parallel.pointers import rows_at
from fsipetsc.physics.layer import FLUID, GIVEN_T

#: whether a ghost point has values already
OLD, NEW = np.bool_(False), np.bool_(True)


@njit(**OPTIONS)
def embedded(layer, side):
    """An embedded boundary, with a ghost point, is at this end of the layer."""
    return layer.kind == FLUID and layer.stretched == 0 and layer.end_kind[side] != INTERFACE_END


@njit(**OPTIONS)
def boundary_distance(layer, side):
    """Distance between interface and embedded boundary in cells, from the position of the frame (not by (4.25))."""
    return abs(layer.end_x[side] - layer.x_interface) / layer.h


@njit(**OPTIONS)
def beyond_the_end(layer, side):
    """How far the ghost point lies beyond the embedded boundary in cells; 0 of a stretched layer, whose end point it is."""
    return 0.0 if layer.stretched != 0 else layer.hi - layer.lo - boundary_distance(layer, side)


@njit(**OPTIONS)
def ghost_of(head, layer, side):
    """(ghost point of an embedded boundary, step inwards, most points inside of it that a formula takes, has this rank all)."""
    G, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
    # one less than the halo, so that who owns the next point to come in knows the ghost point before it, too
    depth = min(NODES - 1, head.halo - 1, layer.hi - layer.lo)
    return G, step, depth, holds(layer, G) and holds(layer, G + step * depth)


@njit(**ARRAYS)
def fetch_nodes(law, head, layer, memory, area, side, first):
    """(rho, u, T) of the ghost point (0) and those inside of it from number ``first`` on, as ``fill_ghost`` takes them."""
    nodes, (G, step, depth, _) = rows_at(memory, head.nodes, 5, NODES), ghost_of(head, layer, side)
    constants = law.gas.constants(layer)
    for k in range(first, depth + 1):
        w = work_point(head, layer, area, G + step * k)
        mass = memory[U64(w)]
        u, rho = memory[U64(w + layer.stride)] / mass, mass / layer.J
        nodes[0, k], nodes[1, k] = rho, u
        nodes[2, k] = law.gas.temperature(constants, rho, memory[U64(w + 2 * layer.stride)] / mass - 0.5 * u * u)
    return nodes


@njit(**OPTIONS)
def close_gas(law, head, layer, memory, area, side, new):
    """Apply the condition at the outer end of a fluid layer; new: its ghost point has no values yet."""
    if layer.stretched != 0 and layer.end_kind[side] == WALL:
        stop_at_wall(law, head, layer, memory, area, side)
    else:
        fill_embedded(law, head, layer, memory, area, side, new)


@njit(**OPTIONS)
def stop_at_wall(law, head, layer, memory, area, side):
    """The end point of a stretched layer has the velocity of its wall, and perhaps its T; see fsipetsc.scheme.end_rates."""
    point = layer.lo if side == 0 else layer.hi
    if not holds(layer, point):
        return
    w, u = work_point(head, layer, area, point), layer.end_v[side]
    mass = memory[U64(w)]
    layer.end_impulse[side] = layer.h * head.op.norm[0] * (mass * u - memory[U64(w + layer.stride)])
    memory[U64(w + layer.stride)] = mass * u
    if layer.end_thermal[side] == GIVEN_T and layer.kappa > 0.0:
        internal = law.gas.energy(law.gas.constants(layer), mass / layer.J, layer.end_heat[side])
        memory[U64(w + 2 * layer.stride)] = mass * (internal + 0.5 * u * u)


@njit(**OPTIONS)
def fill_embedded(law, head, layer, memory, area, side, new):
    """Give the ghost point of a fluid layer its values, where this rank has the points that this takes.

    So, too, the end point of a stretched one where gas may go through. new: the point has no values yet.
    """
    G, _, _, here = ghost_of(head, layer, side)
    if not here:
        return
    nodes = fetch_nodes(law, head, layer, memory, area, side, 1 if new else 0)
    fill_ghost(law, layer, head.op, side, beyond_the_end(layer, side), nodes, new)
    w, rho, u, T = work_point(head, layer, area, G), nodes[0, 0], nodes[1, 0], nodes[2, 0]
    mass = layer.J * rho
    memory[U64(w)], memory[U64(w + layer.stride)] = mass, mass * u
    memory[U64(w + 2 * layer.stride)] = mass * (law.gas.energy(law.gas.constants(layer), rho, T) + 0.5 * u * u)


@njit(**OPTIONS)
def note_embedded(law, head, layer, memory, area, side):
    """Note what the gradients take at the ghost point of a fluid layer, where this rank has the points that this takes."""
    if layer.end_apart[side] != 0 and ghost_of(head, layer, side)[3]:
        nodes = fetch_nodes(law, head, layer, memory, area, side, 0)
        note_gradient(law, layer, side, beyond_the_end(layer, side), nodes)


@njit(**OPTIONS)
def close_end(law, head, layer, memory, area, side, new):
    """Apply the condition at the outer end of a solid, where this rank has the rows that this takes."""
    point, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
    if not (holds(layer, point) and holds(layer, point + step * (head.rows - 1))):
        return
    if layer.unloaded[side] != 0:  # what loads it is in the rates
        w = work_point(head, layer, area, point)
        if layer.end_kind[side] == CLAMPED:
            change = layer.end_data[side, 0] - memory[U64(w)]
            layer.end_impulse[side] = layer.h * head.op.norm[0] * layer.m0 * change
            memory[U64(w)] = layer.end_data[side, 0]
        if layer.end_thermal[side] == GIVEN_T and layer.kappa_e > 0.0:
            memory[U64(w + 2 * layer.stride)] = layer.end_heat[side]
        return
    trace = rows_at(memory, head.scratch, head.rows, 4)
    for j in range(head.rows):
        w = work_point(head, layer, area, point + step * j)
        for c in range(4):
            trace[j, c] = memory[U64(w + c * layer.stride)]
    close_solid(law, layer, head.op, side, trace)
    w = work_point(head, layer, area, point)
    for c in range(4):
        memory[U64(w + c * layer.stride)] = trace[0, c]


@njit(**OPTIONS)
def note_nothing(law, head, layer, memory, area, side):
    """The gradients at the end of a solid take its values."""
