"""The nodes of all faces of a gas block, and how what is not known of them follows from the rest.

Nodes whose displacement is known, at solids and at walls that move, have it. Any other face is
blended from its edges, edges are linear between their vertices, and vertices that are not known do
not move. Along periodic axes there are no faces. A face at r = 0 is none, either: what lies between
it and the opposite one follows this alone.

Inside is the Boolean sum of the faces: axis after axis, what is missing at the two faces is added,
with the weights of the ends between them. On faces their values, to the bit.
"""

from collections.abc import Mapping
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.blocks.block import Block, mesh
from fsipetsc.blocks.faces import face_nodes
from fsipetsc.blocks.metrics import Wide
from fsipetsc.checks import Array
from fsipetsc.kernels.loops import each, pick, when
from fsipetsc.kernels.symbols import exact


class Hull(NamedTuple):
    """nodes: numbers (H,) of the nodes, ascending. given: columns (M,) of those that are known.

    columns, weights: (9, T) and (d, 4, T), of nodes that follow: the node, its edges low a, high a,
    low b, high b, four vertices; weights of the edges. moved, moving: (d, H) values, one 0 where no
    node is on a face.
    """

    nodes: Array
    given: Array
    columns: Array
    weights: Array
    moved: Array
    moving: Array

    def fill(self, values, known, first):
        """Complete values (d, H) from known (M, …), of which the columns from `first` count: edges
        between their ends, then faces. Sums do not depend on the order of ends and axes.
        """
        given, columns, weights = self.given, self.columns, self.weights
        for c in each(values.shape[0]):
            f, w = values[c], weights[c]
            for m in each(given.size):
                f[given[m]] = known[m, first + c]
            for t in each(columns.shape[1]):
                a0, a1, b0, b1, v00, v11, v10, v01 = (f[columns[k, t]] for k in range(1, 9))
                la, ha, lb, hb = (w[k, t] for k in range(4))
                edges = (la * a0 + ha * a1) + (lb * b0 + hb * b1)
                vertices = (la * lb * v00 + ha * hb * v11) + (ha * lb * v10 + la * hb * v01)
                f[columns[0, t]] = exact(edges - vertices)


def hull_of(block: Block, given: Array, centred: bool = False) -> Hull:
    """given: numbers (M,) of the nodes that are known, in any order. centred: the block goes to
    r = 0.
    """
    d, last = block.dimension, [n - 1 for n in block.shape]
    sides = [(None,) if closed else (0, 1, None) for closed in block.periodic]
    faces = [face_nodes(block.shape, k, s) for k in range(d) for s in sides[k] if s is not None]
    nodes = np.unique(np.concatenate([np.zeros(0, int), *faces]))
    index = np.array(np.unravel_index(nodes, block.shape[::-1]))[::-1]
    known, columns, weights = np.isin(nodes, given), [np.zeros((9, 0), int)], [np.zeros((d, 4, 0))]

    def columns_at(at: Array, ends: Mapping[int, int]) -> Array:
        """Columns of the nodes with these indices, but for some axes, where they are at an end."""
        moved = [ends[k] * last[k] + 0 * i if k in ends else i for k, i in enumerate(at)]
        return np.searchsorted(nodes, np.ravel_multi_index(moved[::-1], block.shape[::-1]))

    for entity in sorted(product(*sides), key=lambda e: e.count(None)):  # vertices, edges, faces
        free = [k for k in range(d) if entity[k] is None and not block.periodic[k]]
        on = np.ones(len(nodes), bool)
        for k, side in enumerate(entity):
            on &= (index[k] == side * last[k]) if side is not None else True
        if not free or entity.count(None) == d or known[on].all():
            continue
        for k in free:
            on &= (index[k] >= (0 if centred and k == d - 1 else 1)) & (index[k] < last[k])
        at, a, b = index[:, on], free[0], free[-1]
        ends = {}, {a: 0}, {a: 1}, {b: 0}, {b: 1}
        vertices = ({a: i, b: j} for i, j in ((0, 0), (1, 1), (1, 0), (0, 1)))
        of_ends = [end_weights(block, k, at[k], centred) for k in (a, b)]
        if a == b:  # the ends of an edge count as its edges a
            of_ends[1][:] = 0.0
        columns.append(np.array([columns_at(at, e) for e in (*ends, *vertices)]))
        weights.append(np.concatenate(of_ends).transpose(1, 0, 2))
    table = (np.concatenate(pieces, axis=-1) for pieces in (columns, weights))
    at = np.searchsorted(nodes, np.asarray(given, int))
    return Hull(nodes, at, *table, *np.zeros((2, d, max(1, len(nodes)))))


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


class BlendAxis(NamedTuple):
    """An axis that has faces, in an array of nodes with both ends taken along: columns (H,) of the
    hull of the low and the high face, weights (d, n) of the ends by component, nodes of faster axes
    between neighbours, None if there are no such axes.
    """

    low: Array
    high: Array
    l: Array
    h: Array
    before: int | None


class Blend(NamedTuple):
    """axes: of BlendAxis; u: (d, …), missing: their room; rows: where rows of wide nodes along the
    first axis begin in it; images: numbers of those wide nodes that are images before a centre,
    whose component along r has the other sign.
    """

    axes: Any
    u: Array
    missing: Array
    rows: Array
    images: Array

    def fill(self, values, out, base=None):
        """out (d, W) from values (d, H) of the hull, added to a base (d, W) if there is one: then
        without images.
        """
        for c in each(values.shape[0]):
            u, f = self.u[c], values[c]
            for number, axis in enumerate(self.axes):
                find_missing(self, axis, u, f, number == 0)
                add_between(self, axis, u, c, number == 0)
            for axis in self.axes:
                put_faces(axis, u, f)
            n = out.shape[1] // self.rows.size
            for row in each(self.rows.size):
                first, at = self.rows[row], row * n
                for i in each(n, vector=True):
                    more = 0.0 if base is None else base[c, at + i]
                    out[c, at + i] = more + u[first + i]
        for i in each(self.images.size):
            out[-1, self.images[i]] *= -1.0


def blend_of(block: Block, wide: Wide, nodes: Array, centred: bool = False) -> Blend:
    """nodes: of the hull. centred: the block goes to r = 0."""
    d, index, places = block.dimension, [], []
    for k, (ends, n) in enumerate(zip(wide.wide, block.shape)):
        i = np.arange(*ends)
        if centred and k == d - 1:
            i = np.where(i < 0, -1 - i, i)
        if block.periodic[k]:
            index.append(i % n)
            places.append(np.arange(i.size))
        else:  # both ends are taken along
            index.append(np.concatenate([[0], np.arange(i.min(), i.max() + 1), [n - 1]]))
            places.append(1 + i - i.min())
    sizes, axes = [len(i) for i in index], []
    for axis in (k for k in range(d) if not block.periodic[k]):
        faces = []
        for end in (0, block.shape[axis] - 1):
            at = [np.array([end]) if k == axis else i for k, i in enumerate(index)]
            numbers = np.ravel_multi_index(mesh(at)[::-1], block.shape[::-1]).ravel()
            faces.append(np.searchsorted(nodes, numbers))
        weights = end_weights(block, axis, index[axis], centred)
        axes.append(BlendAxis(*faces, *weights, int(np.prod(sizes[:axis])) if axis else None))
    size = int(np.prod(sizes))
    starts = np.ravel_multi_index(mesh(places)[::-1], sizes[::-1]).ravel()
    if (np.diff(places[0]) == 1).all():  # else, along a line from a centre, each is a row
        starts = np.ascontiguousarray(starts.reshape(-1, len(places[0]))[:, 0])
    rows = max(-wide.wide[-1][0], 0) if centred else 0
    images = np.arange(rows * int(np.prod(wide.sizes[:-1])))
    return Blend(tuple(axes), np.zeros((d, size)), np.zeros((2, size)), starts, images)


def find_places(grid, X, places):
    """places = X + the displacement of a grid that blends places less those of linear maps."""
    for c in each(X.shape[0]):
        for i in each(grid.inner.size, vector=True):
            n = grid.inner[i]
            places[c, i] = X[c, i] + (grid.x[c, n] - grid.y[c, n])


def find_missing(of, axis, u, f, first):
    """What u lacks at the faces of an axis; it is 0 before the first one."""
    n, before = axis.l.shape[1], 1 if axis.before is None else axis.before
    low, high = of.missing[0], of.missing[1]
    for m in each(axis.low.size):
        at = m // before * n * before + m % before
        low[m] = f[axis.low[m]] - (0.0 if first else u[at])
        high[m] = f[axis.high[m]] - (0.0 if first else u[at + (n - 1) * before])


def add_between(of, axis, u, c, first):
    """u += l low + h high along an axis, of what is missing at its faces; u is 0 before the first
    one.
    """
    low, high, l, h = of.missing[0], of.missing[1], axis.l[c], axis.h[c]
    n, before = axis.l.shape[1], axis.before
    if before is None:
        for a in each(axis.low.size):
            for i in each(n, vector=True):
                more = exact(l[i] * low[a] + h[i] * high[a])
                u[a * n + i] = more if first else u[a * n + i] + more
        return
    for row in each(axis.low.size // before * n):
        i, a = row % n, row // n * before
        for j in each(before, vector=True):
            at, more = row * before + j, exact(l[i] * low[a + j] + h[i] * high[a + j])
            u[at] = more if first else u[at] + more


def put_faces(axis, u, f):
    """Values of faces, to the bit."""
    n, before = axis.l.shape[1], 1 if axis.before is None else axis.before
    for i in each(n):
        at_low = axis.l[-1, i] == 1.0
        with when(at_low | (axis.h[-1, i] == 1.0)):
            for m in each(axis.low.size):
                face = pick(at_low, axis.low[m], axis.high[m])
                u[(m // before * n + i) * before + m % before] = f[face]
