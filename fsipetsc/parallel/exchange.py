"""Messages: edges to the neighbours, traces of the interfaces to all. Compiled.

A rank sends the edges of its parts to its neighbours (one message per layer and side), and the traces of all
interfaces go round in one small reduction. The reduction is a maximum of 64-bit words over buffers that are zero
where a rank owns nothing: exact, bit for bit, and all ranks learn the traces and from them the frames' positions and
velocities. Ranks that share a node do both in one turn at their mailboxes (fsipetsc.parallel.shared_memory), without messages.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64, whole_vectors
from fsipetsc.operators.memory import load, store_interlaced
from fsipetsc.operators.vectors import LANES
from fsipetsc.parallel.mpi import mpi_startall, mpi_waitall
from fsipetsc.parallel.pointers import rows_of
from fsipetsc.parallel.shared_memory import largest, next_turn
from fsipetsc.physics.layer import ENDS, FLUID

#: what a point of the traces holds: fluid (rho, rho u, e), then solid (u, sigma, T, x), then the kinetic energy of its end
TRACE = 8
#: directions of ``move_edges``
SEND, RECEIVE = np.bool_(True), np.bool_(False)


@njit(**FORMULA)
def unknowns(layer):
    """Unknowns per point."""
    return 3 if layer.kind == FLUID else 4


@njit(**FORMULA)
def work_point(head, layer, area, i):
    """Where the first unknown of point i of a layer stands; the others follow ``layer.stride`` apart."""
    return head.area[area] + layer.work + i - layer.own_lo + layer.halo_lo


@njit(**FORMULA)
def holds(layer, i):
    """This rank has point i in its work areas."""
    return layer.present == 1 and layer.own_lo - layer.halo_lo <= i < layer.own_hi + layer.halo_hi


@njit(**FORMULA)
def side_of(face, part):
    """(layer at an interface, solid or fluid is on the right of it): part 0 fluid, 1 solid."""
    return (face.fluid if part == 0 else face.solid), (face.normal > 0.0) == (part == 0)


@njit(**FORMULA)
def kinetic_energy_of(layer, side):
    """Where the kinetic energy m0 u^2/2 of an end point of a solid stands, counted as a point: behind the first unknown's.

    It is what the conservative coupling integrates beside the unknowns, and is there for the owner of the end point.
    """
    return layer.own_hi + layer.halo_hi + side


@njit(**OPTIONS)
def load_state(head, layers, memory, area, at):
    """Copy a state, whose interlaced owned part begins at memory[at], into an area."""
    for layer in layers:
        if layer.ends >= 0:
            for side in range(ENDS):
                memory[U64(work_point(head, layer, area, kinetic_energy_of(layer, side)))] = memory[U64(at + layer.ends + side)]
        dof, own = unknowns(layer), work_point(head, layer, area, layer.own_lo)
        for c in range(dof):
            a, b, step = U64(at + layer.start + c), U64(own + c * layer.stride), U64(dof)
            for i in range(U64(layer.own_hi - layer.own_lo)):
                memory[b + i] = memory[a + step * i]


@njit(**OPTIONS)
def store_state(head, layer, memory, area, at, begin, end):
    """Copy the owned points begin .. end-1 of a layer in an area to the state whose owned part begins at memory[at]."""
    dof, w, step = unknowns(layer), work_point(head, layer, area, 0), layer.stride
    to, whole = at + layer.start - dof * layer.own_lo, whole_vectors(begin, end)
    for i in range(begin, whole, LANES):
        a, b, c = load(memory, w + i), load(memory, w + step + i), load(memory, w + 2 * step + i)
        if dof == 3:
            store_interlaced(memory, to + 3 * i, (a, b, c))
        else:
            store_interlaced(memory, to + 4 * i, (a, b, c, load(memory, w + 3 * step + i)))
    for i in range(whole, end):
        for c in range(dof):
            memory[U64(to + dof * i + c)] = memory[U64(w + c * step + i)]
    if layer.ends >= 0:
        for side in range(ENDS):
            memory[U64(at + layer.ends + side)] = memory[U64(w + kinetic_energy_of(layer, side))]


@njit(**OPTIONS)
def move_edges(head, layers, memory, area, turn, sending):
    """Owned edges of a work area to where the neighbours find them in this turn, or the neighbours' into its halos."""
    width = head.halo
    for layer in layers:
        if layer.present == 0:
            continue
        for side in range(2):
            if (layer.halo_lo if side == 0 else layer.halo_hi) == 0:
                continue
            if sending:
                i = layer.own_lo if side == 0 else layer.own_hi - width
            else:
                i = layer.own_lo - width if side == 0 else layer.own_hi
            place = (layer.outbox if sending else layer.inbox)[side] + (turn & 1) * head.world.buffer
            edge = rows_of(place, unknowns(layer), width)
            for c in range(unknowns(layer)):
                w = U64(work_point(head, layer, area, i) + c * layer.stride)
                for j in range(U64(width)):
                    if sending:
                        edge[c, j] = memory[w + j]
                    else:
                        memory[w + j] = edge[c, j]


@njit(**OPTIONS)
def exchange(head, layers, faces, memory, area):
    """Fill the halos of a work area and learn the traces of all interfaces. Collective on all ranks."""
    if head.world.size == 1:
        for k in range(faces.size):
            pack(head, layers, faces[k], memory, area, head.traces + k * head.rows * TRACE)
        return
    turn = next_turn(head.world)
    move_edges(head, layers, memory, area, turn, SEND)
    if head.requests > 0:
        mpi_startall(head.requests, head.request_list)
    for i in range(head.message):
        memory[U64(head.sent + i)] = 0.0
    for k in range(faces.size):
        pack(head, layers, faces[k], memory, area, head.sent + k * head.rows * TRACE)
    base = memory.ctypes.data
    largest(head.world, base + 8 * head.sent, base + 8 * head.traces, head.message)
    if head.requests > 0:
        mpi_waitall(head.requests, head.request_list, head.status_list)
    move_edges(head, layers, memory, area, turn, RECEIVE)


@njit(**OPTIONS)
def pack(head, layers, face, memory, area, at):
    """Write what this rank owns of the rows at an interface to memory[at:]."""
    for part in range(2):
        k, right = side_of(face, part)
        layer = layers[k]
        point, step = (layer.lo, 1) if right else (layer.hi, -1)
        if layer.present == 0 or point < layer.own_lo or point >= layer.own_hi:
            continue
        dof, column = (3, 0) if part == 0 else (4, 3)
        for j in range(head.rows):
            w, o = work_point(head, layer, area, point + step * j), at + TRACE * j + column
            for c in range(dof):
                memory[U64(o + c)] = memory[U64(w + c * layer.stride)]
        if layer.ends >= 0:
            w = work_point(head, layer, area, kinetic_energy_of(layer, 0 if right else 1))
            memory[U64(at + TRACE - 1)] = memory[U64(w)]


@njit(**OPTIONS)
def unpack(head, layers, face, memory, area, at):
    """Write the rows at an interface back into a work area, as far as this rank has them."""
    for part in range(2):
        k, right = side_of(face, part)
        layer = layers[k]
        if layer.present == 0:
            continue
        point, step = (layer.lo, 1) if right else (layer.hi, -1)
        dof, column = (3, 0) if part == 0 else (4, 3)
        for j in range(head.rows):
            if holds(layer, point + step * j):
                w, o = work_point(head, layer, area, point + step * j), at + TRACE * j + column
                for c in range(dof):
                    memory[U64(w + c * layer.stride)] = memory[U64(o + c)]
        if layer.ends >= 0:
            w = work_point(head, layer, area, kinetic_energy_of(layer, 0 if right else 1))
            memory[U64(w)] = memory[U64(at + TRACE - 1)]
