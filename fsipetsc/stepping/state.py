"""The state of a run on its ranks: layout, plan and solution, initial data, growth of the fluid grids."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc import given
from fsipetsc.boundaries import NODES, in_time
from fsipetsc.errors import FsiError, InputError
from fsipetsc.operators.cache import compiling, garbage_waiting
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.parallel.layout import Grid, Layout, make_grids
from fsipetsc.physics.layer import FLUID, SOLID
from fsipetsc.problem import Problem
from fsipetsc.process.together import agree, together, wait_asleep
from fsipetsc.scheme import runge_kutta
from fsipetsc.scheme.burst import MADE
from fsipetsc.scheme.fields import fields
from fsipetsc.scheme.laws import PLAIN, Form, ProblemLaws
from fsipetsc.scheme.plan import BURST, FLAGS, FORCING, LIMITS, LOW, RATE, SAID_STOP, make_plan
from fsipetsc.stepping import frames, initial_data, snapshot
from fsipetsc.stepping.diagnosis import Failure, describe_failure
from fsipetsc.stepping.petsc_path import PetscPath, compile_entries
from fsipetsc.stepping.start import Start

#: what a rank says of STOP whose user's functions have failed: more than any signal
FAULT = 1000.0


class State:
    """Solution and everything that belongs to it; all methods are collective on ``comm``.

    Attributes: layout, plan, solution (world Vec); results of the last completed step (scheme.finish_step says where what
    stands); burst (scheme.burst); journal, the records of steps (scheme.plan.step_record), and latest, that of the last
    one without its time. The integrals in them are this rank's shares. evaluations of the right-hand side are counted.
    begin: time [s] of the initial data; started: they are those of a frame (``begin_with``). convection: its form.
    Raises InputError where grid, order and number of ranks do not fit.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        problem: Problem,
        order: int,
        h: float,
        coupling: str,
        mapping: str,
        mode: str,
        spare: int,
        entropy: bool = False,
        shared: bool = True,
        form: Form = PLAIN,
    ) -> None:
        self.comm, self.problem, self.h = comm, problem, h
        self.op = OPERATORS[order]
        self._coupling, self.mapping, self._mode, self._spare = coupling, mapping, mode, spare
        self._entropy, self._shared, self._form = entropy, shared, form
        self.convection = "entropy" if form.entropy else "divergence"
        self.evaluations, self.begin, self.started = 0, 0.0, False
        self.fault: InputError | None = None  # of a user's function, on this rank
        self._path: PetscPath | None = None
        ends = ((0, 0, problem.left), (len(problem.layers) - 1, 1, problem.right))
        self.moving = [(k, side) for k, side, end in ends if "x" in in_time(end)]
        # in a step each time is asked for twice, and each answer takes several calls of the user's function
        self._end_motion = lru_cache(maxsize=8)(partial(given.end_motion, problem))
        self.laws = together(comm, lambda: ProblemLaws(problem, entropy, form))
        self._place(make_grids(problem, self.op, h, spare, mapping))

    def compile(self, announce: Callable[[str], None], also: Callable[[], object] = lambda: None) -> None:
        """Compile the kernels if that has not been done for this machine: one rank first, the others take its result.

        also: calls further compiled functions.
        """
        if self.comm.rank == 0:
            with garbage_waiting(), compiling(self.plan.compiled(runge_kutta.run_task), announce):
                runge_kutta.do_nothing(self.plan)
                also()
        wait_asleep(self.comm)
        runge_kutta.do_nothing(self.plan)
        also()

    def _place(self, grids: list[Grid], kept: Layout | None = None, shares: list | None = None) -> None:
        conservative = self._coupling == "conservative"
        self.layout = Layout(self.comm, self.problem, self.op, self.h, grids, self._mode, conservative, kept, shares)
        forced = any(layer.forcing for layer in self.problem.layers)
        asked = (forced, self._entropy, self._shared, self._form.narrow, self._form.shocks)
        self.plan, self._neighbours = make_plan(self.layout, self.op, self._coupling, *asked)
        self.plan.compiled = self.laws.compiled
        self.laws.number(self.plan.layers, self.plan.faces)
        self.plan.layers["dissipation"], self.plan.layers["shocks"] = self._form.dissipation, self._form.shocks
        for record, grid in zip(self.layout.records, grids, strict=True):
            record["lo"], record["hi"] = grid.lo, grid.hi
        # the solution vector's own memory is the plan's
        values = self.plan.part("solution", self.layout.local_size)
        self.solution = PETSc.Vec().createWithArray(values, comm=self.comm)
        self.results = self.plan.part("results", FLAGS + LIMITS)
        self.burst = self.plan.part("burst", BURST)
        self.journal, self.latest = self.plan.journal, self.plan.latest

    def set_data(self, t: float) -> None:
        """Evaluate boundary data, jumps and forcing at time t [s] for the next evaluation of the right-hand side.

        If a function of the user's fails, here alone perhaps, the data stay as they are, the step goes on, and all ranks
        learn of it when it is complete: see ``fault``.
        """
        try:
            self._set_data(t)
        except InputError as error:
            self.fault = self.fault or error
            self.results[SAID_STOP] = FAULT

    def _set_data(self, t: float) -> None:
        problem, records = self.problem, self.layout.records
        for k, side in ((0, 0), (len(records) - 1, 1)):
            values = given.end_data(problem, side, t)
            records[k]["end_data"][side, : len(values)] = values
            records[k]["end_heat"][side] = given.end_heat(problem, side, t)
        for k, side in self.moving:
            records[k]["end_x"][side], records[k]["end_v"][side], records[k]["end_a"][side] = self.motion(side, t)
        if problem.jumps is not None:
            for k, face in enumerate(self.plan.faces):
                face["jump"] = given.jumps(problem, k, t)
                records[face["solid"]]["end_jump"][1 if face["normal"] > 0 else 0] = face["jump"]
        for k, layer in enumerate(problem.layers):
            if layer.forcing is not None and records[k]["present"]:
                part = self.plan.owned(k, FORCING)
                for c, values in enumerate(given.fields(layer, "forcing", self.layout.owned_X(k), t, self.active(k))):
                    part[:, c] = values

    def active(self, k: int) -> slice:
        """The active ones among this rank's points of layer k."""
        record = self.layout.records[k]
        own, begin, end = int(record["own_lo"]), int(record["lo"]), int(record["hi"]) + 1
        return slice(max(begin - own, 0), max(end - own, 0))

    def begin_with(self, start: Start) -> None:
        """Let initial data be those of a frame, at its time, instead of the case's. Collective."""
        self.problem, self.begin, self.started = start.problem, start.t, True
        if start.cells:
            self._release()
            self._place(make_grids(self.problem, self.op, self.h, self._spare, self.mapping, start.cells))

    def set_initial(self) -> None:
        """Initial data of all layers, projected, at the time ``begin``. InputError where they are not what they must be."""
        self.check_data()
        self.finish()

    def check_data(self) -> None:
        """Ask the user's functions for all data at the beginning. InputError, on all ranks, where they are not what they must
        be.
        """
        initial_data.set_data(self)

    @property
    def places(self) -> list[float]:
        """Positions x [m] of the interfaces."""
        return self.latest["x_interface"].tolist() if len(self.plan.faces) else []

    @property
    def points(self) -> int:
        """Active points of all layers."""
        return sum(int(r["hi"] - r["lo"]) + 1 for r in self.layout.records)

    @property
    def reserve(self) -> int:
        """Points held in reserve, at first."""
        return sum(g.n - (g.hi - g.lo + 1) for g in self.layout.grids)

    @property
    def recorded(self) -> list[list[float]]:
        """Points of interfaces that are recorded at each step, as in two dimensions: none."""
        return []

    def header(self) -> list[dict[str, Any]]:
        """What a result file says of each layer."""
        return [{"name": layer.name, "kind": layer.kind, "fields": list(layer.fields)} for layer in self.problem.layers]

    def grids(self) -> list[dict[str, Any]]:
        """What the writer must know of the points of each layer: see RunWriter.start_segment."""
        records, layout = self.layout.records, self.layout
        return [
            {"local": int(r["own_hi"] - r["own_lo"]), "n": int(r["n"]), "X": layout.owned_X(k)} for k, r in enumerate(records)
        ]

    def save(self, slots: tuple[np.ndarray, np.ndarray, int]) -> None:
        """Put what is saved of this rank's points in the slots of a frame (fsipetsc.output.buffers.Slots)."""
        self.plan.compiled(fields)(self.plan.head, self.plan.layers, self.plan.memory, *slots)

    def errors(self, t: float, norm: str) -> dict[str, dict[str, float]] | None:
        """See fsipetsc.stepping.frames.errors."""
        return frames.errors(self, t, norm)

    def failure(self, t: float, step: int) -> Failure:
        """What is wrong with a state that is not physical. Collective."""
        return describe_failure(self, t, step)

    def unknowns(self, y: np.ndarray) -> list[np.ndarray]:
        """The active ones in this rank's part y, layer by layer."""
        found = []
        for k, record in enumerate(self.layout.records):
            if record["present"]:
                own = np.arange(record["own_lo"], record["own_hi"])
                found.append(self.layout.local(k, y)[(own >= record["lo"]) & (own <= record["hi"])])
        return found

    def compile_saving(self) -> None:
        """Compile what frames take."""
        frames.layer_fields(self)

    def compile_path(self, announce: Callable[[str], None]) -> None:
        """Compile what PETSc's own methods call, or load it. Not collective."""
        compile_entries(self.plan, announce)

    @property
    def path(self) -> PetscPath:
        """What PETSc's own methods take for the right-hand side. Collective when it is asked for first."""
        if self._path is None:
            self._path = PetscPath(self.layout, self.plan)
        return self._path

    def right_hand_side(self, y: np.ndarray, f: np.ndarray) -> None:
        """f = dy/dt of this rank's part, at the projected y, for the data set last."""
        self.evaluations += 1
        self.path.rates(y, f)

    def project(self, y: np.ndarray) -> None:
        """Fill the ghost points of this rank's part y and project its interfaces, in place; undoes the completion."""
        self.path.apply_conditions(y)
        for k, record in enumerate(self.layout.records):
            if record["present"]:
                self.layout.local(k, y)[:] = self.plan.owned(k)
                self.layout.ends(k, y)[:] = self.plan.ends(k)

    def finish(self) -> None:
        """Complete a step whose raw result PETSc has left in the solution: see scheme.finish_step."""
        runge_kutta.complete_step(self.plan, "solution")

    def step(self, t: float, dt: float, steady: bool) -> None:
        """A step dt [s] of the fused Runge-Kutta method from the completed solution at t [s], and its completion.

        steady: the data do not depend on time; then further steps follow as the burst allows, by itself none.
        """
        if steady:
            runge_kutta.make_steps(self.plan, dt)
            self.evaluations += runge_kutta.STAGES * max(1, int(self.burst[MADE]))
            return
        self.evaluations += runge_kutta.STAGES
        walls = self._walls(t, dt)
        for number, fraction in enumerate((0.0, 0.5, 0.5, 1.0, 1.0)):
            self.set_data(t + fraction * dt)
            for record, side, places, velocities in walls:
                record["end_x"][side], record["end_v"][side] = places[number], velocities[number]
            runge_kutta.make_stage(self.plan, number, dt)

    def _walls(self, t: float, dt: float) -> list[tuple[np.void, int, tuple[float, ...], tuple[float, ...]]]:
        """(record, side, places, velocities) of the walls that move, in the stages of a step and after it.

        The places are what the Runge-Kutta method makes of the velocities, and J of them what it makes of J_t: else a free
        stream would not stay one. That of the middle of the step is such that the wall ends where it should (Simpson's rule).
        """
        found = []
        try:
            for k, side in self.moving:
                record = self.layout.records[k]
                x, (_, before, _) = float(record["end_x"][side]), self.motion(side, t)
                end, after, _ = self.motion(side, t + dt)
                middle = (6.0 * (end - x) / dt - before - after) / 4.0
                places = x, x + 0.5 * dt * before, x + 0.5 * dt * middle, x + dt * middle, end
                found.append((record, side, places, (before, middle, middle, after, after)))
        except InputError:
            return []  # set_data will say it
        return found

    def motion(self, side: int, t: float) -> tuple[float, float, float]:
        """(x, velocity, acceleration) of a wall that moves: see given.end_motion. InputError."""
        return self._end_motion(side, t, self._instant())

    def _instant(self) -> float:
        """A time [s] in which little happens, for differences in time: a fraction of a step, before there is one of h/1000."""
        rate = float(self.results[RATE])
        return 0.25 / rate if 0.0 < rate < np.inf else 1e-3 * self.h

    def grow(self, noted: int = 0) -> None:
        """Lay the grids anew with more spare points at the embedded boundaries; the completed solution moves along.

        noted: records of the journal that are needed. Nothing else changes, not even in the last bit. Rare, so it is simple:
        every rank sees each layer once, whole.
        """
        old, y = self.layout, self.solution.getArray(readonly=True)
        whole = [snapshot.gather(self.comm, old, k, y) for k in range(len(old.grids))]
        cells = {k: int(r["hi"] - r["lo"]) for k, r in enumerate(old.records) if r["kind"] == FLUID}
        results, journal = self.results.copy(), self.journal[:noted].copy()
        self._release()
        spare = max(self._spare, NODES)
        self._place(make_grids(self.problem, self.op, self.h, spare, self.mapping, cells, old.grids), old)
        self.results[:], self.journal[:noted] = results, journal
        self.results[LOW] = 0.0
        y = self.solution.getArray()
        for k, (grid, record) in enumerate(zip(self.layout.grids, self.layout.records, strict=True)):
            before = old.records[k]
            for name in ("s", "spread", "J", "x_interface", "end_x", "end_v", "end_data"):
                record[name] = before[name]
            if record["present"]:
                active = whole[k][before["lo"] : before["hi"] + 1]
                rows = np.arange(record["own_lo"], record["own_hi"]) - grid.lo
                self.layout.local(k, y)[:] = active[np.clip(rows, 0, len(active) - 1)]
                if record["kind"] == SOLID:
                    initial_data.note_kinetic_energies(self.layout, k, y)
        runge_kutta.load_completed(self.plan, "solution")

    def keep(self, room: tuple[np.ndarray, ...] | None = None) -> tuple[np.ndarray, ...]:
        """What ``back`` takes, of this rank: the completed state as it is, on these grids; room: what it may overwrite."""
        return snapshot.kept(self, room)

    def back(self, kept: tuple[np.ndarray, ...]) -> None:
        """Be what was kept again."""
        snapshot.put_back(self, kept)
        runge_kutta.load_completed(self.plan, "solution")

    def capture(self, rates: np.ndarray | None = None) -> dict[str, np.ndarray] | None:
        """See fsipetsc.stepping.snapshot.capture."""
        return snapshot.capture(self, rates)

    def restore(self, arrays: Mapping[str, np.ndarray], t: float) -> np.ndarray | None:
        """Be at time t [s] what arrays, known on all ranks, tell of; the rates among them, if any. InputError."""
        grids, shares = snapshot.grids_of(self.problem, self.layout.grids, arrays), snapshot.shares_of(arrays, self.comm.size)
        old = self.layout
        self._release()
        self._place(grids, old, shares)
        self.results[:], snapshot.as_numbers(self.latest)[:] = arrays["results"], arrays["latest"]
        self.set_data(t)
        agree(self.comm, self.fault)
        snapshot.put_frames(self.layout, arrays)
        snapshot.put(self.layout, self.solution.getArray(), arrays)
        runge_kutta.load_completed(self.plan, "solution")
        return snapshot.rates_of(self.layout, arrays)

    def _release(self) -> None:
        if self._path is not None:
            self._path.destroy()
            self._path = None
        self._neighbours.free()
        self.solution.destroy()
        self.layout.destroy()

    def destroy(self) -> None:
        """Free requests, shared memory, vectors, DMDAs and communicators, in this order."""
        self._release()

    def __enter__(self) -> State:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Destroy it, unless this rank may be alone with an error: the others would not meet it there."""
        if error is None or self.comm.size == 1 or (isinstance(error, FsiError) and error.collective):
            self.destroy()
