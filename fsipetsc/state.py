"""What the states of both methods have in common: see BlockState and PaperState."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from mpi4py import MPI

from fsipetsc.errors import FsiError
from fsipetsc.kernels.procedure import Procedure
from fsipetsc.scheme.batch import ALLOWED, Plan
from fsipetsc.scheme.plan import BATCH, FLAGS, LIMITS

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

    results: flags and limits of the last step (fsipetsc.scheme.plan). batch: fsipetsc.scheme.batch.
    journal: records of steps; latest: that of the last one, without its time; the integrals in them
    are this rank's shares. plan: what `plan_next` of fsipetsc.scheme.batch takes, planning: that
    procedure. fault: the first one of a user's function, on this rank, of
    which all learn after the step.
    """

    #: time of the solution that is saved [s], of which notes tell
    time = 0.0
    #: when -> what says something of a state then
    NOTES: Mapping[str, Sequence[Callable[[Any], Sequence[str]]]] = MappingProxyType({})
    comm: MPI.Comm
    problem: Any
    results: np.ndarray
    planning: Procedure

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

    def _lay_journal(
        self, record: np.dtype, steps: int, more: int = 0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Make batch, journal, results and latest. Returns, as numbers, the journal, and results,
        so many ``more`` and latest.
        """
        rows, self.batch = np.zeros((steps, record.itemsize // 8)), np.zeros(BATCH)
        first = FLAGS + LIMITS
        numbers = np.zeros(first + more + rows.shape[1] - 2)
        self.results, latest = numbers[:first], numbers[first + more :]
        self.journal = rows.reshape(-1).view(record)
        self.latest = latest.view([(name, record[name]) for name in record.names[2:]])[0]
        self.plan = Plan(self.batch, self.results, rows, latest)
        return rows, numbers

    def notes(self, when: str) -> list[str]:
        """What is to be said of the solution: at the "begin", when it is "saved", at the "end", and
        where it has "failed". Collective.
        """
        of_case = self.problem.notes if when == "begin" else ()
        return [*of_case, *(said for say in self.NOTES.get(when, ()) for said in say(self))]

    def go_to_fault(self, unphysical: Callable[[], Any]) -> str:
        """Go to where a failed step became unphysical, if that can be found. Returns what the
        state before the step says of the cause, or "". unphysical: tells, of the values that are
        seen now, whether they are. Collective.
        """
        return ""

    def _norms(
        self, sums: Mapping[str, np.ndarray], names: Mapping[str, Sequence[str]], power: int
    ) -> dict[str, dict[str, float]]:
        """kind -> name -> (sum over all ranks)^(1/p), and "combined"; sums: of powers, kind -> this
        rank's, in the order of the names. Collective.
        """
        found = {}
        for kind, own in sums.items():
            total = self.comm.allreduce(own)
            roots = (total ** (1 / power)).tolist()
            combined = float(total.sum() ** (1 / power))
            found[kind] = {**dict(zip(names[kind], roots, strict=True)), "combined": combined}
        return found

    def __enter__(self) -> Any:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Destroy it, which is collective, unless this rank may be alone with an error."""
        together_here = isinstance(error, FsiError) and error.collective
        if error is None or self.comm.size == 1 or together_here:
            self.destroy()


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
