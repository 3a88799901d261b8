"""Errors against exact solutions: norms with the operators' weights and the volume of the map."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.blockrun.columns import compared, fields_of
from fsipetsc.blocks.values import block_values, checked
from fsipetsc.process.together import together

if TYPE_CHECKING:
    from fsipetsc.blockrun.block_state import BlockState
    from fsipetsc.parallel.block_layout import Part

Array = np.ndarray


def errors(state: BlockState, t: float, norm: str = "L2") -> dict[str, dict[str, float]] | None:
    """Errors at time t [s]: kind of block -> name -> (sum w |difference|^p)^(1/p), and "combined".

    norm: "L1" or "L2", p = 1 or 2. w: H times J of the reference map. All blocks of a kind are
    taken together, stresses where all solids have an exact_stress. None without an exact solution.
    Collective; InputError if it cannot be had.
    """
    blocks, d = state.problem.layers, state.problem.dimension
    if any(block.exact is None for block in blocks):
        return None
    power = {"L1": 1, "L2": 2}[norm]
    names = {kind: compared_errors(blocks, kind, d) for kind in sorted({b.kind for b in blocks})}
    sums = {kind: np.zeros(len(names[kind])) for kind in names}
    for kind, shares in together(state.comm, lambda: _departures(state, t, power)):
        sums[kind] += shares
    result = {}
    for kind, own in sums.items():
        total = state.comm.allreduce(own)
        roots = (total ** (1 / power)).tolist()
        result[kind] = dict(zip(names[kind], roots, strict=True))
        result[kind]["combined"] = float(total.sum() ** (1 / power))
    return result


def compared_errors(blocks: Sequence[Any], kind: str, d: int) -> tuple[str, ...]:
    """What is compared of the blocks of a kind."""
    unknowns = compared(kind, d)
    if kind == "fluid" or any(b.exact_stress is None for b in blocks if b.kind == kind):
        return unknowns
    saved = fields_of(kind, d)
    return (*unknowns, *(name for name in saved if name.startswith(("s_", "sigma"))))


def _departures(state: BlockState, t: float, power: int) -> list[tuple[str, Array]]:
    """(kind, sums of weighted powers) of this rank's parts."""
    found, d = [], state.problem.dimension
    for part in state.layout.parts:
        block = state.problem.layers[part.k]
        X = state.problem.places(part.k, part.numbers).T
        names = compared_errors(state.problem.layers, block.kind, d)
        exact = block_values(block, "exact", X, t)
        if len(names) > len(exact):
            where = f"exact_stress of block '{block.name}' at t = {t:.6g}"
            stresses = names[len(exact) :]
            exact += checked(block.exact_stress, (*X, t), X, stresses, where)
        columns = fields_of(block.kind, d, state.problem.symmetry)
        saved = dict(zip(columns, state.fields(part.k).T, strict=True))
        weights = node_weights(state, part)
        shares = [
            np.sum(weights * np.abs(saved[name] - value) ** power)
            for name, value in zip(names, exact, strict=True)
        ]
        found.append((block.kind, np.array(shares)))
    return found


def node_weights(state: BlockState, part: Part) -> Array:
    """(M,) H J of the reference map of this rank's nodes; J by the differences of its places."""
    d, shape = state.problem.dimension, state.layout.shapes[part.k]
    numbers = part.numbers
    index = np.unravel_index(numbers, shape, order="F")
    block = state.problem.layers[part.k]
    weights = np.ones(numbers.size)
    edges = np.empty((numbers.size, d, d))
    for axis in range(d):
        n, cells = shape[axis], block.cells[axis]
        weights *= state.problem.band(part.k, state.layout.order, axis).weight[index[axis]]
        low, high = ((index[axis] + s) for s in (-1, 1))
        if not block.periodic[axis]:
            low, high = np.maximum(low, 0), np.minimum(high, n - 1)
        length = (high - low) / cells
        ends = []
        for at in (low, high):
            turns = at // n if block.periodic[axis] else 0 * at
            moved = list(index)
            moved[axis] = at - turns * n
            nodes = np.ravel_multi_index(moved, shape, order="F")
            X = state.problem.places(part.k, nodes)
            ends.append(X + turns[:, None] * np.asarray(block.periods[axis]))
        edges[:, axis] = (ends[1] - ends[0]) / length[:, None]
    return weights * np.abs(np.linalg.det(edges))
