"""What the states of both methods have in common: steps, checkpoints, errors."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI

from fsipetsc.errors import FsiError, InputError
from fsipetsc.kernels.procedure import Calls, Code, Procedure
from fsipetsc.process.together import agree, together
from fsipetsc.scheme import plan
from fsipetsc.scheme.plan import FRACTIONS, SOLUTION, STAGES
from fsipetsc.scheme.recorded_data import Source, set_data, timed

#: what a rank says of STOP whose user's functions have failed: more than any signal
FAULT = 1000.0


class OfRates(NamedTuple):
    """A procedure of a phase which takes the rates alone."""

    procedure: Procedure


class State(AbstractContextManager[Any]):
    """A solution and all that belongs to it: steps, checkpoints, errors. All is collective.

    Stages 0 to 3 of a step begin with the solution; SOLUTION is the one that comes of them. A
    method has arrays y, this rank's part of the solution, and `changing`, which steps change and
    stages do not follow from; shapes of the grids of layers; parts: layer -> what is here. It says

        refresh(t)      data of the case are those at t [s], as Python finds them; InputError
        load(n, y), unload(n, y)  copy a solution into stage n, or out of it
        vectors(n)      stage n, and where its rates go
        show(n)         let what is saved and seen be that of stage n
        begin()         what follows from the solution, and not from the stages before it
        owned(k), numbers(k)  (M, unknowns), a view of the solution at the points of this rank; (M,)
        fields(k), compared(kind)  names of what is saved of a point, of what has exact solutions
        powers(k, names, t, power)  integrals of |difference|^power over this rank's part
        seen()          of each layer here its number; (n,) numbers of points, as they count over
                        all ranks; field -> (n,), those first of which others are made; x, X (n, d)
        more(), take(arrays)  what a checkpoint has beside layers and results, on rank 0

    results: flags and limits of the last step, batch: fsipetsc.scheme.plan. journal: records of
    steps; latest: that of the last one, without its time, latest_numbers: the same as doubles; the
    integrals in them are this rank's shares. asked: Python is asked for data that depend on time;
    not_recorded: why. fault:
    the first one of a user's function, on this rank, of which all learn after the step.
    evaluations: of the right-hand side.

    phases: name, or name_n for stage n -> procedures and exchanges in their order, of the stage
    and its rates, or `OfRates`:

        data        set the data of its time, which C knows
        fulfil      let it obey all conditions
        begin       find what rates need of a solution that obeys them
        rates       f = dy/dt
        advance     make the next stage
        complete    the same, and find bounds, integrals, records of the solution
    """

    fault: FsiError | None = None
    asked = False
    _begun = False  # the phase begin, for the solution and the data of its time
    evaluations = 0
    phases: dict[str, list[Any]]
    #: a step that leaves an unphysical state is made anew in up to so many parts
    MOST_PARTS = 1

    def _take_calls(self, library: Any, planning: Procedure, exchanges: Sequence[Any]) -> None:
        """Load exchanges; list the calls of a step, of which `plan_next` plans the next one."""
        self._library, self.planning, self._exchanges = library, planning, exchanges
        for exchange in exchanges:
            exchange.load(library)
        self._made: dict[Any, Calls] = {}
        calls, names = self._calls("advance", 0), ("data", "fulfil", "advance")
        for n in range(1, STAGES):
            calls += [one for name in names for one in self._calls(name, n)]
        calls += [*self._calls("fulfil", SOLUTION), *self._calls("complete", SOLUTION)]
        self._whole_step = Calls(library, [*calls, (planning, ())])

    def _calls(self, name: str, n: int) -> list[Any]:
        """The calls of a phase of stage n: procedure, vectors."""
        (y, rates), found = self.vectors(n), []
        for one in self.phases.get(f"{name}_{n}", self.phases.get(name, ())):
            alone = isinstance(one, OfRates)
            procedure, vectors = (one.procedure, (rates,)) if alone else (one, (y, rates))
            if not getattr(procedure, "empty", False):
                found.append((procedure, vectors[: len(procedure.vectors)]))
        return found

    def _do(self, name: str, n: int) -> None:
        if (name, n) not in self._made:
            self._made[name, n] = Calls(self._library, self._calls(name, n))
        self._made[name, n]()

    def set_data(self, t: float) -> None:
        """Let data be those at time t [s]: C fills those that depend on it, unless Python is asked,
        whose errors are faults.
        """
        if not self.asked:
            return self._fill(t)
        try:
            self.refresh(t)
        except InputError as error:  # the step goes on, as other ranks wait for messages
            self.fault = self.fault or error
            self.results[plan.SAID_STOP] = FAULT

    def right_hand_side(self, y: np.ndarray, f: np.ndarray) -> None:
        """f = dy/dt of this rank's part y, which stays as it is, for the data set last. f is not
        filled here: a method copies rates to it, as nothing may keep vectors of PETSc's for later.
        """
        self.evaluations += 1
        self._begun = False
        self.load(1, y)
        self._do("fulfil", 1)
        self._do("rates", 1)

    def project(self, y: np.ndarray) -> None:
        """Let this rank's part y obey all conditions, in place."""
        self._begun = False
        self.load(1, y)
        self._do("fulfil", 1)
        self.unload(1, y)

    def finish(self) -> None:
        """Complete the solution that PETSc, or the case, has made."""
        self.load(SOLUTION, self.solution.getArray())
        self._do("fulfil", SOLUTION)
        self.solution.stateIncrease()
        self.complete()

    def complete(self) -> None:
        self._do("complete", SOLUTION)
        self.completed()

    def completed(self) -> None:
        """Be at the solution that is completed, from which the next step has begun."""
        self._begun = True

    def keep(self) -> None:
        self._kept = [array.copy() for array in self.changing]

    def step(self) -> None:
        """Make the planned step from the completed solution, and the others of its batch, in C."""
        self.keep()
        if self.asked:
            self._advance()
            self.planning()
        else:
            self.set_data(float(self.batch[plan.TIME]))
            if not self._begun:
                self._do("begin", 0)
            self._whole_step(self.results[plan.BAD :], self.batch[plan.ALLOWED :])
            self.completed()
        self.evaluations += STAGES * max(1, int(self.batch[plan.MADE]))

    def step_in_parts(self, parts: int) -> None:
        """Make the step that is planned in so many equal parts; what is noted is one step."""
        times = [plan.TIME, plan.DT, plan.NEXT]
        t, dt, after = planned = self.batch[times].tolist()
        for part in range(parts):
            last = part + 1 == parts
            end = after if last else t + dt * (part + 1) / parts
            self.batch[times] = t + dt * part / parts, dt / parts, end
            self._advance(ends=last)
        self.batch[times] = planned
        self.planning()
        self.evaluations += STAGES * parts

    def _advance(self, look: Any = None, ends: bool = True) -> Any:
        """Make a step, until look() finds something in a stage; ends: complete the solution."""
        for n, part in enumerate(FRACTIONS):
            self.set_data(float(plan.time_of(part, self.batch)))
            self._do("fulfil" if n > 0 else "begin", n)
            if n == SOLUTION and ends:
                self.complete()
            if n > 0 and look is not None:
                self.show(n)
                if found := look():
                    return found
            if n < SOLUTION:
                self._do("advance", n)
        return None

    def go_back(self) -> None:
        """Be where the last batch of steps began."""
        for array, kept in zip(self.changing, self._kept):
            array[:] = kept
        self._begun = False
        self.begin()

    def repeat(self, look: Callable[[], Any]) -> Any:
        """Go on from there until look() finds something in a stage, which is returned: NaN spreads
        from there. None if it finds nothing. Python is asked for recorded data, as it says what is
        wrong. InputError for data that are wrong.
        """
        self.asked = not self.problem.steady_data
        while True:
            found = self._advance(look)
            agree(self.comm, self.fault)
            if found:
                return found
            self.planning()  # the same steps write the same records
            if self.batch[plan.ALLOWED] == 0.0:
                return None

    def _record_data(self, groups: Sequence[Sequence[Source]], time: np.ndarray) -> list[Code]:
        """Codes that fill the data that depend on time, of each group; none if one cannot be
        recorded. time: (1,), that of the data. _targets: what they fill, and what it is of.
        """
        tried = [timed(sources) for sources in groups]
        self._ask([why for _, refused in tried for why in refused])
        every = [tuple(found) for found, _ in tried if found and not self.asked]
        codes, self._time = [Code() for _ in every], time
        self._data = [c.procedure("set_data", set_data, f, time) for c, f in zip(codes, every)]
        self._targets = [(one.about, of) for found in every for one in found for of in one.targets]
        return codes

    def _ask(self, why: list[str]) -> None:
        """Let Python be asked for data if a rank has a reason."""
        self.not_recorded = [one for some in self.comm.allgather(why) for one in some]
        self.asked = bool(self.not_recorded)

    def _fill(self, t: float) -> None:
        """Let C fill the recorded data at time t [s]."""
        self._time[0] = t
        for procedure in self._data:
            procedure()

    def _lay_journal(self, record: np.dtype, more: int = 0) -> np.ndarray:
        """Make batch, journal, latest and results. Returns results with so many numbers more."""
        rows, self.batch = np.zeros((plan.CAPACITY, record.itemsize // 8)), np.zeros(plan.BATCH)
        self.latest_numbers, numbers = np.zeros(rows.shape[1] - 2), np.zeros(plan.RESULTS + more)
        self.results, self.journal = numbers[: plan.RESULTS], rows.reshape(-1).view(record)
        kind = [(name, record[name]) for name in record.names[2:]]
        self.latest = self.latest_numbers.view(kind)[0]
        of_steps = {"journal": rows, "latest": self.latest_numbers}
        self.plan = SimpleNamespace(batch=self.batch, results=self.results, **of_steps)
        return numbers

    def header(self) -> dict[str, Any]:
        """What a result file says of layers, and of points that are recorded: none."""
        about = [
            {"name": v.name, "kind": v.kind, "fields": [*self.fields(k)], "shape": [*shape[::-1]]}
            for k, (v, shape) in enumerate(zip(self.problem.layers, self.shapes, strict=True))
        ]
        return {"layers": about, "points": ()}

    def errors(self, t: float, norm: str = "L2") -> dict[str, dict[str, float]] | None:
        """Errors at time t [s]: kind of layer -> name -> (sum w |difference|^p)^(1/p), and
        "combined"; p = 1 or 2 for the norm "L1" or "L2". None without an exact solution.
        Collective; InputError.
        """
        layers, power = self.problem.layers, {"L1": 1, "L2": 2}[norm]
        if any(layer.exact is None for layer in layers):
            return None
        names = {kind: self.compared(kind) for kind in sorted({v.kind for v in layers})}
        sums = {kind: np.zeros(len(names[kind])) for kind in names}

        def add_up() -> None:
            for k in self.parts:
                kind = layers[k].kind
                sums[kind] += self.powers(k, names[kind], t, power)

        together(self.comm, add_up)
        found = {}
        for kind, own in sums.items():
            total = self.comm.allreduce(own)
            of_names = dict(zip(names[kind], (total ** (1 / power)).tolist(), strict=True))
            found[kind] = {**of_names, "combined": float(total.sum() ** (1 / power))}
        return found

    def capture(self) -> dict[str, Any] | None:
        """What a step depends on, on rank 0: whole layers, (points, unknowns), and results."""
        layers = range(len(self.shapes))
        found = {f"layer{k}": whole(self.comm, self.numbers(k), self.owned(k)) for k in layers}
        found |= {**self.more(), "evaluations": np.array(self.evaluations)}
        found |= {"results": self.results, "latest": self.latest_numbers}
        return found if self.comm.rank == 0 else None

    def restore(self, arrays: Mapping[str, np.ndarray], t: float) -> None:
        """Be at time t [s] what ``capture`` told of, which all ranks know. InputError."""
        self.results[:], self.latest_numbers[:] = arrays["results"], arrays["latest"]
        self.evaluations = int(arrays["evaluations"])
        for k in self.parts:
            self.owned(k)[:] = arrays[f"layer{k}"][self.numbers(k)]
        self.take(arrays)
        self.set_data(t)
        self.begin()
        agree(self.comm, self.fault)

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Destroy it, which is collective, unless this rank may be alone with an error."""
        together_here = isinstance(error, FsiError) and error.collective
        if error is None or self.comm.size == 1 or together_here:
            self.destroy()

    def destroy(self) -> None:
        for exchange in self._exchanges:
            exchange.destroy()
        self.solution.destroy()


def whole(comm: MPI.Comm, numbers: np.ndarray, values: np.ndarray) -> np.ndarray | None:
    """On rank 0, of all ranks' rows of values those by their numbers. Collective."""
    every, sent = comm.gather(numbers), [np.ascontiguousarray(values), MPI.DOUBLE]
    if every is None:
        comm.Gatherv(sent, None)
        return None
    order, width = np.concatenate(every), values.shape[1]
    received = np.empty((len(order), width))
    comm.Gatherv(sent, [received, [width * len(some) for some in every], MPI.DOUBLE])
    return received[np.argsort(order)]
