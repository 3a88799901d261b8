"""The fused Runge-Kutta method in two dimensions: the stages of fsipetsc.scheme.runge_kutta, each written where the next reads.

What a rank has stands in areas (fsipetsc.parallel.plane.areas), as in one dimension: a stage reads one, and sends source + a k
to another and, at edges, base + b k to the sum (fsipetsc.scheme.plane.targets). What is done in a stage is what
fsipetsc.stepping.plane.path does for PETSc, by the same compiled functions; here they are prepared for all stages before the
first step, and points of interfaces and halos come in messages of their own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.operators.formulas import in_python
from fsipetsc.operators.prepared import Prepared
from fsipetsc.operators.program import Program
from fsipetsc.parallel.plane.areas import SUM, WORK
from fsipetsc.parallel.plane.fetch import Fetch
from fsipetsc.parallel.plane.halos import Halos
from fsipetsc.scheme.plan import STAGES
from fsipetsc.scheme.plan import SUM as OTHER_SUM
from fsipetsc.scheme.plane import entries
from fsipetsc.scheme.runge_kutta import Stage, stage_of

if TYPE_CHECKING:
    from fsipetsc.stepping.plane.path import PlanePath


def _stage(number: int) -> Stage:
    """Of a step of length 1: that of one dimension, but each finds its values in an area of its own."""
    known = Stage(*in_python(stage_of)(number, 1.0))
    source, base = (SUM if area == OTHER_SUM else int(area) for area in (known.source, known.base))
    return Stage(WORK + number, WORK + (number + 1) % STAGES, source, base, known.a, known.b)


#: steps after which it pays to make a program of the calls of a step, which takes as long as some hundred of small ones
WARM = 64
_STAGES = [_stage(number) for number in range(STAGES)]


class FusedSteps:
    """Steps of the path's own; for data that do not depend on time. All but ``free`` is collective on its communicator."""

    def __init__(self, path: PlanePath) -> None:
        self._path, layout, areas, interfaces = path, path.layout, path.areas, path.interfaces
        self._behind, self._work = layout.behind, areas.behind(WORK)
        self._halos = [[Halos(layout, p.k, areas.points(p.k, n), areas.begin[p.k]) for p in path.layers] for n in range(SUM)]
        self._points = Fetch(layout, interfaces.wanted.ravel(), areas.places, interfaces.points.reshape(-1))
        places, tractions = np.arange(layout.local_size), interfaces.tractions.reshape(-1)
        self._rates = Fetch(layout, interfaces.wanted_rates.ravel(), places, tractions)
        memory, apart = areas.memory, areas.apart
        meetings, slips = interfaces.meetings, any(interfaces.slips)
        self._bring = [[self._points.prepared(memory, n * apart, self._halos[n]), *meetings] for n in range(SUM)]
        # how normals turn follows from velocities that the completion may have changed
        first = [self._points.prepared(memory, WORK * apart), *meetings] if slips else []
        self._slide = [self._rates.prepared(path.changes), *interfaces.sliding] if slips else []
        settle = [[part.settling(stage.area) for part in path.layers] for stage in _STAGES]
        before = [first, *(self._bring[stage.area] + calls for stage, calls in zip(_STAGES[1:], settle[1:], strict=True))]
        #: each with its factors, beside which it gets those times the step
        self._calls: list[tuple[Prepared, tuple[float, ...]]] = []
        for stage, calls in zip(_STAGES, before, strict=True):
            factors, (rates, ending) = (stage.a, stage.b), self._of_stage(stage)
            self._calls += [(call, ()) for call in calls] + [(call, factors) for call in rates]
            self._calls += [(call, ()) for call in self._slide] + [(call, factors) for call in ending]
        self._calls += [(call, ()) for call in self._bring[WORK]]
        self._made = 0
        self._program: Program | None = None

    def _of_stage(self, stage: Stage) -> tuple[list[Prepared], list[Prepared]]:
        """The rates, and what is left to do when they are there; both to be told a and b."""
        path = self._path
        of_layers = [part.in_stage(stage) for part in path.layers]
        behind = [path.areas.behind(area) for area in (stage.source, stage.next, stage.base, SUM)]
        if stage.base < 0:
            behind[2:] = np.empty(0), np.empty(0)
        ending = Prepared(entries.advance_behind, path.changes[self._behind], *behind)
        return [rates for rates, _ in of_layers], [*(end for _, end in of_layers), ending]

    def step(self, y: np.ndarray, dt: float) -> None:
        """Go by dt [s] from the completed solution in WORK; then WORK is raw. Of y what stands behind the points is read."""
        self._work[:] = y[self._behind]
        if self._program is None:
            for call, factors in self._calls:
                call(*(dt * factor for factor in factors))
        else:
            self._program(dt)
        self._path.state[self._behind] = self._work
        self._made += 1
        if self._made == WARM:
            self._program = Program(self._calls)

    def share(self) -> None:
        """Let halos of WORK be what the owners have."""
        self._bring[WORK][0]()

    def free(self) -> None:
        """Release the messages."""
        for thing in (*(h for several in self._halos for h in several), self._points, self._rates):
            thing.free()
        self._halos, self._calls, self._bring, self._slide, self._program = [], [], [], [], None
