"""Area vectors of faces at particles, and how they turn; derivatives at single nodes.

The area vector of a face of axis k is +-a^k times the weights of the other axes. With x' the
velocity of the grid it turns by

    2-D      (D_2 y', -D_2 x') on faces of axis 1,   (-D_1 y', D_1 x') on those of axis 2

which takes derivatives within the face only. In 1-D it does not turn. In 3-D a^k is bilinear in
places, and turns by 1/2 (a^k(x + x') - a^k(x - x')).
"""

from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.equations.vectors import along, per, scale
from fsipetsc.kernels.loops import each, pick, variable, when
from fsipetsc.kernels.recording import Index
from fsipetsc.kernels.symbols import exact
from fsipetsc.scheme.part import moving


def turned(c, a):
    """Return c times a vector of two numbers turned to the right; a vector of another length as it
    is.
    """
    return (c * a[1], -c * a[0]) if len(a) == 2 else a


def listed(part: Any, rows: list[tuple[int, int, int, float, int]]) -> SimpleNamespace:
    """Faces of a block at members of this rank, from (row, number of the node in the block, axis,
    sign, column): row of the member in a table, node in the ghosted array, axis of the face, sign
    of its outward normal times the weights of the other axes, column of the table where its area
    vector begins.
    """
    row, number, axis, sign, column = np.array(rows).reshape(-1, 5).T
    row, number, axis, column = (i.astype(np.int64) for i in (row, number, axis, column))
    node = part.patch.ghosted_rows(part.rows(number))
    place = np.unravel_index(node, part.patch.ghosted, order="F")
    weights = np.stack([band.weight[at] for band, at in zip(part.bands, place, strict=True)])
    weight = sign * weights.prod(axis=0) / weights[axis, np.arange(axis.size)]
    return SimpleNamespace(row=row, node=node, axis=axis, weight=weight, column=column)


def turned_faces(faces: Any, patch: Any) -> list[tuple[int, int]]:
    """The faces of a patch on which there are nodes: axis and index along it."""
    strides = np.cumprod([1, *patch.ghosted[:2]])
    index = faces.node // strides[faces.axis] % np.array(patch.ghosted)[faces.axis]
    return sorted(set(zip(faces.axis.tolist(), index.tolist(), strict=True)))


def add_areas(faces, d, areas, table, less=None):
    """Add areas (d d + …, ghosted nodes), by axis and component, to the rows of a table; or half
    of what they are more than others.
    """
    for i in each(faces.row.shape[0]):
        for c in range(d):
            at = faces.axis[i] * d + c, faces.node[i]
            area = areas[at] if less is None else exact(0.5 * (areas[at] - less[at]))
            table[faces.row[i], faces.column[i] + c] += faces.weight[i] * area


def normals(part, particles):
    """Add area vectors of faces to the table of members at constraints."""
    add_areas(part.at_particles, len(part.like), part.metrics, particles.of_normals)


def turn_plane(part, table):
    """Add to a table how area vectors turn on a flat plane."""
    faces, d = part.at_particles, len(part.like)
    for i in each(faces.row.shape[0]):
        slope = slope_at(part, faces.node[i], 1 - faces.axis[i], lambda n: moving(part, n))
        turning = turned(np.where(faces.axis[i] == 0, 1.0, -1.0) * faces.weight[i], slope)
        for c in range(d):
            table[faces.row[i], faces.column[i] + c] += turning[c]


def slope_at(part, at, axis, of, own=-1.0):
    """Return D_axis of a vector at a node of the ghosted array. With own = 1 it is D°, the operator
    without the flux through the ends.

    at: number of the node. axis: known, or read from an array. of: a function that returns the
    vector at a node, a tuple.
    """
    S, (nx, ny, nz) = part.S, part.patch.ghosted
    stride, nodes = along_axis(axis, (1, nx, nx * ny)), along_axis(axis, (nx, ny, nz))
    place, here = at // stride % nodes, of(at)
    total = [variable() for _ in here]
    for k in each(1, along_axis(axis, [band.shape[0] for band in S])):
        for sign in (1, -1):
            first = place if sign > 0 else place - k
            with when((first >= 0) & (first + k < nodes)):
                band = of_axis(axis, S, k, first)
                with when(band != 0.0):
                    both = along(of(at + sign * k * stride), own, here)
                    for sum_, number in zip(total, both, strict=True):
                        sum_.value += sign * band * number
    return per(scale(0.5, tuple(sum_.value for sum_ in total)), of_axis(axis, part.weight, place))


def along_axis(axis, numbers):
    """Return the one of three whole numbers that belongs to the axis."""
    if not isinstance(axis, Index):
        return numbers[axis]
    return pick(axis == 0, numbers[0], pick(axis == 1, *numbers[1:]))


def of_axis(axis, arrays, *at):
    """Return a number of the one of three arrays that belongs to the axis."""
    if not isinstance(axis, Index):
        return arrays[axis][at]
    found = variable()
    for k, array in enumerate(arrays):
        with when(axis == k):
            found.value = array[at]
    return found.value
