"""Faces of blocks: their nodes, which nodes are at one place."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from fsipetsc.blocks.block import Block, mesh
from fsipetsc.checks import Array

#: places are the same within this part of the shortest edge of a cell on a face, or of all
_OF_CELL, _OF_ALL = 1e-9, 1e-13


def face_nodes(shape: Sequence[int], axis: int, side: int) -> Array:
    """Numbers of a face's nodes, lower axis fastest; shape: nodes of the block along its axes."""
    ends = range(shape[axis])[-1:] if side else range(1)
    index = mesh([np.array(ends if k == axis else range(n)) for k, n in enumerate(shape)])
    return np.ravel_multi_index(index[::-1], shape[::-1]).ravel()


@dataclass(frozen=True, eq=False)
class Face:
    """A face of block number `block`: its nodes, their places X (N, d), its axes in the block."""

    block: int
    owner: Block
    axis: int
    side: int
    axes: tuple[int, ...]
    nodes: Array
    X: Array

    def __str__(self) -> str:
        return f"{self.owner}, face (axis {self.axis}, side {self.side})"

    @property
    def shape(self) -> tuple[int, ...]:
        """Nodes along its axes."""
        return tuple(self.owner.shape[k] for k in self.axes)

    @property
    def grid(self) -> list[tuple[int, bool]]:
        """Nodes along its axes and whether these are periodic, sorted."""
        return sorted((self.owner.shape[k], self.owner.periodic[k]) for k in self.axes)

    def places(self, index: Sequence[Array]) -> Array:
        """X (d, N) of those of its nodes that have these indices in the block."""
        block, number, stride, beyond = self.owner, 0, 1, 0.0
        for k, n in zip(self.axes, self.shape):
            number, stride = number + stride * (index[k] % n), stride * n
            beyond = beyond + np.multiply.outer(block.periods[k], index[k] // n)
        return self.X[number].T + beyond

    def corners(self, values: Array) -> Array:
        """The values (N,) at its corners, sorted; of a periodic axis at its first node."""
        array = values.reshape(self.shape[::-1])
        for k, axis in enumerate(self.axes):
            ends = [0] if self.owner.periodic[axis] else [0, -1]
            array = np.take(array, ends, axis=array.ndim - 1 - k)
        return np.sort(array.ravel())


def all_faces(blocks: Sequence[Block]) -> list[Face]:
    """Block after block, axis after axis; none on periodic axes."""
    found = []
    for k, block in enumerate(blocks):
        for axis, side in product(range(block.dimension), (0, 1)):
            if not block.periodic[axis]:
                axes = tuple(j for j in range(block.dimension) if j != axis)
                nodes, X = face_nodes(block.shape, axis, side), block.face_positions(axis, side)
                found.append(Face(k, block, axis, side, axes, nodes, X.T.copy()))
    return found


def same_within(faces: Sequence[Face]) -> float:
    """How far apart places may be that are the same [m]."""
    edges, size = [np.inf], 0.0
    for face in faces:
        X = face.X.reshape(*face.shape[::-1], -1)
        size = max(size, float(np.abs(X).max()))
        for axis in range(X.ndim - 1):
            lengths = np.linalg.norm(np.diff(X, axis=axis), axis=-1)
            edges.append(lengths.min(initial=np.inf))
        across = np.diff([face.owner.face_positions(face.axis, side) for side in (0, 1)], axis=0)
        edges.append(np.linalg.norm(across[0], axis=0).max() / face.owner.cells[face.axis])
    return float(max(_OF_CELL * min(edges), _OF_ALL * size)) if faces else 0.0


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


def united(labels: Array, pairs: Sequence[tuple[Array, Array]]) -> Array:
    """The labels (N,), where those of pairs are one: the smallest of them."""
    smallest = np.arange(labels.max(initial=-1) + 1)
    before = None
    while not np.array_equal(smallest, before):
        before = smallest.copy()
        for a, b in pairs:
            least = np.minimum(smallest[a], smallest[b])
            np.minimum.at(smallest, a, least)
            np.minimum.at(smallest, b, least)
    return smallest[labels]
