"""Area vectors of faces at particles, and how they turn. Compiled.

The area vector of a face of axis k is +-a^k times the weights of the other axes. With x' the
velocity of the grid it turns by

    2-D      (D_2 y', -D_2 x') on faces of axis 1,   (-D_1 y', D_1 x') on those of axis 2

which takes derivatives within the face only. In 1-D it does not turn. In 3-D a^k is bilinear in
places, and turns by 1/2 (a^k(x + x') - a^k(x - x')): see GridMotion.turning.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fsipetsc.operators.loops import CALL, INNER_CALL

Array = NDArray[Any]


class Faces(NamedTuple):
    """Faces of a block at members of this rank: row of the member in a table, node in the ghosted
    array and its places along the three axes, axis of the face, sign of its outward normal times
    the weights of the other axes, column of the table where its area vector begins.
    """

    row: Array
    node: Array
    place: Array
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
    return Faces(row, node, place, axis, weight, column)


@njit(**CALL)
def add_areas(faces, d, areas, table):
    """Add areas (d d + …, ghosted nodes), by axis and component, to the rows of a table."""
    for i in range(faces.row.size):
        for c in range(d):
            area = areas[faces.axis[i] * d + c, faces.node[i]]
            table[faces.row[i], faces.column[i] + c] += faces.weight[i] * area


@njit(**INNER_CALL)
def derivative(S, weight, stride, values, at, place, own=-1.0):
    """D of values (ghosted nodes,) at node ``at``, which is number ``place`` along the axis; own =
    1: D°, without the flux through the ends.
    """
    total = 0.0
    for k in range(1, S.shape[0]):
        if place + k < S.shape[1] and S[k, place] != 0.0:
            total += S[k, place] * (values[at + k * stride] + own * values[at])
        if place - k >= 0 and S[k, place - k] != 0.0:
            total -= S[k, place - k] * (values[at - k * stride] + own * values[at])
    return 0.5 * total / weight


@njit(**INNER_CALL)
def sum_members(particle, row, table, total):
    """Add rows of members, in their order, to particles; total: (p, K, n), table: (rows, K n)."""
    total[:] = 0.0
    n = total.shape[2]
    for m in range(particle.size):
        for c in range(table.shape[1]):
            total[particle[m], c // n, c % n] += table[row[m], c]


@njit(**INNER_CALL)
def turn_plane(part, table):
    """Add to a table how area vectors turn on a flat plane; in one dimension they do not."""
    faces, metrics = part.at_particles, part.metrics
    nx, d = part.patch.ghosted[0], len(part.like)
    for i in range(faces.row.size if d == 2 and part.known.shape[0] > 0 else 0):
        axis, other = faces.axis[i], 1 - faces.axis[i]
        place, stride = faces.place[other, i], nx if other == 1 else 1
        band = part.S[other], part.weight[other][place], stride
        x = derivative(*band, metrics[d * d], faces.node[i], place)
        y = derivative(*band, metrics[d * d + d - 1], faces.node[i], place)
        sign = faces.weight[i] if axis == 0 else -faces.weight[i]
        table[faces.row[i], faces.column[i]] += sign * y
        table[faces.row[i], faces.column[i] + d - 1] -= sign * x
