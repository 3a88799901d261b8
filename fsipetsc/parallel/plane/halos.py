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


class Halos:
    """The halos of this rank's part of layer k in an array of all points that it holds, (height, width, DOF) doubles.

    Not collective, but all ranks of the layer must make theirs, and ``start`` and ``wait`` as often as the others do.
    """

    def __init__(self, layout: PlaneLayout, k: int, held: np.ndarray) -> None:
        self._kinds: list[MPI.Datatype] = []
        self._requests: list[MPI.Prequest] = []
        self._own: list[tuple[np.ndarray, np.ndarray]] = []  # (halo, what comes there) within this block
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
                rows, columns = slice(*given[0]), slice(*_strip(*own[1], halo, -dx, True))
                self._own.append((held[rows, slice(*taken[1])], held[rows, columns]))
                continue
            # tags: the way that it goes
            self._requests.append(comm.Send_init([held, 1, self._kind(held, *given)], rank, 4 + way))
            self._requests.append(comm.Recv_init([held, 1, self._kind(held, *taken)], rank, 4 - way))

    def _kind(self, held: np.ndarray, rows: tuple[int, int], columns: tuple[int, int]) -> MPI.Datatype:
        """Of a rectangle of points."""
        height, width, _ = held.shape
        sizes, starts = (rows[1] - rows[0], (columns[1] - columns[0]) * DOF), (rows[0], columns[0] * DOF)
        self._kinds.append(MPI.DOUBLE.Create_subarray((height, width * DOF), sizes, starts).Commit())
        return self._kinds[-1]

    def start(self) -> None:
        """Begin the exchange; the array must not change before ``wait``, but for points within."""
        if self._requests:
            MPI.Prequest.Startall(self._requests)
        for halo, values in self._own:
            halo[...] = values

    def wait(self) -> None:
        """The halos are there."""
        if self._requests:
            MPI.Request.Waitall(self._requests)

    def free(self) -> None:
        """Nothing may be under way."""
        for thing in self._requests:
            thing.Free()
        for kind in self._kinds:
            kind.Free()
        self._requests, self._kinds = [], []


def _strip(first: int, end: int, halo: int, way: int, out: bool) -> tuple[int, int]:
    """Rows or columns that go to the neighbour in a direction (-1, 0, 1), or come from there."""
    if way == 0:
        return int(first), int(end)
    edge = int(end) if way > 0 else int(first)
    inside = (way > 0) == out
    return (edge - halo, edge) if inside else (edge, edge + halo)
