"""Blocks that begin with a frame of an earlier result, on whatever number of cells: -fsi_initial.

Blocks are matched by their order, and interpolated along their own axes, so maps must be the same.
Displacements of solids are interpolated, and J of a gas follows from the grid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.blockrun.columns import compared
from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.blocks.values import AtNodes
from fsipetsc.errors import InputError
from fsipetsc.stepping.splines import interpolated

if TYPE_CHECKING:
    from fsipetsc.blocks.block import Block
    from fsipetsc.output.reader import BlockLayer

Array = np.ndarray
#: part of a block's size within which corners are at one place
_ALIKE = 1e-6


@dataclass(frozen=True)
class BlockFrame:
    """A block in a frame. places: (…, n_1, n_0, d) in the reference map; values: (…, fields)."""

    name: str
    kind: str
    periodic: tuple[bool, ...]
    places: Array
    values: Array


def block_frame(layer: BlockLayer, frame: int, place: str) -> BlockFrame:
    """What a result has of a block. InputError where that is no state; place: of the frame."""
    d, found = len(layer.shape), layer.frame(frame)
    names = compared(layer.kind, d)
    for name in names:
        good = np.isfinite(found[name]) & ((found[name] > 0) | (name not in ("rho", "T")))
        if not good.all():
            worst = f"{name} of block '{layer.name}' is {found[name][~good][0]:g}"
            raise InputError(f"-fsi_initial: {place}: {worst}; take an earlier one")
    values = np.stack([found[name] for name in names], axis=-1)
    if layer.kind == "solid":
        values[..., -d:] -= layer.places
    return BlockFrame(layer.name, layer.kind, layer.periodic, layer.places, values)


def begun_with(
    problem: RunProblem,
    frames: Sequence[BlockFrame],
    order: int,
    place: str,
    notes: tuple[str, ...] = (),
) -> RunProblem:
    """The problem with these initial data and notes. InputError where the blocks are others."""
    kinds, there = ([f"{b.name} ({b.kind})" for b in some] for some in (problem.layers, frames))
    if [b.kind for b in problem.layers] != [b.kind for b in frames]:
        found = f"{place} has the blocks {', '.join(there)}"
        raise InputError(f"-fsi_initial: {found}; the case has {', '.join(kinds)}")
    blocks = []
    for k, (block, frame) in enumerate(zip(problem.layers, frames, strict=True)):
        _check_corners(problem, k, frame, place)
        blocks.append(replace(block, initial=AtNodes(_on_grid(problem, k, frame, order))))
    return RunProblem(replace(problem.blocks_problem, blocks=tuple(blocks), notes=notes))


def _check_corners(problem: RunProblem, k: int, frame: BlockFrame, place: str) -> None:
    """InputError where the corners of a block are elsewhere; a periodic axis has one end."""
    block: Block = problem.layers[k]
    if block.periodic != frame.periodic:
        raise InputError(
            f"-fsi_initial: {place}: block '{frame.name}' is periodic along other axes than "
            f"'{block.name}'"
        )
    size = np.ptp(frame.places.reshape(-1, block.dimension), axis=0).max()
    for ends in product(*([0] if closed else [0, 1] for closed in block.periodic)):
        at = [end * (n - 1) for end, n in zip(ends, block.shape)]
        node = np.ravel_multi_index(tuple(at), block.shape, order="F")
        wanted = problem.places(k, np.array([node]))[0]
        found = frame.places[tuple(-end for end in ends[::-1])]
        if np.abs(found - wanted).max() > _ALIKE * size:
            one, other = (f"({', '.join(f'{x:g}' for x in X)})" for X in (found, wanted))
            raise InputError(
                f"-fsi_initial: {place}: block '{frame.name}' has a corner at {one}; "
                f"'{block.name}' has it at {other}"
            )


def _on_grid(problem: RunProblem, k: int, frame: BlockFrame, order: int) -> Array:
    """(nodes, unknowns) of the new grid."""
    block: Block = problem.layers[k]
    values, d = frame.values, block.dimension
    for axis in range(d):
        row = d - 1 - axis
        rows = np.moveaxis(values, row, 0)
        closed = block.periodic[axis]
        there = len(rows) if closed else len(rows) - 1
        places = np.arange(block.shape[axis]) / block.cells[axis] * there
        flat = interpolated(rows.reshape(len(rows), -1), places, order, closed)
        values = np.moveaxis(flat.reshape(-1, *rows.shape[1:]), 0, row)
    values = values.reshape(-1, values.shape[-1]).copy()
    if block.kind == "solid":
        values[:, -d:] += problem.places(k, np.arange(len(values)))
    return values
