"""The nodes of all faces of a gas block, and how what is not known of them follows from the rest.

Nodes whose displacement is known, at solids and at walls that move, have it. Any other face is
blended from its edges, edges are linear between their vertices, and vertices that are not known do
not move (SCHEME-BLOCKS.md, section 5). Along periodic axes there are no faces. A face at r = 0 is
none, either: what lies between it and the opposite one follows this alone.
"""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numba import njit

from fsipetsc.blocks.block import Block, mesh
from fsipetsc.blocks.faces import face_nodes
from fsipetsc.checks import Array
from fsipetsc.operators.loops import CALL


class Hull(NamedTuple):
    """nodes: numbers (H,) of the nodes, ascending. given: columns (M,) of those that are known.

    columns, weights: (9, T) and (d, 4, T), of nodes that follow: the node, its edges low a, high a,
    low b, high b, four vertices; weights of the edges. moved, moving: (d, H) values.
    """

    nodes: Array
    given: Array
    columns: Array
    weights: Array
    moved: Array
    moving: Array

    def fill(self, values, known, first):
        """Complete values (d, H) from known (M, …), of which the columns from `first` count."""
        fill_hull(values, known, first, self.given, self.columns, self.weights)

    def ends(self, values):
        """Values at both ends of a block in one dimension; 0 if it is periodic."""
        return (values[0, 0], values[0, -1]) if values.size > 0 else (0.0, 0.0)


def hull_of(block: Block, given: Array, centred: bool = False) -> Hull:
    """given: numbers (M,) of the nodes that are known, in any order. centred: the block goes to
    r = 0.
    """
    d = block.dimension
    sides = [(None,) if closed else (0, 1, None) for closed in block.periodic]
    faces = [face_nodes(block.shape, k, s) for k in range(d) for s in sides[k] if s is not None]
    nodes = np.unique(np.concatenate([np.zeros(0, int), *faces]))
    known, pieces = np.isin(nodes, given), {1: [], 2: []}
    for entity in product(*sides):
        free = [k for k in range(d) if entity[k] is None and not block.periodic[k]]
        whole = _columns(block, nodes, _nodes_of(block, entity))
        if free and entity.count(None) < d and not known[whole].all():
            pieces[len(free)].append(_follows(block, nodes, entity, free, centred))
    none = np.zeros((9, 0), int), np.zeros((d, 4, 0))
    parts = (np.concatenate(p, axis=-1) for p in zip(none, *pieces[1], *pieces[2]))
    at = np.searchsorted(nodes, np.asarray(given, int))
    return Hull(nodes, at, *parts, *np.zeros((2, d, len(nodes))))


def _nodes_of(
    block: Block, entity: Sequence[int | None], inner: Sequence[int] = (), centred: bool = False
) -> list[Array]:
    """Indices (T,) along each axis of the nodes of a face, an edge, a vertex, by the side at which
    each axis is fixed, None where it is free; along some axes the inner ones only.
    """
    ranges = []
    for k, (n, side) in enumerate(zip(block.shape, entity)):
        whole, first = np.arange(n), 0 if centred and k == block.dimension - 1 else 1
        free = whole[first:-1] if k in inner else whole
        ranges.append(free if side is None else whole[-1:] if side else whole[:1])
    return [index.ravel() for index in mesh(ranges)]


def _columns(block: Block, nodes: Array, index: Sequence[Array]) -> Array:
    index = [i % n for i, n in zip(index, block.shape)]
    return np.searchsorted(nodes, np.ravel_multi_index(index[::-1], block.shape[::-1]))


def _follows(
    block: Block, nodes: Array, entity: Sequence[int | None], free: Sequence[int], centred: bool
) -> tuple[Array, Array]:
    """Columns and weights of the inner nodes of an edge or a face. The ends of an edge count as its
    edges a.
    """
    index = _nodes_of(block, entity, free, centred)
    a, b = free[0], free[-1]
    edges = [{a: 0}, {a: -1}, {b: 0}, {b: -1}]
    vertices = [{a: i, b: j} for i, j in ((0, 0), (-1, -1), (-1, 0), (0, -1))]
    columns = []
    for ends in ({}, *edges, *vertices):
        at = [i if k not in ends else 0 * i + ends[k] for k, i in enumerate(index)]
        columns.append(_columns(block, nodes, at))
    weights = np.concatenate([end_weights(block, k, index[k], centred) for k in (a, b)])
    if a == b:
        weights[2:] = 0.0
    return np.array(columns), weights.transpose(1, 0, 2)


def end_weights(block: Block, axis: int, index: Array, centred: bool = False) -> Array:
    """1 - xi and xi of nodes (2, d, N), for each component of what is blended; the same bits seen
    from both ends; 0 on a periodic axis. Along one to r = 0 a block is half of one whose other end
    is an image of the first: 0 and 1, or 0 and xi of the component along r, which is odd.
    """
    cells, d = block.cells[axis], block.dimension
    found = np.zeros((2, d, len(index)))
    if centred and axis == d - 1:
        found[1], found[1, -1] = 1.0, (index + 0.5) / (cells + 0.5)
    elif not block.periodic[axis]:
        found[0], found[1] = (cells - index) / cells, index / cells
    return found


@njit(**CALL)
def fill_hull(values, given, first, known, columns, weights):
    """Edges between their ends, then faces; sums do not depend on the order of ends and axes."""
    for c in range(values.shape[0]):
        f = values[c]
        for m in range(known.size):
            f[known[m]] = given[m, first + c]
        for t in range(columns.shape[1]):
            to, a0, a1, b0, b1, v00, v11, v10, v01 = columns[:, t]
            la, ha, lb, hb = weights[c, :, t]
            edges = (la * f[a0] + ha * f[a1]) + (lb * f[b0] + hb * f[b1])
            equal = la * lb * f[v00] + ha * hb * f[v11]
            opposite = ha * lb * f[v10] + la * hb * f[v01]
            f[to] = edges - (equal + opposite)
