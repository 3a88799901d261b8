"""Metrics of a moving grid in three dimensions: fsipetsc/blocks/cube.c, and what it takes."""

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np

from fsipetsc.blocks.metrics import Wide
from fsipetsc.checks import Array
from fsipetsc.kernels.memory import zeros
from fsipetsc.kernels.unit import c_source
from fsipetsc.operators.bands import Band

_POINTER, _NUMBER = ctypes.c_void_p, ctypes.c_long
#: pairs of a node: see struct pairs of cube.c
MOST_PAIRS = 7
_PAIRS = np.dtype(
    [
        *((name, np.int64) for name in ("count", "even")),
        *((name, np.int64, MOST_PAIRS) for name in ("before", "after")),
        *((name, np.float64, MOST_PAIRS) for name in ("behind", "ahead")),
    ]
)


class _Cube(ctypes.Structure):
    _fields_ = [
        ("pairs", _POINTER * 3),
        *((name, _NUMBER * 3) for name in ("reach", "size", "first", "end")),
        ("inner", _NUMBER * 2),
        ("P", ctypes.c_double * 9),
        *((name, _POINTER) for name in ("x", "v", "q", "metrics", "volume", "faces", "turning")),
        *((name, _POINTER) for name in ("moved", "other", "rows")),
        *((name, _NUMBER) for name in ("N", "count", "slots", "only")),
    ]


def cube_text() -> str:
    """The C code of cube_move, cube_volumes and cube_turn."""
    return c_source("fsipetsc.blocks", "cube.c")


class Cube:
    """The range of nodes of a Wide in three dimensions.

    x, v: (3, wide nodes) places less those of linear maps, and velocities. metrics: (12, N) a^1,
    a^2, a^3, by cube_move, or of these a^(only + 1) alone. volume: (N,) det D x, by cube_volumes.
    turning: (9, N) how a^i changes in time on faces, (axis i, index along it) each, by cube_turn.
    address: of the struct in C.
    """

    def __init__(
        self, wide: Wide, metrics: Array, faces: Sequence[Any] = (), only: int = 3
    ) -> None:
        nodes = wide.y.shape[1]
        self.x, self.v = zeros((2, 3, nodes))
        self.x[:] = wide.y
        self.volume, self.turning = np.zeros(metrics.shape[1]), np.zeros((9, metrics.shape[1]))
        slots, steps = 2 * len(wide.S[2]) - 1, np.cumprod((1, *wide.sizes[:-1]))
        bands = zip(wide.S, wide.weight, steps, strict=True)
        pairs_of_axes = [_pairs(*band) for band in bands]
        memory = {
            "moved": np.zeros((3, nodes)),
            "other": np.zeros((9, metrics.shape[1])),
            "rows": np.zeros((9, wide.sizes[0])),
            "faces": np.array(faces, np.int64),
            "metrics": metrics,
            "q": np.zeros((9, slots * steps[2])),
        }
        self._kept = pairs_of_axes, memory
        ranges = list(zip(wide.where, wide.wide, strict=True))
        self._struct = _Cube(
            pairs=(_POINTER * 3)(*(of_axis.ctypes.data for of_axis in pairs_of_axes)),
            reach=(_NUMBER * 3)(*(len(of_axis) - 1 for of_axis in wide.S)),
            size=(_NUMBER * 3)(*wide.sizes),
            first=(_NUMBER * 3)(*(begin - wide_begin for (begin, _), (wide_begin, _) in ranges)),
            end=(_NUMBER * 3)(*(end - wide_begin for (_, end), (wide_begin, _) in ranges)),
            inner=(_NUMBER * 2)(*Band(wide.S[0], wide.weight[0]).interior(wide.order // 2)),
            P=(ctypes.c_double * 9)(*wide.P.ravel()),
            **{name: getattr(self, name).ctypes.data for name in ("x", "v", "volume", "turning")},
            **{name: array.ctypes.data for name, array in memory.items()},
            N=metrics.shape[1],
            count=len(faces),
            slots=slots,
            only=only,
        )
        self.address = ctypes.addressof(self._struct)


def _pairs(S: Array, weight: Array, step: int) -> Array:
    """Of the nodes of an axis, with so many numbers between neighbours; S, weight: of a band."""
    n, found = len(weight), np.zeros(len(weight), _PAIRS)
    for i, pairs in enumerate(found):
        pairs["even"] = 1
        for k in range(1, len(S)):
            ahead = S[k, i] if i + k < n else 0.0
            behind = S[k, i - k] if i >= k else 0.0
            if ahead or behind:
                m, half = pairs["count"], 0.5 / weight[i]
                pairs["before"][m], pairs["after"][m] = (
                    k * step * (behind != 0),
                    k * step * (ahead != 0),
                )
                pairs["behind"][m], pairs["ahead"][m] = half * behind, half * ahead
                pairs["even"] &= ahead == behind
                pairs["count"] += 1
    return found
