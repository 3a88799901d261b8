"""A state in two dimensions taken apart for a checkpoint, and put together again: see fsipetsc.stepping.snapshot.

Arrays hold whole layers, row by row, and the kinetic energies along whole interfaces.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.physics.plane.layer import DOF, GAINED
from fsipetsc.stepping.snapshot import RATES, as_numbers, gather_local

if TYPE_CHECKING:
    from fsipetsc.stepping.plane.state import PlaneState

Array = np.ndarray


def capture(state: PlaneState, rates: Array | None = None) -> dict[str, Array] | None:
    """The arrays, on rank 0. Collective. rates: this rank's part of the last rates, where the next step takes them."""
    arrays = whole_layers(state.layout, gather_local(state.comm, state.solution.getArray(readonly=True)), "")
    if rates is not None:
        arrays |= whole_layers(state.layout, gather_local(state.comm, rates), RATES)
    if state.comm.rank > 0:
        return None
    arrays["results"], arrays["latest"] = state.results.copy(), as_numbers(state.latest).copy()
    return arrays


def whole_layers(layout: PlaneLayout, parts: list[Array] | None, prefix: str) -> dict[str, Array]:
    """Name -> points of a layer, (ny, nx, DOF), and kinetic energies at an interface, (nx,), from all ranks, on rank 0; of
    rates those of what each layer gains, too.
    """
    if parts is None:
        return {}
    arrays = {f"{prefix}layer{k}": np.empty((grid.ny, grid.nx, DOF)) for k, grid in enumerate(layout.grids)}
    for number, meeting in enumerate(layout.meetings):
        arrays[f"{prefix}energies{number}"] = np.empty(layout.grids[meeting.layers[1]].nx)
    for rank, part in enumerate(parts):
        for name, place, at, shape in layout.places(rank):
            size = int(np.prod(shape))
            arrays[prefix + name][place] = part[at : at + size].reshape(shape)
    if prefix:  # of a solution that is complete they are 0
        arrays |= {f"{prefix}gains{k}": np.zeros(GAINED) for k in range(len(layout.grids))}
        for rank, part in enumerate(parts):
            for k, at in layout.gains_at(rank):
                arrays[f"{prefix}gains{k}"] += part[at : at + GAINED]
    return arrays


def put(layout: PlaneLayout, y: Array, arrays: Mapping[str, Array], prefix: str = "") -> None:
    """Fill this rank's part y of a vector from whole layers."""
    for name, place, at, shape in layout.places(layout.comm.rank):
        size = int(np.prod(shape))
        y[at : at + size] = arrays[prefix + name][place].reshape(-1)
    for k, at in layout.gains_at(layout.comm.rank):  # one rank has those of all
        first = layout.comm.rank == min(layout.shares[k].ranks)
        y[at : at + GAINED] = arrays[f"{prefix}gains{k}"] if prefix and first else 0.0


def check(state: PlaneState, arrays: Mapping[str, Array]) -> None:
    """InputError if the arrays are those of other grids."""
    for layer, (k, grid) in zip(state.problem.layers, enumerate(state.layout.grids), strict=True):
        ny, nx = arrays[f"layer{k}"].shape[:2]
        if (ny, nx) != (grid.ny, grid.nx):
            raise InputError(f"layer '{layer.name}' has {grid.nx} by {grid.ny} points, and {nx} by {ny} in the checkpoint")
