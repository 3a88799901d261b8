"""What may not be meant in a run on blocks: notes on the completed initial data, and on what the
grid does not resolve at the end. NOTES says when each is asked for; all are collective.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from mpi4py import MPI

from fsipetsc.blockrun.gas_part import GasPart
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.maps import place_text
from fsipetsc.scheme.gas_forms import CONSERVED

Array = np.ndarray
#: the part of the larger of two pressures by which they may differ at an interface
JUMP = 0.01
#: cells by which a wall may stand away from the end of its block
AWAY = 0.1
#: parts of the larger modulus K = rho dp/drho, p of a perfect gas, and of ranges in a block, by
#: which neighbouring nodes may differ
MOST = np.array([0.2, 0.5, 0.5])
#: ranges below this part of the temperature, or of sqrt(K/rho), do not count
LEAST = 0.01
#: part of the speed of sound with which gas must flow in through an outflow to be told of
INWARD = 1e-3
#: of what the grid may not resolve: what changes, over what, what to do
_THIN = "the layer there is not resolved"
_BESIDE = "of its range from a wall to the node beside it"
_WORDS = (
    ("the pressure", "from one node to the next", "shocks need -fsi_shock 1 -fsi_dissipation 1"),
    ("the temperature", _BESIDE, _THIN),
    ("the velocity along a wall", _BESIDE, _THIN),
)


def walls_away(state: Any) -> list[str]:
    """Walls that are not at the ends of their blocks."""
    blocks, m = state.problem.layers, state.problem.unit("m")
    away = np.zeros(len(blocks))
    for k, part in state.scheme.parts.items():
        if part.block.kind == "fluid":
            away[k] = state.scheme.particles.walls_away(k)
    state.comm.Allreduce(MPI.IN_PLACE, away, MPI.MAX)
    return [
        f"a wall of '{block.name}' is {distance:.3g}{m} from the end of its block at t = 0: the "
        "grid of the gas is stretched to it"
        for block, distance, h in zip(blocks, away.tolist(), state.problem.spacings, strict=True)
        if distance > AWAY * h
    ]


def asked_data(state: Any) -> list[str]:
    """Why Python is asked for data in each stage of a step."""
    why = [one for some in state.comm.allgather(state.scheme.not_recorded) for one in some]
    words = "Python is asked for data in each stage of a step, which takes longer"
    return [f"{words}: {why[0]}"] if why else []


def pressure_jumps(state: Any) -> list[str]:
    """Interfaces at which the pressures of both sides differ; halos are filled."""
    problem, blocks, Pa = state.problem, state.problem.layers, state.problem.unit("Pa")
    pushes = np.zeros((len(problem.interfaces), 2, 2))  # of gas and solid: the sum, number of nodes
    for k, part in state.scheme.parts.items():
        for face, met in problem.faces_of(k).items():
            if problem.is_interface(k, *face):
                pair = (met.block, k) if part.block.kind == "solid" else (k, met.block)
                rows = part.part.rows_among(problem.face_nodes(k, *face))
                found = part.pushes(state.y.ghosted(k), rows, *face)
                pushes[problem.interfaces.index(pair), pair.index(k)] += found.sum(), found.size
    state.comm.Allreduce(MPI.IN_PLACE, pushes)
    means = (pushes[..., 0] / pushes[..., 1]).tolist()
    return [
        f"at t = 0 '{blocks[gas].name}' has a pressure of {p:.4g}{Pa} where it meets "
        f"'{blocks[solid].name}', which pushes with {push:.4g}{Pa} (means of the interface): "
        "waves start there"
        for (gas, solid), (p, push) in zip(problem.interfaces, means, strict=True)
        if abs(p - push) > JUMP * max(abs(p), abs(push))
    ]


def loose_forces(state: Any) -> list[str]:
    """A note for each gas on which a constant force acts node by node."""
    words = (
        "is added node by node: a gas at rest stays so to the order of the scheme only, and "
        "small motions may grow"
    )
    advice = "; -fsi_convection entropy keeps rest"
    return [
        f"the force on '{gas.name}' {words}" + advice * isinstance(gas.material.gas_law, CONSERVED)
        for gas in state.loose
    ]


def weak_hinges(state: Any) -> list[str]:
    """Hinges of order 8, whose derivative hardly sees a motion of a single point at an end
    (tests/test_operators.py).
    """
    words = "with -fsi_order 8 a hinge hardly holds its point; take 6 or less"
    return [words] if state.problem.hinges and state.op.order == 8 else []


def unresolved(state: Any) -> list[str]:
    """Where a wave is as steep as the grid, or a layer at a wall as thin as a cell, in a gas.

    Of a state whose halos are filled. Collective.
    """
    problem, d, m = state.problem, state.problem.dimension, state.problem.unit("m")
    blocks = problem.layers
    changes = np.zeros((len(blocks), 3, 1 + d))  # the largest of each of _WORDS, and where it is
    ranges = np.full((len(blocks), d + 2, 2), -np.inf)  # largest T, velocities, K/rho; minus least
    for k, part in state.scheme.parts.items():
        if part.block.kind == "solid":
            continue
        with np.errstate(all="ignore"):  # corners of halos hold nothing, and are not used
            w = part.equations.primitive(tuple(state.y.ghosted(k).T))
            u = np.array(part.equations.velocity(w))
            K = part.equations.law.bulk_modulus(w[0], w[2])
            values = np.array([w[2], *u, K / w[0]])[:, part.owned]
        ranges[k] = np.stack([values.max(axis=1), -values.min(axis=1)], axis=1)
        found = [] if state.shocks else [(0, steepest(part, w[1], K), part.owned)]
        for kind, change, at in [*found, *_at_walls(problem, part, w[2], u)]:
            if change.size and change.max() > changes[k, kind, 0]:
                changes[k, kind] = change.max(), *part.X[:, at[change.argmax()]]
    state.comm.Allreduce(MPI.IN_PLACE, ranges, MPI.MAX)
    changes, largest = _largest(state, changes), ranges[:, :, 0]
    T, u = ranges[:, 0].sum(axis=1), ranges[:, 1:-1].sum(axis=2).max(axis=1)
    changes[:, 1, 0] /= np.where(T > LEAST * largest[:, 0], T, np.inf)
    changes[:, 2, 0] /= np.where(u > LEAST * np.sqrt(np.abs(largest[:, -1])), u, np.inf)
    notes = []
    for k, kind in np.argwhere(changes[..., 0] > MOST):
        (what, where, advice), (value, *X) = _WORDS[kind], changes[k, kind].tolist()
        notes.append(
            f"at the end {what} in '{blocks[k].name}' changes by {100 * value:.0f} % "
            f"{where}, at {place_text(X)}{m}: {advice}"
        )
    return notes


def inflows(state: Any) -> list[str]:
    """Where gas flows in through an Outflow, which has no data for it: the fastest one of each
    block. Collective.
    """
    problem, d, m = state.problem, state.problem.dimension, state.problem.unit("m")
    found = np.zeros((len(problem.layers), 1 + d))  # speed inwards over that of sound, and place
    for k, part in state.scheme.parts.items():
        for (axis, side), met in problem.faces_of(k).items():
            if getattr(met, "knows_inflow", True):
                continue
            at = part.owned[part.part.rows_among(problem.face_nodes(k, axis, side))]
            with np.errstate(all="ignore"):  # it may have gone wrong just there
                w = part.equations.primitive(tuple(state.y.ghosted(k)[at].T))
                a = part.metrics[axis * d : axis * d + d, at]
                u = (np.array(part.equations.velocity(w)) * a).sum(axis=0)
                speed = (1 - 2 * side) * u / np.linalg.norm(a, axis=0)
                mach = speed / part.equations.speed_of_sound(w)
            mach = np.nan_to_num(mach, posinf=0.0, neginf=0.0)
            if mach.size and mach.max() > found[k, 0]:
                found[k] = mach.max(), *part.X[:, at[mach.argmax()]]
    return [
        f"gas flows in through the Outflow of '{block.name}' at {place_text(X)}{m}, and an Outflow "
        "does not say what gas that is: take Open there, or put it farther away"
        for block, (mach, *X) in zip(problem.layers, _largest(state, found).tolist(), strict=True)
        if mach > INWARD
    ]


def _largest(state: Any, found: Array) -> Array:
    """Of sizes and their places (…, 1 + d), size first, those of the rank with the largest size."""
    every = np.array(state.comm.allgather(found))
    rank = every[None, ..., :1].argmax(axis=1)
    largest: Array = np.take_along_axis(every, rank, axis=0)[0]
    return largest


def _strides(part: GasPart) -> list[int]:
    """How far neighbours along each axis are apart in the ghosted array."""
    return np.cumprod([1, *part.part.patch.ghosted])[: part.block.dimension].tolist()


def steepest(part: GasPart, p: Array, K: Array) -> Array:
    """|p1 - p0|/max(K0, K1) from each owned node to the next, the largest of all axes."""
    at, change = part.owned, np.zeros(part.owned.size)
    for stride, size in zip(_strides(part), part.part.patch.ghosted):
        beside = np.where(at // stride % size < size - 1, at + stride, at)
        change = np.maximum(change, np.abs(p[beside] - p[at]) / np.maximum(K[beside], K[at]))
    return change


def _at_walls(
    problem: BlockProblem, part: GasPart, T: Array, u: Array
) -> Iterator[tuple[int, Array, Array]]:
    """(kind, change from nodes of walls to those beside them, these nodes in the ghosted array)."""
    k, d, material = part.part.k, part.block.dimension, part.block.material
    for (axis, side), met in problem.faces_of(k).items():
        if not (getattr(met, "part", "") == "wall" or problem.is_interface(k, axis, side)):
            continue
        at = part.owned[part.part.rows_among(problem.face_nodes(k, axis, side))]
        beside = at + _strides(part)[axis] * (1 - 2 * side)
        if material.kappa:
            yield 1, np.abs(T[beside] - T[at]), at
        if material.mu:
            a = part.metrics[axis * d : axis * d + d, at]
            change, normal = u[:, beside] - u[:, at], a / np.linalg.norm(a, axis=0)
            along = change - normal * (normal * change).sum(axis=0)
            yield 2, np.linalg.norm(along, axis=0), at


#: when -> what may be said then
NOTES = {
    "begin": (walls_away, weak_hinges, loose_forces, asked_data, pressure_jumps),
    "end": (unresolved, lambda state: [f"at the end {said}" for said in inflows(state)]),
    "failed": (inflows,),
}
