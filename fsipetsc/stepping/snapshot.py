"""A solution taken apart for a checkpoint, and put together again: whole layers or blocks, so that
any number of ranks can go on from them.

A piece is what a rank has of one: number, place in it, where it begins among the doubles of the
rank, shape.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import prod
from typing import Any

import numpy as np
from mpi4py import MPI

Array = np.ndarray
Pieces = Iterable[tuple[int, Any, int, tuple[int, ...]]]


def gather_local(comm: MPI.Comm, local: Array) -> list[Array] | None:
    """Each rank's doubles, on rank 0. Collective."""
    counts = comm.gather(local.size)
    whole = np.empty(sum(counts)) if comm.rank == 0 else None
    comm.Gatherv(
        [np.ascontiguousarray(local), MPI.DOUBLE],
        [whole, counts, MPI.DOUBLE] if comm.rank == 0 else None,
    )
    return np.split(whole, np.cumsum(counts)[:-1]) if comm.rank == 0 else None


def whole(
    parts: Sequence[Array], shapes: Iterable[tuple[int, ...]], pieces: Callable[[int], Pieces]
) -> dict[str, Array]:
    """ "layer0", "layer1" … of these shapes, from the doubles of all ranks."""
    arrays = {f"layer{k}": np.empty(shape) for k, shape in enumerate(shapes)}
    for rank, part in enumerate(parts):
        for k, place, at, shape in pieces(rank):
            arrays[f"layer{k}"][place] = part[at : at + prod(shape)].reshape(shape)
    return arrays


def put_whole(local: Array, arrays: Mapping[str, Array], pieces: Pieces) -> None:
    """Fill a rank's doubles from whole layers."""
    for k, place, at, shape in pieces:
        local[at : at + prod(shape)] = arrays[f"layer{k}"][place].reshape(-1)


def as_numbers(record: np.void) -> Array:
    """View of a record of doubles as these."""
    return record.reshape(1).view(np.float64)
