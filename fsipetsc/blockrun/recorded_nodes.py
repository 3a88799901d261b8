"""Nodes that are recorded at each step: -fsi_points, on interfaces, and -fsi_probes, anywhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.blockrun.columns import fields_of, point_names
from fsipetsc.errors import InputError
from fsipetsc.options import Option

if TYPE_CHECKING:
    from fsipetsc.blockrun.block_state import BlockState
    from fsipetsc.blocks.problem import BlockProblem

Array = np.ndarray


@dataclass(frozen=True)
class Recorded:
    """A node of a block. name: of its interface or block; X: its place in the reference map [m].

    face: (axis, side) of the solid's face at an interface; None where there is none.
    """

    name: str
    block: int
    node: int
    X: tuple[float, ...]
    face: tuple[int, int] | None = None


def chosen(problem: BlockProblem, points: Sequence[float], probes: str | None) -> list[Recorded]:
    """What the options ask for: the nearest nodes. InputError for places outside."""
    if points and problem.dimension != 2:
        raise InputError("-fsi_points is of two dimensions: expected -fsi_probes X,Y,Z;…")
    on_interfaces = dict.fromkeys(node for X in points for node in _on_interfaces(problem, X))
    found = sorted(on_interfaces, key=lambda node: problem.interface_names.index(node.name))
    return found + [_nearest(problem, place) for place in _places(probes, problem.dimension)]


def _places(text: str | None, d: int) -> list[Array]:
    """Of "X,Y;X,Y". InputError."""
    pieces = text.split(";") if text else ()
    one = Option("fsi_probes", "floats", None, "m", "a place")
    found = [np.array(one.parse(piece)) for piece in pieces]
    if any(place.size != d for place in found):
        wanted = ",".join("XYZ"[:d])
        raise InputError(f"-fsi_probes {text}: expected {wanted}, and ; between several")
    return found


def _on_interfaces(problem: BlockProblem, X: float) -> list[Recorded]:
    """The node of each interface that is nearest to X. InputError where there is none."""
    found = []
    for number, (_, solid) in enumerate(problem.interfaces):
        nodes = problem.interface_nodes(number)
        places = problem.places(solid, nodes)
        low, high = places[:, 0].min(), places[:, 0].max()
        if low <= X <= high or problem.layers[solid].periodic[0]:
            at = int(np.argmin(np.abs(places[:, 0] - X)))
            name, node = problem.interface_names[number], int(nodes[at])
            place = tuple(places[at].tolist())
            found.append(Recorded(name, solid, node, place, _face_of(problem, solid, node)))
    if not found:
        raise InputError(f"-fsi_points {X:g}: there is no interface at this X")
    return found


def _nearest(problem: BlockProblem, place: Array) -> Recorded:
    """The node next to a place; on an interface that of the solid. InputError for one outside."""
    order = sorted(range(len(problem.layers)), key=lambda k: problem.layers[k].kind != "solid")
    X = {k: problem.places(k, np.arange(np.prod(problem.layers[k].shape))) for k in order}
    apart = {k: np.linalg.norm(places - place, axis=1) for k, places in X.items()}
    least = min(float(distance.min()) for distance in apart.values())
    near = {k: np.flatnonzero(d <= least + problem.tolerance) for k, d in apart.items()}
    known = [(k, n) for k, nodes in near.items() for n in nodes]
    if not any(_has_cell(problem, k, n, X[k], place) for k, n in known):
        text = ",".join(f"{x:g}" for x in place)
        nearest = f"the nearest node is {least:g} away"
        raise InputError(f"-fsi_probes {text}: no block is there; {nearest}")
    k = known[0][0]
    node = int(apart[k].argmin())
    face = _face_of(problem, k, node)
    return Recorded(problem.layers[k].name, k, node, tuple(X[k][node].tolist()), face)


def _has_cell(problem: BlockProblem, k: int, node: int, X: Array, place: Array) -> bool:
    """Whether a place is in a block, or by at most half of the cell at its nearest node out of it;
    by one cell on a periodic axis. X: all nodes of the block.
    """
    block = problem.layers[k]
    X = X.reshape(*block.shape, block.dimension, order="F")
    at, cells, most = np.unravel_index(node, block.shape, order="F"), [], []
    for axis, (i, n) in enumerate(zip(at, block.shape, strict=True)):
        low, high = max(i - 1, 0), min(i + 1, n - 1)
        ends = (X[(*at[:axis], end, *at[axis + 1 :])] for end in (low, high))
        cells.append(np.subtract(*ends) / (low - high))
        beyond = 1.0 if block.periodic[axis] else 0.5
        most.append([-beyond if i == 0 else -np.inf, beyond if i == n - 1 else np.inf])
    steps = np.linalg.lstsq(np.array(cells).T, place - X[at], rcond=None)[0]
    low, high = np.array(most).T * (1.0 + 1e-9)
    return bool(np.all((low <= steps) & (steps <= high)))


def _face_of(problem: BlockProblem, k: int, node: int) -> tuple[int, int] | None:
    """The face at which a node of a solid is on an interface."""
    faces = problem.faces_of(k) if problem.layers[k].kind == "solid" else ()
    there = (f for f in sorted(faces) if problem.is_interface(k, *f))
    return next((f for f in there if node in problem.face_nodes(k, *f)), None)


class Recorder:
    """Writes what is known of the nodes that this rank owns into the record of a step."""

    def __init__(self, state: BlockState, nodes: Sequence[Recorded]) -> None:
        self._state, self._names = state, point_names(state.problem.dimension)
        self._own: list[tuple[int, Recorded, int]] = []
        for number, node in enumerate(nodes):
            part = state.layout.part(node.block)
            if part is not None and node.node in part.numbers:
                self._own.append((number, node, int(part.rows(np.array([node.node]))[0])))

    def write(self, record: Any) -> None:
        """Of the completed state, whose halos are filled."""
        for number, node, row in self._own:
            for name, value in zip(self._names, self._values(node, row), strict=True):
                record[name][number] = value

    def _values(self, node: Recorded, row: int) -> list[float]:
        """Place, velocity, temperature, pressure; traction on the solid at an interface, else 0."""
        state, d = self._state, self._state.problem.dimension
        kind = state.problem.layers[node.block].kind
        part, q = state.scheme.parts[node.block], state.y.ghosted(node.block)
        saved = part.fields(q, slice(row, row + 1))[0]
        columns = fields_of(kind, d, state.problem.symmetry)
        known = dict(zip(columns, saved.tolist(), strict=True))
        traction = [0.0] * d
        if kind == "solid":
            stress = stresses_of(saved[None], d)[0]
            known["p"] = -float(np.trace(stress)) / d
            if node.face is not None:
                traction = (stress @ part.normal(row, *node.face)).tolist()
        names = (name.removesuffix("_point") for name in self._names[: 2 * d + 2])
        return [*(known[name] for name in names), *traction]


def stresses_of(saved: Array, d: int) -> Array:
    """(n, d, d) Cauchy stress of nodes of a solid, from what is saved of them (n, columns)."""
    columns = fields_of("solid", d)
    stress = np.empty((len(saved), d, d))
    upper = saved[:, d + 1 : d + 1 + d * (d + 1) // 2]
    for column, (i, j) in zip(upper.T, zip(*np.triu_indices(d), strict=True), strict=True):
        stress[:, i, j] = stress[:, j, i] = column
    return stress if d > 1 else stress - saved[:, columns.index("p"), None, None]
