"""Area vectors of faces at particles, and how they turn; derivatives at single nodes. Compiled.

The area vector of a face of axis k is +-a^k times the weights of the other axes. With x' the
velocity of the grid it turns by

    2-D      (D_2 y', -D_2 x') on faces of axis 1,   (-D_1 y', D_1 x') on those of axis 2

which takes derivatives within the face only. In 1-D it does not turn. In 3-D a^k is bilinear in
places, and turns by 1/2 (a^k(x + x') - a^k(x - x')): see GridMotion.turning.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import (
    CALL,
    INNER_CALL,
    along,
    by_length,
    column_of,
    per,
    scale,
)

Array = NDArray[Any]
#: c times a vector of two numbers turned to the right; a vector of another length as it is
turned = by_length(
    "turned", "c, a", lambda d: " return (c * a[1], -c * a[0])" if d == 2 else " return a"
)


class Faces(NamedTuple):
    """Faces of a block at members of this rank: row of the member in a table, node in the ghosted
    array, axis of the face, sign of its outward normal times the weights of the other axes, column
    of the table where its area vector begins.
    """

    row: Array
    node: Array
    axis: Array
    weight: Array
    column: Array


def listed(part: Any, rows: list[tuple[int, int, int, float, int]]) -> Faces:
    """From (row, number of the node in the block, axis, sign, column)."""
    row, number, axis, sign, column = np.array(rows).reshape(-1, 5).T
    row, number, axis, column = (i.astype(np.int64) for i in (row, number, axis, column))
    node = part.ghosted_rows(part.rows(number))
    nx, ny, _ = part.patch.ghosted
    place = np.stack([node % nx, node // nx % ny, node // (nx * ny)])
    weights = np.stack([band.weight[at] for band, at in zip(part.bands, place, strict=True)])
    weight = sign * weights.prod(axis=0) / weights[axis, np.arange(axis.size)]
    return Faces(row, node, axis, weight, column)


def turned_faces(faces: Faces, patch: Any) -> list[tuple[int, int]]:
    """The faces of a patch on which there are nodes: axis and index along it."""
    strides = np.cumprod([1, *patch.ghosted[:2]])
    index = faces.node // strides[faces.axis] % np.array(patch.ghosted)[faces.axis]
    return sorted(set(zip(faces.axis.tolist(), index.tolist(), strict=True)))


@njit(**CALL)
def add_areas(faces, d, areas, table):
    """Add areas (d d + …, ghosted nodes), by axis and component, to the rows of a table."""
    for i in range(faces.row.size):
        for c in range(d):
            area = areas[faces.axis[i] * d + c, faces.node[i]]
            table[faces.row[i], faces.column[i] + c] += faces.weight[i] * area


@njit(**INNER_CALL)
def turn_plane(part, table):
    """Add to a table how area vectors turn on a flat plane; in one dimension they do not."""
    faces, like, of_axes = part.at_particles, part.like, (part.S, part.weight, part.patch)
    d, velocity = len(like), Columns(part.metrics, len(like) ** 2)
    for i in range(faces.row.size if d == 2 and part.known.shape[0] > 0 else 0):
        slope = slope_at(like, faces.node[i], 1 - faces.axis[i], *of_axes, velocity)
        turning = turned(faces.weight[i] if faces.axis[i] == 0 else -faces.weight[i], slope)
        for c in range(d):
            table[faces.row[i], faces.column[i] + c] += turning[c]


class Columns(NamedTuple):
    """Numbers of a node in an array by components, from row ``first`` on."""

    array: Array
    first: int

    def at(self, like, n):
        return column_of(like, self.array, self.first, n)


@njit(**INNER_CALL)
def slope_at(like, at, axis, S, weight, patch, of, own=-1.0):
    """D_axis of a vector, ``of`` an object as Columns, at a node of the ghosted array; own = 1: D°,
    without the flux through the ends.
    """
    nx, ny, nz = patch.ghosted
    stride, nodes = (1, nx) if axis == 0 else (nx, ny) if axis == 1 else (nx * ny, nz)
    place, band, here, total = at // stride % nodes, S[axis], of.at(like, at), like
    for k in range(1, band.shape[0]):
        for sign in (1, -1):
            first = place if sign > 0 else place - k
            if first >= 0 and first + k < nodes and band[k, first] != 0.0:
                both = along(of.at(like, at + sign * k * stride), own, here)
                total = along(total, sign * band[k, first], both)
    return per(scale(0.5, total), weight[axis][place])
