"""Memory of a sweep over a patch of gas, its tiles, and the weights of their pairs."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable

from fsipetsc.operators.loops import EXACT_LOOP
from fsipetsc.scheme.rows import MARGIN, ROW, TILE, U64, Array, aligned

#: rows of a tile along the second of three axes
DEPTH = 8
#: zeros between two nodes with pairs of one distance that make two spans of them
GAP = 16


class Axis(NamedTuple):
    """One axis of a patch: band, owned nodes begin … end - 1 of size, distance in memory."""

    S: Array
    weight: Array
    begin: int
    end: int
    size: int
    stride: int


class Axes(NamedTuple):
    """first: the contiguous one. last: that of the sweep. inner: the other one of three."""

    first: Axis
    inner: Axis
    last: Axis


class Tile(NamedTuple):
    """Nodes x0 … x1 - 1 along the first axis, y0 … y1 - 1 along the inner one.

    weights: where its gain and loss begin. spans, end: its spans are those from `spans` to `end`.
    """

    x0: int
    x1: int
    y0: int
    y1: int
    weights: np.uint64
    spans: int
    end: int


class Work(NamedTuple):
    """Memory of a sweep.

    w: rows of nodes with `numbers` each, `layers` layers of `depth` rows, `before` of these before
    the tile. high: sums of each row as the upper one of pairs, low: of one row as the lower one.
    slope: D_k z of one row. Of each tile along the first axis: gain, loss (tiles, K + 1, ROW), S
    over the weight of the upper and the lower node of pairs by distance, 0 where there are none;
    spans (n, 3), distance, begin and end of pairs, those of tile m from number begins[m] on. Rows 0
    of gain and loss serve the other axes. Where a constant force acts pair by pair, potential: (N,)
    Phi of the ghosted nodes, supplied: (M (d + 1),) the force on each owned node and the power of
    what diffuses, interlaced, over the node's weight (fsipetsc.scheme.gas_force); else (0,).
    """

    layers: int
    depth: int
    before: int
    numbers: int
    w: Array
    high: Array
    low: Array
    slope: Array
    gain: Array
    loss: Array
    spans: Any
    begins: Any
    potential: Array
    supplied: Array


def scratch(like: Any, force: Any, viscous: Any, bands: Any, patch: Any) -> Work:
    """Memory for `gas_rates` with the three bands of a patch."""
    d, reach, row = len(like), 1 + viscous.reach, int(ROW)
    K = [len(band.S) - 1 for band in bands]
    inner, last = (K[1], K[2]) if d == 3 else (0, K[1])
    layers, depth = reach * last + 1, (DEPTH if d == 3 else 1) + 2 * reach * inner
    gain, loss, spans, begins = _weights(bands[0], patch)
    numbers, sums = 2 * d + 6 + d * d + d * (d + 1), len(force.sums(like))
    raised, nodes = sums > d + 2, int(np.prod(patch.ghosted))
    return Work(
        layers,
        depth,
        reach * inner,
        numbers + raised,
        w=aligned(layers * depth * row * (numbers + raised)),
        high=aligned(layers * depth * row * sums),
        low=aligned(row * sums),
        slope=aligned(row * d * (d + 1)),
        gain=gain,
        loss=loss,
        spans=spans,
        begins=begins,
        potential=np.zeros(nodes * raised),
        supplied=np.zeros(int(np.prod(patch.own)) * (d + 1) * raised),
    )


def _weights(band: Any, patch: Any) -> tuple[Array, Array, Any, Any]:
    """gain, loss, spans and begins of a Work."""
    S, weight, size = band.S, band.weight, patch.ghosted[0]
    begin, own = int(patch.first[0]), int(patch.own[0])
    wide, spans, begins = tiles_of(own), [], [0]
    gain, loss = (aligned(wide * len(S) * int(ROW)).reshape(wide, len(S), -1) for _ in range(2))
    for m in range(wide):
        x0, x1 = piece(begin, begin + own, m, wide), piece(begin, begin + own, m + 1, wide)
        nodes = x0 - MARGIN + np.arange(int(ROW))
        for k in range(1, len(S)):
            column = np.flatnonzero((nodes >= 0) & (nodes < size - k))
            i = nodes[column]
            gain[m, k, column], loss[m, k, column] = S[k, i] / weight[i + k], S[k, i] / weight[i]
            found = np.flatnonzero(S[k, max(x0 - k, 0) : x1]) + max(x0 - k, 0)
            for span in np.split(found, np.flatnonzero(np.diff(found) >= GAP) + 1):
                if span.size:
                    spans.append((k, span[0], span[-1] + 1))
        begins.append(len(spans))
    listed = np.array(spans, np.int64).reshape(-1, 3)
    return gain.reshape(-1), loss.reshape(-1), listed, np.array(begins)


@register_jitable
def number_of(work, tile, layer, j):
    """Number of the row j of a layer among those in memory."""
    return U64((layer % work.layers) * work.depth + j - tile.y0 + work.before)


@register_jitable
def row_of(work, tile, layer, j):
    """Where it begins in work.w."""
    return number_of(work, tile, layer, j) * U64(work.numbers) * ROW


@register_jitable
def tiles_of(nodes):
    """Tiles along the first axis."""
    return (nodes + TILE - 1) // TILE


@register_jitable
def piece(begin, end, m, count):
    """Where piece m of so many begins."""
    return begin + (end - begin) * m // count


@njit(**EXACT_LOOP)
def clear(to, start, components, n):
    """Zeros."""
    for c in range(components):
        for i in range(n):
            to[start + U64(c) * ROW + i] = 0.0


@njit(**EXACT_LOOP)
def fill(gain, loss, upper, lower, n):
    """Weights of pairs across rows, which are the same for all nodes of a row."""
    for i in range(n):
        gain[i], loss[i] = upper, lower
