"""What the states of both methods have in common: see BlockState and PaperState."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI

from fsipetsc.errors import FsiError
from fsipetsc.kernels.procedure import Procedure
from fsipetsc.process.together import agree, together
from fsipetsc.scheme.plan import ALLOWED, BATCH, FLAGS, LIMITS, Plan

#: what a rank says of STOP whose user's functions have failed: more than any signal
FAULT = 1000.0


class Seen(NamedTuple):
    """What a rank sees of a layer. numbers: of the points, (n,), as they count over all ranks;
    values: field -> (n,), those first of which others are made; x, X: (n, d) places.
    """

    layer: int
    numbers: np.ndarray
    values: Mapping[str, np.ndarray]
    x: np.ndarray
    X: np.ndarray


class State:
    """A solution and all that belongs to it.

    shapes: of the grids of layers; parts: number k of a layer -> what this rank has of it, if it
    has some. A method says

        owned(k)        a view (M, unknowns) of the solution at the points that this rank owns
        numbers(k)      (M,) of these points
        fields(k)       names of what is saved of a point
        compared(kind)  names of what is compared with exact solutions
        powers(k, names, t, power)  integrals of |difference|^power over this rank's part
        more()          what a checkpoint has beside layers and results, on rank 0
        go_on(t, arrays)  what follows once the solution is that of a checkpoint
        go_to_fault(unphysical)  let the state be the first one of a failed step of which
                        unphysical() says something, if that can be found; returns what the state
                        before the step says of the cause, or ""

    results: flags and limits of the last step (fsipetsc.scheme.plan). batch:
    fsipetsc.scheme.plan. journal: records of steps; latest: that of the last one, without its
    time; the integrals in them are this rank's shares. plan: what `plan_next` of
    fsipetsc.scheme.plan takes, planning: that procedure. fault: the first one of a user's
    function, on this rank, of which all learn after the step.
    """

    #: time of the solution that is saved [s], of which notes tell
    time = 0.0
    #: when -> what says something of a state then
    NOTES: Mapping[str, Sequence[Callable[[Any], Sequence[str]]]] = MappingProxyType({})
    comm: MPI.Comm
    problem: Any
    shapes: Sequence[tuple[int, ...]]
    parts: Mapping[int, Any]
    results: np.ndarray
    planning: Procedure
    fault: FsiError | None

    def plan_next(self) -> bool:
        """Put the last step into the journal; whether another one of its batch follows."""
        self.planning()
        return bool(self.batch[ALLOWED] != 0.0)

    @property
    def asks(self) -> bool:
        """Python is asked for data at each stage: no steps are made together."""
        return not self.problem.steady_data

    @property
    def invariants(self) -> Mapping[str, Any]:
        """What must not change, as JSON has it: see fsipetsc.scheme.conservation_check."""
        return self.problem.invariants

    def _lay_journal(self, record: np.dtype, steps: int, more: int = 0) -> np.ndarray:
        """Make batch, journal, results and latest. Returns the numbers of results, so many
        ``more``, and those of latest.
        """
        rows, self.batch = np.zeros((steps, record.itemsize // 8)), np.zeros(BATCH)
        first = FLAGS + LIMITS
        numbers = np.zeros(first + more + rows.shape[1] - 2)
        self.results, latest = numbers[:first], numbers[first + more :]
        self.journal = rows.reshape(-1).view(record)
        self.latest = latest.view([(name, record[name]) for name in record.names[2:]])[0]
        self.plan = Plan(self.batch, self.results, rows, latest)
        return numbers

    def notes(self, when: str) -> list[str]:
        """What is to be said of the solution at the "begin", when it is "saved", and at the "end".
        Collective.
        """
        of_case = self.problem.notes if when == "begin" else ()
        return [*of_case, *(said for say in self.NOTES.get(when, ()) for said in say(self))]

    # what is made of it

    def header(self) -> dict[str, Any]:
        """What a result file says of layers, and of points that are recorded: none."""
        about = [
            {"name": v.name, "kind": v.kind, "fields": [*self.fields(k)], "shape": [*shape[::-1]]}
            for k, (v, shape) in enumerate(zip(self.problem.layers, self.shapes, strict=True))
        ]
        return {"layers": about, "points": ()}

    def errors(self, t: float, norm: str = "L2") -> dict[str, dict[str, float]] | None:
        """Errors at time t [s]: kind of layer -> name -> (sum w |difference|^p)^(1/p), and
        "combined"; of all layers of a kind.

        norm: "L1" or "L2", p = 1 or 2. None without an exact solution. Collective; InputError if
        it cannot be had.
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
            roots = (total ** (1 / power)).tolist()
            combined = float(total.sum() ** (1 / power))
            found[kind] = {**dict(zip(names[kind], roots, strict=True)), "combined": combined}
        return found

    def capture(self) -> dict[str, np.ndarray] | None:
        """What a step depends on, on rank 0: whole layers, (…, n_1, n_0, unknowns), so that it does
        not depend on who had what, and the results of the last step. Collective.
        """
        arrays = {}
        for k, shape in enumerate(self.shapes):
            found = whole(self.comm, int(np.prod(shape)), self.numbers(k), self.owned(k))
            if found is not None:
                arrays[f"layer{k}"] = found.reshape(*shape[::-1], -1)
        more, latest = self.more(), as_numbers(self.latest).copy()
        if self.comm.rank > 0:
            return None
        return {**arrays, **more, "results": self.results.copy(), "latest": latest}

    def restore(self, arrays: Mapping[str, np.ndarray], t: float) -> None:
        """Be at time t [s] what arrays tell of, which all ranks know. InputError. Collective."""
        self.results[:], as_numbers(self.latest)[:] = arrays["results"], arrays["latest"]
        for k in self.parts:
            own = self.owned(k)
            own[:] = arrays[f"layer{k}"].reshape(-1, own.shape[1])[self.numbers(k)]
        self.go_on(t, arrays)
        agree(self.comm, self.fault)

    def __enter__(self) -> Any:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Destroy it, which is collective, unless this rank may be alone with an error."""
        together_here = isinstance(error, FsiError) and error.collective
        if error is None or self.comm.size == 1 or together_here:
            self.destroy()


def loose(name: str) -> str:
    """What is said of a gas on which a constant force acts node by node."""
    return (
        f"the force on '{name}' is added node by node: a gas at rest stays so to the order of the "
        "scheme only, and small motions may grow"
    )


def whole(comm: MPI.Comm, size: int, numbers: np.ndarray, values: np.ndarray) -> np.ndarray | None:
    """(size, columns), on rank 0, of all ranks' rows of values by their numbers. Collective."""
    every, sent = comm.gather(numbers), [np.ascontiguousarray(values), MPI.DOUBLE]
    if every is None:
        comm.Gatherv(sent, None)
        return None
    received, found = np.empty((2, size, values.shape[1]))
    counts = [values.shape[1] * len(some) for some in every]
    comm.Gatherv(sent, [received, counts, MPI.DOUBLE])
    found[np.concatenate(every)] = received
    return found


def as_numbers(record: np.void) -> np.ndarray:
    """View of a record of doubles as these."""
    return record.reshape(1).view(np.float64)
