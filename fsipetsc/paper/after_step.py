"""What several ranks do after a step: boundaries move, each rank looks at its points, and all learn
of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from mpi4py import MPI

from fsipetsc.paper import entries, sums
from fsipetsc.paper.layer import FLUID
from fsipetsc.scheme.plan import RATE, SAID_STOP, STOP

if TYPE_CHECKING:
    from fsipetsc.paper.state import PaperState

Array = np.ndarray
#: numbers of a layer that all ranks learn after a step, beside those that are seen
FRAME = "lo", "hi", "s", "x_interface"
#: kind -> 1 for numbers of which the largest counts, -1 for the least
SIGNS = {True: np.array([1, -1, -1, 1, 1]), False: np.array([-1, -1, -1, 1, 1])}


def complete(state: PaperState) -> None:
    """Project the stage, which is the new solution, let boundaries move, and look at it.
    Collective."""
    path = state.path
    path.fulfil_conditions()
    state.results[:RATE] = 0.0
    for part in path.layers:
        if part.is_gas:
            entries.look_at_gas(part.box, part.side, part.number, state.entropy)
        else:
            entries.look_at_solid(part.box, state.entropy)
    path.keep_ghosts()
    path.y[:] = path.stage
    for interface in path.interfaces:
        if interface.here[1]:
            entries.note_interface(interface.box, interface.side)
    state.results[STOP] = state.results[SAID_STOP]
    _tell(state)
    good = True
    for k, (box, record) in enumerate(zip(state.boxes, state.layout.records, strict=True)):
        gas = record["kind"] == FLUID
        speeds = entries.gas_rates_of_step if gas else entries.solid_rates_of_step
        good &= speeds(box, float(record["h"]), state.first + k)
    entries.finish_step(state.boxes[0], good)


def _tell(state: PaperState) -> None:
    """Let all ranks know what each has seen, exactly: the largest of each number."""
    room, records, interfaces = state.rooms[0], state.layout.records, state.path.interfaces
    seen = np.full((len(records), sums.SEEN + len(FRAME)), -np.inf)
    notes = np.full((len(interfaces), 8), -np.inf)
    for k, record in enumerate(records):
        if record["present"]:
            signs = SIGNS[bool(record["kind"] == FLUID)]
            seen[k, : sums.SEEN] = room["seen"][state.first + k] * signs
            seen[k, sums.SEEN :] = [record[name] for name in FRAME]
    for k, interface in enumerate(interfaces):
        if interface.here[1]:
            notes[k] = room["notes"][interface.side]
    flags = np.append(state.results[:RATE], state.results[STOP])
    _largest(state.comm, seen, notes, flags)
    for k, record in enumerate(records):
        signs = SIGNS[bool(record["kind"] == FLUID)]
        room["seen"][state.first + k] = seen[k, : sums.SEEN] * signs
        for name, value in zip(FRAME, seen[k, sums.SEEN :], strict=True):
            record[name] = value
        if not record["present"]:
            room["shares"][state.first + k] = 0.0
    for k, interface in enumerate(interfaces):
        room["notes"][interface.side] = notes[k]
    state.results[:RATE], state.results[STOP] = flags[:RATE], flags[RATE]


def _largest(comm: MPI.Comm, *arrays: Array) -> None:
    """Let each array have the largest numbers of all ranks, in one reduction."""
    told = np.concatenate([array.ravel() for array in arrays])
    # the largest of numbers and what is none would depend on their order
    told[np.isnan(told)] = np.inf
    comm.Allreduce(MPI.IN_PLACE, told, MPI.MAX)
    ends = np.cumsum([array.size for array in arrays])[:-1]
    for array, found in zip(arrays, np.split(told, ends), strict=True):
        array[...] = found.reshape(array.shape)
