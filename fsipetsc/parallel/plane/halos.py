"""The ghost exchange of a layer in two dimensions without PETSc's vectors: persistent messages between blocks, in place.

What a block needs of its eight neighbours, and of itself where a periodic layer is not cut along X, goes straight from the
array of the one to that of the other. It is what DMDA's globalToLocal does with a box stencil, without the copy of all else.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from mpi4py import MPI

from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.physics.plane.layer import DOF

#: what is known of a rectangle that is copied: where it goes, where it comes from, rows, doubles of each and to the next one
RECTANGLE = 5


class Halos:
    """The halos of this rank's part of layer k in an array of all points that it holds, (height, width, DOF) doubles.

    Attributes: requests, messages that all ranks of the layer must start as often as the others do; rectangles, (n, RECTANGLE),
    what is copied within the block itself, counted from ``begin`` doubles before it. Not collective.
    """

    def __init__(self, layout: PlaneLayout, k: int, held: np.ndarray, begin: int) -> None:
        self._kinds: list[MPI.Datatype] = []
        self.requests: list[MPI.Prequest] = []
        rectangles = []
        comm, share, halo = layout.dms[k].comm.tompi4py(), layout.shares[k], layout.halo
        along, across = len(share.columns) - 1, len(share.rows) - 1
        y, x = divmod(comm.rank, along)
        own = layout.records[k]["own_y"], layout.records[k]["own_x"]
        for dy, dx in product((-1, 0, 1), repeat=2):
            to_x = (x + dx) % along if layout.grids[k].periodic else x + dx
            if (dx, dy) == (0, 0) or not (0 <= to_x < along and 0 <= y + dy < across):
                continue
            rank, way = (y + dy) * along + to_x, 3 * dy + dx
            given, taken = ([_strip(*o, halo, d, out) for o, d in zip(own, (dy, dx), strict=True)] for out in (True, False))
            if rank == comm.rank:  # the layer goes on where it began
                (first, end), (to, to_end), (start, _) = given[0], taken[1], _strip(*own[1], halo, -dx, True)
                stride = held.shape[1] * DOF
                at = begin + first * stride
                rectangles.append((at + to * DOF, at + start * DOF, end - first, (to_end - to) * DOF, stride))
                continue
            # tags: the way that it goes
            self.requests.append(comm.Send_init([held, 1, self._kind(held, *given)], rank, 4 + way))
            self.requests.append(comm.Recv_init([held, 1, self._kind(held, *taken)], rank, 4 - way))
        self.rectangles = np.array(rectangles, np.int64).reshape(-1, RECTANGLE)

    def _kind(self, held: np.ndarray, rows: tuple[int, int], columns: tuple[int, int]) -> MPI.Datatype:
        """Of a rectangle of points."""
        height, width, _ = held.shape
        sizes, starts = (rows[1] - rows[0], (columns[1] - columns[0]) * DOF), (rows[0], columns[0] * DOF)
        self._kinds.append(MPI.DOUBLE.Create_subarray((height, width * DOF), sizes, starts).Commit())
        return self._kinds[-1]

    def free(self) -> None:
        """Nothing may be under way."""
        for thing in self.requests:
            thing.Free()
        for kind in self._kinds:
            kind.Free()
        self.requests, self._kinds = [], []


def _strip(first: int, end: int, halo: int, way: int, out: bool) -> tuple[int, int]:
    """Rows or columns that go to the neighbour in a direction (-1, 0, 1), or come from there."""
    if way == 0:
        return int(first), int(end)
    edge = int(end) if way > 0 else int(first)
    inside = (way > 0) == out
    return (edge - halo, edge) if inside else (edge, edge + halo)
