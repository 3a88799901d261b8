"""The state of a run of blocks: what stepping and the writer ask for, ``right_hand_side``,
``step``, ``finish``, ``capture`` …; the equations are those of fsipetsc.blockrun.scheme.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from fsipetsc.blockrun.block_solution import BlockSolution
from fsipetsc.blockrun.notes import NOTES
from fsipetsc.blockrun.recorded_nodes import here_of, note_nodes
from fsipetsc.blockrun.saved import errors_of, grids, header, seen
from fsipetsc.blockrun.solid_limits import imaginary_waves, most_crushed
from fsipetsc.parallel.block_layout import BlockVector
from fsipetsc.process.together import agree, together
from fsipetsc.scheme.batch import DT, MADE, TIME
from fsipetsc.scheme.block_monitor import LEAST_J, MONITORED
from fsipetsc.scheme.plan import BAD, RATE, SAID_STOP
from fsipetsc.scheme.runge_kutta import STAGES
from fsipetsc.state import FAULT, as_numbers, whole

#: of how many parts a step is made, one after the other, until its state is physical
PARTS = 1, 2, 4, 8, 16


def new_imaginary_waves(state: "BlockState") -> list[str]:
    """Solids whose waves have become imaginary, each once."""
    return imaginary_waves(state, state.time, state.told)


class BlockState(BlockSolution):
    """A run's solution on blocks: its steps, checkpoints, and what is said of it; all methods are
    collective on ``comm``.

    retries: steps that were made anew in parts. told: solids of which it was said that they are
    beyond their law.
    """

    NOTES = MappingProxyType({**NOTES, "saved": (new_imaginary_waves,)})

    def __init__(self, *arguments: Any, **more: Any) -> None:
        super().__init__(*arguments, **more)
        self._recorded_here = here_of(self)
        self.retries = 0
        self._tried = 1  # in how many parts the last step was made
        self.told: set[int] = set()
        self.evaluations, self._t = 0, 0.0

    # set-up

    def check_data(self) -> None:
        """Ask the case's functions for all data at t = 0. InputError."""
        together(self.comm, lambda: self.scheme.initial(0.0, self.y))

    def check_motion(self, t_end: float) -> None:
        """InputError where walls do not have the velocity with which they move until t_end [s]."""
        together(self.comm, lambda: self.scheme.particles.prescribed.check_motion(t_end))

    def set_initial(self) -> None:
        """Initial data of all blocks and J of the grids. InputError."""
        self.check_data()
        self.y.auxiliary[:] = 0.0
        self.scheme.stretch(0.0, self.y)
        agree(self.comm, self.fault)

    def set_data(self, t: float) -> None:
        """The next evaluation of the right-hand side is at time t [s]."""
        self._t = t

    # steps

    def right_hand_side(self, y: np.ndarray, f: np.ndarray) -> None:
        """f = dy/dt of this rank's part, at y completed; y stays as it is."""
        self.evaluations += 1
        f[f.size - self.layout.auxiliary :] = 0.0
        self._load_stage(y)
        self.scheme.rates(self._t, self.stages[0], f)

    def _load_stage(self, y: np.ndarray) -> None:
        self.stages[0].array[:] = y
        self.scheme.complete(self._t, self.stages[0])

    def project(self, y: np.ndarray) -> None:
        """Let this rank's part y obey all conditions, in place."""
        self._load_stage(y)
        y[:] = self.stages[0].array

    def step(self, t: float, dt: float, steady: bool) -> None:
        """A step dt [s] of the fused method from the completed solution at t [s].

        The others of its batch follow.
        """
        more = True
        while more:
            if not self.scheme.asks and not self.recorded:
                ended_well, t, dt = self._steps(t, dt)
                if ended_well:
                    break
                self.scheme.forget()
            self._advance(t, dt)
            t = self._t
            more = self.plan_next()
            dt = float(self.batch[DT])

    def _steps(self, t: float, dt: float) -> tuple[bool, float, float]:
        """All steps of a batch in one call, from t [s] on, the first of dt [s].

        Whether all ended well; begin and length of one that is to be made anew.
        """
        made = self.batch[MADE]
        found = self.scheme.steps(t, dt)
        self._t = found[1]
        self.scheme.fill_halos(self.y)
        self.evaluations += STAGES * max(int(self.batch[MADE] - made), int(found[0]))
        self._tried = 1
        return found

    def _advance(self, t: float, dt: float) -> None:
        """Make the step; one that leaves an unphysical state is made anew in 2, 4 … parts."""
        self.before[:], rate = self.y.array, self.results[RATE]
        for parts in PARTS:
            for part in range(parts):
                self.evaluations += STAGES
                begin = t + dt * part / parts
                self.scheme.step(begin, dt / parts)
            self._t, self._tried = t + dt, parts
            self._monitor()
            if self.results[BAD] == 0.0 or parts == PARTS[-1]:
                break
            self.y.array[:], self.results[RATE] = self.before, rate
            self.scheme.forget()
            self.retries += 1

    def finish(self) -> None:
        """Complete a step that PETSc has made."""
        self.scheme.complete(self._t, self.y)
        self.solution.stateIncrease()
        self._monitor()
        if not self._failed:
            self.before[:] = self.y.array

    @property
    def _failed(self) -> bool:
        """The run cannot go on from the state that was monitored last."""
        return bool(self.results[BAD]) or not self.results[RATE] < np.inf

    def go_to_fault(self, unphysical: Callable[[], Any]) -> str:
        """Repeat the step that has failed, and let y be its first unphysical stage: NaN spreads
        from there. Steps of PETSc's other methods are repeated by the classical one; if that does
        not fail, y stays. Returns what was wrong with solids before the step, or what is wrong with
        their waves now, or "". InputError where data that depend on time were wrong.
        """
        if not self.batch[MADE]:
            return ""
        last, dt = self.y.array.copy(), float(self.batch[DT]) / self._tried
        end = float(self.batch[TIME])
        begin = end - dt * self._tried
        halves = range(2 * self._tried + 1)
        self.scheme.check_data([begin + 0.5 * dt * half for half in halves])
        self.y.array[:] = self.before
        self.scheme.forget()
        self._find_extremes(self.y)
        said = "; ".join(imaginary_waves(self, begin, set())) or most_crushed(self)
        for part in range(self._tried):
            if self.scheme.step(begin + part * dt, dt, self._fails):
                break
        else:
            self.y.array[:] = last
            self._find_extremes(self.y)
        least_J = -self.extremes[1:].reshape(-1, MONITORED)[:, LEAST_J]
        if not said and least_J.min() > 0.0:
            return "; ".join(imaginary_waves(self, end, set()))
        return said

    def _fails(self, now: BlockVector) -> bool:
        """Whether a completed stage is unphysical; if so, y is this stage. Collective."""
        rate = float(self.results[RATE])
        self._find_extremes(now)
        failed = self._failed
        if failed and now is not self.y:
            self.y.array[:] = now.array
            self._find_extremes(self.y)
        elif not failed:
            self.results[RATE] = rate  # that of the step, for differences in time
        return failed

    def _monitor(self) -> None:
        """What is known of the completed solution: bounds of all ranks, shares of the integrals."""
        self._find_extremes(self.y)
        note_nodes(self, self._recorded_here)
        self.scheme.note_gained(self.y)

    def _find_extremes(self, now: BlockVector) -> None:
        """Bounds of all ranks, and this rank's shares of the integrals of a completed stage."""
        if self.fault is not None:
            self.results[SAID_STOP] = FAULT
        self.scheme.monitor(now)

    # checkpoints

    def capture(self) -> dict[str, np.ndarray] | None:
        """What a step depends on, on rank 0: whole blocks, (…, n_1, n_0, unknowns), so that it does
        not depend on who had what; auxiliary unknowns are added up. Collective.
        """
        arrays = {}
        for k, shape in enumerate(self.layout.shapes):
            part = self.layout.parts.get(k)
            numbers = np.empty(0, np.int64) if part is None else part.numbers
            found = whole(self.comm, int(np.prod(shape)), numbers, self.y.owned(k))
            if found is not None:
                arrays[f"layer{k}"] = found.reshape(*shape[::-1], -1)
        every = self.comm.gather(self.y.auxiliary)
        if every is None:
            return None
        total, latest = sum(every, np.zeros(self.layout.auxiliary)), as_numbers(self.latest).copy()
        # "behind": the auxiliary unknowns, by the name that files have
        return {**arrays, "behind": total, "results": self.results.copy(), "latest": latest}

    def restore(self, arrays: Mapping[str, np.ndarray], t: float) -> None:
        """Be at time t [s] what arrays tell of, which all ranks know. InputError."""
        self.results[:], as_numbers(self.latest)[:] = arrays["results"], arrays["latest"]
        behind = arrays["behind"]  # asked for on all ranks, so that all fail alike
        self.y.auxiliary[:] = behind if self.comm.rank == 0 else 0.0
        self._t = t
        for k, part in self.layout.parts.items():
            self.y.owned(k)[:] = arrays[f"layer{k}"].reshape(-1, part.dof)[part.numbers]
        self.before[:] = self.y.array
        self._load_stage(self.y.array)  # what the scheme derives of it; it stays as it is
        self.scheme.fill_halos(self.y)
        agree(self.comm, self.fault)

    # what is saved and said

    header, grids, seen, errors = header, grids, seen, errors_of
