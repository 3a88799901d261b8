"""From PETSc's order of the points of a layer to the natural one, row by row of the whole layer: that of result files."""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc

from fsipetsc.physics.plane.layer import DOF
from fsipetsc.scheme.plane.fields import SAVED


class NaturalOrder:
    """Brings what is saved of a layer's points into natural order. Collective on the ranks of the layer.

    numbers: of the points that this rank holds then, which need not be those that it owns.
    """

    def __init__(self, dm: PETSc.DMDA) -> None:
        (_, _), (columns, rows) = dm.getCorners()
        count, comm = columns * rows, dm.comm
        first = comm.tompi4py().scan(count) - count
        self.numbers = np.arange(first, first + count)
        ordering = dm.getAO()
        mine = ordering.app2petsc((self.numbers * DOF).astype(PETSc.IntType)) // DOF  # it numbers unknowns
        self._own, self._there = np.empty(count * SAVED), np.empty(count * SAVED)
        self._from = PETSc.Vec().createWithArray(self._own, bsize=SAVED, comm=comm)
        self._to = PETSc.Vec().createWithArray(self._there, bsize=SAVED, comm=comm)
        blocks = [PETSc.IS().createBlock(SAVED, np.asarray(n, PETSc.IntType), comm=comm) for n in (mine, self.numbers)]
        self._scatter = PETSc.Scatter().create(self._from, blocks[0], self._to, blocks[1])
        for block in blocks:
            block.destroy()

    def reorder(self, saved: np.ndarray) -> np.ndarray:
        """(points, SAVED), of ``numbers``, from the (rows, columns, SAVED) that this rank owns."""
        self._own[:] = saved.reshape(-1)
        self._scatter.scatter(self._from, self._to)
        return self._there.reshape(-1, SAVED)

    def destroy(self) -> None:
        for thing in (self._scatter, self._from, self._to):
            thing.destroy()
