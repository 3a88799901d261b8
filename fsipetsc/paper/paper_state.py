"""The state of a run of the paper's method: what fsipetsc.stepping drives.

One evaluation of the right-hand side:

    1  interfaces   the owners of the two sides of an interface swap the rows that D reaches from
                    it, and each of them solves the same small system      (Thm 4.1, Sec. 4.2)
    2  frames       the owner of a gas's interface point tells the layer its velocity s and its
                    place x_I                                              (4.20), (4.25)
    3  halos        neighbours fill the local arrays: twice the reach of D, because D acts twice
    4  points       ghost points (4.26), then the rates of all points      (4.19), (4.20)

Interfaces come before halos, so that neighbours of an owner get rows that fulfil the conditions.
The point arithmetic is the same on any number of ranks, and nothing is added up over ranks: so are
the results, bit for bit.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.paper import steps
from fsipetsc.paper.layout import check_ends
from fsipetsc.paper.solution import PaperSolution
from fsipetsc.process.together import agree, together
from fsipetsc.scheme.batch import ALLOWED, DT, MADE, TIME
from fsipetsc.scheme.plan import BAD, SAID_STOP
from fsipetsc.state import FAULT, as_numbers, crushed, whole

Array = np.ndarray
#: times of the stages, in steps
FRACTIONS = 0.0, 0.5, 0.5, 1.0
#: of the record of a layer: what all ranks learn after a step, beside its rates
FRAME = "lo", "hi", "s", "x_interface"


def loose_forces(state: PaperSolution) -> list[str]:
    """Forces that do not keep rest. Of blocks more may be said: here frames are cut where walls
    are, and the couplings bring stresses together.
    """
    return [
        f"the force on '{layer.name}' is added node by node: a gas at rest stays so to the order "
        "of the scheme only, and small motions may grow; -fsi_coupling conservative keeps rest"
        for layer in state.problem.layers
        if layer.kind == "fluid" and any(layer.material.force)
    ]


class PaperState(PaperSolution):
    """A run in the paper's method: its data, steps and checkpoints; all methods are collective on
    ``comm``.
    """

    NOTES = MappingProxyType({"begin": (loose_forces,)})
    fault: InputError | None = None
    _kept: tuple[Array, ...] = ()  # what the last call of ``step`` began with

    # data

    def set_data(self, t: float) -> None:
        """Evaluate boundary data, jumps and forcing at time t [s] for the next evaluation of the
        right-hand side.

        If a function of the user's fails, here alone perhaps, the data stay as they are, the step
        goes on, and all ranks learn of it when it is complete: see ``fault``.
        """
        try:
            self._set_data(t)
        except InputError as error:
            self.fault = self.fault or error
            self.results[SAID_STOP] = FAULT

    def _set_data(self, t: float) -> None:
        problem, records = self.problem, self.records
        for k, side, end in ((0, 0, problem.left), (-1, 1, problem.right)):
            values = end.data(t)
            records[k]["end_data"][side, : len(values)] = values
            records[k]["end_heat"][side] = end.heat(t)
        if problem.jumps is not None:
            for k, interface in enumerate(self.interfaces):
                interface.jump[:] = problem.jumps_at(k, t)
        for part in self.here:
            if part.forcing is not None:
                values = part.layer.values("forcing", part.X, t, part.active)
                part.forcing[:] = 0.0
                part.forcing[part.active] = np.stack(values, axis=-1)[part.active]

    def check_data(self) -> None:
        """Fill the solution, not projected, with initial data, and ask for all else at t = 0.

        InputError, on all ranks, where something is not what it must be.
        """

        def set_layers() -> list[dict[tuple[int, int], float]]:
            return [part.set_initial(part.of(self.y)) for part in self.here]

        found = self.comm.allgather(together(self.comm, set_layers))
        ends = {end: x for mine in found for layer in mine for end, x in layer.items()}
        check_ends(self.problem, ends, self.h)
        self.set_data(0.0)
        agree(self.comm, self.fault)

    def check_motion(self, t_end: float) -> None:
        """Do nothing: walls are at rest (fsipetsc.paper.layout.check_form)."""

    def set_initial(self) -> None:
        """Initial data of all layers, projected. InputError where they are not what they must
        be."""
        self.check_data()
        self.finish()

    # steps

    def right_hand_side(self, y: Array, f: Array) -> None:
        """f = dy/dt of this rank's part, at the projected y, for the data set last."""
        self.evaluations += 1
        self._load(y)
        self.fulfil()
        self.stages[steps.RATES_ALONE]()
        f[:] = self.k

    def _complete(self) -> None:
        """Project the stage, which is the new solution, let boundaries move, and monitor it."""
        self.fulfil()
        self.completing()

    def finish(self) -> None:
        """Complete a step whose raw result PETSc has left in the solution."""
        self._load(self.y)
        self._complete()

    def step(self, t: float, dt: float, steady: bool) -> None:
        """A step dt [s] of the classical Runge-Kutta method from the completed solution at t [s],
        and its completion.

        The others of its batch follow. steady: the data do not depend on time; all steps are one
        call of C then.
        """
        self.batch[DT] = dt
        changed = self.y, self.records, self.results, self.batch
        self._kept = tuple(array.copy() for array in changed)
        if steady:
            self.whole_step.batch(self.results[BAD:], self.batch[ALLOWED:])
            self.evaluations += steps.STAGES * max(1, int(self.batch[MADE]))
            return
        more = True
        while more:
            self.evaluations += steps.STAGES
            self._advance(t, dt, steady)
            more, dt = self.plan_next(), self.batch[DT]

    def _advance(
        self, t: float, dt: float, steady: bool, ends: Callable[[], Any] = lambda: None
    ) -> bool:
        """A step of the length that batch has, dt [s]; ends: called with each stage that fulfils
        the conditions, and with the completed one. Where it returns something, the step ends, and
        returns True.
        """
        for number, fraction in enumerate(FRACTIONS):
            if not steady:
                self.set_data(t + fraction * dt)
            if number > 0:  # it begins with the completed solution
                self.fulfil()
                if ends():
                    return True
            self.stages[number]()
        if not steady:
            self.set_data(t + dt)
        self._complete()
        return bool(ends())

    def go_to_fault(self, unphysical: Callable[[], Any]) -> str:
        """Repeat the steps since the last call of ``step`` up to the first unphysical stage: NaN
        spreads from there. Steps of PETSc's methods are not repeated.
        """
        if not self._kept:
            return ""
        self.y[:], records, self.results[:], self.batch[:] = self._kept
        for name in FRAME:
            self.records[name] = records[name]
        self._begin()
        said, more = "", True
        while more:
            said = self._crushed()
            t, dt = self.batch[[TIME, DT]].tolist()
            more = (
                not self._advance(t, dt, self.problem.steady_data, unphysical) and self.plan_next()
            )
        return said

    def _crushed(self) -> str:
        """Where the solid is crushed most, if it is. Collective."""
        mine = [(*part.shortest(), part.number) for part in self.here if not part.is_gas]
        every = (one for some in self.comm.allgather(mine) for one in some)
        stretch, node, X, push, k = min(every)
        layer = self.problem.layers[k]
        where = f"'{layer.name}' at X = {X:.6g}{self.problem.unit('m')} (node {node})"
        return crushed(where, stretch, push, layer.material.K)

    # checkpoints

    def capture(self) -> dict[str, Array] | None:
        """What a step depends on, on rank 0: whole layers, where their grids lie and how they move,
        and the results of the last step. Collective."""
        arrays = {}
        for layer in self.layers:
            size, own = int(layer.record["n"]), layer.of(self.y)
            arrays[f"layer{layer.number}"] = whole(self.comm, size, layer.numbers, own)
        if self.comm.rank > 0:
            return None
        frames = {name: self.records[name].copy() for name in FRAME}
        latest = as_numbers(self.latest).copy()
        return {**arrays, **frames, "results": self.results.copy(), "latest": latest}

    def restore(self, arrays: Mapping[str, Array], t: float) -> None:
        """Be at time t [s] what arrays, known on all ranks, tell of. InputError."""
        for name in FRAME:
            self.records[name] = arrays[name]
        self.results[:], as_numbers(self.latest)[:] = arrays["results"], arrays["latest"]
        self.set_data(t)
        agree(self.comm, self.fault)
        for layer in self.here:
            layer.of(self.y)[:] = arrays[f"layer{layer.number}"][layer.numbers]
        self._begin()

    def _begin(self) -> None:
        """Let the stage be the solution, which is completed: it fulfils the conditions."""
        self._load(self.y)
        for layer in self.here:
            layer.fill_halos()
