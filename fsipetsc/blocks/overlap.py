"""Do blocks overlap? Points inside one block are sought in the others by winding numbers."""

from collections.abc import Sequence
from itertools import combinations, product

import numpy as np

from fsipetsc.blocks.block import Block, determinant, mesh
from fsipetsc.blocks.maps import place_text
from fsipetsc.checks import Array
from fsipetsc.errors import InputError

#: cells along an axis of a face of a block in 3-D, of which triangles are made
_MOST = 64


def check_overlap(blocks: Sequence[Block]) -> None:
    """InputError where a point inside one block is inside another; of each, 3^d cells are tried."""
    bounds = [_boundary(block) for block in blocks]
    boxes = [(bound.min(axis=(0, 1)), bound.max(axis=(0, 1))) for bound in bounds]
    for a, b in combinations(range(len(blocks)), 2):
        (low, high), (other_low, other_high) = boxes[a], boxes[b]
        if np.any(low >= other_high) or np.any(other_low >= high):
            continue
        for inner, outer in ((a, b), (b, a)):
            for point in _inside(blocks[inner]):
                if abs(_angles(np.moveaxis(bounds[outer] - point, 0, -1)).sum()) > 0.5:
                    where = f"{blocks[a]} and {blocks[b]} overlap at {place_text(point)}"
                    raise InputError(f"{where}: expected blocks that meet at faces only")


def _inside(block: Block) -> Array:
    """Centres of some cells, (M, d)."""
    cells = product(*({c // 6, c // 2, c - 1 - c // 6} for c in block.cells))
    return np.array([block.positions([(i, i + 2) for i in cell]).mean(axis=1) for cell in cells])


def _boundary(block: Block) -> Array:
    """The points, segments or triangles that bound a block, oriented: (M, d corners, d)."""
    d, found = block.dimension, []
    for axis, side in product(range(d), (0, 1)):
        index = [np.arange(c + 1) for c in block.cells]
        if d == 3:
            numbers = (min(c, _MOST) + 1 for c in block.cells)
            index = [np.linspace(0, i[-1], n).astype(int) for i, n in zip(index, numbers)]
        index[axis] = index[axis][-1:] if side else index[axis][:1]
        X = np.squeeze(block.places(mesh(index)), axis=d - axis)
        pieces = _simplices(np.moveaxis(X, 0, -1))
        found.append(pieces if (axis + side) % 2 else pieces[:, ::-1])
    return np.concatenate(found)


def _simplices(X: Array) -> Array:
    """Those of a face with nodes X (…, d)."""
    if X.ndim == 1:
        return X[None, None]
    if X.ndim == 2:
        return np.stack([X[:-1], X[1:]], axis=1)
    corners = X[:-1, :-1], X[:-1, 1:], X[1:, 1:], X[1:, :-1]
    a, b, c, e = (X.reshape(-1, 3) for X in corners)
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, e], axis=1)])


def _angles(corners: Array) -> Array:
    """Part of all directions that simplices (d corners, d, M) take, seen from 0.

    In 3-D: van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125-126.
    """
    if len(corners) == 1:
        return 0.5 * np.sign(corners[0, 0]) * np.array([-1.0, 1.0])
    volume = determinant(corners)
    if len(corners) == 2:
        return np.arctan2(volume, (corners[0] * corners[1]).sum(axis=0)) / (2.0 * np.pi)
    a, b, c = corners
    la, lb, lc = (np.sqrt((x * x).sum(axis=0)) for x in corners)
    ab, bc, ca = ((x * y).sum(axis=0) for x, y in ((a, b), (b, c), (c, a)))
    return np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb) / (2.0 * np.pi)
