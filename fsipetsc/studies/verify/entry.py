"""Entries of the command `verify`: how they run cases, and what they compare the results with."""

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from importlib.resources import files
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from fsipetsc.cases import case_of, load_case
from fsipetsc.checks import Array
from fsipetsc.errors import RanksError
from fsipetsc.options import defaults
from fsipetsc.output.reader import Run, open_run
from fsipetsc.process.together import Comm, together
from fsipetsc.studies.tables import Compared, Expected

FOLDER = files("fsipetsc.studies.verify")


class Trial:
    """An entry at an order of the operators, with a grid spacing h. Results go to ``folder``.

    found: quantity -> (an error, or the number that is compared; what is expected if this is the
    finest grid).
    """

    def __init__(self, comm: Comm, folder: Path, order: int, h: float) -> None:
        self.comm, self.order, self.h = comm, order, h
        self.paths = (str(folder / f"{order}-{h!r}-{k}.h5") for k in count())
        self.found: dict[str, tuple[float | Compared, Expected]] = {}

    def solve(self, what: Any, end: float | None = None, **options: Any) -> Run:
        """Run a case, given by its name or as a problem, to its end or to another time, and return
        its result. Too many ranks: the first of them run it. Collective; FsiError.
        """
        from fsipetsc.stepping.run import run_case

        case = load_case(what) if isinstance(what, str) else case_of(what)
        opt = {**defaults(case), "fsi_order": self.order, "fsi_h": self.h, "fsi_quiet": True}
        if end is not None:
            opt |= {"ts_max_time": end, "fsi_output_dt": end}
        opt |= {**options, "fsi_output": next(self.paths)}
        for size in range(self.comm.size, 0, -1):
            here = self.comm.rank < size
            ranks = self.comm.Split(int(not here), self.comm.rank)
            action = partial(run_case, case, opt, ranks) if here else lambda: None
            with suppress(*[RanksError] * (size > 1)):
                together(self.comm, action, asleep=True)
                break
        return open_run(opt["fsi_output"])

    def check(self, quantity: str, found: Any, order: Any = None, error: Any = None) -> None:
        """Note a quantity, and the order and the error that are expected (see Expected). found: a
        number that is compared, or errors, of which the largest counts.
        """
        one = found if isinstance(found, Compared) else float(np.abs(found).max())
        self.found[quantity] = one, Expected(order, error)


class Entry(NamedTuple):
    """The function of an entry, and the grids of the two levels: order of the operators -> cells in
    a length [m], coarse to fine.
    """

    measure: Callable[[Trial], None]
    quick: Mapping[int, Sequence[int]]
    full: Mapping[int, Sequence[int]]
    length: float = 1.0


#: all entries by name, in the order of the table, once their files are imported
ENTRIES: dict[str, Entry] = {}


def entry(*grids: Mapping[int, Sequence[int]], length: float = 1.0) -> Callable[[Any], Any]:
    """Make a function of a Trial an entry of its own name; problems/NAME.md says the rest."""

    def registered(measure: Any) -> Any:
        ENTRIES[measure.__name__] = Entry(measure, *grids, length)
        return measure

    return registered


def problem(name: str) -> str:
    """Return problems/NAME.md: title, problem and parameters; then a paragraph with the reference,
    and why its errors are expected, which no run of this program says.
    """
    return (FOLDER / "problems" / f"{name}.md").read_text("utf-8")


def reference(name: str) -> dict[str, Array]:
    """Columns of references/NAME.csv; lines that begin with # say units and source."""
    text = (FOLDER / "references" / f"{name}.csv").read_text("utf-8")
    table = csv.reader(line for line in text.splitlines() if not line.startswith("#"))
    return {head: np.array([float(v) for v in column]) for head, *column in zip(*table)}


def mean(errors: Any, power: int = 1) -> float:
    """Return the norm of the mean of |error|^power."""
    return float(np.mean(np.abs(errors) ** power) ** (1 / power))


def joined(frames: Iterable[Mapping[str, Array]]) -> dict[str, Array]:
    """Return the fields of several blocks as one array each."""
    parts = list(frames)
    return {name: np.concatenate([part[name].ravel() for part in parts]) for name in parts[0]}


def smooth(x: Array, y: Array) -> Callable[[Array], Array]:
    """Return a reference between its points: the spline of fifth degree."""
    return make_interp_spline(x, y, k=5)
