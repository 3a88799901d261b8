"""Errors against exact solutions: norms with the operators' weights and the volume of the map."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.blockrun.columns import fields_of
from fsipetsc.blocks.values import block_values, checked, names_of
from fsipetsc.process.together import together

if TYPE_CHECKING:
    from fsipetsc.blockrun.block_state import BlockState

Array = np.ndarray


def errors_of(state: BlockState, t: float, norm: str) -> dict[str, dict[str, float]] | None:
    """Errors at time t [s]: kind of block -> name -> (sum w |difference|^p)^(1/p), and "combined".

    norm: "L1" or "L2", p = 1 or 2. w: H times J of the reference map. All blocks of a kind are
    taken together, stresses where all solids have an exact_stress. None without an exact solution.
    Collective; InputError if it cannot be had.
    """
    blocks = state.problem.layers
    if any(block.exact is None for block in blocks):
        return None
    power = {"L1": 1, "L2": 2}[norm]
    names = {kind: _compared(blocks, kind) for kind in sorted({b.kind for b in blocks})}
    sums = {kind: np.zeros(len(names[kind])) for kind in names}
    for kind, shares in together(state.comm, lambda: _departures(state, t, power, names)):
        sums[kind] += shares
    return state._norms(sums, names, power)


def _compared(blocks: Sequence[Any], kind: str) -> tuple[str, ...]:
    """What is compared of the blocks of a kind."""
    d = blocks[0].dimension
    unknowns = names_of(kind, "exact", d)
    if kind == "fluid" or any(b.exact_stress is None for b in blocks if b.kind == kind):
        return unknowns
    return (*unknowns, *(n for n in fields_of(kind, d) if n.startswith(("s_", "sigma"))))


def _departures(
    state: BlockState, t: float, power: int, names: dict[str, tuple[str, ...]]
) -> list[tuple[str, Array]]:
    """(kind, sums of weighted powers) of this rank's parts."""
    found, problem = [], state.problem
    for k, part in state.scheme.parts.items():
        block, of_kind, X = part.block, names[part.block.kind], part.X[:, part.owned]
        exact = block_values(block, "exact", X, t)
        if len(of_kind) > len(exact):
            where = f"exact_stress of block '{block.name}' at t = {t:.6g}"
            exact += checked(block.exact_stress, (*X, t), X, of_kind[len(exact) :], where)
        columns = fields_of(block.kind, problem.dimension, problem.symmetry)
        saved = dict(zip(columns, state.fields(k).T, strict=True))
        weights = part.weights * part.reference / (X[-1] ** problem.symmetry)
        apart = (np.abs(saved[name] - value) for name, value in zip(of_kind, exact, strict=True))
        found.append((block.kind, np.array([np.sum(weights * a**power) for a in apart])))
    return found
