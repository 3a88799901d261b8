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
    problem, blocks = state.problem, state.problem.layers
    away, m, Pa = np.zeros(len(blocks)), problem.unit("m"), problem.unit("Pa")
    for k, distance in state.scheme.particles.walls_away().items():
        away[k] = distance
    state.comm.Allreduce(MPI.IN_PLACE, away, MPI.MAX)
    found = [
        f"note: a wall of '{block.name}' is {distance:.3g}{m} from the end of its block at "
        f"t = 0: the grid of the gas is stretched to it"
        for block, distance in zip(blocks, away.tolist(), strict=True)
        if distance > AWAY * state.h
    ]
    sums = np.zeros((len(problem.interfaces), 4))
    for row, (gas, solid) in zip(sums, problem.interfaces, strict=True):
        row[:2] = _sum_of_pressures(state, gas, solid)
        row[2:] = _sum_of_pressures(state, solid, gas)
    state.comm.Allreduce(MPI.IN_PLACE, sums)
    for (gas, solid), (p, n, push, count) in zip(problem.interfaces, sums, strict=True):
        p, push = p / n, push / count
        if abs(p - push) > JUMP * max(abs(p), abs(push)):
            found.append(
                f"note: at t = 0 '{blocks[gas].name}' has a pressure of {p:.4g}{Pa} where it meets "
                f"'{blocks[solid].name}', which pushes with {push:.4g}{Pa} (means of the "
                "interface): waves start there"
            )
    return found


def _sum_of_pressures(state: BlockState, k: int, other: int) -> tuple[float, int]:
    """Of this rank's nodes of block k on its interface with another block: the sum of what they
    push with, the pressure of a gas, minus the normal stress of a solid; how many they are.
    """
    d, total, count, part = state.problem.dimension, 0.0, 0, state.scheme.parts.get(k)
    for face, met in sorted(state.problem.faces_of(k).items() if part else ()):
        if not (isinstance(met, Meeting) and met.block == other):
            continue
        nodes = state.problem.face_nodes(k, *face)
        rows = part.part.rows(nodes[np.isin(nodes, part.part.numbers)])
        saved, count = part.fields(state.y.ghosted(k), rows), count + rows.size
        if part.block.kind == "fluid":
            total += float(saved[:, fields_of("fluid", d).index("p")].sum())
            continue
        for row, stress in zip(rows, stresses_of(saved, d), strict=True):
            n = part.normal(row, *face)
            total -= float(n @ stress @ n)
    return total, count
