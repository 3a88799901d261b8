"""A state of blocks taken apart for a checkpoint, and put together again, on any number of ranks.

Arrays hold whole blocks, (…, n_1, n_0, unknowns), so the solution does not depend on who had what.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.parallel.block_layout import BlockLayout
from fsipetsc.stepping.snapshot import as_numbers, gather_local

if TYPE_CHECKING:
    from fsipetsc.blockrun.block_state import BlockState

Array = np.ndarray


def capture(state: BlockState) -> dict[str, Array] | None:
    """The arrays, on rank 0. Collective."""
    arrays = whole_blocks(state.layout, gather_local(state.comm, state.y.array))
    if state.comm.rank > 0:
        return None
    arrays["results"], arrays["latest"] = state.results.copy(), as_numbers(state.latest).copy()
    return arrays


def whole_blocks(layout: BlockLayout, parts: list[Array] | None) -> dict[str, Array]:
    """Name -> nodes of a block, from the parts of all ranks, on rank 0.

    What stands behind the nodes is added up.
    """
    if parts is None:
        return {}
    shapes = [(*shape[::-1], dof) for shape, dof in zip(layout.shapes, layout.dofs, strict=True)]
    arrays = {f"layer{k}": np.empty(shape) for k, shape in enumerate(shapes)}
    behind = np.zeros(layout.behind)
    for rank, part in enumerate(parts):
        for k, place, at, shape in layout.pieces(rank):
            arrays[f"layer{k}"][place] = part[at : at + prod(shape)].reshape(shape)
        behind += part[part.size - layout.behind :]
    arrays["behind"] = behind
    return arrays


def put(layout: BlockLayout, y: Array, arrays: Mapping[str, Array]) -> None:
    """Fill this rank's part y of a vector from whole blocks."""
    for k, place, at, shape in layout.pieces(layout.comm.rank):
        y[at : at + prod(shape)] = arrays[f"layer{k}"][place].reshape(-1)
    y[y.size - layout.behind :] = arrays["behind"] if layout.comm.rank == 0 else 0.0


def check(state: BlockState, arrays: Mapping[str, Array]) -> None:
    """InputError if the arrays are those of other grids."""
    for k, (block, shape) in enumerate(zip(state.problem.layers, state.layout.shapes, strict=True)):
        there = arrays[f"layer{k}"].shape[-2::-1]
        if there != shape:
            now, then = (" by ".join(map(str, sizes)) for sizes in (shape, there))
            raise InputError(f"block '{block.name}' has {now} nodes, and {then} in the checkpoint")
