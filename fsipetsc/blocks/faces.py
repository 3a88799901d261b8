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


#: (axis, side) -> what stands there, of the faces of a block; there are none on a periodic axis
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
    named = isinstance(faces, Mapping)
    if not named or not all(isinstance(face, tuple) and len(face) == 3 for face in faces):
        wanted = "expected {(block name, axis, side): condition, …}"
        raise InputError(f"BlockProblem: faces is {described(faces)}: {wanted}")
    for name, condition in faces.items():
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

    nodes: their numbers, X: their places (N, d). labels: (N,), the same for nodes at one place;
    wanted: those of the nodes that the face meets.
    """

    labels: Array
    wanted: Array

    def __init__(self, block: int, owner: Block, axis: int, side: int, condition: Any) -> None:
        self.block, self.owner, self.axis, self.side = block, owner, axis, side
        self.condition, self.nodes = condition, owner.face_nodes(axis, side)
        self.X = owner.face_positions(axis, side).T

    def __str__(self) -> str:
        return f"{self.owner}, face (axis {self.axis}, side {self.side})"

    def met_by(self, others: Sequence["Face"]) -> Condition | Meeting:
        """What stands at this face, at whose place others are. InputError for a condition too many
        or none.
        """
        condition, wrong = self.condition, ""
        if len(others) > 1:
            wrong = f"is at one place with {others[0]} and {others[1]}: expected two faces"
        elif isinstance(condition, Periodic):
            if not others or _key(others[0].wanted) != _key(self.labels):
                at = f"{place_text(self.X[0])} + {condition.shift}"
                wrong = f"is Periodic, and no Periodic face with the opposite shift is at {at}"
            elif self.owner.kind != others[0].owner.kind:
                wrong = f"goes on at {others[0]}: expected gas and gas, or two solids"
        elif others and condition is not None:
            named = type(condition).__name__
            wrong = f"meets {others[0]}: expected no condition, and {named} is named"
        elif not others and condition is None:
            wanted = f"expected one, or a face with the same {len(self.X)} nodes"
            wrong = f"has no condition, and no face meets it: {wanted}"
        if wrong:
            raise InputError(f"{self}, about {place_text(self.X.mean(axis=0))}, {wrong}")
        return Meeting(others[0].block, others[0].axis, others[0].side) if others else condition


def meet(
    blocks: Sequence[Block], named: Mapping[FaceName, Condition]
) -> tuple[float, list[Kinds], list[tuple[Array, Array]], list[list[tuple[int, int]]]]:
    """Find out which faces meet. InputError for what does not. named: conditions of faces.

    Returns the distance [m] within which places are the same; what stands at the faces of each
    block; of each block the numbers of the nodes on faces, ascending, and X (d, M) of the first
    node that is at their place; (block, node) of the nodes at each place, ascending, places in the
    order of their first nodes.
    """
    check_faces(blocks, named)
    every = [(k, block, *face) for k, block in enumerate(blocks) for face in block.faces]
    faces = [Face(*of, named.get((of[1].name, *of[2:]))) for of in every]
    periodic = [face for face in faces if isinstance(face.condition, Periodic)]
    shifted = (face.X + face.condition.shift for face in periodic)
    X = [np.zeros((0, blocks[0].dimension)), *(face.X for face in faces), *shifted]
    places = np.concatenate(X)
    tolerance = float(_SAME * np.abs(places).max(initial=0.0))
    labels = same_place(places, tolerance)
    places = places[np.unique(labels, return_index=True)[1]]  # of the first of a label
    pieces = iter(np.split(labels, np.cumsum([len(x) for x in X[1:]])))
    at = defaultdict[bytes, list[Face]](list)
    for face in faces:
        face.labels = face.wanted = next(pieces)
        at[_key(face.labels)].append(face)
    for face in periodic:
        face.wanted = next(pieces)
    kinds: list[Kinds] = [{} for _ in blocks]
    for face in faces:
        others = [other for other in at[_key(face.wanted)] if other is not face]
        kinds[face.block][face.axis, face.side] = face.met_by(others)
    nodes = np.concatenate([np.zeros(0, int), *(face.nodes for face in faces)])
    owners = np.repeat([face.block for face in faces], [face.nodes.size for face in faces])
    smallest = united(len(places), [(face.labels, face.wanted) for face in periodic])
    labels, known = labels[: nodes.size], list[tuple[Array, Array]]()
    for own in (owners == k for k in range(len(blocks))):
        numbers, first = np.unique(nodes[own], return_index=True)
        known.append((numbers, places[labels[own][first]].T))
    label, *members = np.unique([smallest[labels], owners, nodes], axis=1)
    groups = np.split(np.transpose(members), np.flatnonzero(np.diff(label)) + 1)
    particles = sorted([*map(tuple, group.tolist())] for group in groups if group.size)
    return tolerance, kinds, known, particles


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
