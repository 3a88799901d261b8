"""Metrics of a moving grid in three dimensions: fsipetsc/blocks/cube.c, and what it takes."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fsipetsc.blocks.metrics import Wide
from fsipetsc.checks import Array
from fsipetsc.kernels.memory import zeros
from fsipetsc.kernels.unit import c_source
from fsipetsc.operators.bands import Band

#: pairs of a node: see struct pairs of cube.c
MOST_PAIRS = 7
_PAIRS = np.dtype(
    [
        *((name, np.int64) for name in ("count", "even")),
        *((name, np.int64, MOST_PAIRS) for name in ("before", "after")),
        *((name, np.float64, MOST_PAIRS) for name in ("behind", "ahead")),
    ]
)


def cube_text() -> str:
    """The C code of cube_move, cube_volumes and cube_turn."""
    return c_source("fsipetsc.blocks", "cube.c")


class Cube:
    """The range of nodes of a Wide in three dimensions.

    x, v: (3, wide nodes) places less those of linear maps, and velocities. metrics: (12, N) a^1,
    a^2, a^3, by cube_move, or of these a^(only + 1) alone. volume: (N,) det D x, by cube_volumes.
    turning: (9, N) how a^i changes in time on faces, (axis i, index along it) each, by cube_turn.
    address: of the struct in C, which has whole numbers and pointers alone.
    """

    def __init__(
        self, wide: Wide, metrics: Array, faces: Sequence[Any] = (), only: int = 3
    ) -> None:
        nodes, N = wide.y.shape[1], metrics.shape[1]
        self.x, self.v = zeros((2, 3, nodes))
        self.x[:] = wide.y
        self.volume, self.turning = np.zeros(N), np.zeros((9, N))
        slots, steps = 2 * len(wide.S[2]) - 1, np.cumprod((1, *wide.sizes[:-1]))
        pairs = [_pairs(*band) for band in zip(wide.S, wide.weight, steps, strict=True)]
        q, listed = np.zeros((9, slots * steps[2])), np.array(faces, np.int64)
        room = np.zeros((3, nodes)), np.zeros((9, N)), np.zeros((9, wide.sizes[0]))
        arrays = wide.P, self.x, self.v, q, metrics, self.volume, listed, self.turning, *room
        begins = np.array([begin for begin, _ in wide.wide])
        numbers = (
            *([of_axis.ctypes.data for of_axis in pairs], [len(S) - 1 for S in wide.S], wide.sizes),
            *np.array(wide.where).T - begins,
            Band(wide.S[0], wide.weight[0]).interior(wide.order // 2),
            [array.ctypes.data for array in arrays],
            (N, len(faces), slots, only),
        )
        self._struct, self._kept = np.concatenate(numbers).astype(np.int64), (pairs, arrays)
        self.address = self._struct.ctypes.data


def _pairs(S: Array, weight: Array, step: int) -> Array:
    """Of the nodes of an axis, with so many numbers between neighbours; S, weight: of a band."""
    n, found = len(weight), np.zeros(len(weight), _PAIRS)
    for i, pairs in enumerate(found):
        pairs["even"] = 1
        for k in range(1, len(S)):
            ahead, behind = S[k, i] * (i + k < n), S[k, i - k] * (i >= k)
            if ahead or behind:
                m, half, far = pairs["count"], 0.5 / weight[i], k * step
                pairs["before"][m], pairs["after"][m] = far * (behind != 0), far * (ahead != 0)
                pairs["behind"][m], pairs["ahead"][m] = half * behind, half * ahead
                pairs["even"] &= ahead == behind
                pairs["count"] += 1
    return found
