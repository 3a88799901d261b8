"""A problem: blocks, what stands at their faces, and which faces and nodes of them are at one
place.

Faces are (block, axis, side), side 0 at xi_axis = 0 and 1 at xi_axis = 1. Faces whose nodes are at
the same places meet: a join of gas and gas or solid and solid, an interface of gas and solid. Every
other face needs a condition. Nodes of faces at one place are one particle (SCHEME-BLOCKS.md,
section 3), also where blocks touch at an edge or a vertex only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block import Block, Range, mesh
from fsipetsc.blocks.conditions import Centre, Condition, Hinge, Periodic
from fsipetsc.blocks.faces import Face, all_faces, orientation, same_place, same_within, united
from fsipetsc.blocks.maps import place_text
from fsipetsc.blocks.overlap import check_overlap
from fsipetsc.checks import Array, described, function
from fsipetsc.errors import InputError
from fsipetsc.operators.bands import Band, centred_band

#: (block name, axis, side)
FaceName = tuple[str, int, int]


@dataclass(frozen=True, eq=False)
class Meeting:
    """What stands at a face that another one meets: its number of block, axis and side.

    order: node j of this face is node order[j] of the other one. axes, flips: the k-th axis of this
    face runs along axis axes[k] of the other block, backwards where flips[k]. shift: what takes
    this face to the other one [m], 0 but for Periodic.
    """

    block: int
    axis: int
    side: int
    order: Array
    axes: tuple[int, ...]
    flips: tuple[bool, ...]
    shift: tuple[float, ...]


#: of the faces (axis, side) of a block
Kinds = dict[tuple[int, int], Condition | Meeting]


class Members(NamedTuple):
    """All nodes of faces, sorted by particle, block, node: integer arrays (M,).

    Particles count from 0, in the order of their first members.
    """

    particle: Array
    block: Array
    node: Array


@dataclass(frozen=True, eq=False)
class BlockProblem:
    """Blocks and the conditions at their faces. InputError for what does not fit together.

    faces: (block name, axis, side) -> condition, for each face that no other one meets; or pairs of
    these. jumps(*X, t) -> (traction per axis [Pa], heat [W/m2]) per reference area that interfaces
    supply from outside, or None. points: (block name, place X, Hinge()) for points of solids' faces
    that are held. notes: lines for the summary. units: "SI" or "".

    symmetry: in one dimension, 1 if X is the distance from an axis, 2 if it is that from a centre;
    integrals are then those of a sector of unit angle, or of unit solid angle.
    """

    blocks: tuple[Block, ...]
    faces: Mapping[FaceName, Condition] | Iterable[tuple[FaceName, Condition]]
    jumps: Callable[..., Any] | None = None
    points: tuple[tuple[str, Any, Hinge], ...] = ()
    notes: tuple[str, ...] = ()
    units: str = "SI"
    symmetry: int = 0
    held: tuple[tuple[int, int, Hinge], ...] = field(default=(), init=False)
    """(block, node, condition) of points."""
    members: Members = field(init=False)
    tolerance: float = field(init=False)
    """Places are the same that are no further apart than this [m]."""

    def __post_init__(self) -> None:
        blocks = tuple(self.blocks)
        self._put("blocks", blocks)
        if not blocks or not all(isinstance(block, Block) for block in blocks):
            raise InputError("BlockProblem: blocks: expected one or more Blocks")
        for k, block in enumerate(blocks):
            if block.name in [other.name for other in blocks[:k]]:
                raise InputError(f"BlockProblem: two blocks are named '{block.name}'")
            if block.dimension != blocks[0].dimension:
                numbers = f"{block.dimension} dimensions, {blocks[0]} {blocks[0].dimension}"
                raise InputError(f"{block} has {numbers}: expected the same")
        form = "jumps(*X, t) -> (traction per axis, heat)"
        function(self.jumps, "BlockProblem: jumps", form, optional=True)
        self._put("faces", self._named_faces())
        self._check_symmetry()
        check_overlap(blocks)
        faces = all_faces(blocks)
        self._put("tolerance", same_within(faces))
        self._put("_faces", {(face.block, face.axis, face.side): face for face in faces})
        matching = _Matching(faces, self.faces, self.tolerance)
        self._put("_kinds", matching.kinds(len(blocks)))
        self._put("members", matching.members())
        matching.share_places()
        self._put("held", tuple(self._held_point(*point) for point in self.points))

    @property
    def dimension(self) -> int:
        """1, 2 or 3."""
        return self.blocks[0].dimension

    def centred(self, k: int) -> bool:
        """Whether block k goes to r = 0."""
        return isinstance(self.faces.get((self.blocks[k].name, 0, 0)), Centre)

    def band(self, k: int, order: int, axis: int) -> Band:
        """Pair weights of an axis of block k. InputError if it has too few nodes."""
        found = self.blocks[k].band(order, axis)
        return centred_band(order, self.blocks[k].cells[0]) if self.centred(k) else found

    def number(self, name: str) -> int:
        """Of a block. InputError if there is none of this name."""
        names = [block.name for block in self.blocks]
        if name not in names:
            known = ", ".join(map(repr, names))
            raise InputError(f"there is no block {described(name)}: expected one of {known}")
        return names.index(name)

    def faces_of(self, k: int) -> Kinds:
        """(axis, side) -> what stands at the faces of block k; nothing on a periodic axis."""
        return self._kinds[k]

    @property
    def outer_faces(self) -> list[tuple[int, int, int]]:
        """(block, axis, side) of the faces that no other one meets."""
        faces = [(k, *face) for k, kinds in enumerate(self._kinds) for face in kinds]
        return [f for f in faces if not isinstance(self._kinds[f[0]][f[1:]], Meeting)]

    def is_interface(self, k: int, axis: int, side: int) -> bool:
        """Whether gas meets a solid at a face of block k."""
        kind = self._kinds[k].get((axis, side))
        return isinstance(kind, Meeting) and self.blocks[kind.block].kind != self.blocks[k].kind

    @property
    def joined(self) -> bool:
        """Whether there are joins of gas and gas or solid and solid."""
        faces = ((k, *face) for k, kinds in enumerate(self._kinds) for face in kinds)
        meeting = (f for f in faces if isinstance(self._kinds[f[0]][f[1:]], Meeting))
        return not all(self.is_interface(*face) for face in meeting)

    def face_nodes(self, k: int, axis: int, side: int) -> Array:
        """Numbers of the nodes of a face of block k, lower axis fastest."""
        return self._faces[k, axis, side].nodes

    def places(self, k: int, nodes: Array) -> Array:
        """X of nodes of block k, (len, d); on faces the same bits for all nodes at one place."""
        shape = self.blocks[k].shape[::-1]
        return self._places(k, np.unravel_index(np.asarray(nodes), shape)[::-1]).T

    def positions(self, k: int, where: Range) -> Array:
        """X of a range of nodes of block k, (d, N), axis 0 fastest, as `places`. Beyond the ends of
        a periodic axis they go on.
        """
        index = mesh([np.arange(*ends) for ends in where])
        return self._places(k, index).reshape(self.dimension, -1)

    def hinged(self, members: Iterable[tuple[int, int]]) -> bool:
        """Whether one of these (block, node) is a point that is held."""
        return not {(k, node) for k, node, _ in self.held}.isdisjoint(members)

    def face_normal(self, k: int, node: int, axis: int, side: int) -> tuple[Array, Array, Array]:
        """At a node of a face: the outward unit normal of the reference map, the place X of the
        node, and the mean place of its neighbours on the face; of a point, a place inwards. (d,)
        each.
        """
        block, slopes, around = self.blocks[k], [], []
        index = np.array(np.unravel_index(node, block.shape[::-1]))[::-1, None]
        here = self._places(k, index)[:, 0]
        for along, n in enumerate(block.shape):
            steps = [s for s in (-1, 1) if block.periodic[along] or 0 <= index[along, 0] + s < n]
            unit = np.arange(self.dimension)[:, None] == along
            places = [self._places(k, index + s * unit)[:, 0] for s in steps]
            slopes.append(np.mean([s * (X - here) for s, X in zip(steps, places)], axis=0))
            around += places if along != axis else []
        normal = np.linalg.inv(np.array(slopes))[:, axis] * (1.0 if side else -1.0)
        normal /= np.linalg.norm(normal)
        return normal, here, np.mean(around, axis=0) if around else here - normal

    def _places(self, k: int, index: Sequence[Array]) -> Array:
        """X of the nodes of these indices, d arrays of one shape: (d, …)."""
        block = self.blocks[k]
        if self.centred(k) and (index[0] < 0).any():
            i, images = index[0], index[0] < 0
            return np.where(images, -1.0, 1.0) * self._places(k, [np.where(images, -1 - i, i)])
        X = block.places(index)
        for axis, side in self._kinds[k]:
            there = index[axis] == (block.shape[axis] - 1 if side else 0)
            if there.any():
                X[:, there] = self._faces[k, axis, side].places([i[there] for i in index])
        return X

    def _check_symmetry(self) -> None:
        """InputError for what a problem with an axis or a centre cannot have."""
        if self.symmetry not in (0, 1, 2) or (self.symmetry and self.dimension > 1):
            found = f"symmetry is {described(self.symmetry)} in {self.dimension} dimensions"
            raise InputError(f"BlockProblem: {found}: expected 0, or 1 or 2 in one dimension")
        centres = [name for name, met in self.faces.items() if isinstance(met, Centre)]
        for name in centres:
            if not self.symmetry or name[1:] != (0, 0):
                wanted = "expected axis 0, side 0 of a problem with symmetry=1 or 2"
                raise InputError(f"block '{name[0]}', face {name[1:]}: Centre(): {wanted}")
        for block in self.blocks if self.symmetry else ():
            _check_radial(block, (block.name, 0, 0) in centres)

    def _put(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    def _named_faces(self) -> dict[FaceName, Condition]:
        """The faces as a dict. InputError for wrong names and conditions, and for those named
        twice.
        """
        given = self.faces.items() if isinstance(self.faces, Mapping) else list(self.faces)
        found: dict[FaceName, Condition] = {}
        for name, condition in given:
            if not isinstance(name, tuple) or len(name) != 3:
                wanted = "expected (block name, axis, side)"
                raise InputError(f"BlockProblem: faces: {described(name)}: {wanted}")
            block = self.blocks[self.number(name[0])]
            where = f"{block}, face (axis {name[1]}, side {name[2]})"
            if name[1] not in range(block.dimension) or name[2] not in (0, 1):
                last = block.dimension - 1
                raise InputError(f"{where}: expected an axis from 0 to {last} and side 0 or 1")
            if block.periodic[name[1]]:
                raise InputError(f"{where} is named, but a periodic axis has no faces")
            if name in found:
                raise InputError(f"{where} is named twice: expected one condition")
            _check_condition(block, where, condition)
            found[name] = condition
        return found

    def _held_point(self, name: str, place: Any, condition: Hinge) -> tuple[int, int, Hinge]:
        """(block, node, condition). InputError where no node of a solid's face is at the place."""
        k, d = self.number(name), self.dimension
        block, X = self.blocks[k], np.atleast_1d(np.asarray(place, float))
        where = f"{block}, point at {place_text(X)}"
        if block.kind != "solid" or not isinstance(condition, Hinge) or X.shape != (d,):
            raise InputError(f"{where}: expected (name of a solid, {d} coordinates, Hinge())")
        nodes = np.unique([n for f in self._kinds[k] for n in self.face_nodes(k, *f)])
        places = self.places(k, nodes)
        apart = np.abs(places - X).max(axis=1)
        i = int(np.argmin(apart))
        if not apart[i] <= 1e3 * self.tolerance:
            nearest = place_text(places[i])
            raise InputError(f"{where}: no node of a face is there; the nearest is at {nearest}")
        return k, int(nodes[i]), condition


class _Matching:
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
            raise InputError(f"{face}, {others} are at one place: expected two faces")
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
        face, other, condition = self.faces[f], self.faces[partner], self.given[f]
        order, axes, flips = orientation(face, self.wanted[f], other, self.labels[partner])
        self._pairs.append((self.labels[f], self.labels[partner][order]))
        shift = (0.0,) * face.owner.dimension
        if isinstance(condition, Periodic):
            shift = condition.shift
            if face.owner.kind != other.owner.kind:
                raise InputError(f"{face} goes on at {other}: expected gas and gas, or two solids")
        return Meeting(other.block, other.axis, other.side, order, axes, flips, shift)

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


def _check_radial(block: Block, centred: bool) -> None:
    """InputError where a block does not fit around an axis or a centre."""
    if block.periodic[0] or block.prestress is not None:
        raise InputError(f"{block}: it is periodic or has a prestress: expected neither at r > 0")
    first, second = block.positions([(0, 2)])[0]
    if not first > 1e-9 * abs(second):
        wanted = "expected r > 0 at all nodes; with Centre() the map ball(radius, cells)"
        raise InputError(f"{block}: its first node is at r = {first:.3g}: {wanted}")
    if centred and abs(3.0 * first - second) > 0.1 * (second - first):
        found = f"its first nodes are at r = {first:.6g} and {second:.6g}"
        wanted = "expected half a spacing and one and a half, as ball(radius, cells) has them"
        raise InputError(f"{block}: Centre(): {found}: {wanted}")


def _check_condition(block: Block, where: str, condition: Any) -> None:
    """InputError for what is no condition of this kind of block, or has another dimension."""
    if not isinstance(condition, Condition) or isinstance(condition, Hinge):
        wanted = "expected a condition, as NoSlip() or Clamped()"
        raise InputError(f"{where}: {described(condition)}: {wanted}")
    name = type(condition).__name__
    if block.kind not in condition.of:
        raise InputError(f"{where}: {name} is no condition of a {block.kind}")
    vector = {"Open": "u", "Periodic": "shift"}.get(name, "")
    numbers = getattr(condition, vector, ())
    if vector and not callable(numbers) and len(numbers) != block.dimension:
        found = f"{vector} has {len(numbers)} numbers"
        raise InputError(f"{where}: {name}: {found}: expected {block.dimension}")
