"""A state taken apart for a checkpoint, and put together again: in one dimension.

What a step depends on: the solution, the points that are active, how the grids lie and move, and the results of the last step,
among them the bound on the next one. All else follows from the case and from the time. Arrays hold whole layers, point by
point from left to right, so that any number of ranks can go on from them. On as many ranks as before each owns what it did: so
the sums over ranks are the same, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from mpi4py import MPI

from fsipetsc.errors import InputError
from fsipetsc.problem import Problem

if TYPE_CHECKING:
    from fsipetsc.paper.layout import Grid, Layout
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
    arrays["shares"] = np.array([(k, *share) for k, shares in enumerate(layout.shares) for share in shares])
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
    comm.Gatherv([np.ascontiguousarray(local), MPI.DOUBLE], [whole, counts, MPI.DOUBLE] if comm.rank == 0 else None)
    return np.split(whole, np.cumsum(counts)[:-1]) if comm.rank == 0 else None


def as_numbers(record: np.void) -> Array:
    """View of a record of doubles as these."""
    return record.reshape(1).view(np.float64)


def grids_of(problem: Problem, grids: Sequence[Grid], arrays: Mapping[str, Array]) -> list[Grid]:
    """The grids as they were; grids: those that a run begins with. InputError if those were others."""
    found = []
    for k, (grid, (n, lo, hi)) in enumerate(zip(grids, arrays["grids"].tolist(), strict=True)):
        rigid, first = problem.layers[k].kind == "fluid", k == 0
        fits = 0 <= lo < hi < n and n >= grid.n and (hi == n - 1 if first else lo == 0)
        if not (fits if rigid else (n, lo, hi) == (grid.n, grid.lo, grid.hi)):
            raise InputError(f"layer '{problem.layers[k].name}' has {grid.n} points, and {n} in the checkpoint")
        found.append(replace(grid, n=n, lo=lo, hi=hi, anchor_index=n - 1 if rigid and first else grid.anchor_index))
    return found


def shares_of(arrays: Mapping[str, Array], size: int) -> list[list[tuple[int, int, int]]] | None:
    """Who owned what; None if that is not wanted, or there were another number of ranks."""
    shares = arrays.get("shares")
    if shares is None or shares[:, 1].max() != size - 1:
        return None
    layers = range(int(shares[:, 0].max()) + 1)
    return [[(rank, begin, end) for at, rank, begin, end in shares.tolist() if at == k] for k in layers]


def put(layout: Layout, y: Array, arrays: Mapping[str, Array]) -> None:
    """Fill this rank's part y of a vector from whole layers."""
    for k, record in enumerate(layout.records):
        if record["present"]:
            layout.local(k, y)[:] = arrays[f"layer{k}"][record["own_lo"] : record["own_hi"]]


def put_frames(layout: Layout, arrays: Mapping[str, Array]) -> None:
    """Let the grids lie and move as they did."""
    for name in FRAME:
        layout.records[name] = arrays[name]


def gather(comm: MPI.Comm, layout: Layout, k: int, y: np.ndarray) -> np.ndarray:
    """Layer k of the solution, shape (n, dof), on every rank. Collective."""
    record = layout.records[k]
    dof = layout.dof[k]
    counts = np.zeros(comm.size, np.int64)
    for rank, begin, end in layout.shares[k]:
        counts[rank] = dof * (end - begin)
    whole = np.empty((int(record["n"]), dof))
    offsets = np.zeros(comm.size, np.int64)
    for rank, begin, _ in layout.shares[k]:
        offsets[rank] = dof * begin
    part = np.ascontiguousarray(layout.local(k, y)) if record["present"] else np.empty(0)
    comm.Allgatherv([part, MPI.DOUBLE], [whole, counts, offsets, MPI.DOUBLE])
    return whole
