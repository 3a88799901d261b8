"""What a right-hand side takes of one layer and of one interface on its own: for stepping.petsc_path. Compiled.

None of these sends anything. They work on the first work area, where each unknown of a layer stands for itself with its halos.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.operators.formulas import with_chosen
from fsipetsc.operators.kernels import ENTRY, U64
from fsipetsc.parallel.exchange import unknowns
from fsipetsc.scheme.conditions import move_points, place_points
from fsipetsc.scheme.laws import LAWS, PAIRS, of_interface, of_layer
from fsipetsc.scheme.layer_ends import OLD
from fsipetsc.scheme.plan import SUM, WORK
from fsipetsc.scheme.runge_kutta import Stage, evaluate


@njit(**ENTRY)
def place_grids(heads, layers, faces, memory):
    """The ends of the gases that this rank has a part of have been placed: so are their points."""
    place_points(layers, faces)


@njit(**ENTRY)
def move_grids(heads, layers, faces, memory):
    """How fast these ends are is known: so is how fast the points are."""
    move_points(layers)


@njit(**ENTRY)
def couple_rows(heads, layers, faces, memory, k, trace_f, trace_s):
    """Project the rows at interface k, (rows, 3) of the fluid and (rows, 5) of the solid, counted from the interface."""
    with_chosen(of_interface.couple, PAIRS, faces[k].pair, faces[k], heads[0].op, trace_f, trace_s)


@njit(**ENTRY)
def apply_ends(heads, layers, faces, memory, k):
    """Fill the ghost point of layer k, or the end point of a solid, where this rank has the points that this takes."""
    head, layer = heads[0], layers[k]
    for side in range(2):
        if layer.end_kind[side] != INTERFACE_END:
            with_chosen(of_layer.end, LAWS, layer.law, head, layer, memory, WORK, side, OLD)


@njit(**ENTRY)
def evaluate_rates(heads, layers, faces, memory, k):
    """Rates of the owned points of layer k, 0 where they are not active, to the area SUM."""
    head, layer = heads[0], layers[k]
    at = U64(head.area[SUM] + layer.work)
    for i in range(U64(unknowns(layer) * layer.stride)):
        memory[at + i] = 0.0
    evaluate(head, layer, memory, Stage(WORK, SUM, SUM, -1, 1.0, 0.0), layer.own_lo, layer.own_hi)
