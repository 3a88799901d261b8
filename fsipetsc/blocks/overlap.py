"""Do blocks overlap? Points inside one block are sought in the others by winding numbers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from fsipetsc.blocks.block import Block, determinant
from fsipetsc.blocks.maps import place_text
from fsipetsc.checks import Array
from fsipetsc.errors import InputError

#: nodes along an axis of a face by which a block in 3-D is bounded here
_MOST = 65


def check_overlap(blocks: Sequence[Block]) -> None:
    """InputError where a point inside one block is inside another; a sample of points."""
    bounds = [_boundary(block) for block in blocks]
    for a, b in combinations(range(len(blocks)), 2):
        (low, high), (other_low, other_high) = _box(bounds[a]), _box(bounds[b])
        if not np.all((low < other_high) & (other_low < high)):
            continue
        for inner, outer in ((a, b), (b, a)):
            points = _inside(blocks[inner])
            winding = _winding(points, bounds[outer])
            if np.abs(winding).max() > 0.5:
                place = place_text(points[:, int(np.argmax(np.abs(winding)))])
                raise InputError(f"{blocks[a]} and {blocks[b]} overlap at {place}: expected blocks that meet at faces only")


def _inside(block: Block) -> Array:
    """Centres of some cells, (d, M)."""
    at = [np.unique([c // 6, c // 2, c - 1 - c // 6]) for c in block.cells]
    index = np.meshgrid(*at, indexing="ij")
    cells = np.stack([i.ravel() for i in index])
    return np.stack([block.positions([(i, i + 2) for i in cell]).mean(axis=1) for cell in cells.T], axis=1)


def _boundary(block: Block) -> Array:
    """The simplices that bound a block, oriented: (M, d corners, d)."""
    d, found = block.dimension, []
    for axis in range(d):
        for side in (0, 1):
            last = block.cells[axis] if side else 0
            where = [(last, last + 1) if k == axis else (0, c + 1) for k, c in enumerate(block.cells)]
            sizes = [c + 1 for k, c in enumerate(block.cells) if k != axis][::-1]
            X = np.moveaxis(block.positions(where).reshape(d, *sizes), 0, -1)
            pieces = _simplices(X)
            found.append(pieces if (axis + side) % 2 else pieces[:, ::-1])
    return np.concatenate(found)


def _simplices(X: Array) -> Array:
    """Points, segments or triangles of a face with nodes X (…, d)."""
    if X.ndim == 1:
        return X[None, None]
    if X.ndim == 2:
        return np.stack([X[:-1], X[1:]], axis=1)
    X = X[_some(X.shape[0])][:, _some(X.shape[1])]
    a, b, c, e = (part.reshape(-1, 3) for part in (X[:-1, :-1], X[:-1, 1:], X[1:, 1:], X[1:, :-1]))
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, e], axis=1)])


def _some(n: int) -> Array:
    return np.unique(np.linspace(0, n - 1, min(n, _MOST)).astype(int))


def _box(simplices: Array) -> tuple[Array, Array]:
    return simplices.min(axis=(0, 1)), simplices.max(axis=(0, 1))


def _winding(points: Array, simplices: Array) -> Array:
    """How often closed simplices go around each of the points (d, M): their solid angles over that of all directions.

    In 3-D after van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125-126.
    """
    return np.array([_angle(np.moveaxis(simplices - point, 0, -1)).sum() for point in points.T])


def _angle(corners: Array) -> Array:
    """Part of all directions that simplices (d corners, d, M) take, seen from 0."""
    if len(corners) == 1:
        return 0.5 * np.sign(corners[0, 0])
    volume = determinant(corners)
    if len(corners) == 2:
        a, b = corners
        return np.arctan2(volume, (a * b).sum(axis=0)) / (2.0 * np.pi)
    a, b, c = corners
    la, lb, lc = (np.sqrt((x * x).sum(axis=0)) for x in corners)
    below = la * lb * lc + (a * b).sum(axis=0) * lc + (b * c).sum(axis=0) * la + (c * a).sum(axis=0) * lb
    return np.arctan2(volume, below) / (2.0 * np.pi)
