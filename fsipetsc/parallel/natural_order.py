"""From PETSc's order of the nodes of a block to the natural one, that of their numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from fsipetsc.parallel.block_layout import Part

Array = NDArray[np.float64]


class NaturalOrder:
    """Brings ``columns`` numbers of a block's nodes into natural order. Collective on its ranks.

    numbers: of the nodes that this rank holds then, which need not be those that it owns.
    """

    def __init__(self, part: Part, columns: int) -> None:
        count = len(part.numbers)
        first = part.comm.scan(count) - count
        self.numbers = np.arange(first, first + count)
        ordering = part.dm.getAO()  # of unknowns
        here = (self.numbers * part.dof).astype(PETSc.IntType)
        mine = ordering.app2petsc(here) // part.dof
        self._columns = columns
        self._own, self._there = np.empty(count * columns), np.empty(count * columns)
        self._from, self._to = (
            PETSc.Vec().createWithArray(array, bsize=columns, comm=part.comm)
            for array in (self._own, self._there)
        )
        blocks = [
            PETSc.IS().createBlock(columns, np.asarray(n, PETSc.IntType), comm=part.comm)
            for n in (mine, self.numbers)
        ]
        self._scatter = PETSc.Scatter().create(self._from, blocks[0], self._to, blocks[1])
        for block in blocks:
            block.destroy()

    def reorder(self, saved: Array) -> Array:
        """(nodes, columns), of ``numbers``, from those of the nodes that this rank owns."""
        self._own[:] = saved.reshape(-1)
        self._scatter.scatter(self._from, self._to)
        return self._there.reshape(-1, self._columns)

    def destroy(self) -> None:
        """Before the DMDA of the block."""
        for thing in (self._scatter, self._from, self._to):
            thing.destroy()
