"""What a rank's parts of gas and solid blocks have in common."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.face_terms import FaceTerms
from fsipetsc.blockrun.saved import fields_of
from fsipetsc.checks import block_values
from fsipetsc.kernels.procedure import Code, Procedure
from fsipetsc.kernels.symbols import Symbol, numbers_of
from fsipetsc.parallel.block_layout import BlockLayout, Part
from fsipetsc.scheme.monitor import MONITORED
from fsipetsc.scheme.part import Nothing
from fsipetsc.scheme.recorded_data import Source
from fsipetsc.scheme.sweep import in_order

Array = NDArray[Any]


class BlockPart:
    """One part of a block. code: has its procedures; does: name -> procedure.

    X: (d, ghosted nodes) places in the reference map. names: of what is saved of a node. sources:
    of data that may depend on time. at_particles: faces at constraints, known once there are
    particles. added: whether something adds to the rates of nodes within the block, after its
    sweep. reads_ghosted: whether something but sweeps reads the ghosted array.
    """

    added: bool
    metrics: Array
    at_particles: Any
    _record: Any  # (system, begins) -> the text of its kernels, its record, what becomes procedures

    def __init__(self, layout: BlockLayout, part: Part, order: int, form: Any) -> None:
        self.part, self._layout, self._problem = part, layout, layout.problem
        self.block, self._order, self._form = self._problem.blocks[part.k], order, form
        self._d = d = self.block.dimension
        self.names = fields_of(self.block.kind, d, self._problem.symmetry)
        self.X = self._problem.positions(part.k, part.ghosted)
        self.owned = part.patch.ghosted_rows(np.arange(part.numbers.size))
        self.weights = part.weights(self.owned)
        self.faces = FaceTerms(self._problem, part, order, self.X)
        self.sources, self.forcing = self.faces.sources, None
        self.reads_ghosted = not isinstance(self.faces.record, Nothing)
        if self.block.forcing is not None:
            rows, x = d + 2 if self.block.kind == "fluid" else 2 * d + 1, self.X[:, self.owned]
            self.forcing = np.zeros((rows, self.owned.size))
            self.sources.append(Source("forcing", self._forced, x, None, *self.forcing))

    def _forced(self, x: Any, t: Any) -> Any:
        """The forcing, of numbers or symbols."""
        if isinstance(t, Symbol):
            return numbers_of(self.block.forcing(*x, t), len(self.forcing))
        return block_values(self.block, "forcing", x, t)

    @property
    def free(self) -> list[tuple[int, int]]:
        """First node and first beyond along each axis of the ghosted array, of the owned nodes to
        whose rates nothing is added after a sweep: none of them is on a face of the block.
        """
        patch, found = self.part.patch, []
        for axis, (first, n) in enumerate(zip(patch.first, patch.own, strict=True)):
            begin, end = first, first + (0 if self.added else n)
            if axis < self._d and not self.block.periodic[axis]:
                at = self.part.ghosted[axis][0] + first
                begin, end = begin + (at == 0), end - (at + n == self.block.shape[axis])
            found.append((begin, max(begin, end)))
        return found

    @property
    def free_nodes(self) -> Array:
        """(M,) whether an owned node is one of ``free``."""
        patch = self.part.patch
        found = np.zeros(patch.own[::-1], bool)
        ends = zip(self.free, patch.first, strict=True)
        found[tuple(slice(a - first, b - first) for (a, b), first in ends)[::-1]] = True
        return found.reshape(-1)

    def refresh(self, t: float) -> None:
        """Data of faces and of the forcing at time t [s]. InputError."""
        for one in self.sources:
            one.fill(t)
        self.faces.check(t)

    def record(self, system: Any, found: Any, begins: Mapping[str, int]) -> Code:
        """Record the procedures of this part. InputError, perhaps on this rank alone.

        system: of particles; found: see fsipetsc.scheme.runge_kutta; begins: name -> where a series
        begins in the record of a step.
        """
        text, record, functions = self._record(system, begins)
        self.code, self.does = Code(text), dict[str, Procedure]()
        takes = {"particles": system.record, "gain": found.gain, "found": found}
        for f in functions:  # they take what their parameters name
            beside = [takes[p] for p in inspect.signature(f).parameters if p in takes]
            self.does[f.__name__] = self.code.procedure(f"part_{f.__name__}", f, record, *beside)
        return self.code

    def _common(self, begins: Mapping[str, int]) -> dict[str, Any]:
        part, d = self.part, self._d
        return {
            "like": (0.0,) * d,
            "free": in_order(self.free, d),
            "faces": self.faces.record,
            "block": part.k,
            "begin": part.begin,
            "halo": part.local if part.has_halo else np.empty((part.dof, 0)),
            "signs": part.signs,
            "X": self.X,
            "metrics": self.metrics,
            "S": tuple(np.ascontiguousarray(band.S) for band in part.bands),
            "weight": tuple(np.ascontiguousarray(band.weight) for band in part.bands),
            "patch": part.patch,
            "per_h": np.array(self.block.cells, float),
            "at_particles": self.at_particles,
            "forcing": self.forcing,
            "seen": np.zeros(MONITORED),
            "level": begins.get("potential_energy", -1),
        }
