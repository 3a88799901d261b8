"""Steps of the classical Runge-Kutta method of fourth order.

It is PETSc's ``-ts_type rk -ts_rk_type 4`` up to round-off, on the same right-hand side; see
fsipetsc.scheme.runge_kutta. Stages and the step are completed, see fsipetsc.blockrun.block_scheme.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fsipetsc.parallel.block_layout import BlockLayout, BlockVector
from fsipetsc.scheme.runge_kutta import further_stage, last_stage, next_stage


class FusedRK4:
    """Steps of a scheme; stage: the vector of the stages, which others may use between steps."""

    def __init__(self, layout: BlockLayout, scheme: Any, stage: BlockVector) -> None:
        self._scheme, self._stage = scheme, stage
        self._load = getattr(scheme, "load", scheme.complete)
        self._rates, self._total = np.zeros(layout.local_size), np.zeros(layout.local_size)

    def step(self, t: float, dt: float, y: BlockVector) -> None:
        """From the completed y at t [s] to the completed one at t + dt. Collective.

        It begins with what follows from y alone, so that a step after a restart has the same bits.
        """
        scheme, stage, k, total = self._scheme, self._stage, self._rates, self._total
        middle = t + 0.5 * dt
        self._load(t, y)
        scheme.rates(t, y, k)
        next_stage(y.array, k, 0.5 * dt, dt / 6.0, stage.array, total)
        scheme.complete(middle, stage)
        scheme.rates(middle, stage, k)
        further_stage(y.array, k, 0.5 * dt, dt / 3.0, stage.array, total)
        scheme.complete(middle, stage)
        scheme.rates(middle, stage, k)
        further_stage(y.array, k, dt, dt / 3.0, stage.array, total)
        scheme.complete(t + dt, stage)
        scheme.rates(t + dt, stage, k)
        last_stage(total, k, dt / 6.0, y.array)
        scheme.complete(t + dt, y)
