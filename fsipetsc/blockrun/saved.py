"""What a result file holds of blocks, and what messages say of them: names, sizes, grids, values at
nodes, errors against exact solutions.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from fsipetsc.blockrun.columns import fields_of
from fsipetsc.blocks.values import block_values, checked, names_of
from fsipetsc.process.together import together
from fsipetsc.scheme.observables import PLACES, VELOCITIES
from fsipetsc.state import Seen


def header(state: Any) -> dict[str, Any]:
    """What a result file says of blocks, interfaces, and nodes recorded at each step."""
    d = state.problem.dimension
    blocks = [
        {
            "name": block.name,
            "kind": block.kind,
            "fields": list(fields_of(block.kind, d, state.problem.symmetry)),
            "shape": list(shape[::-1]),
            "periodic": list(block.periodic)[::-1],
        }
        for block, shape in zip(state.problem.layers, state.layout.shapes, strict=True)
    ]
    return {
        "layers": blocks,
        "interface_faces": state.problem.interface_faces,
        "faces": state.problem.face_names,
        "symmetry": state.problem.symmetry,
        "points": [[node.name, list(node.X)] for node in state.recorded],
    }


def grids(state: Any) -> list[dict[str, Any]]:
    """What the writer must know: see RunWriter."""
    found = []
    for k, shape in enumerate(state.layout.shapes):
        numbers = state.orders[k].numbers if k in state.orders else np.empty(0, np.int64)
        none = np.empty((0, state.problem.dimension))
        X = state.problem.places(k, numbers) if numbers.size else none
        found.append({"n": int(np.prod(shape)), "X": X})
    return found


def seen(state: Any) -> Iterator[Seen]:
    """Values at this rank's nodes, block by block."""
    problem, d = state.problem, state.problem.dimension
    for k, part in state.scheme.parts.items():
        columns = dict(zip(part.names, state.fields(k).T, strict=True))
        names = "J", "rho", *VELOCITIES[:d], "T"
        if part.block.kind == "solid":  # T of a law of J < 0 is no number: J says more
            columns["J"] = part.volume_ratio()
            names = "J", *PLACES[:d], *VELOCITIES[:d], "T"
        values, numbers = {name: columns[name] for name in names}, part.part.numbers
        x = np.stack([columns[name] for name in PLACES[:d]], axis=1)
        yield Seen(k, numbers, values, x, problem.places(k, numbers))


def errors_of(state: Any, t: float, norm: str) -> dict[str, dict[str, float]] | None:
    """Errors at time t [s]: kind of block -> name -> (sum w |difference|^p)^(1/p), and "combined".

    norm: "L1" or "L2", p = 1 or 2. w: H times J of the reference map. All blocks of a kind are
    taken together, stresses where all solids have an exact_stress. None without an exact solution.
    Collective; InputError if it cannot be had.
    """
    problem, blocks = state.problem, state.problem.layers
    if any(block.exact is None for block in blocks):
        return None
    power = {"L1": 1, "L2": 2}[norm]
    names = {kind: _compared(blocks, kind) for kind in sorted({b.kind for b in blocks})}
    sums = {kind: np.zeros(len(names[kind])) for kind in names}

    def add_up() -> None:
        for k, part in state.scheme.parts.items():
            block, of_kind, X = part.block, names[part.block.kind], part.X[:, part.owned]
            exact = block_values(block, "exact", X, t)
            if len(of_kind) > len(exact):
                where = f"exact of block '{block.name}' at t = {t:.6g}"
                exact += checked(block.exact_stress, (*X, t), X, of_kind[len(exact) :], where)
            saved = dict(zip(part.names, state.fields(k).T, strict=True))
            weights = part.weights * part.reference / (X[-1] ** problem.symmetry)
            for c, (name, value) in enumerate(zip(of_kind, exact, strict=True)):
                sums[block.kind][c] += np.sum(weights * np.abs(saved[name] - value) ** power)

    together(state.comm, add_up)
    return state._norms(sums, names, power)


def _compared(blocks: Sequence[Any], kind: str) -> tuple[str, ...]:
    """What is compared of the blocks of a kind."""
    d = blocks[0].dimension
    unknowns = names_of(kind, "exact", d)
    if kind == "fluid" or any(b.exact_stress is None for b in blocks if b.kind == kind):
        return unknowns
    return (*unknowns, *(n for n in fields_of(kind, d) if n.startswith(("s_", "sigma"))))
