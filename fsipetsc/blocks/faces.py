"""Faces of blocks: which of them meet, which of their nodes are at one place.

Faces whose nodes are at the same places meet. Nodes of faces at one place are one particle
(docs/derivation.md, Particles), also where blocks touch at an edge or a vertex only.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
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


class BlockFace:
    """A face of block number `block`, and the condition that is named for it; also what stands at
    the face that it meets. InputError for a condition that cannot stand there.

    nodes: their numbers, X: their places (N, d). labels: (N,), the same for nodes at one place;
    wanted: those of the nodes that the face meets.
    """

    labels: Array
    wanted: Array

    def __init__(self, block: int, owner: Block, axis: int, side: int, condition: Any) -> None:
        self.block, self.owner, self.axis, self.side = block, owner, axis, side
        self.condition, self.nodes = condition, owner.face_nodes(axis, side)
        self.X = owner.face_positions(axis, side).T
        vectors = (getattr(condition, name, None) for name in VECTORS)
        stands = isinstance(condition, Condition) and owner.kind in condition.of
        if condition is not None and not stands:
            wrong = f"{type(condition).__name__} is no condition of a {owner.kind}"
            raise InputError(f"{self}: {wrong}")
        if {len(v) for v in vectors if isinstance(v, tuple)} - {owner.dimension}:
            raise InputError(f"{self}: {condition}: expected {owner.dimension} numbers")

    def __str__(self) -> str:
        return f"{self.owner}, face (axis {self.axis}, side {self.side})"

    def met_by(self, others: Sequence["BlockFace"]) -> "Condition | BlockFace":
        """What stands here; others: faces there. InputError for a condition too many or none."""
        condition, other, wrong = self.condition, others[0] if others else None, ""
        if len(others) > 1:
            wrong = f"is at one place with {other} and {others[1]}: expected two faces"
        elif isinstance(condition, Periodic):
            if other is None or _key(other.wanted) != _key(self.labels):
                at = f"{place_text(self.X[0])} + {condition.shift}"
                wrong = f"is Periodic, and no Periodic face with the opposite shift is at {at}"
            elif self.owner.kind != other.owner.kind:
                wrong = f"goes on at {other}: expected gas and gas, or two solids"
        elif other and condition is not None:
            wrong = f"meets {other}: expected no condition, and {type(condition).__name__} is named"
        elif other is None and condition is None:
            wanted = f"expected one, or a face with the same {len(self.X)} nodes"
            wrong = f"has no condition, and no face meets it: {wanted}"
        if wrong:
            raise InputError(f"{self}, about {place_text(self.X.mean(axis=0))}, {wrong}")
        return other or condition


#: (axis, side) -> what stands there, of the faces of a block; there are none on a periodic axis
Kinds = dict[tuple[int, int], Condition | BlockFace]


def meet(
    blocks: Sequence[Block], named: Mapping[FaceName, Condition]
) -> tuple[float, list[Kinds], list[tuple[Array, Array]], list[list[tuple[int, int]]]]:
    """Find out which faces meet. InputError for what does not. named: conditions of faces.

    Returns the distance [m] within which places are the same; what stands at the faces of each
    block; of each block the numbers of the nodes on faces, ascending, and X (d, M) of the first
    node that is at their place; (block, node) of the nodes at each place, ascending, places in the
    order of their first nodes.
    """
    every = {(b.name, *face): (k, b, *face) for k, b in enumerate(blocks) for face in b.faces}
    is_map = isinstance(named, Mapping)
    unknown = [name for name in named if name not in every] if is_map else [named]
    if unknown:
        name = unknown[0]
        own = [of for of in every if isinstance(name, tuple) and of[:1] == name[:1]]
        known = own or [block.name for block in blocks]
        wanted = f"expected {{(block name, axis, side): condition, …}}, of {known}"
        raise InputError(f"BlockProblem: faces: there is no {described(name)}: {wanted}")
    faces = [BlockFace(*of, named.get(name)) for name, of in every.items()]
    periodic = [face for face in faces if isinstance(face.condition, Periodic)]
    shifted = (face.X + face.condition.shift for face in periodic)
    X = [np.zeros((0, blocks[0].dimension)), *(face.X for face in faces), *shifted]
    places = np.concatenate(X)
    tolerance = float(_SAME * np.abs(places).max(initial=0.0))
    labels = same_place(places, tolerance)
    places = places[np.unique(labels, return_index=True)[1]]  # of the first of a label
    pieces = iter(np.split(labels, np.cumsum([len(x) for x in X[1:]])))
    at = defaultdict[bytes, list[BlockFace]](list)
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
    labels = labels[: nodes.size]
    known = list[tuple[Array, Array]]()
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
