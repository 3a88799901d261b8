"""The semi-discrete scheme of blocks in time: data at an instant, the conditions, the right-hand
side, and steps of the classical Runge-Kutta method, for any number of dimensions and ranks.

C makes all calls of a phase (fsipetsc.blockrun.phases), and those of many steps where no data
depend on time. `y` is a fsipetsc.parallel.block_layout.BlockVector; `f` an array of the same
layout.
"""

from collections.abc import Callable, Sequence
from typing import Any

from numpy.typing import NDArray

from fsipetsc.blockrun.phases import STAGES, Phases
from fsipetsc.blocks.values import block_values
from fsipetsc.errors import InputError
from fsipetsc.parallel.block_layout import BlockVector
from fsipetsc.process.together import together
from fsipetsc.scheme.plan import ALLOWED, BAD, SAID_STOP
from fsipetsc.state import FAULT

Array = NDArray[Any]


class Scheme(Phases):
    """Right-hand side of a problem on this rank's parts of its blocks. Making one is collective.
    InputError.

    vectors: the solution, and three for stages. The rest is that of fsipetsc.blockrun.phases.

    fault: the first error of a function of the case's on this rank, after `initial`. The rank goes
    on with the data before it, so that others do not wait for its messages; all end after the step.
    """

    fault: InputError | None = None
    _filled: tuple[Any] | None = None  # the instant that the data are of

    def __init__(self, vectors: Sequence[BlockVector], *about: Any) -> None:
        super().__init__(*about)
        # the solution, and three stages: each becomes the next one
        self._now = tuple(vectors)
        # the phase of each stage, of which vector it takes the rates, and where it goes
        self._stages = list(zip(STAGES, self._now, (*self._now[1:], self._now[0]), strict=True))

    def initial(self, t: float, y: BlockVector) -> None:
        """Fill y with the data of the case at time t [s]. InputError for what its functions return,
        those of exact solutions, conditions and forcing as well.
        """
        for k, part in self.parts.items():
            part.initial(t, y.owned(k))
            if part.block.exact is not None:
                block_values(part.block, "exact", part.X[:, part.owned], t)
        self._refresh(t)

    def stretch(self, t: float, y: BlockVector) -> None:
        """Let grids of gases follow the solids, and J be that of the grid, at the same density,
        velocity and temperature. Gas at walls then gets their velocity, at the same temperature.
        """
        self._refresh(t)
        self.do("share", y.array)
        for gas in self.gases:
            gas.stretch(y.owned(gas.part.k))
            gas.impose_velocities(y.owned(gas.part.k), *self.particles.at_walls(gas.part.k))

    def _refresh(self, t: float) -> None:
        """Data of the case at time t [s]. InputError the first time; later ones are kept."""
        if self.asks or self._filled is None:
            self._ask(t)
        if not self.asks:
            self.fill(t)

    def _ask(self, t: float) -> None:
        """Ask Python for the data at time t [s]. InputError the first time."""
        differs = self.particles.prescribed.by_differences
        instant = None if self.steady else (t, self.instant() if differs else 0.0)
        if self._filled is not None and self._filled[0] == instant:
            return
        try:
            self.particles.prescribed.refresh(t)
            for part in self.parts.values():
                part.refresh(t)
        except InputError as error:
            if self._filled is None:
                raise
            self.fault = self.fault or error
            self.found.results[SAID_STOP] = FAULT
        self._filled = (instant,)

    def complete(self, t: float, y: BlockVector) -> None:
        """Impose on y, in place, all conditions of its particles. Collective."""
        self._refresh(t)
        self.do("share impose", y.array)

    def rates(self, t: float, y: BlockVector, f: Array) -> None:
        """f = dy/dt for a completed y. Collective."""
        self._refresh(t)
        self.do("rates", y.array, f)

    def step(self, t: float, dt: float, ends: Callable[[BlockVector], bool] | None = None) -> bool:
        """A step of the classical Runge-Kutta method from the solution at t [s] to the completed
        one at t + dt. Collective. It is PETSc's ``-ts_type rk -ts_rk_type 4`` up to round-off.

        It begins with what follows from y alone, so that a step after a restart has the same bits.
        ends: if given, called with each completed stage; where it says True, the step ends, and
        returns True.
        """
        y = self._now[0]
        self.found.now[1] = dt
        instants = t, t + 0.5 * dt, t + 0.5 * dt, t + dt
        for (name, now, to), instant in zip(self._stages, instants, strict=True):
            self._refresh(instant)
            if ends is None:
                self.do(f"share impose {name}", now.array, to.array)
            else:
                self.do("share impose", now.array)
                if now is not y and ends(now):
                    return True
                self.do(name, now.array, to.array)
        self.complete(t + dt, y)
        return ends is not None and ends(y)

    def steps(self, t: float, dt: float) -> tuple[bool, float, float]:
        """Make the steps of a batch from t [s] on, the first of dt [s]. Returns whether all ended
        well, and the time that is reached; else begin and length of the step to be made anew.
        """
        self._refresh(t)
        results, batch, now = self.found.results, self.found.plan.batch, self.found.now
        now[:2] = t, dt
        calls = self.batch(self._stages, self._now[0])
        calls.batch(results[BAD:], batch[ALLOWED:])
        return bool(results[BAD] == 0.0), float(now[0]), float(now[1])

    def check_data(self, times: Sequence[float]) -> None:
        """InputError where recorded data are wrong at some of these times [s]. Collective."""

        def check() -> None:
            for t in times:
                self.particles.prescribed.refresh(t)
                for part in self.parts.values():
                    part.refresh(t)
                self.fill(t)
                why = "expected a motion with a finite acceleration"
                for recorder in self.recorders:
                    if what := recorder.faulty():
                        raise InputError(f"{what} is not finite at t = {t:.6g}: {why}")

        if self.data and not self.asks:
            together(self.layout.comm, check)

    def monitor(self, y: BlockVector) -> None:
        """Find extremes of all ranks, this rank's shares of integrals, and what is recorded of
        interfaces, of the completed solution y; fill ghosted arrays. Collective.
        """
        self.do("monitor inside", y.array)

    def fill_halos(self, y: BlockVector) -> None:
        """Fill the ghosted arrays of all parts. Collective."""
        self.do("halos", y.array)

    def note_gained(self, y: BlockVector) -> None:
        """Put what came in into the record of the step."""
        self.does["note_gained"](y.array)

    def forget(self) -> None:
        """Clear what gases remember of a bad state: no NaN may stay there for another step."""
        for gas in self.gases:
            gas.volume.forget()
