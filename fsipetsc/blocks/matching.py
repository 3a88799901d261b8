"""Which faces and nodes of blocks are at one place.

Faces whose nodes are at the same places meet. Nodes of faces at one place are one particle
(SCHEME-BLOCKS.md, section 3), also where blocks touch at an edge or a vertex only.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.conditions import Condition, Periodic
from fsipetsc.blocks.faces import Face, same_place, united
from fsipetsc.blocks.maps import place_text
from fsipetsc.checks import Array
from fsipetsc.errors import InputError


@dataclass(frozen=True, eq=False)
class Meeting:
    """What stands at a face that another one meets: its number of block, axis and side."""

    block: int
    axis: int
    side: int


#: of the faces (axis, side) of a block
Kinds = dict[tuple[int, int], Condition | Meeting]


class Members(NamedTuple):
    """All nodes of faces, sorted by particle, block, node: integer arrays (M,).

    Particles count from 0, in the order of their first members.
    """

    particle: Array
    block: Array
    node: Array


class Matching:
    """Which faces have the same nodes, which nodes are one particle."""

    def __init__(self, faces: list[Face], named: Mapping[Any, Condition], within: float) -> None:
        self.faces, self._pairs = faces, []
        self.given = [named.get((face.owner.name, face.axis, face.side)) for face in faces]
        periodic = [f for f, given in enumerate(self.given) if isinstance(given, Periodic)]
        X = [face.X for face in faces] + [faces[f].X + self.given[f].shift for f in periodic]
        labels = same_place(np.concatenate(X), within) if X else np.zeros(0, int)
        labels = np.split(labels, np.cumsum([len(x) for x in X])[:-1])
        self.labels = labels[: len(faces)]
        # those of the nodes that a face meets
        self.wanted = dict(enumerate(self.labels)) | dict(zip(periodic, labels[len(faces) :]))
        self._at: dict[bytes, list[int]] = {}
        for f, label in enumerate(self.labels):
            self._at.setdefault(_key(label), []).append(f)

    def kinds(self, blocks: int) -> list[Kinds]:
        """What stands at the faces of each block. InputError."""
        kinds: list[Kinds] = [{} for _ in range(blocks)]
        for f, face in enumerate(self.faces):
            partner = self._partner(f)
            kind = self.given[f] if partner is None else self._meeting(f, partner)
            kinds[face.block][face.axis, face.side] = kind
        return kinds

    def members(self) -> Members:
        """After `kinds`."""
        faces = self.faces
        if not faces:
            return Members(*np.zeros((3, 0), int))
        label = united(np.concatenate(self.labels), self._pairs)
        block = np.concatenate([np.full(len(face.nodes), face.block) for face in faces])
        node = np.concatenate([face.nodes for face in faces])
        order = np.lexsort((node, block))
        again = np.append(False, (np.diff([block[order], node[order]]) == 0).all(axis=0))
        label, block, node = (a[order][~again] for a in (label, block, node))
        _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
        particle = np.argsort(np.argsort(first))[inverse]
        order = np.lexsort((node, block, particle))
        return Members(particle[order], block[order], node[order])

    def share_places(self) -> None:
        """Nodes at one place get the X of the first of them."""
        if self.faces:
            known, first = np.unique(np.concatenate(self.labels), return_index=True)
            X = np.concatenate([face.X for face in self.faces])[first]
            for face, label in zip(self.faces, self.labels):
                face.X[...] = X[np.searchsorted(known, label)]

    def _partner(self, f: int) -> int | None:
        """The face that face f meets, or None. InputError for a condition too many or none."""
        face, condition = self.faces[f], self.given[f]
        found = [g for g in self._at.get(_key(self.wanted[f]), []) if g != f]
        if len(found) > 1:
            others = f"{self.faces[found[0]]} and {self.faces[found[1]]}"
            where = place_text(face.X.mean(axis=0))
            raise InputError(f"{face}, {others} are at one place, {where}: expected two faces")
        if isinstance(condition, Periodic):
            if not found or _key(self.wanted[found[0]]) != _key(self.labels[f]):
                at = f"{place_text(face.X[0])} + {condition.shift}"
                wanted = "expected one with the opposite shift"
                raise InputError(f"{face} is Periodic, and no Periodic face is at {at}: {wanted}")
        elif found and condition is not None:
            what = f"{self.faces[found[0]]} and is named {type(condition).__name__}(…), too"
            raise InputError(f"{face} meets {what}: expected no condition")
        elif not found and condition is None:
            raise InputError(self._why_alone(f))
        return found[0] if found else None

    def _meeting(self, f: int, partner: int) -> Meeting:
        face, other = self.faces[f], self.faces[partner]
        if face.grid != other.grid:
            what = "have the same nodes, but one of them is periodic and the other ends there"
            raise InputError(f"{face} and {other} {what}, about {place_text(face.X.mean(axis=0))}")
        self._pairs.append((self.labels[f], self.wanted[f]))
        if isinstance(self.given[f], Periodic) and face.owner.kind != other.owner.kind:
            raise InputError(f"{face} goes on at {other}: expected gas and gas, or two solids")
        return Meeting(other.block, other.axis, other.side)

    def _why_alone(self, f: int) -> str:
        """What is wrong with a face that has no condition and that no other meets."""
        face, corners = self.faces[f], self.faces[f].corners(self.labels[f])
        centre, others = face.X.mean(axis=0), [g for g in range(len(self.faces)) if g != f]
        for g in others:
            other = self.faces[g]
            if face.shape and np.array_equal(corners, other.corners(self.labels[g])):
                if sorted(face.shape) != sorted(other.shape):
                    mine, its = (" by ".join(map(str, x.shape)) for x in (face, other))
                    between = f"{face} has {mine} nodes, {other} that it meets has {its}"
                    return f"{between}, about {place_text(centre)}: expected the same"
                alone = int(np.argmin(np.isin(self.labels[f], self.labels[g])))
                return f"{face} and {other} do not conform at {place_text(face.X[alone])}"
        apart = [np.linalg.norm(self.faces[g].X.mean(axis=0) - centre) for g in others]
        near = int(np.argmin(apart))
        nearest = f"{self.faces[others[near]]}, {apart[near]:.3g} away"
        alone = f"{face}, about {place_text(centre)}, has no condition"
        wanted = f"expected one, or a face with the same nodes; the nearest is {nearest}"
        return f"{alone}, and no face meets it: {wanted}"


def _key(labels: Array) -> bytes:
    return np.sort(labels).tobytes()
