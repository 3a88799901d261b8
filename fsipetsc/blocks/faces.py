"""Faces of blocks: which of them meet, which of their nodes are at one place.

Faces whose nodes are at the same places meet. Nodes of faces at one place are one particle
(docs/derivation.md, Particles), also where blocks touch at an edge or a vertex only.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import VECTORS, Condition, Periodic
from fsipetsc.checks import Array, described, place_text
from fsipetsc.errors import InputError

#: (block name, axis, side)
FaceName = tuple[str, int, int]
#: places are the same within this part of the largest coordinate
_SAME = 1e-10


@dataclass(frozen=True, eq=False)
class Meeting:
    """What stands at a face that another one meets: its number of block, axis and side."""

    block: int
    axis: int
    side: int


#: of the faces (axis, side) of a block
Kinds = dict[tuple[int, int], Condition | Meeting]


def number_of(blocks: Sequence[Block], name: Any) -> int:
    """The number of the block of this name. InputError."""
    names = [block.name for block in blocks]
    if name not in names:
        known = ", ".join(map(repr, names))
        raise InputError(f"there is no block {described(name)}: expected one of {known}")
    return names.index(name)


def check_faces(blocks: Sequence[Block], faces: Mapping[FaceName, Condition]) -> None:
    """InputError for wrong names and conditions."""
    if not isinstance(faces, Mapping):
        wanted = "expected {(block name, axis, side): condition, …}"
        raise InputError(f"BlockProblem: faces is {described(faces)}: {wanted}")
    for name, condition in faces.items():
        if not isinstance(name, tuple) or len(name) != 3:
            wanted = "expected (block name, axis, side)"
            raise InputError(f"BlockProblem: faces: {described(name)}: {wanted}")
        block = blocks[number_of(blocks, name[0])]
        vectors = (getattr(condition, vector, None) for vector in VECTORS)
        wrong = ""
        if name[1:] not in block.faces:
            wrong = f"expected (axis, side) of {', '.join(map(str, block.faces))}"
        elif not isinstance(condition, Condition) or block.kind not in condition.of:
            wrong = f"{type(condition).__name__} is no condition of a {block.kind}"
        elif {len(v) for v in vectors if isinstance(v, tuple)} - {block.dimension}:
            wrong = f"{condition}: expected {block.dimension} numbers"
        if wrong:
            raise InputError(f"{block}, face (axis {name[1]}, side {name[2]}): {wrong}")


class Face:
    """A face of block number `block`, and the condition that is named for it.

    nodes: their numbers, X: their places (N, d). labels: the same for nodes at one place; wanted:
    those of the nodes that the face meets.
    """

    labels: Array
    wanted: Array

    def __init__(self, block: int, owner: Block, axis: int, side: int, condition: Any) -> None:
        self.block, self.owner, self.axis, self.side = block, owner, axis, side
        self.condition, self.nodes = condition, owner.face_nodes(axis, side)
        self.X = owner.face_positions(axis, side).T

    def __str__(self) -> str:
        return f"{self.owner}, face (axis {self.axis}, side {self.side})"


class Faces:
    """The faces of all blocks, none on periodic axes. InputError for what does not meet.

    named: conditions of faces. tolerance: places are the same that are no further apart [m]. kinds:
    what stands at the faces of each block. particles: (block, node) of the nodes at each place,
    ascending, particles in the order of their first nodes.
    """

    def __init__(self, blocks: Sequence[Block], named: Mapping[FaceName, Condition]) -> None:
        check_faces(blocks, named)
        every = [(k, block, *face) for k, block in enumerate(blocks) for face in block.faces]
        self._faces = [Face(*of, named.get((of[1].name, *of[2:]))) for of in every]
        periodic = [face for face in self._faces if isinstance(face.condition, Periodic)]
        shifted = (face.X + face.condition.shift for face in periodic)
        X = [np.zeros((0, blocks[0].dimension)), *(face.X for face in self._faces), *shifted]
        places = np.concatenate(X)
        self.tolerance = float(_SAME * np.abs(places).max(initial=0.0))
        labels = same_place(places, self.tolerance)
        self._places = places[np.unique(labels, return_index=True)[1]]  # of the first of a label
        pieces = iter(np.split(labels, np.cumsum([len(x) for x in X[1:]])))
        at = defaultdict[bytes, list[Face]](list)
        for face in self._faces:
            face.labels = face.wanted = next(pieces)
            at[_key(face.labels)].append(face)
        for face in periodic:
            face.wanted = next(pieces)
        self.kinds: list[Kinds] = [{} for _ in blocks]
        for face in self._faces:
            met = [other for other in at[_key(face.wanted)] if other is not face]
            self.kinds[face.block][face.axis, face.side] = _kind(face, met)
        smallest = united(len(self._places), [(f.labels, f.wanted) for f in periodic])
        found = defaultdict[int, set[tuple[int, int]]](set)
        for face in self._faces:
            for node, label in zip(face.nodes.tolist(), smallest[face.labels].tolist()):
                found[label].add((face.block, node))
        self.particles = sorted(sorted(members) for members in found.values())

    def places(self, k: int) -> tuple[Array, Array]:
        """Numbers of the nodes on faces of block k, ascending, and X (d, M) of the first node that
        is at their place.
        """
        own = [(face.nodes, face.labels) for face in self._faces if face.block == k]
        nodes, labels = np.concatenate([np.zeros((2, 0), int), *map(np.array, own)], axis=1)
        numbers, first = np.unique(nodes, return_index=True)
        return numbers, self._places[labels[first]].T


def _kind(face: Face, met: Sequence[Face]) -> Condition | Meeting:
    """What stands at a face, at whose place others are. InputError for a condition too many or
    none.
    """
    condition, wrong = face.condition, ""
    if len(met) > 1:
        wrong = f"is at one place with {met[0]} and {met[1]}: expected two faces"
    elif isinstance(condition, Periodic):
        if not met or _key(met[0].wanted) != _key(face.labels):
            at = f"{place_text(face.X[0])} + {condition.shift}"
            wrong = f"is Periodic, and no Periodic face with the opposite shift is at {at}"
        elif face.owner.kind != met[0].owner.kind:
            wrong = f"goes on at {met[0]}: expected gas and gas, or two solids"
    elif met and condition is not None:
        wrong = f"meets {met[0]}: expected no condition, and {type(condition).__name__} is named"
    elif not met and condition is None:
        wanted = f"expected one, or a face with the same {len(face.X)} nodes"
        wrong = f"has no condition, and no face meets it: {wanted}"
    if wrong:
        raise InputError(f"{face}, about {place_text(face.X.mean(axis=0))}, {wrong}")
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
