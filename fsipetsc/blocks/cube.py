"""Metrics of a moving grid in three dimensions: fsipetsc/blocks/cube.c, and what it takes."""

import ctypes
from collections.abc import Iterable

import numpy as np

from fsipetsc.blocks.metrics import Wide
from fsipetsc.checks import Array
from fsipetsc.kernels.unit import c_source

_POINTER, _NUMBER = ctypes.c_void_p, ctypes.c_long


class _Cube(ctypes.Structure):
    _fields_ = [
        *((name, _POINTER * 3) for name in ("S", "half")),
        *((name, _NUMBER * 3) for name in ("reach", "size", "first", "end")),
        ("inner", _NUMBER * 2),
        ("P", ctypes.c_double * 9),
        *((name, _POINTER) for name in ("x", "v", "q", "metrics", "volume", "faces", "of_faces")),
        *((name, _NUMBER) for name in ("N", "count")),
    ]


def cube_text() -> str:
    """The C code of cube_move, cube_volumes, cube_swing, cube_faces and cube_turn."""
    return c_source("fsipetsc.blocks", "cube.c")


class Cube:
    """The range of nodes of a Wide in three dimensions.

    x, v: (3, wide nodes) places less those of linear maps, and velocities. metrics: (13, N) a^1,
    a^2, a^3, velocity, J_t of the range. volume: (N,) det D x, by
    cube_volumes. of_faces: (9, N) a^1, a^2, a^3 on
    faces, by cube_faces, or how they change in time, by cube_turn. address: of the struct in C.
    """

    def __init__(self, wide: Wide, metrics: Array) -> None:
        nodes = wide.y.shape[1]
        self.x, self.v = wide.y.copy(), np.zeros((3, nodes))
        self.volume, self.of_faces = np.zeros(metrics.shape[1]), np.zeros((9, metrics.shape[1]))
        half, q = [0.5 / weight for weight in wide.weight], np.zeros((9, nodes))
        S = [np.ascontiguousarray(of_axis) for of_axis in wide.S]
        self._kept = half, q, metrics, S
        pairs = list(zip(wide.where, wide.wide, strict=True))
        self._struct = _Cube(
            S=(_POINTER * 3)(*(of_axis.ctypes.data for of_axis in S)),
            half=(_POINTER * 3)(*(of_axis.ctypes.data for of_axis in half)),
            reach=(_NUMBER * 3)(*(len(of_axis) - 1 for of_axis in S)),
            size=(_NUMBER * 3)(*wide.sizes),
            first=(_NUMBER * 3)(*(begin - wide_begin for (begin, _), (wide_begin, _) in pairs)),
            end=(_NUMBER * 3)(*(end - wide_begin for (_, end), (wide_begin, _) in pairs)),
            inner=(_NUMBER * 2)(*_inner(S[0], half[0])),
            P=(ctypes.c_double * 9)(*wide.P.ravel()),
            **{name: getattr(self, name).ctypes.data for name in ("x", "v", "volume", "of_faces")},
            q=q.ctypes.data,
            metrics=metrics.ctypes.data,
            N=metrics.shape[1],
        )
        self.address = ctypes.addressof(self._struct)

    def name_faces(self, faces: Iterable[tuple[int, int]]) -> None:
        """Let cube_faces and cube_turn take these faces: (axis i, index along it) each; of these
        they find a^i alone.
        """
        self._faces = np.array([*faces], np.int64).reshape(-1, 2)
        self._struct.faces, self._struct.count = self._faces.ctypes.data, len(self._faces)


def _inner(S: Array, half: Array) -> tuple[int, int]:
    """First node and first beyond of the most nodes side by side that have the same pairs as the
    node in the middle.
    """
    n = S.shape[1]
    columns = np.zeros((2 * len(S) + 1, n))
    columns[-1] = half
    for k in range(1, min(len(S), n)):
        columns[k, : n - k] = S[k, : n - k]
        columns[len(S) + k, k:] = S[k, : n - k]
    differs = np.flatnonzero((columns != columns[:, [n // 2]]).any(axis=0))
    below, above = differs[differs < n // 2], differs[differs > n // 2]
    return int(below.max(initial=-1)) + 1, int(above.min(initial=n))
