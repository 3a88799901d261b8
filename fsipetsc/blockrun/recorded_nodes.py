"""Nodes that are recorded at each step: -fsi_probes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fsipetsc.blockrun.columns import point_names
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.errors import InputError
from fsipetsc.options import floats

Array = np.ndarray


@dataclass(frozen=True)
class Recorded:
    """A node of a block. name: of the block; X: its place in the reference map [m].

    face: (axis, side) of the solid's face at an interface; None where there is none.
    """

    name: str
    block: int
    node: int
    X: tuple[float, ...]
    face: tuple[int, int] | None = None


def chosen(problem: BlockProblem, probes: str | None) -> list[Recorded]:
    """The nodes nearest to the places that "X,Y;X,Y" names. InputError for places outside."""
    d, pieces = problem.dimension, probes.split(";") if probes else ()
    places = [np.array(floats(piece, "fsi_probes", "m")) for piece in pieces]
    if any(place.size != d for place in places):
        wanted = ",".join("XYZ"[:d])
        raise InputError(f"-fsi_probes {probes}: expected {wanted}, and ; between several")
    return [_nearest(problem, place) for place in places]


def _nearest(problem: BlockProblem, place: Array) -> Recorded:
    """The node next to a place; on an interface that of the solid. InputError for a place that is
    further from it than its neighbours are: it is outside.
    """
    found = []  # of each block: distance, whether it is a gas, its number, node, X, size of cells
    for k, block in enumerate(problem.layers):
        X = problem.places(k, np.arange(np.prod(block.shape)))
        apart = np.linalg.norm(X - place, axis=1)
        node = int(apart.argmin())
        at = np.unravel_index(node, block.shape, order="F")
        beside = tuple(slice(max(i - 1, 0), i + 2) for i in at)
        around = X.reshape(*block.shape, -1, order="F")[beside] - X[node]
        size = np.linalg.norm(around, axis=-1).max()
        found.append((float(apart[node]), block.kind == "fluid", k, node, X[node].tolist(), size))
    least = min(found)[0]
    near = [of_block for of_block in found if of_block[0] <= least + problem.tolerance]
    if not any(apart <= size for apart, *_, size in near):
        text = ",".join(f"{x:g}" for x in place)
        nearest = f"the nearest node is {least:g} away"
        raise InputError(f"-fsi_probes {text}: no block is there; {nearest}")
    _, _, k, node, X, _ = min(near, key=lambda of_block: of_block[1:3])
    return Recorded(problem.layers[k].name, k, node, tuple(X), _face_of(problem, k, node))


def _face_of(problem: BlockProblem, k: int, node: int) -> tuple[int, int] | None:
    """The face at which a node of a solid is on an interface."""
    faces = problem.faces_of(k) if problem.layers[k].kind == "solid" else ()
    there = (f for f in sorted(faces) if problem.is_interface(k, *f))
    return next((f for f in there if node in problem.face_nodes(k, *f)), None)


def here_of(state: Any) -> list[tuple[int, Recorded, int]]:
    """(number, node, its place among those that this rank owns) of the recorded nodes here."""
    found = []
    for i, node in enumerate(state.recorded):
        part = state.layout.parts.get(node.block)
        if part is not None and node.node in part.numbers:
            found.append((i, node, int(part.rows(np.array([node.node]))[0])))
    return found


def note_nodes(state: Any, here: Sequence[tuple[int, Recorded, int]]) -> None:
    """Write into the record of a step what is known of nodes here, of the completed state, whose
    halos are filled: place, velocity, temperature; pressure, of solids minus the mean of the normal
    stresses in the plane and of hoops; traction on the solid at an interface, else 0.
    """
    d = state.problem.dimension
    names = point_names(d)
    for number, node, row in here:
        part, q = state.scheme.parts[node.block], state.y.ghosted(node.block)
        saved = part.fields(q, slice(row, row + 1))[0]
        known = dict(zip(part.names, saved.tolist(), strict=True))
        traction = [0.0] * d
        if part.block.kind == "solid":
            (stress,) = part.stresses(q, [row])
            of_hoops = known.get("sigma_theta", 0.0) - (known["p"] if d == 1 else 0.0)
            normal = [*np.diag(stress), *[of_hoops] * state.problem.symmetry]
            known["p"] = -float(np.sum(normal)) / len(normal)
            if node.face is not None:
                traction = (stress @ part.normals([row], *node.face)[0]).tolist()
        fields = (known[name.removesuffix("_point")] for name in names[: 2 * d + 2])
        for name, value in zip(names, [*fields, *traction], strict=True):
            state.latest[name][number] = value
