"""What may not be meant in a run on blocks: notes on initial data, and on what the grid does not
resolve at the end.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from mpi4py import MPI

from fsipetsc.blockrun.columns import fields_of
from fsipetsc.blockrun.recorded_nodes import stresses_of
from fsipetsc.blocks.conditions import NoSlip
from fsipetsc.blocks.problem import BlockProblem, Meeting

if TYPE_CHECKING:
    from fsipetsc.blockrun.block_state import BlockState
    from fsipetsc.blockrun.gas_part import GasPart

Array = np.ndarray
#: the part of the larger of two pressures by which they may differ
JUMP = 0.01
#: cells by which a wall may stand away from the end of its block
AWAY = 0.1
#: kinds of what the grid may not resolve
_SHOCK, _HEAT, _SHEAR = range(3)
#: parts of the larger pressure, and of ranges in a block, by which neighbouring nodes may differ
MOST = np.array([0.2, 0.5, 0.5])
#: ranges below this part of the temperature, or of sqrt(p/rho), do not count
LEAST = 0.01
#: what changes, over what, what to do
_THIN = "the layer there is not resolved"
_BESIDE = "of its range from a wall to the node beside it"
_WORDS = (
    ("the pressure", "from one node to the next", "shocks need -fsi_shock 1 -fsi_dissipation 1"),
    ("the temperature", _BESIDE, _THIN),
    ("the velocity along a wall", _BESIDE, _THIN),
)


def first_notes(state: BlockState) -> list[str]:
    """Hinges that do not hold; where walls are not at the ends of their blocks, and where pressure
    jumps at an interface.

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
    found += weak_hinges(problem, state.op.order)
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


def weak_hinges(problem: BlockProblem, order: int) -> list[str]:
    """A note if there are hinges and the order is 8, whose derivative hardly sees a motion of a
    single point at an end (tests/test_operators.py).
    """
    words = "note: with -fsi_order 8 a hinge hardly holds its point; take 6 or less"
    return [words] if problem.hinges and order == 8 else []


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


def last_notes(state: BlockState) -> list[str]:
    """Where a wave is as steep as the grid, or a layer at a wall as thin as a cell, in a gas.

    Of a state whose halos are filled. Collective.
    """
    problem, d = state.problem, state.problem.dimension
    blocks = problem.layers
    gases = []
    for k, part in state.scheme.parts.items():
        if part.block.kind == "fluid":
            with np.errstate(all="ignore"):  # corners of halos hold nothing, and are not used
                gases.append((k, part, part.equations.primitive(tuple(state.y.ghosted(k).T))))
    scales = _scales(state, gases)
    changes = np.zeros((len(blocks), 3, 1 + d))  # the largest of each kind, and where it is
    for k, part, w in gases:
        found = [(_SHOCK, _steepest(part, w[1]), part.owned)] if not state.shocks else []
        for kind, change, at in [*found, *_at_walls(problem, part, w)]:
            if change.size:
                most = int(change.argmax())
                value = change[most] / scales[k, kind]
                changes[k, kind] = value, *part.X[:, at[most]]
    of_ranks = np.array(state.comm.allgather(changes))
    notes = []
    for k, kind in np.argwhere(of_ranks[..., 0].max(axis=0) > MOST):
        value, *X = of_ranks[of_ranks[:, k, kind, 0].argmax(), k, kind].tolist()
        what, where, advice = _WORDS[kind]
        place = ", ".join(f"{name} = {x:.4g}" for name, x in zip("XYZ", X))
        notes.append(
            f"note: at the end {what} in '{blocks[k].name}' changes by {100 * value:.0f} % "
            f"{where}, at {place}{problem.unit('m')}: {advice}"
        )
    return notes


def _scales(state: BlockState, gases: list[tuple[int, GasPart, Any]]) -> Array:
    """(blocks, kinds) what changes are divided by: 1 and the ranges of T and of velocities in a
    block, infinite where these are small. Collective.
    """
    d, count = state.problem.dimension, len(state.problem.layers)
    most = np.full((count, d + 2, 2), -np.inf)  # of T, velocities, p/rho: largest, minus least
    for k, part, w in gases:
        values = np.array([w[2], *part.equations.velocity(w), w[1] / w[0]])[:, part.owned]
        most[k] = np.stack([values.max(axis=1), -values.min(axis=1)], axis=1)
    state.comm.Allreduce(MPI.IN_PLACE, most, MPI.MAX)
    scales, width = np.ones((count, 3)), most.sum(axis=2)
    of_u = width[:, 1:-1].max(axis=1)
    scales[:, _HEAT] = np.where(width[:, 0] > LEAST * most[:, 0, 0], width[:, 0], np.inf)
    scales[:, _SHEAR] = np.where(of_u > LEAST * np.sqrt(np.abs(most[:, -1, 0])), of_u, np.inf)
    return scales


def _steepest(part: GasPart, p: Array) -> Array:
    """|p1 - p0|/max(p0, p1) from each owned node to the next, the largest of all axes."""
    own, ghosted, first = part.part.patch
    change, p = np.zeros(own[::-1]), p.reshape(ghosted[::-1])
    for axis in range(part.block.dimension):
        reach = [slice(f, f + n) for f, n in zip(first, own)]
        reach[axis] = slice(first[axis], first[axis] + own[axis] + 1)
        values = np.moveaxis(p[tuple(reach[::-1])], 2 - axis, 0)
        ratio = np.abs(np.diff(values, axis=0)) / np.maximum(values[1:], values[:-1])
        of_axis = np.moveaxis(change, 2 - axis, 0)[: len(ratio)]
        np.maximum(of_axis, ratio, out=of_axis)
    return change.ravel()


def _at_walls(problem: Any, part: GasPart, w: Any) -> Iterator[tuple[int, Array, Array]]:
    """(kind, change from nodes of walls to those beside them, these nodes in the ghosted array)."""
    k, d, material = part.part.k, part.block.dimension, part.block.material
    strides = 1, part.part.patch.ghosted[0], part.part.patch.ghosted[0] * part.part.patch.ghosted[1]
    for (axis, side), met in problem.faces_of(k).items():
        if not (isinstance(met, NoSlip) or problem.is_interface(k, axis, side)):
            continue
        nodes = problem.face_nodes(k, axis, side)
        nodes = np.sort(nodes[np.isin(nodes, part.part.numbers)])
        at = part.owned[part.part.rows(nodes)]
        beside = at + strides[axis] * (1 - 2 * side)
        if material.kappa:
            yield _HEAT, np.abs(w[2][beside] - w[2][at]), at
        if material.mu:
            u, a = np.array(part.equations.velocity(w)), part.metrics[axis * d : axis * d + d, at]
            change, normal = u[:, beside] - u[:, at], a / np.linalg.norm(a, axis=0)
            along = change - normal * (normal * change).sum(axis=0)
            yield _SHEAR, np.linalg.norm(along, axis=0), at
