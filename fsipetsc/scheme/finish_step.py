"""What follows a time step: the new solution is projected in place, the embedded boundaries move over the grid,
and the bounds on the next step and the integrals are taken. Compiled; collective on all ranks.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.coupling import scale
from fsipetsc.operators.formulas import with_chosen
from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.parallel.exchange import TRACE, store_state, work_point
from fsipetsc.parallel.pointers import rows_at
from fsipetsc.scheme.extremes_and_sums import SIZE, begin_extremes_and_sums
from fsipetsc.scheme.integrals import integrals
from fsipetsc.scheme.laws import LAWS, PAIRS, of_interface, of_layer
from fsipetsc.scheme.layer_ends import NEW, OLD, boundary_distance, embedded
from fsipetsc.scheme.plan import EXHAUSTED, LOW, MOVED, TOO_SHORT, WORK
from fsipetsc.scheme.time_step import bound_step


@njit(**OPTIONS)
def move_boundary(head, layer, memory, side):
    """Let the embedded boundary at one end of a fluid layer move over the grid; True if it changed its cell.

    The ghost point is the first grid point at or beyond the boundary. A grid point that comes in is extrapolated
    and becomes the ghost point, the old one keeps its value; where the boundary moves inwards the last interior
    point becomes the ghost. Returns (moved, the grid has no point left).
    """
    distance = boundary_distance(layer, side)
    if not distance < 1e15:
        return False, False  # not a number: the limits will report it
    target = int(np.ceil(distance - 1e-9))
    moved = False
    while layer.hi - layer.lo < target:
        if (side == 0 and layer.lo == 0) or (side == 1 and layer.hi == layer.n - 1):
            return moved, True
        if side == 0:
            layer.lo -= 1
        else:
            layer.hi += 1
        with_chosen(of_layer.end, LAWS, layer.law, head, layer, memory, WORK, side, NEW)
        moved = True
    if layer.hi - layer.lo > target >= layer.least - 1:
        if side == 0:
            layer.lo = layer.hi - target
        else:
            layer.hi = layer.lo + target
        with_chosen(of_layer.end, LAWS, layer.law, head, layer, memory, WORK, side, OLD)
        moved = True
    return moved, False


@njit(**OPTIONS)
def finish_step(head, layers, faces, memory):
    """Finish a step whose result fulfils the conditions, in work area 0: boundaries move, limits and integrals are taken.

    What lies within ``layer.middle`` has been looked at before (``look``).

    Fills the results in the memory: flags (MOVED, LOW, EXHAUSTED, TOO_SHORT), limits (RATE, BAD, STOP over all ranks),
    states (see ``interface_state``), masses and integrals (this rank's shares, see ``integrals``).
    """
    for i in range(4):
        memory[U64(head.results + i)] = 0.0
    for k in range(layers.size):
        layer = layers[k]
        for side in range(2):
            if embedded(layer, side):
                moved, exhausted = move_boundary(head, layer, memory, side)
                if moved:
                    memory[U64(head.results + MOVED)] = 1.0
                if exhausted:
                    memory[U64(head.results + EXHAUSTED)] = 1.0 + k
                if (side == 0 and layer.lo == 0) or (side == 1 and layer.hi == layer.n - 1):
                    memory[U64(head.results + LOW)] = 1.0 + k
                if boundary_distance(layer, side) <= layer.least - 2 + 1e-9:
                    memory[U64(head.results + TOO_SHORT)] = 1.0 + k
    for k in range(layers.size):
        layer = layers[k]
        a, b = layer.middle
        if a < b:
            look(head, layer, k, memory, layer.own_lo, a)
            look(head, layer, k, memory, b, layer.own_hi)
        else:
            look(head, layer, k, memory, layer.own_lo, layer.own_hi)
    bound_step(head, layers, memory)
    interface_state(head, faces, memory)
    integrals(head, layers, memory)


@njit(**OPTIONS)
def begin_looking(head, layers, memory):
    """Nothing has been seen of the new solution yet."""
    for k in range(layers.size):
        begin_extremes_and_sums(layers[k], memory, head.extremes + SIZE * k)


@njit(**OPTIONS)
def look(head, layer, k, memory, begin, end):
    """Look at the points begin .. end-1 of layer k, which are what they will stay, and give them to PETSc."""
    if layer.present == 0:
        return
    w, at = work_point(head, layer, WORK, 0), head.extremes + SIZE * k
    with_chosen(of_layer.look, LAWS, layer.law, layer, memory, w, at, begin, end)
    store_state(head, layer, memory, WORK, head.solution, begin, end)


@njit(**OPTIONS)
def interface_state(head, faces, memory):
    """Rows of x, u, sigma, T and the residuals of the four conditions at the interfaces; all ranks know them."""
    states = rows_at(memory, head.states, 8, faces.size)
    for k in range(faces.size):
        trace = rows_at(memory, head.traces + k * head.rows * TRACE, head.rows, TRACE)
        states[0, k], states[1, k], states[2, k], states[3, k] = trace[0, 6], trace[0, 3], trace[0, 4], trace[0, 5]
        if faces[k].J != 1.0:
            scale(trace[:, :3], 1.0 / faces[k].J)
        into = states[4:, k]
        with_chosen(of_interface.residuals, PAIRS, faces[k].pair, faces[k], head.op, trace[:, :3], trace[:, 3:], into)
