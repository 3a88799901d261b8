"""What a result file holds of blocks, and what messages say of them: names, sizes, grids, places
of interfaces, values at nodes.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from mpi4py import MPI

from fsipetsc.blockrun.columns import PLACES, VELOCITIES, fields_of
from fsipetsc.parallel.block_layout import Part
from fsipetsc.stepping.verdicts import Seen

if TYPE_CHECKING:
    from fsipetsc.blockrun.block_state import BlockState


def header(state: BlockState) -> dict[str, Any]:
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


def grids(state: BlockState) -> list[dict[str, Any]]:
    """What the writer must know: see RunWriter."""
    found = []
    for k, shape in enumerate(state.layout.shapes):
        numbers = state.orders[k].numbers if k in state.orders else np.empty(0, np.int64)
        X = np.empty((0, state.problem.dimension))
        X = state.problem.places(k, numbers) if numbers.size else X
        found.append({"local": numbers.size, "n": int(np.prod(shape)), "X": X})
    return found


def places(state: BlockState) -> list[float]:
    """Mean of the last coordinate [m] of each interface."""
    problem, sums = state.problem, np.zeros((len(state.problem.interfaces), 2))
    last = problem.dimension - 1
    for number, (_, k) in enumerate(problem.interfaces):
        part, nodes = state.layout.part(k), problem.interface_nodes(number)
        mine = nodes[state.layout.owners(k, nodes) == state.comm.rank]
        if part is not None and mine.size:
            D = state.y.owned(k)[part.rows(mine), last]
            sums[number] = (problem.places(k, mine)[:, last] + D).sum(), mine.size
    state.comm.Allreduce(MPI.IN_PLACE, sums)
    return (sums[:, 0] / sums[:, 1]).tolist()


def seen(state: BlockState) -> Iterator[Seen]:
    """Values at this rank's nodes, block by block, and which of them must be positive."""
    return map(partial(_seen, state), state.layout.parts)


def _seen(state: BlockState, part: Part) -> Seen:
    problem, d = state.problem, state.problem.dimension
    kind, m = problem.layers[part.k].kind, problem.unit("m")
    names = fields_of(kind, d, problem.symmetry)
    columns = dict(zip(names, state.fields(part.k).T, strict=True))
    names = "J", "rho", *VELOCITIES[:d], "T"
    if kind == "solid":  # a temperature of a law of J < 0 is no number: J says more
        of_block = state.scheme.parts[part.k]
        columns["J"] = of_block.volume_ratio(state.y.ghosted(part.k))
        names = "J", *PLACES[:d], *VELOCITIES[:d], "T"
    X = problem.places(part.k, part.numbers)

    def place(i: int) -> str:
        now = ", ".join(f"{name} = {columns[name][i]:.6g}{m}" for name in PLACES[:d])
        then = ", ".join(f"{c} = {x:.6g}{m}" for c, x in zip(PLACES.upper(), X[i]))
        return f"{now} ({then})"

    values = {name: columns[name] for name in names}
    positive = frozenset(("J", "rho", "T"))
    return Seen(part.k, np.asarray(part.numbers), values, positive, place)
