"""Initial data of a state in one dimension: asked of the case's functions, or of a frame, and turned into unknowns."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsipetsc import given
from fsipetsc.boundaries import WALL
from fsipetsc.problem import FluidLayer
from fsipetsc.process.together import agree, together

if TYPE_CHECKING:
    from fsipetsc.parallel.layout import Layout
    from fsipetsc.stepping.state import State


def set_data(state: State) -> None:
    """Fill the solution, not projected, with initial data, and ask for all else at the time ``state.begin``. Collective.

    InputError, on all ranks, where something is not what it must be.
    """
    edges = state.comm.allgather(together(state.comm, lambda: _set_layers(state)))
    for k, side in state.moving:
        state.layout.records[k]["end_x"][side] = state.motion(side, state.begin)[0]
    ends = {point: x for found in edges for point, x in found.items()} | _outer_ends(state.layout)
    if not state.started:  # a frame lies where the run that it is of has come to
        given.check_ends(state.problem, ends, state.h, state.mapping)
    _stretch(state, ends)
    state.set_data(state.begin)
    agree(state.comm, state.fault)


def _set_layers(state: State) -> dict[tuple[int, int], float]:
    """Returns (solid layer, end) -> initial x of the end points [m] that this rank owns."""
    layout, y, edges = state.layout, state.solution.getArray(), {}
    for k, layer in enumerate(state.problem.layers):
        record = layout.records[k]
        if not record["present"]:
            continue
        X = layout.owned_X(k)
        fields = given.initial(layer, X, state.active(k))
        if layer.exact is not None:  # not found out at the end
            given.fields(layer, "exact", X, state.begin, state.active(k))
        if isinstance(layer, FluidLayer):
            _stop_at_walls(state, k, fields)
            with np.errstate(all="ignore"):  # what comes of it is looked at
                layout.local(k, y)[:] = layer.material.conserved(*fields)
        else:
            layout.local(k, y)[:] = np.stack(fields, axis=-1)
            note_kinetic_energies(layout, k, y)
            edges |= {(k, 0): fields[3][0]} if record["own_lo"] == 0 else {}
            edges |= {(k, 1): fields[3][-1]} if record["own_hi"] == record["n"] else {}
    return edges


def _stop_at_walls(state: State, k: int, fields: list[np.ndarray]) -> None:
    """The initial u of a gas; where its grid ends at a wall, the wall's: so the energy there is that of T. InputError."""
    record, (rho, u, T) = state.layout.records[k], fields
    fields[1] = u = u.copy()
    for side, here in ((0, record["own_lo"] == 0), (1, record["own_hi"] == record["n"])):
        if here and record["stretched"] and record["end_kind"][side] == WALL:
            u[-side] = 0.0
            if (k, side) in state.moving:
                with np.errstate(all="ignore"):
                    sound = float(state.problem.layers[k].material.sound_speed(T[-side], rho[-side]))
                given.check_motion(state.problem, side, state.begin, state.h / sound if sound > 0 else state.h)
                u[-side] = state.motion(side, state.begin)[1]


def _outer_ends(layout: Layout) -> dict[tuple[int, int], float]:
    """As of given.check_ends, the places of the outer ends of gases, as if solids stood there."""
    records = layout.records
    places = {(-1, 1): records[0]["end_x"][0], (len(records), 0): records[-1]["end_x"][1]}
    return {point: float(x) for point, x in places.items()}


def note_kinetic_energies(layout: Layout, k: int, y: np.ndarray) -> None:
    """m0 u^2/2 of the end points of solid layer k, which the conservative coupling integrates, from their velocities."""
    ends, part = layout.ends(k, y), layout.local(k, y)
    if len(ends):
        u = part[[0, -1], 0]
        ends[:] = 0.5 * layout.records[k]["m0"] * u * u


def _stretch(state: State, ends: dict[tuple[int, int], float]) -> None:
    """Let the unknowns of stretched layers be J (rho, rho u, e); ends: as of given.check_ends."""
    y = state.solution.getArray()
    for k, record in enumerate(state.layout.records):
        if record["stretched"] and record["present"]:
            first, last = record["end_x"] = ends[k - 1, 1], ends[k + 1, 0]
            state.layout.local(k, y)[:] *= (last - first) / ((record["n"] - 1) * record["h"])
