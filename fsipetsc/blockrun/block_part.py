"""What a rank's parts of gas and solid blocks have in common."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.columns import fields_of
from fsipetsc.blockrun.face_terms import FaceTerms
from fsipetsc.blocks.values import block_values
from fsipetsc.errors import FsiError, InputError
from fsipetsc.parallel.block_layout import BlockLayout, Part
from fsipetsc.scheme.block_monitor import MONITORED

Array = NDArray[Any]


class BlockPart:
    """One part of a block.

    X: (d, ghosted nodes) places in the reference map. names: of what is saved of a node.
    """

    metrics: Array

    def __init__(self, layout: BlockLayout, part: Part, order: int, form: Any) -> None:
        self.part, self._layout, self._problem = part, layout, layout.problem
        self.block, self._order, self._form = self._problem.blocks[part.k], order, form
        self._d = d = self.block.dimension
        self.names = fields_of(self.block.kind, d, self._problem.symmetry)
        self._per_h = np.array(self.block.cells, float)
        self.X = self._problem.positions(part.k, part.ghosted)
        self.owned = part.ghosted_rows(np.arange(part.numbers.size))
        self.weights = part.weights(self.owned)
        self.faces = FaceTerms(self._problem, part, order, self.X)
        rows = d + 2 if self.block.kind == "fluid" else 2 * d + 1
        forced = self.block.forcing is not None
        self._forcing = np.zeros((rows, self.owned.size * forced))

    def refresh(self, t: float) -> None:
        """Data of faces and of the forcing at time t [s]. InputError."""
        self.faces.refresh(t)
        if self.block.forcing is not None:
            self._forcing[:] = block_values(self.block, "forcing", self.X[:, self.owned], t)

    def _text(self, make: Callable[..., str], *about: Any) -> str:
        """The C code that ``make`` makes of a block's equations. InputError where a law of a case
        cannot be recorded, perhaps on this rank alone.
        """
        try:
            return make(*about)
        except FsiError as error:
            raise InputError(f"{self.block}: {error}", collective=False) from error
        except Exception as error:  # of other kinds of functions, such as numba's
            reason = (str(error).strip() or repr(error)).splitlines()[0]
            words = f"a law of {self.block} cannot be recorded: {reason}"
            raise InputError(words, collective=False) from error

    def _common(self, at_particles: Any, alone: bool) -> dict[str, Any]:
        """Fields of the records of both kinds for compiled code, as `calls` has them."""
        part, d = self.part, self._d
        return {
            "like": (0.0,) * d,
            "faces": self.faces.record,
            "block": part.k,
            "begin": part.begin,
            "halo": part.local if part.has_halo else np.empty((0, part.dof)),
            "wraps": int(alone and part.has_halo),
            "signs": part.signs,
            "X": self.X,
            "metrics": self.metrics,
            "S": tuple(band.S for band in part.bands),
            "weight": tuple(band.weight for band in part.bands),
            "patch": part.patch,
            "per_h": self._per_h,
            "at_particles": at_particles,
            "forcing": self._forcing,
            "seen": np.zeros(MONITORED),
        }
