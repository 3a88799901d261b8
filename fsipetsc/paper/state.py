"""The state of a run of the paper's method: what fsipetsc.stepping drives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc import given
from fsipetsc.errors import FsiError, InputError
from fsipetsc.operators.boxed import Box
from fsipetsc.operators.kernel_cache import announced
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.paper import after_step, batch, coupling, entries, fields, layout
from fsipetsc.paper.ends import NODES
from fsipetsc.paper.laws import check_entropy, elastic_of, gas_of
from fsipetsc.paper.layer import FLUID
from fsipetsc.paper.layout import Grid
from fsipetsc.paper.parts import RightHandSide
from fsipetsc.paper.stencils import packed
from fsipetsc.problem import Problem
from fsipetsc.process.together import agree, together, wait_asleep
from fsipetsc.scheme.burst import MADE
from fsipetsc.scheme.plan import CAPACITY, LOW, SAID_STOP, step_record
from fsipetsc.stepping import initial_data, snapshot
from fsipetsc.stepping.diagnosis import Failure, described
from fsipetsc.stepping.phases import logged
from fsipetsc.stepping.state import FAULT

Array = np.ndarray
#: times of the stages, in steps, and of the completed step
FRACTIONS = 0.0, 0.5, 0.5, 1.0, 1.0


class PaperState:
    """Solution and everything that belongs to it; all methods are collective on ``comm``.

    Attributes: layout; solution (world Vec); results of the last completed step; burst
    (fsipetsc.scheme.burst); journal, the records of steps (fsipetsc.scheme.plan.step_record), and
    latest, that of the last one without its time. The integrals in them are this rank's shares.
    evaluations of the right-hand side are counted. rates: (layers, 2), the largest rates of
    convection and diffusion [1/s] of each layer. Raises InputError where grid, order and number
    of ranks do not fit, or the problem is not of the paper's form.
    """

    convection = "divergence"

    def __init__(
        self,
        comm: MPI.Comm,
        problem: Problem,
        order: int,
        h: float,
        coupling_name: str,
        mode: str = "auto",
        spare: int = 64,
        entropy: bool = False,
        narrow: bool = False,
    ) -> None:
        layout.check_form(problem)
        if coupling_name not in coupling.KINDS:
            raise InputError(
                f"-fsi_coupling {coupling_name}: expected {', '.join(coupling.KINDS)}, "
                "in the paper's method"
            )
        self.comm, self.problem, self.h = comm, problem, h
        self.op, self.operator = OPERATORS[order], packed(order, narrow)
        self._kind = coupling.KINDS[coupling_name]
        form = order, h, coupling_name, mode, spare, entropy, narrow
        self._alike = lambda comm: PaperState(comm, problem, *form)
        self._mode, self._spare, self.entropy = mode, spare, entropy
        self.evaluations, self._said = 0, False
        self.fault: InputError | None = None  # of a user's function, on this rank
        if entropy:
            check_entropy(problem.layers)
        make = {"fluid": gas_of, "solid": elastic_of}
        self.laws = together(
            comm, lambda: [make[layer.kind](layer.material) for layer in problem.layers]
        )
        # layers are counted from the left gas, which there may not be
        self.first = 0 if problem.layers[0].kind == "fluid" else 1
        self._place(layout.make_grids(problem, self.op, h, spare))

    # memory

    def _place(
        self, grids: list[Grid], kept: layout.Layout | None = None, shares: list | None = None
    ) -> None:
        problem = self.problem
        self.layout = layout.Layout(self.comm, problem, self.op, grids, self._mode, kept, shares)
        values = np.zeros(self.layout.local_size)
        self.solution = PETSc.Vec().createWithArray(values, comm=self.comm)
        forced = [layer.forcing is not None for layer in problem.layers]
        self.rooms = np.zeros(1, batch.ROOM)
        room = self._room = self.rooms[0]
        self.path = RightHandSide(
            self.layout, self.operator, self.laws, self._kind, values, forced, self.rooms
        )
        gases = [layer.kind == "fluid" for layer in problem.layers]
        room["there"][self.first : self.first + len(gases)] = gases
        record = step_record(len(problem.interfaces), sum(gases), self.entropy)
        self.journal = np.zeros(CAPACITY, record)
        self._journal = self.journal.view(np.float64).reshape(CAPACITY, -1)
        names, count = record.names[2:], self._journal.shape[1] - 2
        self.results, self.burst, room["numbers"] = room["results"], room["burst"], count
        self._boxes: list[Box] = []
        self._shared: Box | None = None
        self.told = np.zeros(entries.told_size(len(gases), len(problem.interfaces)))
        self.latest = room["latest"][:count].view([(name, record[name]) for name in names])[0]

    @property
    def boxes(self) -> list[Box]:
        """What calls after a step take, by layer."""
        if not self._boxes:
            memory = self.rooms, self._journal
            self._boxes = [Box(entries.StepData(self.operator, v, *memory)) for v in self.laws]
        return self._boxes

    @property
    def shared(self) -> Box:
        """What all ranks learn after a step."""
        if self._shared is None:
            layers = self.first + np.arange(len(self.laws))
            sides = np.array([interface.side for interface in self.path.interfaces])
            noted = np.array([interface.here[1] for interface in self.path.interfaces])
            memory = self.rooms, self.layout.records
            self._shared = Box(entries.SharedData(*memory, layers, sides, noted, self.told))
        return self._shared

    @property
    def _batched(self) -> bool:
        """One rank, which has all: steps go together."""
        return self.comm.size == 1

    def _chain(self) -> tuple[Any, ...]:
        """What ``batch.run_task`` takes of the state; on one rank."""
        parts: list[Any] = [None] * 3
        faces: list[Any] = [None] * 2
        for layer in self.path.layers:
            parts[self.first + layer.number] = layer.part
        for interface in self.path.interfaces:
            faces[interface.side] = interface.face
        return self.operator, *parts, tuple(faces), self.entropy, self.rooms, self._journal

    def compile(
        self, announce: Callable[[str], None], also: Callable[[], object] = lambda: None
    ) -> None:
        """Compile the kernels: rank 0 first, with a state of its own; the others find them on the
        disk."""
        self._first(announce, self._step_once if self._batched else self._all_entries)
        also()

    def compile_path(self, announce: Callable[[str], None]) -> None:
        """Compile what PETSc's own methods call."""
        self._first(announce, self._all_entries)

    def compile_saving(self) -> None:
        """Compile what frames take."""
        fields.fields(self)

    def _first(self, announce: Callable[[str], None], call: Callable[[PaperState], None]) -> None:
        """Let rank 0 call something of a state like this one, of which it has all."""
        say, self._said = (lambda words: None) if self._said else announce, True
        if self.comm.rank == 0:
            with announced(say), self._alike(MPI.COMM_SELF) as alone, np.errstate(all="ignore"):
                call(alone)
        wait_asleep(self.comm)

    @staticmethod
    def _step_once(alone: PaperState) -> None:
        alone._run(batch.STEPS)

    @staticmethod
    def _all_entries(alone: PaperState) -> None:
        alone.project(alone.path.y)
        alone.path.rates(alone.path.y, alone.path.k)
        alone._stage(0, 0.0)
        for interface in alone.path.interfaces:
            interface.couple_apart()
        after_step.complete(alone)
        entries.goes_on(alone.boxes[0])
        fields.fields(alone)

    # data

    def first_notes(self) -> list[str]:
        """Nothing: frames are cut where walls are, and the couplings bring stresses together."""
        return []

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
        problem, records = self.problem, self.layout.records
        for k, side in ((0, 0), (len(records) - 1, 1)):
            values = given.end_data(problem, side, t)
            records[k]["end_data"][side, : len(values)] = values
            records[k]["end_heat"][side] = given.end_heat(problem, side, t)
        if problem.jumps is not None:
            for k, interface in enumerate(self.path.interfaces):
                interface.jump[:] = given.jumps(problem, k, t)
        for layer in self.path.layers:
            if len(layer.forcing):
                k = layer.number
                values = given.fields(
                    problem.layers[k], "forcing", self.layout.owned_X(k), t, self.active(k)
                )
                for c, value in enumerate(values):
                    layer.forcing[:, c] = value

    def active(self, k: int) -> slice:
        """The active ones among this rank's points of layer k."""
        record = self.layout.records[k]
        own, begin, end = int(record["own_lo"]), int(record["lo"]), int(record["hi"]) + 1
        return slice(max(begin - own, 0), max(end - own, 0))

    def set_initial(self) -> None:
        """Initial data of all layers, projected. InputError where they are not what they must be."""
        self.check_data()
        self.finish()

    def check_data(self) -> None:
        """Ask for all data at the beginning. InputError, on all ranks, where they are wrong."""
        initial_data.set_data(self)

    # what is said of it

    @property
    def rates(self) -> Array:
        return self._room["rates"][self.first : self.first + len(self.laws)]

    @property
    def places(self) -> list[float]:
        """Positions x [m] of the interfaces."""
        return self.latest["x_interface"].tolist() if self.path.interfaces else []

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
        return [
            {"name": v.name, "kind": v.kind, "fields": list(v.fields)} for v in self.problem.layers
        ]

    def grids(self) -> list[dict[str, Any]]:
        """What the writer must know of the points of each layer: see RunWriter.start_segment."""
        records = enumerate(self.layout.records)
        return [
            {"local": int(r["own_hi"] - r["own_lo"]), "n": int(r["n"]), "X": self.layout.owned_X(k)}
            for k, r in records
        ]

    def save(self, slots: tuple[Array, Array, int]) -> None:
        """Put what is saved of this rank's points in the slots of a frame
        (fsipetsc.output.buffers.Slots)."""
        out, starts, stride = slots
        for k, values in fields.fields(self).items():
            for c in range(5):
                out[starts[k] + c :: stride][: len(values)] = values[:, c]

    def errors(self, t: float, norm: str = "L2") -> dict[str, dict[str, float]] | None:
        """See fsipetsc.paper.fields.errors."""
        return fields.errors(self, t, norm)

    def failure(self, t: float, step: int) -> Failure:
        """What is wrong with a state that is not physical. Collective."""
        return described(self, fields.seen(self), t, step)

    # steps

    def right_hand_side(self, y: Array, f: Array) -> None:
        """f = dy/dt of this rank's part, at the projected y, for the data set last."""
        self.evaluations += 1
        self.path.rates(y, f)

    def project(self, y: Array) -> None:
        """Fill the ghost points of this rank's part y and project its interfaces, in place; undoes
        the completion."""
        self.path.stage[:] = y
        self.path.fulfil_conditions()
        for part in self.path.layers:
            part.fill_ghost()
        self.path.keep_ghosts()
        y[:] = self.path.stage

    def finish(self) -> None:
        """Complete a step whose raw result PETSc has left in the solution."""
        self.path.stage[:] = self.path.y
        self._complete()

    def _complete(self) -> None:
        """Project the stage, which is the new solution, let boundaries move, and look at it."""
        if self._batched:
            self._run(batch.STAGE, batch.STAGES)
        else:
            after_step.complete(self)

    def _run(self, task: int, number: int = 0, dt: float = 0.0) -> None:
        """A task of the compiled batch, on one rank."""
        batch.run_task(task, *self._chain(), number, dt)
        for part in self.path.layers if task == batch.STEPS or number == batch.STAGES else ():
            part.owned[:] = part.part.stage

    def step(self, t: float, dt: float, steady: bool) -> None:
        """A step dt [s] of the classical Runge-Kutta method from the completed solution at t [s],
        and its completion.

        steady: the data do not depend on time; then further steps follow as the burst allows, by
        itself none.
        """
        if steady and self._batched:
            self._run(batch.STEPS, dt=dt)
            self.evaluations += batch.STAGES * max(1, int(self.burst[MADE]))
            return
        self._step(t, dt, steady)
        while steady and entries.goes_on(self.boxes[0]):
            self._step(t, self.burst[batch.DT], steady)

    def _step(self, t: float, dt: float, steady: bool) -> None:
        self.evaluations += batch.STAGES
        for number, fraction in enumerate(FRACTIONS):
            if not steady:
                self.set_data(t + fraction * dt)
            if number == batch.STAGES:
                self._complete()
            elif self._batched:
                self._run(batch.STAGE, number, dt)
            else:
                self._stage(number, dt)

    def _stage(self, number: int, dt: float) -> None:
        """A stage by way of PETSc's exchange."""
        if number > 0:
            self.path.fulfil_conditions()
        self.path.evaluate(self.path.k, filled=number == 0)
        self.path.advance(number, dt)

    # grids that grow, checkpoints

    def _load(self) -> None:
        """Go on from the solution, which fulfils the conditions: a completed one."""
        self.path.stage[:] = self.path.y
        for part in self.path.layers:
            part.fill_halos()

    def grow(self, noted: int = 0) -> None:
        """Lay the grids anew with more spare points at the embedded boundaries; the completed
        solution moves along.

        noted: records of the journal that are needed. Nothing else changes, not even in the last
        bit. Rare, so it is simple: every rank sees each layer once, whole.
        """
        old, y = self.layout, self.path.y
        whole = [snapshot.gather(self.comm, old, k, y) for k in range(len(old.grids))]
        cells = {k: int(r["hi"] - r["lo"]) for k, r in enumerate(old.records) if r["kind"] == FLUID}
        journal, room = self.journal[:noted].copy(), self._room
        self._release()
        spare = max(self._spare, NODES)
        self._place(layout.make_grids(self.problem, self.op, self.h, spare, cells, old.grids), old)
        self.journal[:noted] = journal
        for name in room.dtype.names:
            self._room[name] = room[name]
        self.results[LOW] = 0.0
        for k, (grid, record, before) in enumerate(
            zip(self.layout.grids, self.layout.records, old.records, strict=True)
        ):
            for name in ("s", "x_interface", "end_data", "end_heat"):
                record[name] = before[name]
            if record["present"]:
                active = whole[k][before["lo"] : before["hi"] + 1]
                rows = np.arange(record["own_lo"], record["own_hi"]) - grid.lo
                self.layout.local(k, self.path.y)[:] = active[np.clip(rows, 0, len(active) - 1)]
        self._load()

    def capture(self) -> dict[str, Array] | None:
        """See fsipetsc.stepping.snapshot.capture."""
        return snapshot.capture(self)

    def restore(self, arrays: Mapping[str, Array], t: float) -> None:
        """Be at time t [s] what arrays, known on all ranks, tell of. InputError."""
        grids, shares = (
            snapshot.grids_of(self.problem, self.layout.grids, arrays),
            snapshot.shares_of(arrays, self.comm.size),
        )
        old = self.layout
        self._release()
        self._place(grids, old, shares)
        self.results[:], snapshot.as_numbers(self.latest)[:] = arrays["results"], arrays["latest"]
        self.set_data(t)
        agree(self.comm, self.fault)
        snapshot.put_frames(self.layout, arrays)
        snapshot.put(self.layout, self.path.y, arrays)
        self._load()

    def _release(self) -> None:
        self.path.destroy()
        self.solution.destroy()
        self.layout.destroy()

    def destroy(self) -> None:
        """Free vectors, DMDAs and communicators, in this order."""
        self._release()

    def __enter__(self) -> PaperState:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Destroy it, unless this rank may be alone with an error: the others would not meet it
        there."""
        if (
            error is None
            or self.comm.size == 1
            or (isinstance(error, FsiError) and error.collective)
        ):
            self.destroy()


#: what the paper's method has of options that choose between methods
_WITHOUT = {
    "fsi_mapping": ("auto", "rigid"),
    "fsi_dissipation": (0.0, -1.0),
    "fsi_shock": (0.0,),
    "fsi_convection": ("auto", "divergence"),
}
#: methods that appear in PETSc's log, as "fsi NAME"
_EVENTS = {
    "step": "step",
    "right_hand_side": "rates",
    "finish": "complete",
    "grow": "grow",
    "set_initial": "initial",
}


def make_paper_state(problem: Problem, opt: Mapping[str, Any], comm: MPI.Comm) -> PaperState:
    """The state that the options in force ask for; with -log_view its work appears in PETSc's log.

    Collective. InputError for what the paper's method has not.
    """
    for name, without in _WITHOUT.items():
        if opt[name] not in without:
            raise InputError(
                f"-{name} {opt[name]}: -fsi_coupling {opt['fsi_coupling']} has none: "
                "take -fsi_coupling conservative"
            )
    names = ("fsi_order", "fsi_h", "fsi_coupling", "fsi_partition", "fsi_spare")
    entropy = bool(opt["fsi_entropy"] or opt["fsi_check"])
    state = PaperState(
        comm, problem, *(opt[name] for name in names), entropy, opt["fsi_viscous"] == "narrow"
    )
    for method, name in _EVENTS.items():
        setattr(state, method, logged(f"fsi {name}", getattr(state, method)))
    return state
