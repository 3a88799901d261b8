"""What several ranks do after a step: boundaries move, each rank looks at its points, and all learn
of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mpi4py import MPI

from fsipetsc.paper import entries
from fsipetsc.scheme.plan import RATE

if TYPE_CHECKING:
    from fsipetsc.paper.state import PaperState


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
    entries.tell(state.shared)
    state.comm.Allreduce(MPI.IN_PLACE, state.told, MPI.MAX)
    entries.hear(state.shared)
    good = True
    for k, (box, layer) in enumerate(zip(state.boxes, state.problem.layers, strict=True)):
        gas = layer.kind == "fluid"
        speeds = entries.gas_rates_of_step if gas else entries.solid_rates_of_step
        good &= speeds(box, state.layout.grids[k].h, state.first + k)
    entries.finish_step(state.boxes[0], good)
