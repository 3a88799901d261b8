"""A problem: blocks, what stands at their faces, and which faces and nodes of them are at one place.

Faces are (block, axis, side), side 0 at xi_axis = 0 and 1 at xi_axis = 1. Faces whose nodes are at the same places meet: a join
of gas and gas or solid and solid, an interface of gas and solid. Every other face needs a condition. Nodes of faces at one
place are one particle (SCHEME-BLOCKS.md, section 3), also where blocks touch at an edge or a vertex only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block import Block, Range, mesh
from fsipetsc.blocks.conditions import Condition, Hinge, Open, Periodic
from fsipetsc.blocks.faces import Face, all_faces, orientation, same_place, tolerance, united
from fsipetsc.blocks.maps import place_text
from fsipetsc.blocks.overlap import check_overlap
from fsipetsc.checks import Array, described, function
from fsipetsc.errors import InputError

#: (block name, axis, side)
FaceName = tuple[str, int, int]


@dataclass(frozen=True, eq=False)
class Meeting:
    """What stands at a face that another one meets: its number of block, axis and side.

    order: node j of this face is node order[j] of the other one. axes, flips: the k-th axis of this face runs along axis
    axes[k] of the other block, backwards where flips[k]. shift: what takes this face to the other one [m], 0 but for Periodic.
    """

    block: int
    axis: int
    side: int
    order: Array
    axes: tuple[int, ...]
    flips: tuple[bool, ...]
    shift: tuple[float, ...]


class Members(NamedTuple):
    """All nodes of faces, sorted by particle, block, node: integer arrays (M,); particles count from 0."""

    particle: Array
    block: Array
    node: Array


@dataclass(frozen=True, eq=False)
class BlockProblem:
    """Blocks and the conditions at their faces. InputError for what does not fit together.

    faces: (block name, axis, side) -> condition, for each face that no other one meets; or pairs of these. jumps(*X, t) ->
    (traction per axis [Pa], heat [W/m2]) per reference area that interfaces supply from outside, or None. points: (block
    name, place X, Hinge()) for points of solids' faces that are held. notes: lines for the summary. units: "SI" or "".
    """

    blocks: tuple[Block, ...]
    faces: Mapping[FaceName, Condition] | Iterable[tuple[FaceName, Condition]]
    jumps: Callable[..., Any] | None = None
    points: tuple[tuple[str, Any, Hinge], ...] = ()
    notes: tuple[str, ...] = ()
    units: str = "SI"
    held: tuple[tuple[int, int, Hinge], ...] = field(default=(), init=False)
    """(block, node, condition) of points."""
    members: Members = field(init=False)
    tolerance: float = field(init=False)
    """Places are the same that are no further apart than this [m]."""

    def __post_init__(self) -> None:
        blocks = tuple(self.blocks)
        self._put("blocks", blocks)
        _check_blocks(blocks)
        function(self.jumps, "BlockProblem: jumps", "jumps(*X, t) -> (traction per axis, heat)", optional=True)
        self._put("faces", self._named_faces())
        check_overlap(blocks)
        faces = all_faces(blocks)
        self._put("tolerance", tolerance(faces))
        kinds, labels, particles = _Matching(faces, self.faces, self.tolerance).result()
        self._put("_kinds", kinds)
        self._put("_faces", {(face.block, face.axis, face.side): face for face in faces})
        self._put("members", _members(faces, particles))
        self._share_places(faces, labels)
        self._put("held", tuple(self._held_point(*point) for point in self.points))

    @property
    def dimension(self) -> int:
        """1, 2 or 3."""
        return self.blocks[0].dimension

    def number(self, name: str) -> int:
        """Of a block. InputError if there is none of this name."""
        names = [block.name for block in self.blocks]
        if name not in names:
            raise InputError(f"there is no block {described(name)}: expected one of {', '.join(map(repr, names))}")
        return names.index(name)

    def check(self, order: int) -> None:
        """InputError where an axis of a block has too few nodes for the operators of this order."""
        for block in self.blocks:
            for axis in range(self.dimension):
                block.band(order, axis)

    def faces_of(self, k: int) -> dict[tuple[int, int], Condition | Meeting]:
        """(axis, side) -> what stands at the faces of block k; nothing on a periodic axis."""
        return self._kinds[k]

    def is_interface(self, k: int, axis: int, side: int) -> bool:
        """Whether gas meets a solid at a face of block k."""
        kind = self._kinds[k].get((axis, side))
        return isinstance(kind, Meeting) and self.blocks[kind.block].kind != self.blocks[k].kind

    @property
    def joined(self) -> bool:
        """Whether there are joins of gas and gas or solid and solid."""
        meeting = [(k, *face) for k, kinds in enumerate(self._kinds) for face, kind in kinds.items() if isinstance(kind, Meeting)]
        return not all(self.is_interface(*face) for face in meeting)

    def face_nodes(self, k: int, axis: int, side: int) -> Array:
        """Numbers of the nodes of a face of block k, lower axis fastest."""
        return self._faces[k, axis, side].nodes

    def places(self, k: int, nodes: Array) -> Array:
        """X of nodes of block k, (len, d); on faces the same bits for all nodes at one place."""
        return self._places(k, np.unravel_index(np.asarray(nodes), self.blocks[k].shape[::-1])[::-1]).T

    def positions(self, k: int, where: Range) -> Array:
        """X of a range of nodes of block k, (d, N), axis 0 fastest, as `places`. Beyond the ends of a
        periodic axis they go on."""
        index = mesh([np.arange(*ends) for ends in where])
        return self._places(k, index).reshape(self.dimension, -1)

    def hinged(self, members: Iterable[tuple[int, int]]) -> bool:
        """Whether one of these (block, node) is a point that is held."""
        return not {(k, node) for k, node, _ in self.held}.isdisjoint(members)

    def face_normal(self, k: int, node: int, axis: int, side: int) -> tuple[Array, Array, Array]:
        """At a node of a face: the outward unit normal of the reference map, the place X of the node, and
        the mean place of its neighbours on the face; of a point, a place inwards. (d,) each.
        """
        block, d = self.blocks[k], self.dimension
        index = np.array(np.unravel_index(node, block.shape[::-1]))[::-1, None]
        here, slopes, around = self._places(k, index)[:, 0], [], []
        for along in range(d):
            found = []
            for step in (-1, 1):
                other = index.copy()
                other[along] += step
                if block.periodic[along] or 0 <= other[along, 0] < block.shape[along]:
                    X = self._places(k, other)[:, 0]
                    found.append(step * (X - here))
                    if along != axis:
                        around.append(X)
            slopes.append(np.mean(found, axis=0))
        normal = np.linalg.inv(np.array(slopes))[:, axis] * (1.0 if side else -1.0)
        normal /= np.linalg.norm(normal)
        return normal, here, np.mean(around, axis=0) if around else here - normal

    def _places(self, k: int, index: Sequence[Array]) -> Array:
        """X of the nodes of these indices, d arrays of one shape: (d, …)."""
        block = self.blocks[k]
        X = block.places(index)
        for axis, side in self._kinds[k]:
            face = self._faces[k, axis, side]
            there = index[axis] == (block.shape[axis] - 1 if side else 0)
            if there.any():
                X[:, there] = face.places([i[there] for i in index])
        return X

    def _put(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    def _named_faces(self) -> dict[FaceName, Condition]:
        """The faces as a dict; InputError for names that are wrong or come twice, and for conditions of another kind."""
        given = self.faces.items() if isinstance(self.faces, Mapping) else list(self.faces)
        found: dict[FaceName, Condition] = {}
        for name, condition in given:
            if not isinstance(name, tuple) or len(name) != 3:
                raise InputError(f"BlockProblem: faces: {described(name)}: expected (block name, axis, side)")
            block = self.blocks[self.number(name[0])]
            where = f"{block}, face (axis {name[1]}, side {name[2]})"
            if name[1] not in range(block.dimension) or name[2] not in (0, 1):
                raise InputError(f"{where}: expected an axis from 0 to {block.dimension - 1} and side 0 or 1")
            if block.periodic[name[1]]:
                raise InputError(f"{where} is named, but the block is periodic along this axis: it has no face there")
            if name in found:
                raise InputError(f"{where} is named twice: expected one condition")
            _check_condition(block, where, condition)
            found[name] = condition
        return found

    def _share_places(self, faces: Sequence[Face], labels: Sequence[Array]) -> None:
        """Nodes at one place get the X of the first of them."""
        together = np.concatenate(labels)
        first = np.unique(together, return_index=True)[1]
        X = np.concatenate([face.X for face in faces])[first]
        for face, label in zip(faces, labels):
            face.X[...] = X[label]

    def _held_point(self, name: str, place: Any, condition: Hinge) -> tuple[int, int, Hinge]:
        """(block, node, condition). InputError where no node of a face of a solid is at the place."""
        k = self.number(name)
        block, X = self.blocks[k], np.atleast_1d(np.asarray(place, float))
        where = f"{block}, point at {place_text(X)}"
        if block.kind != "solid" or not isinstance(condition, Hinge) or X.shape != (self.dimension,):
            raise InputError(f"{where}: expected (name of a solid, {self.dimension} coordinates, Hinge())")
        mine = [face for face in self._faces.values() if face.block == k]
        nodes, places = (np.concatenate([getattr(face, what) for face in mine]) for what in ("nodes", "X"))
        apart = np.abs(places - X).max(axis=1)
        i = int(np.argmin(apart))
        if not apart[i] <= 1e3 * self.tolerance:
            raise InputError(f"{where}: there is no node of a face; the nearest is at {place_text(places[i])}")
        return k, int(nodes[i]), condition


class _Matching:
    """Finds which faces have the same nodes."""

    def __init__(self, faces: list[Face], named: Mapping[FaceName, Condition], apart: float) -> None:
        self.faces = faces
        self.given = [named.get((face.owner.name, face.axis, face.side)) for face in faces]
        shifted = [f for f, condition in enumerate(self.given) if isinstance(condition, Periodic)]
        X = [face.X for face in faces] + [faces[f].X + self.given[f].shift for f in shifted]
        self.count, labels = 0, np.split(same_place(np.concatenate(X), apart), np.cumsum([len(x) for x in X])[:-1])
        self.labels = labels[: len(faces)]
        self.shifted = dict(zip(shifted, labels[len(faces) :]))
        self.at: dict[bytes, list[int]] = {}
        for f, label in enumerate(self.labels):
            self.at.setdefault(_key(label), []).append(f)

    def result(self) -> tuple[list[dict[tuple[int, int], Condition | Meeting]], list[Array], list[Array]]:
        """Kinds of faces by block; for each face its nodes' labels: of their place, and of their particle. InputError."""
        kinds: list[dict[tuple[int, int], Condition | Meeting]] = [{} for _ in range(1 + max(face.block for face in self.faces))]
        pairs = []
        for f, face in enumerate(self.faces):
            partner = self._partner(f)
            if partner is None:
                kinds[face.block][face.axis, face.side] = self.given[f]
            else:
                meeting = self._meeting(f, partner)
                kinds[face.block][face.axis, face.side] = meeting
                pairs.append((self.labels[f], self.labels[partner][meeting.order]))
        every = np.concatenate(self.labels)
        particle = united(every.max() + 1, pairs)
        return kinds, self.labels, [particle[label] for label in self.labels]

    def _partner(self, f: int) -> int | None:
        """The face that face f meets, or None. InputError where it has a condition too many or none."""
        face, condition = self.faces[f], self.given[f]
        found = [g for g in self.at.get(_key(self.shifted.get(f, self.labels[f])), []) if g != f]
        if len(found) > 1:
            raise InputError(f"{face}, {self.faces[found[0]]} and {self.faces[found[1]]} are at one place: expected two faces")
        if isinstance(condition, Periodic):
            back = [g for g in found if _key(self.shifted.get(g, ())) == _key(self.labels[f])]
            if not back:
                raise InputError(
                    f"{face} is Periodic, and there is no Periodic face with the same nodes at {place_text(face.X[0])}"
                    f" + {condition.shift}: expected one with the opposite shift"
                )
            return back[0]
        if found and condition is not None:
            what = type(condition).__name__
            raise InputError(f"{face} meets {self.faces[found[0]]} and is named {what}(…), too: expected no condition")
        if not found and condition is None:
            raise InputError(self._why_alone(f))
        return found[0] if found else None

    def _meeting(self, f: int, partner: int) -> Meeting:
        face, other, condition = self.faces[f], self.faces[partner], self.given[f]
        order, axes, flips = orientation(face, self.shifted.get(f, self.labels[f]), other, self.labels[partner])
        if isinstance(condition, Periodic) and face.owner.kind != other.owner.kind:
            raise InputError(f"{face} is Periodic and goes on at {other}: expected gas and gas or solid and solid")
        shift = condition.shift if isinstance(condition, Periodic) else (0.0,) * face.owner.dimension
        return Meeting(other.block, other.axis, other.side, order, axes, flips, shift)

    def _why_alone(self, f: int) -> str:
        """What is wrong with a face that has no condition and that no other meets."""
        face, label = self.faces[f], self.labels[f]
        others = [g for g in range(len(self.faces)) if g != f]
        for g in others:
            other, its = self.faces[g], self.labels[g]
            if face.shape and _key(face.corners(label)) == _key(other.corners(its)):
                if sorted(face.shape) != sorted(other.shape):
                    numbers = " by ".join(map(str, face.shape)), " by ".join(map(str, other.shape))
                    at = place_text(face.X.mean(axis=0))
                    return f"{face} has {numbers[0]} nodes, {other} that it meets about {at} has {numbers[1]}: expected the same"
                at = place_text(face.X[int(np.argmin(np.isin(label, its)))])
                return f"{face} and {other} do not conform: the node at {at} is of one of them only"
        at = place_text(face.X.mean(axis=0))
        alone = f"{face}, about {at}, has no condition, and no face with the same nodes meets it"
        if not others:
            return alone
        apart = [np.linalg.norm(self.faces[g].X.mean(axis=0) - face.X.mean(axis=0)) for g in others]
        nearest = int(np.argmin(apart))
        return f"{alone}: expected one of both; the nearest is {self.faces[others[nearest]]}, {apart[nearest]:.3g} away"


def _key(labels: Any) -> bytes:
    return np.sort(np.asarray(labels, int)).tobytes()


def _members(faces: Sequence[Face], particles: Sequence[Array]) -> Members:
    block = np.concatenate([np.full(len(face.nodes), face.block) for face in faces])
    node = np.concatenate([face.nodes for face in faces])
    label, first, particle = np.unique(np.concatenate(particles), return_index=True, return_inverse=True)
    smallest = np.full(len(label), len(node))
    np.minimum.at(smallest, particle, np.lexsort((node, block)).argsort())
    particle = smallest.argsort().argsort()[particle]
    order = np.lexsort((node, block, particle))
    found = np.array([particle, block, node])[:, order]
    again = np.append(False, (np.diff(found) == 0).all(axis=0))  # nodes of two faces of a block
    return Members(*found[:, ~again])


def _check_blocks(blocks: tuple[Any, ...]) -> None:
    if not blocks or not all(isinstance(block, Block) for block in blocks):
        raise InputError("BlockProblem: blocks: expected one or more Blocks")
    for k, block in enumerate(blocks):
        if block.name in [other.name for other in blocks[:k]]:
            raise InputError(f"BlockProblem: two blocks are named '{block.name}': expected different names")
        if block.dimension != blocks[0].dimension:
            raise InputError(f"{block} has {block.dimension} dimensions, {blocks[0]} {blocks[0].dimension}: expected the same")


def _check_condition(block: Block, where: str, condition: Any) -> None:
    if not isinstance(condition, Condition) or isinstance(condition, Hinge):
        raise InputError(f"{where}: {described(condition)}: expected a condition, as NoSlip() or Clamped()")
    if block.kind not in condition.of:
        raise InputError(f"{where}: {type(condition).__name__} is a condition of a {'gas' if block.kind == 'solid' else 'solid'}")
    if isinstance(condition, Open) and not callable(condition.u) and len(condition.u) != block.dimension:
        raise InputError(f"{where}: Open: u has {len(condition.u)} numbers: expected {block.dimension}")
    if isinstance(condition, Periodic) and len(condition.shift) != block.dimension:
        raise InputError(f"{where}: Periodic: shift has {len(condition.shift)} numbers: expected {block.dimension}")
