"""What lies between the faces of a block in any number of dimensions: their Boolean sum. Compiled.

Axis after axis, what is missing at the two faces is added, with the weights of
fsipetsc.blocks.hull between them. On faces their values, to the bit.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from fsipetsc.blocks.block import Block, mesh
from fsipetsc.blocks.hull import end_weights
from fsipetsc.blocks.metrics import EXACT, Wide
from fsipetsc.checks import Array
from fsipetsc.operators.loops import CALL


class BlendAxis(NamedTuple):
    """An axis that has faces, in an array of nodes with both ends taken along: columns (H,) of the
    hull of the low and the high face, weights (d, n) of the ends by component, nodes of faster axes
    between neighbours.
    """

    low: Array
    high: Array
    l: Array
    h: Array
    before: int


class Blend(NamedTuple):
    """axes: of BlendAxis; u: (d, …), missing: their room; at: of the W wide nodes in it; images:
    numbers of those wide nodes that are images before a centre, whose component along r has the
    other sign.
    """

    axes: Any
    u: Array
    missing: Array
    at: Array
    images: Array

    def fill(self, values, out):
        """out (d, W) from values (d, H) of the hull."""
        blend(self, values, out)


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
        axes.append(BlendAxis(*faces, *weights, int(np.prod(sizes[:axis]))))
    if not axes:  # compiled loops over no axes have no types
        none = np.zeros(0, int)
        axes.append(BlendAxis(none, none, *np.zeros((2, d, 0)), 1))
    size = int(np.prod(sizes))
    at = np.ravel_multi_index(mesh(places)[::-1], sizes[::-1]).ravel()
    rows = max(-wide.wide[-1][0], 0) if centred else 0
    images = np.arange(rows * int(np.prod(wide.sizes[:-1])))
    return Blend(tuple(axes), np.zeros((d, size)), np.zeros((2, size)), at, images)


@njit(**CALL)
def blend(of, values, out):
    """See Blend.fill."""
    for c in range(values.shape[0]):
        u, f = of.u[c], values[c]
        u[:] = 0.0
        for axis in of.axes:
            n, before, (low, high) = axis.l.shape[1], axis.before, of.missing
            for m in range(axis.low.size):
                first = m // before * n * before + m % before
                low[m] = f[axis.low[m]] - u[first]
                high[m] = f[axis.high[m]] - u[first + (n - 1) * before]
            size = axis.low.size
            _add_between(u, low[:size], high[:size], axis.l[c], axis.h[c], before)
        for axis in of.axes:
            n, before, l, h = axis.l.shape[1], axis.before, axis.l[-1], axis.h[-1]
            for i in range(n):
                for m in range(axis.low.size if l[i] == 1.0 or h[i] == 1.0 else 0):
                    face = axis.low[m] if l[i] == 1.0 else axis.high[m]
                    u[(m // before * n + i) * before + m % before] = f[face]
        for m in range(of.at.size):
            out[c, m] = u[of.at[m]]
    for m in of.images:
        out[out.shape[0] - 1, m] *= -1.0


@njit(**CALL)
def _add_between(u, low, high, l, h, before):
    """u += l low + h high along an axis."""
    n = l.size
    for a in range(0, low.size, before):
        if before == 1:
            _add_row(u[a * n : (a + 1) * n], l, h, low[a], high[a])
            continue
        for i in range(n):
            b = a * n + i * before
            _add_row(u[b : b + before], low[a : a + before], high[a : a + before], l[i], h[i])


@njit(**EXACT)
def _add_row(u, low, high, l, h):
    for j in range(u.size):
        u[j] += l * low[j] + h * high[j]
