"""The fused Runge-Kutta method in two dimensions: the stages of fsipetsc.scheme.runge_kutta, each written where the next reads.

The points that a rank holds of a layer stand in areas, as in one dimension: a stage reads one, and sends source + a k to
another and base + b k to the sum. Of the world vector only that is kept up which others fetch: the rows at interfaces, and
what stands behind the layers. Everything else is fsipetsc.stepping.plane.path, whose right-hand side this is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.operators.formulas import in_python
from fsipetsc.parallel.plane.halos import Halos
from fsipetsc.scheme.plan import STAGES
from fsipetsc.scheme.runge_kutta import Stage, stage_of

if TYPE_CHECKING:
    from fsipetsc.stepping.plane.path import PlanePath

#: as in one dimension: that of the solution, those of the two other stages between them, the sum
WORK, SUM, AREAS = 0, 3, 4
#: of a step of length 1
_STAGES = [Stage(*map(int, stage[:4]), *stage[4:]) for stage in (in_python(stage_of)(n, 1.0) for n in range(STAGES))]


class FusedSteps:
    """Steps of the path's own; for data that do not depend on time. All but ``free`` is collective on its communicator."""

    def __init__(self, path: PlanePath) -> None:
        self._path, layout = path, path.layout
        behind = slice(int(layout.starts[len(layout.grids)]), None)
        self._state, self._changes = path.state[behind], path.changes[behind]
        self._behind = list(np.zeros((AREAS, self._state.size)))
        self._halos = [[Halos(layout, part.k, part.areas[n]) for part in path.layers] for n in range(SUM)]
        parts = [(part, layout.local(part.k, path.state)) for part in path.layers]
        self._rows = [(part, world, row) for part, world in parts for row in part.interface_rows()]

    def step(self, y: np.ndarray, t: float, dt: float) -> None:
        """Go by dt [s] from the completed solution at t [s], this rank's part y, which WORK holds, too; then WORK is raw."""
        self._behind[WORK][:] = y[y.size - self._state.size :]
        for number, stage in enumerate(_STAGES):
            if number > 0:
                self.bring(stage.area)
                self._path.put_in_place(t)
            elif any(self._path.interfaces.slips):
                self._meet(WORK)  # how normals turn follows from velocities that the completion may have changed
            a, b = dt * stage.a, dt * stage.b
            for part in self._path.layers:
                part.begin_stage(stage, a, b)
            self._path.evaluate(t)
            for part in self._path.layers:
                part.end_stage()
            behind = self._behind
            np.add(behind[stage.source], a * self._changes, out=behind[stage.next])
            if stage.base >= 0:
                np.add(behind[stage.base], b * self._changes, out=behind[SUM])

    def bring(self, area: int = WORK) -> None:
        """Exchange halos of an area, and solve for what gas and solid have together at interfaces."""
        for halos in self._halos[area]:
            halos.start()
        self._meet(area)
        for halos in self._halos[area]:
            halos.wait()

    def _meet(self, area: int) -> None:
        """Solve for what gas and solid have together, from the points in an area, which is in use then."""
        for part in self._path.layers:
            part.use(area)
        for part, world, row in self._rows:
            world[row] = part.own[row]
        self._state[:] = self._behind[area]
        self._path.interfaces.meet()

    def free(self) -> None:
        """Release the messages."""
        for halos in (h for several in self._halos for h in several):
            halos.free()
        self._halos = []
