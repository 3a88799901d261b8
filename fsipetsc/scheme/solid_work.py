"""What the sweeps of fsipetsc/scheme/solid.c know of a patch before a run, and their memory.

A tile is a range of nodes along the first axis, and along the second one of three; its layers along
the last axis are swept. Boxes of nodes around a tile say where what is needed: F, T and t^k where
its pairs reach, displacements where these reach in turn; conduction reaches once more.
"""

from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fsipetsc.kernels.memory import aligned
from fsipetsc.operators.bands import Band, Patch

Array = NDArray[Any]
#: kinds of derivatives: D_k and D°_k
PLAIN, FREE = range(2)
#: most nodes of a tile along the first axis, and along the second one of three, for d = 1, 2, 3
TILES = ((1024, 1), (128, 1), (64, 32))
#: longest pairs of all operators; nodes of a row with all that they reach
REACH = 7
WIDTH = 1024 + 6 * REACH
#: what is known of a tile's nodes: rates; heats; F, T and t^k; unknowns
OWN, NEAR, STRAINED, KNOWN = range(4)


class Layout(NamedTuple):
    """Of a tile's arrays, row, layer: nodes of a row and of a layer; layers: how many are kept."""

    row: int
    layer: int
    layers: int


class Work(NamedTuple):
    """What the sweeps know of a patch, and their memory. The axes are first, inner and last one.

    patch: in this order. boxes: (tiles, 4, 3, 2) first node and first beyond of OWN … KNOWN. jumps:
    (3, n, 1 + most) of each axis and node how many neighbours there are, and how far; weights: (2,
    3, n, 1 + most) S_il/(2 weight_i) of these, for PLAIN and FREE, which differ at the node itself;
    ends: the first node along the first axis, after each, for which they are others; inside: (3, 2)
    first node and first beyond of those of the interior; far: (2, layers, d pairs) of these, how
    far those of a pair are ahead and behind in a tile, by place in the ring; inner: (d pairs,)
    weights of both. In flat arrays by components, of the nodes of a tile: unknowns, strains F,
    tractions t^k, temps T, heats A^k . h; of those of a row: slopes.
    """

    patch: Patch
    layout: Layout
    boxes: Array
    jumps: Array
    weights: Array
    ends: Array
    inside: Array
    far: Array
    inner: Array
    unknowns: Array
    strains: Array
    tractions: Array
    temps: Array
    heats: Array
    slopes: Array


def solid_work(solid: Any, bands: Any, patch: Patch, pairs: int) -> Work:
    """Work for a patch with these three bands of its ghosted nodes; pairs: of a node of the
    interior, on each side.
    """
    d = len(solid.force)
    bands, patch = in_order(bands, d), Patch(*(in_order(of_axes, d) for of_axes in patch))
    conducts = int(solid.kappa > 0.0)
    tiles = tiles_of(patch, d)
    boxes = np.array([boxes_of(bands, own, conducts) for own in tiles])
    boxes[:, NEAR] *= conducts  # else no rows of heats
    row, inner = (int((b[:, 1] - b[:, 0]).max()) for b in (boxes[:, KNOWN, 0], boxes[:, KNOWN, 1]))
    reach = bands[2].reach
    layout = Layout(row, row * inner, (3 + conducts) * reach + 1)
    strains = len(solid.unstrained((0.0,) * d))
    # whole vectors, an odd number: components do not compete for one place of the fast memory
    step = 8 * (layout.layers * layout.layer // 16 * 2 + 3)
    memory = [aligned(count * step) for count in (2 * d + 1, strains, d * d, 1, d)]
    slopes = np.zeros((2 * d * d + d) * WIDTH)
    _, weights, _, inside = known = neighbours(bands, pairs)
    axes = (0, 2) if d == 2 else range(d)
    of_pairs = np.concatenate([weights[PLAIN, k, inside[k, 0], 1 : 1 + pairs] for k in axes])
    far = distances(layout, axes, pairs)
    return Work(patch, layout, boxes, *known, far, of_pairs, *memory, slopes)


def distances(layout: Layout, axes: Sequence[int], pairs: int) -> Array:
    """Return `far` of Work."""
    m, places = np.arange(1, pairs + 1), np.arange(layout.layers)[:, None]
    found = []
    for sign in (1, -1):
        in_ring = ((places + sign * m) % layout.layers - places) * layout.layer
        of_axes = [in_ring if k == 2 else sign * m * (1, layout.row)[k] for k in axes]
        found.append([np.broadcast_to(one, in_ring.shape) for one in of_axes])
    return np.ascontiguousarray(np.moveaxis(np.array(found, np.int64), 1, 2)).reshape(2, -1)


def in_order(of_axes: Any, d: int) -> Any:
    """Return three numbers in the order first axis, second one of three, last one."""
    return (of_axes[0], of_axes[2], of_axes[1]) if d == 2 else tuple(of_axes)


def tiles_of(patch: Patch, d: int) -> list[Any]:
    """Return the tiles of the owned nodes: (begin, end) along each axis."""
    cuts = []
    for first, count, most in zip(patch.first, patch.own, (*TILES[d - 1], patch.own[2])):
        ends = range(first, first + count, most)
        cuts.append([(begin, min(begin + most, first + count)) for begin in ends])
    return list(product(*cuts))


def boxes_of(bands: tuple[Band, ...], own: Any, conducts: int) -> list[Any]:
    """Return the boxes OWN … KNOWN of a tile."""

    def reached(box: Any) -> Any:
        return [reached_along(b.S, *ends) for b, ends in zip(bands, box, strict=True)]

    near = reached(own)
    strained = reached(near) if conducts else near
    return [own, near, strained, reached(strained)]


def reached_along(S: Array, begin: int, end: int) -> tuple[int, int]:
    """Return the first node and the first one beyond that have pairs with nodes begin … end - 1."""
    first = max(begin - len(S) + 1, 0)
    m, i = np.nonzero(S[:, first:end])
    i += first
    l = np.minimum(i + m, S.shape[1] - 1)
    inside = (i >= begin) | (begin <= l) & (l < end)
    return min([begin, *i[inside].tolist()]), max([end - 1, *l[inside].tolist()]) + 1


def neighbours(bands: Any, inner: int) -> tuple[Array, Array, Array, Array]:
    """jumps, weights, ends and inside of Work; inner: pairs of a node of the interior."""
    most = max(2 * band.reach + 1 for band in bands)
    shape = 3, max(len(band.weight) for band in bands), 1 + most + -most % 4
    jumps, weights = np.zeros(shape, np.int64), np.zeros((2, *shape))
    for axis, (S, weight) in enumerate(bands):
        for i in range(len(weight)):
            pairs = [(m, S[m, i]) for m in range(1, min(len(S), len(weight) - i))]
            pairs += [(-m, -S[m, i - m]) for m in range(1, min(len(S), i + 1))]
            own = sum(S_il for _, S_il in pairs)
            pairs = [(m, S_il) for m, S_il in [*pairs, (0, own)] if abs(S_il) > 1e-12]
            here = slice(1, 1 + len(pairs))
            jumps[axis, i, 0], jumps[axis, i, here] = len(pairs), [m for m, _ in pairs]
            for kind, sign in ((PLAIN, -1.0), (FREE, 1.0)):
                signed = [S_il if m else sign * S_il for m, S_il in pairs]
                weights[kind, axis, i, here] = np.array(signed) / (2.0 * weight[i])
    n = len(bands[0].weight)
    ends, all_of = np.arange(1, n + 1), np.concatenate([jumps[:1], weights[:, 0]])
    for i in range(n - 2, -1, -1):
        if np.array_equal(all_of[:, i], all_of[:, i + 1]):
            ends[i] = ends[i + 1]
    return jumps, weights, ends, np.array([band.interior(inner) for band in bands])
