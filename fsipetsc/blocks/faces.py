"""Faces of blocks: which of them meet, which of their nodes are at one place.

Faces whose nodes are at the same places meet. Nodes of faces at one place are one particle
(docs/derivation.md, Particles), also where blocks touch at an edge or a vertex only.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Block, mesh
from fsipetsc.blocks.conditions import Condition, Periodic
from fsipetsc.blocks.conditions.condition import VECTORS
from fsipetsc.blocks.maps import place_text
from fsipetsc.checks import Array, described
from fsipetsc.errors import InputError

#: (block name, axis, side)
FaceName = tuple[str, int, int]
#: places are the same within this part of the largest coordinate
_SAME = 1e-10


def number_of(blocks: Sequence[Block], name: Any) -> int:
    """The number of the block of this name. InputError."""
    names = [block.name for block in blocks]
    if name not in names:
        known = ", ".join(map(repr, names))
        raise InputError(f"there is no block {described(name)}: expected one of {known}")
    return names.index(name)


def named_faces(
    blocks: Sequence[Block],
    faces: Mapping[FaceName, Condition] | Iterable[tuple[FaceName, Condition]],
) -> dict[FaceName, Condition]:
    """The faces as a dict. InputError for wrong names and conditions."""
    found: dict[FaceName, Condition] = {}
    for name, condition in faces.items() if isinstance(faces, Mapping) else faces:
        if not isinstance(name, tuple) or len(name) != 3:
            wanted = "expected (block name, axis, side)"
            raise InputError(f"BlockProblem: faces: {described(name)}: {wanted}")
        block = blocks[number_of(blocks, name[0])]
        axes, kind = np.flatnonzero(np.logical_not(block.periodic)).tolist(), type(condition)
        wrong = f"{kind.__name__} is no condition of a {block.kind}"
        if name[1] not in axes or name[2] not in (0, 1):
            wrong = f"expected an axis that is not periodic, of {axes}, and side 0 or 1"
        elif name in found:
            wrong = "it is named twice: expected one condition"
        elif isinstance(condition, Condition) and block.kind in condition.of:
            vectors = (getattr(condition, vector, None) for vector in VECTORS)
            sizes = {len(v) for v in vectors if isinstance(v, tuple)} - {block.dimension}
            wrong = f"{condition}: expected {block.dimension} numbers" if sizes else ""
        if wrong:
            raise InputError(f"{block}, face (axis {name[1]}, side {name[2]}): {wrong}")
        found[name] = condition
    return found


def face_nodes(shape: Sequence[int], axis: int, side: int) -> Array:
    """Numbers of a face's nodes, lower axis fastest; shape: nodes of the block along its axes."""
    ends = range(shape[axis])[-1:] if side else range(1)
    index = mesh([np.array(ends if k == axis else range(n)) for k, n in enumerate(shape)])
    return np.ravel_multi_index(index[::-1], shape[::-1]).ravel()


@dataclass(frozen=True, eq=False)
class Meeting:
    """What stands at a face that another one meets: its number of block, axis and side."""

    block: int
    axis: int
    side: int


#: of the faces (axis, side) of a block
Kinds = dict[tuple[int, int], Condition | Meeting]


class Face:
    """A face of block number `block`, and the condition that is named for it.

    nodes: their numbers, X: their places (N, d). labels: the same for nodes at one place; wanted:
    those of the nodes that the face meets.
    """

    labels: Array
    wanted: Array

    def __init__(self, block: int, owner: Block, axis: int, side: int, condition: Any) -> None:
        self.block, self.owner, self.axis, self.side = block, owner, axis, side
        self.condition, self.nodes = condition, face_nodes(owner.shape, axis, side)
        self.X = owner.face_positions(axis, side).T

    def __str__(self) -> str:
        return f"{self.owner}, face (axis {self.axis}, side {self.side})"


class Faces:
    """The faces of all blocks, none on periodic axes. InputError for what does not meet.

    named: their conditions. tolerance: places are the same that are no further apart [m]. kinds:
    what stands at the faces of each block. particles: (block, node) of the nodes at each place,
    ascending, particles in the order of their first nodes.
    """

    def __init__(self, blocks: Sequence[Block], named: Any) -> None:
        self.named = named_faces(blocks, named)
        self.faces = [
            Face(k, block, axis, side, self.named.get((block.name, axis, side)))
            for k, block in enumerate(blocks)
            for axis, side in product(
                np.flatnonzero(np.logical_not(block.periodic)).tolist(), (0, 1)
            )
        ]
        periodic = [face for face in self.faces if isinstance(face.condition, Periodic)]
        shifted = (face.X + face.condition.shift for face in periodic)
        X = [np.zeros((0, blocks[0].dimension)), *(face.X for face in self.faces), *shifted]
        places = np.concatenate(X)
        self.tolerance = float(_SAME * np.abs(places).max(initial=0.0))
        labels = same_place(places, self.tolerance)
        self._places = places[np.unique(labels, return_index=True)[1]]  # of the first of a label
        pieces = iter(np.split(labels, np.cumsum([len(x) for x in X[1:]])))
        for face in self.faces:
            face.labels = face.wanted = next(pieces)
        for face in periodic:
            face.wanted = next(pieces)
        at = defaultdict[bytes, list[Face]](list)
        for face in self.faces:
            at[_key(face.labels)].append(face)
        self.kinds: list[Kinds] = [{} for _ in blocks]
        for face in self.faces:
            met = [other for other in at[_key(face.wanted)] if other is not face]
            self.kinds[face.block][face.axis, face.side] = self._kind(face, met)
        smallest = united(len(self._places), [(f.labels, f.wanted) for f in periodic])
        found = defaultdict[int, set[tuple[int, int]]](set)
        for face in self.faces:
            for node, label in zip(face.nodes.tolist(), smallest[face.labels].tolist()):
                found[label].add((face.block, node))
        self.particles = sorted(sorted(members) for members in found.values())

    def places(self, k: int) -> tuple[Array, Array]:
        """Numbers of the nodes on faces of block k, ascending, and X (d, M) of the first node that
        is at their place.
        """
        faces = [face for face in self.faces if face.block == k]
        nodes = np.concatenate([np.zeros(0, int), *(face.nodes for face in faces)])
        labels = np.concatenate([np.zeros(0, int), *(face.labels for face in faces)])
        numbers, first = np.unique(nodes, return_index=True)
        return numbers, self._places[labels[first]].T

    def _kind(self, face: Face, met: Sequence[Face]) -> Condition | Meeting:
        """What stands at a face, at whose place others are. InputError for a condition too many or
        none.
        """
        condition, centre = face.condition, face.X.mean(axis=0)
        wrong = ""
        if len(met) > 1:
            wrong = f"is at one place with {met[0]} and {met[1]}: expected two faces"
        elif isinstance(condition, Periodic):
            if not met or _key(met[0].wanted) != _key(face.labels):
                at = f"{place_text(face.X[0])} + {condition.shift}"
                wrong = f"is Periodic, and no Periodic face with the opposite shift is at {at}"
            elif face.owner.kind != met[0].owner.kind:
                wrong = f"goes on at {met[0]}: expected gas and gas, or two solids"
        elif met and condition is not None:
            wrong = (
                f"meets {met[0]}: expected no condition, and {type(condition).__name__} is named"
            )
        elif not met and condition is None:
            wrong = (
                "has no condition, and no face meets it: expected one, or a face with the same "
                f"{len(face.X)} nodes"
            )
        if wrong:
            raise InputError(f"{face}, about {place_text(centre)}, {wrong}")
        return Meeting(met[0].block, met[0].axis, met[0].side) if met else condition


def _key(labels: Array) -> bytes:
    return np.sort(labels).tobytes()


def same_place(X: Array, within: float) -> Array:
    """A label for each of the places (N, d), equal for those that are within a distance.

    Sorted values of each coordinate fall into runs without gaps; places in the same runs are one.
    """
    labels = np.zeros(len(X), int)
    for x in X.T:
        order = np.argsort(x, kind="stable")
        run = np.zeros(len(x), int)
        run[order[1:]] = np.cumsum(np.diff(x[order]) > within)
        labels = np.unique(labels * (len(x) + 1) + run, return_inverse=True)[1]
    return labels


def united(n: int, pairs: Sequence[tuple[Array, Array]]) -> Array:
    """For each of n numbers the smallest one that pairs connect it with, (n,)."""
    smallest, before = np.arange(n), None
    while not np.array_equal(smallest, before):
        before = smallest.copy()
        for a, b in pairs:
            least = np.minimum(smallest[a], smallest[b])
            np.minimum.at(smallest, a, least)
            np.minimum.at(smallest, b, least)
    return smallest
