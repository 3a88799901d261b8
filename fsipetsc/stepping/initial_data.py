"""Initial data of a state of the paper's method, asked of the case's functions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsipetsc import given
from fsipetsc.problem import FluidLayer
from fsipetsc.process.together import agree, together

if TYPE_CHECKING:
    from fsipetsc.paper.state import PaperState


def set_data(state: PaperState) -> None:
    """Fill the solution, not projected, with initial data, and ask for all else at t = 0. Collective.

    InputError, on all ranks, where something is not what it must be.
    """
    edges = state.comm.allgather(together(state.comm, lambda: _set_layers(state)))
    ends = {point: x for found in edges for point, x in found.items()}
    given.check_ends(state.problem, ends, state.h)
    state.set_data(0.0)
    agree(state.comm, state.fault)


def _set_layers(state: PaperState) -> dict[tuple[int, int], float]:
    """Returns (solid layer, end) -> initial x of the end points [m] that this rank owns."""
    layout, y, edges = state.layout, state.solution.getArray(), {}
    for k, layer in enumerate(state.problem.layers):
        record = layout.records[k]
        if not record["present"]:
            continue
        X = layout.owned_X(k)
        fields = given.initial(layer, X, state.active(k))
        if layer.exact is not None:  # not found out at the end
            given.fields(layer, "exact", X, 0.0, state.active(k))
        if isinstance(layer, FluidLayer):
            rho, u, T = fields
            with np.errstate(all="ignore"):  # what comes of it is looked at
                e = rho * (layer.material.internal_energy(rho, T) + 0.5 * u * u)
                layout.local(k, y)[:] = np.stack([rho, rho * u, e], axis=-1)
        else:
            layout.local(k, y)[:] = np.stack(fields, axis=-1)
            edges |= {(k, 0): fields[3][0]} if record["own_lo"] == 0 else {}
            edges |= {(k, 1): fields[3][-1]} if record["own_hi"] == record["n"] else {}
    return edges
