"""All faces of some blocks: their nodes, which nodes are at one place, which faces have the same nodes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations, product

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.checks import Array
from fsipetsc.errors import InputError

#: places are the same that are no further apart than this part of the shortest edge of a cell on a face, or of everything
_OF_CELL, _OF_ALL = 1e-9, 1e-13


def face_nodes(shape: Sequence[int], axis: int, side: int) -> Array:
    """Numbers of the nodes of a face, lower axis fastest, of a block with so many nodes along its axes."""
    numbers = np.arange(int(np.prod(shape))).reshape(shape[::-1])
    return np.take(numbers, -1 if side else 0, axis=len(shape) - 1 - axis).ravel()


@dataclass(frozen=True, eq=False)
class Face:
    """A face of block number `block`: its nodes, their places X (N, d), and its axes other than `axis`."""

    number: int
    block: int
    owner: Block
    axis: int
    side: int
    nodes: Array
    X: Array

    def __str__(self) -> str:
        return f"{self.owner}, face (axis {self.axis}, side {self.side})"

    @cached_property
    def axes(self) -> tuple[int, ...]:
        """Of the block, along the face."""
        return tuple(k for k in range(self.owner.dimension) if k != self.axis)

    @property
    def shape(self) -> tuple[int, ...]:
        """Nodes along these."""
        return tuple(self.owner.shape[k] for k in self.axes)

    @property
    def closed(self) -> tuple[bool, ...]:
        """Which of these are periodic."""
        return tuple(self.owner.periodic[k] for k in self.axes)

    def places(self, index: Sequence[Array]) -> Array:
        """X of the face's nodes of these indices in the block, (d, N), also beyond periodic ends."""
        block, number, stride = self.owner, 0, 1
        X = np.zeros((block.dimension, len(index[0])))
        for k, n in zip(self.axes, self.shape):
            number, stride = number + stride * (index[k] % n), stride * n
            X += np.multiply.outer(block.periods[k], index[k] // n)
        return self.X[number].T + X

    def corners(self, values: Array) -> Array:
        """What an array of the nodes has at the corners; of a periodic axis at its first node."""
        array = values.reshape(self.shape[::-1])
        for k, closed in enumerate(self.closed):
            array = np.take(array, [0] if closed else [0, -1], axis=array.ndim - 1 - k)
        return array.ravel()


def all_faces(blocks: Sequence[Block]) -> list[Face]:
    """Block after block, axis after axis; none on periodic axes."""
    there = [
        (k, block, axis, side)
        for k, block in enumerate(blocks)
        for axis in range(block.dimension)
        if not block.periodic[axis]
        for side in (0, 1)
    ]
    return [
        Face(number, k, block, axis, side, face_nodes(block.shape, axis, side), block.face_positions(axis, side).T)
        for number, (k, block, axis, side) in enumerate(there)
    ]


def tolerance(faces: Sequence[Face]) -> float:
    """How far apart places may be that are the same [m]."""
    edges = [np.inf]
    for face in faces:
        X = face.X.reshape(*face.shape[::-1], -1)
        for axis in range(X.ndim - 1):
            lengths = np.linalg.norm(np.diff(X, axis=axis), axis=-1)
            edges.append(lengths[lengths > 0.0].min(initial=np.inf))
        low, high = (face.owner.face_positions(face.axis, side) for side in (0, 1))
        edges.append(np.linalg.norm(high - low, axis=0).max() / face.owner.cells[face.axis])
    size = max(np.abs(face.X).max() for face in faces)
    return float(max(_OF_CELL * min(edges), _OF_ALL * size))


def same_place(X: Array, apart: float) -> Array:
    """A label for each of the places (N, d), equal for those that are no further apart in any coordinate.

    Along each coordinate sorted values fall into runs without gaps; places in the same runs are the same.
    """
    labels = np.zeros(len(X), int)
    for x in X.T:
        order = np.argsort(x, kind="stable")
        run = np.zeros(len(x), int)
        run[order[1:]] = np.cumsum(np.diff(x[order]) > apart)
        labels = np.unique(labels * (run.max() + 1) + run, return_inverse=True)[1]
    return labels


def orientation(face: Face, labels: Array, other: Face, others: Array) -> tuple[Array, tuple[int, ...], tuple[bool, ...]]:
    """(order, axes, flips) with labels = others[order]; axes, flips as of a Meeting. InputError if nodes are not in order."""
    mine = labels.reshape(face.shape[::-1])
    for axes, flips, turned in _turned(np.arange(len(others)).reshape(other.shape[::-1])):
        closed = tuple(other.closed[k] for k in axes)
        if turned.shape != mine.shape or closed != face.closed:
            continue
        first = np.argwhere(others[turned] == mine.flat[0])[0]
        for along, begin in enumerate(first):
            if closed[-1 - along]:
                turned = np.roll(turned, -begin, axis=along)
        order = turned.ravel()
        if np.array_equal(others[order], labels):
            return order, tuple(other.axes[k] for k in axes), flips
    raise InputError(f"{face} and {other} have the same nodes in different order: expected faces that conform")


def _turned(array: Array) -> Iterator[tuple[tuple[int, ...], tuple[bool, ...], Array]]:
    """(axes, flips, array seen so) for all ways to see it: its k-th axis, counted from the last, is axis axes[k]."""
    m = array.ndim
    for axes in permutations(range(m)):
        seen = array.transpose([m - 1 - k for k in axes[::-1]])
        for flips in product((False, True), repeat=m):
            yield axes, flips, seen[tuple(slice(None, None, -1 if flip else 1) for flip in flips[::-1])]


def united(count: int, pairs: Sequence[tuple[Array, Array]]) -> Array:
    """Labels 0 … count - 1 after those of pairs became one: for each its smallest partner."""
    smallest = np.arange(count)
    while True:
        before = smallest.copy()
        for a, b in pairs:
            least = np.minimum(smallest[a], smallest[b])
            np.minimum.at(smallest, a, least)
            np.minimum.at(smallest, b, least)
        if np.array_equal(smallest, before):
            return smallest
