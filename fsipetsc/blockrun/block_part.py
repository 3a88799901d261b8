"""What a rank's parts of gas and solid blocks have in common."""

from __future__ import annotations

import inspect
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.face_terms import FaceTerms
from fsipetsc.blockrun.saved import fields_of
from fsipetsc.checks import block_values
from fsipetsc.errors import FsiError, InputError, place_in, reason
from fsipetsc.kernels.procedure import Code, Procedure
from fsipetsc.kernels.symbols import numbers_of
from fsipetsc.parallel.block_layout import BlockLayout, Part
from fsipetsc.scheme.monitor import MONITORED
from fsipetsc.scheme.recorded_data import Recorder
from fsipetsc.scheme.sweep import in_order

Array = NDArray[Any]


class Recorded(NamedTuple):
    """What procedures of parts take beside the parts. system: of particles; found: see
    fsipetsc.scheme.runge_kutta. at_particles: block -> its faces at constraints. begins: name ->
    where a series begins in the record of a step. ends: the solid ends of interfaces in one
    dimension.
    """

    system: Any
    found: Any
    at_particles: Any
    begins: Any
    ends: Any


class BlockPart:
    """One part of a block. code: has its procedures; does: name -> procedure.

    X: (d, ghosted nodes) places in the reference map. names: of what is saved of a node.
    added: whether something adds to the rates of nodes within the block, after its sweep.
    reads_ghosted: whether something but sweeps reads the ghosted array.
    """

    added: bool
    reads_ghosted: bool

    metrics: Array

    def __init__(self, layout: BlockLayout, part: Part, order: int, form: Any) -> None:
        self.part, self._layout, self._problem = part, layout, layout.problem
        self.block, self._order, self._form = self._problem.blocks[part.k], order, form
        self._d = d = self.block.dimension
        self.names = fields_of(self.block.kind, d, self._problem.symmetry)
        self._per_h = np.array(self.block.cells, float)
        self.X = self._problem.positions(part.k, part.ghosted)
        self.owned = part.patch.ghosted_rows(np.arange(part.numbers.size))
        self.weights = part.weights(self.owned)
        self.faces = FaceTerms(self._problem, part, order, self.X)
        rows = d + 2 if self.block.kind == "fluid" else 2 * d + 1
        forced = self.block.forcing is not None
        self.forcing = np.zeros((rows, self.owned.size * forced))

    @property
    def free(self) -> list[tuple[int, int]]:
        """First node and first beyond along each axis of the ghosted array, of the owned nodes to
        whose rates nothing is added after a sweep: none of them is on a face of the block.
        """
        patch, found = self.part.patch, []
        for axis, (first, n) in enumerate(zip(patch.first, patch.own, strict=True)):
            begin, end = first, first + (0 if self.added else n)
            if axis < self._d and not self.block.periodic[axis]:
                begin_of_block = self.part.ghosted[axis][0] + first == 0
                end_of_block = self.part.ghosted[axis][0] + first + n == self.block.shape[axis]
                begin, end = begin + begin_of_block, end - end_of_block
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
        self.faces.refresh(t)
        if self.block.forcing is not None:
            self.forcing[:] = block_values(self.block, "forcing", self.X[:, self.owned], t)

    def record_data(self, recorder: Recorder) -> None:
        """Record the same, where it depends on time."""
        self.faces.record_data(recorder)
        if (forcing := self.block.forcing) is not None:

            def make(x: Any, t: Any) -> Any:
                return numbers_of(forcing(*x, t), len(self.forcing))

            recorder.add("forcing", make, self.X[:, self.owned], None, *self.forcing)

    def record(self, about: Recorded) -> Code:
        """Record the procedures of this part. InputError where a law of a case cannot be recorded,
        perhaps on this rank alone.
        """
        try:
            return self._record(about)
        except FsiError as error:
            raise InputError(f"{self.block}: {error}", collective=False) from error
        except Exception as error:
            place = place_in(error)  # in the case; else it is a fault of this program
            if not place:
                raise
            words = f"{place}: a law of {self.block} cannot be recorded: {reason(error)}"
            raise InputError(words, collective=False) from error

    def _procedures(self, text: str, record: Any, about: Recorded, names: Any) -> Code:
        """Record functions, by names, with what their parameters name beside the part's record."""
        self.code, self.does = Code(text), dict[str, Procedure]()
        found = about.found
        takes = {"particles": about.system.record, "gain": found.gain, "found": found}
        for name, function in names.items():
            beside = [takes[p] for p in inspect.signature(function).parameters if p in takes]
            self.does[name] = self.code.procedure(f"part_{name}", function, record, *beside)
        return self.code

    def _common(self, about: Recorded) -> dict[str, Any]:
        """Fields of the records of both kinds."""
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
            "per_h": self._per_h,
            "at_particles": about.at_particles[part.k],
            "forcing": self.forcing if self.block.forcing is not None else None,
            "seen": np.zeros(MONITORED),
            "level": about.begins.get("potential_energy", -1),
        }
