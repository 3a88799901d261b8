"""A state taken apart for a checkpoint, and put together again: in one dimension.

What a step depends on: the solution, the points that are active, how the grids lie and move, and
the results of the last step, among them the bound on the next one. All else follows from the case
and from the time. Arrays hold whole layers, point by point from left to right, so that any number
of ranks can go on from them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from mpi4py import MPI

from fsipetsc.errors import InputError

if TYPE_CHECKING:
    from fsipetsc.paper.layout import Layout
    from fsipetsc.paper.state import PaperState as State

Array = np.ndarray
#: of the record of a layer: how its grid lies and moves
FRAME = "s", "x_interface"
#: of its grid
GRID = "n", "lo", "hi"


def capture(state: State) -> dict[str, Array] | None:
    """The arrays, on rank 0. Collective."""
    layout = state.layout
    arrays = whole_layers(layout, gather_local(state.comm, state.solution.getArray(readonly=True)))
    if state.comm.rank > 0:
        return None
    arrays["grids"] = np.array([[int(record[name]) for name in GRID] for record in layout.records])
    for name in FRAME:
        arrays[name] = layout.records[name].copy()
    arrays["results"], arrays["latest"] = state.results.copy(), as_numbers(state.latest).copy()
    return arrays


def whole_layers(layout: Layout, parts: list[Array] | None) -> dict[str, Array]:
    """Name -> points of a layer, (n, unknowns), from the parts of all ranks, on rank 0."""
    arrays: dict[str, Array] = {}
    if parts is None:
        return arrays
    at = [0] * len(parts)
    for k, (record, shares) in enumerate(zip(layout.records, layout.shares, strict=True)):
        dof, n = layout.dof[k], int(record["n"])
        points = arrays[f"layer{k}"] = np.empty((n, dof))
        for rank, begin, end in shares:
            part = parts[rank][at[rank] :]
            size = dof * (end - begin)
            points[begin:end] = part[:size].reshape(-1, dof)
            at[rank] += size
    return arrays


def gather_local(comm: MPI.Comm, local: Array) -> list[Array] | None:
    """Each rank's doubles, on rank 0. Collective."""
    counts = comm.gather(local.size)
    whole = np.empty(sum(counts)) if comm.rank == 0 else None
    comm.Gatherv(
        [np.ascontiguousarray(local), MPI.DOUBLE],
        [whole, counts, MPI.DOUBLE] if comm.rank == 0 else None,
    )
    return np.split(whole, np.cumsum(counts)[:-1]) if comm.rank == 0 else None


def as_numbers(record: np.void) -> Array:
    """View of a record of doubles as these."""
    return record.reshape(1).view(np.float64)


def put_grids(layout: Layout, arrays: Mapping[str, Array]) -> None:
    """Let the grids lie and move as they did. InputError if they had another number of points."""
    layers = layout.problem.layers, layout.records, arrays["grids"].tolist()
    for layer, record, (n, lo, hi) in zip(*layers, strict=True):
        if n != record["n"] or not 0 <= lo < hi < n:
            raise InputError(
                f"layer '{layer.name}' has {record['n']} points, and {n} in the checkpoint"
            )
        record["lo"], record["hi"] = lo, hi
    for name in FRAME:
        layout.records[name] = arrays[name]


def put(layout: Layout, y: Array, arrays: Mapping[str, Array]) -> None:
    """Fill this rank's part y of a vector from whole layers."""
    for k, record in enumerate(layout.records):
        if record["present"]:
            layout.local(k, y)[:] = arrays[f"layer{k}"][record["own_lo"] : record["own_hi"]]
