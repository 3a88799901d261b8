"""What may not be meant in the initial data of blocks: notes at the begin of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from mpi4py import MPI

from fsipetsc.blockrun.columns import fields_of
from fsipetsc.blockrun.recorded_nodes import stresses_of
from fsipetsc.blocks.problem import Meeting

if TYPE_CHECKING:
    from fsipetsc.blockrun.block_state import BlockState

Array = np.ndarray
#: the part of the larger of two pressures by which they may differ
JUMP = 0.01
#: cells by which a wall may stand away from the end of its block
AWAY = 0.1


def first_notes(state: BlockState) -> list[str]:
    """Where walls are not at the ends of their blocks, and where pressure jumps at an interface.

    Of the completed initial data, whose halos are filled. Collective.
    """
    return [*_walls(state), *_jumps(state)]


def _walls(state: BlockState) -> list[str]:
    blocks, m = state.problem.layers, state.problem.unit("m")
    away = np.zeros(len(blocks))
    for k, distance in state.scheme.particles.walls_away(0.0).items():
        away[k] = distance
    state.comm.Allreduce(MPI.IN_PLACE, away, MPI.MAX)
    return [
        f"note: a wall of '{block.name}' is {distance:.3g}{m} from the end of its block at "
        f"t = 0: the grid of the gas is stretched to it"
        for block, distance in zip(blocks, away.tolist(), strict=True)
        if distance > AWAY * state.h
    ]


def _jumps(state: BlockState) -> list[str]:
    problem, Pa, found = state.problem, state.problem.unit("Pa"), []
    sums = np.zeros((len(problem.interfaces), 4))
    for row, (gas, solid) in zip(sums, problem.interfaces, strict=True):
        row[:2], row[2:] = _sum_of_gas(state, gas, solid), _sum_of_solid(state, gas, solid)
    state.comm.Allreduce(MPI.IN_PLACE, sums)
    for (gas, solid), (p, n, push, m) in zip(problem.interfaces, sums, strict=True):
        p, push = p / n, push / m
        if abs(p - push) > JUMP * max(abs(p), abs(push)):
            found.append(
                f"note: at t = 0 '{problem.layers[gas].name}' has a pressure of "
                f"{p:.4g}{Pa} where it meets '{problem.layers[solid].name}', which pushes with "
                f"{push:.4g}{Pa} (means of the interface): waves start there"
            )
    return found


def _sum_of_gas(state: BlockState, gas: int, solid: int) -> tuple[float, int]:
    """Of this rank's nodes on the interface: the sum of their pressures, how many they are."""
    part, column = state.layout.part(gas), fields_of("fluid", state.problem.dimension).index("p")
    if part is None:
        return 0.0, 0
    rows = np.concatenate([own for _, own in _rows(state, gas, solid)])
    q = state.y.ghosted(gas)
    return float(state.scheme.parts[gas].fields(q, rows)[:, column].sum()), rows.size


def _sum_of_solid(state: BlockState, gas: int, solid: int) -> tuple[float, int]:
    """The same of what the solid pushes with: minus the normal stress."""
    d, total, count = state.problem.dimension, 0.0, 0
    if state.layout.part(solid) is None:
        return 0.0, 0
    part, q = state.scheme.parts[solid], state.y.ghosted(solid)
    for face, rows in _rows(state, solid, gas):
        for row, stress in zip(rows, stresses_of(part.fields(q, rows), d), strict=True):
            n = part.normal(row, *face)
            total -= float(n @ stress @ n)
            count += 1
    return total, count


def _rows(state: BlockState, k: int, other: int) -> list[tuple[tuple[int, int], Array]]:
    """Faces of block k that meet another block, and this rank's owned nodes on them."""
    problem, part, found = state.problem, state.layout.part(k), []
    for face, met in sorted(problem.faces_of(k).items()):
        if isinstance(met, Meeting) and met.block == other:
            nodes = problem.face_nodes(k, *face)
            found.append((face, part.rows(nodes[np.isin(nodes, part.numbers)])))
    return found
