"""The command `verify`: cases against references that other codes can be tested with, too.

An entry is a function of a Trial, which runs cases on one grid, and notes what they give beside
what is expected.
"""

import csv
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from importlib.resources import files
from itertools import count, groupby, takewhile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from fsipetsc.cases import case_of, load_case
from fsipetsc.checks import Array
from fsipetsc.errors import ComputationError, InputError, RanksError
from fsipetsc.operators.sbp import operator
from fsipetsc.options import RUN, Option, defaults
from fsipetsc.output.file_layout import writing
from fsipetsc.output.reader import Run, open_run
from fsipetsc.process.together import Comm, together
from fsipetsc.studies.tables import COLUMNS, HEAD, Compared, Expected, Row, Study, picture, told

FOLDER = files("fsipetsc.studies.verify")
SECTIONS = {
    "Verification": (
        Option("verify_level", str, "quick", "", "how many grids and orders", ("quick", "full")),
        Option("verify_docs", str, None, "", "folder for a page and a picture of each entry"),
        Option("fsi_output", str, "verify", "", "base name of the table NAME.csv and the pictures"),
        *(option for option in RUN if option.name == "fsi_quiet"),
    )
}


class Trial:
    """A case or an entry at an order of the operators, with a grid spacing h. Results go to
    ``folder``.

    found: quantity -> (an error, or the number that is compared; what is expected if this is the
    finest grid).
    """

    def __init__(self, comm: Comm, folder: Path, order: int, h: float) -> None:
        self.comm, self.order, self.h = comm, order, h
        self.paths = (str(folder / f"{order}-{h!r}-{k}.h5") for k in count())
        self.found: dict[str, tuple[float | Compared, Expected]] = {}

    def solve(self, what: Any, end: float | None = None, **options: Any) -> Run:
        """Run a case, or a problem, to its end or to another time, and return its result. Too many
        ranks: the first of them run it. Collective; FsiError.
        """
        from fsipetsc.stepping.run import run_case

        case = load_case(what) if isinstance(what, str) else what
        case = case if hasattr(case, "build") else case_of(case)
        opt = {**defaults(case), "fsi_quiet": True}
        if end is not None:
            opt |= {"ts_max_time": end, "fsi_output_dt": end}
        opt |= {"fsi_h": self.h, **options, "fsi_order": self.order}
        opt["fsi_output"] = next(self.paths)
        for size in range(self.comm.size, 0, -1):
            here = self.comm.rank < size
            ranks = self.comm.Split(int(not here), self.comm.rank)
            action = partial(run_case, case, opt, ranks) if here else lambda: None
            with suppress(*[RanksError] * (size > 1)):
                together(self.comm, action, asleep=True)
                break
        return together(self.comm, partial(open_run, opt["fsi_output"]))

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


def entries() -> dict[str, Entry]:
    """Return all entries by name, in the order of the table. This starts PETSc."""
    from fsipetsc.studies.verify import gases, small_motions, solids  # noqa: F401

    return ENTRIES


def verify(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm.

    Raises InputError; ComputationError at the end where a row falls short; FileError.
    """
    names = list(takewhile(lambda word: not word.startswith("-"), arguments))
    study, every = Study(comm, arguments[len(names) :], SECTIONS), entries()
    for name in names:
        if name not in every:
            raise InputError(f"verify: there is no entry {name!r}: expected {', '.join(every)}")
    counts: Counter[str] = Counter()
    lines: list[Any] = []
    for name in names or every:
        (title, *_), (*_, about) = problem(name).split("\n", 1), problem(name).split("\n\n")
        study.say(f"{title[2:]} ({name})\n{about.rstrip()}")
        source = " ".join(about.split()).removeprefix("Reference: ").split(". Expected: ")[0]
        rows = run_entry(study, name, every[name])
        lines += [line for row in rows for line in row.lines(comm.size, source)]
        study.save(COLUMNS, lines)  # and again after each entry
        study.on_first(partial(_show, study, name, title[2:], rows))
        study.say((told(rows) if rows else "only with -verify_level full") + "\n")
        counts += Counter(row.verdict for row in rows)
    short = counts["falls short"]
    said = f"{counts['converges']} converge, {counts['holds']} hold, {short} fall short"
    study.say(f"{said} of {counts.total()} rows; saved {study.path}")
    if short:
        raise ComputationError(f"{short} of {counts.total()} rows fall short of what is expected")


def run_entry(study: Study, name: str, entry: Entry) -> list[Row]:
    """Rows of an entry. Collective; FsiError."""
    rows: list[Row] = []
    with study.results_folder() as folder:
        for order, cells in getattr(entry, study.opt["verify_level"]).items():
            trials = [Trial(study.comm, folder, order, entry.length / n) for n in cells]
            for trial in trials:
                entry.measure(trial)
            rows += rows_of(name, trials)
    return rows


def rows_of(name: str, trials: Sequence[Trial]) -> list[Row]:
    """Rows of the quantities that the trials of an order have found, from coarse to fine."""
    order, spacings = trials[-1].order, [trial.h for trial in trials]
    return [
        Row(name, quantity, order, spacings, [trial.found[quantity][0] for trial in trials], known)
        for quantity, (_, known) in trials[-1].found.items()
    ]


def _show(study: Study, name: str, title: str, rows: Sequence[Row]) -> None:
    """The picture, and FOLDER/NAME.md with problem, table and picture if wanted. FileError."""
    where = study.path.with_name(f"{study.path.stem}-{name}.png")
    if study.opt["verify_docs"]:
        where = Path(study.opt["verify_docs"]) / f"{name}.png"
        lines = [problem(name), "Only `-verify_level full` runs this."]
        if rows:
            table = [f"| {' | '.join(cells)} |" for cells in (HEAD, *(row.cells for row in rows))]
            lines[1:] = [table[0], "|---|---:|---|---|---|---|---|", *table[1:]]
            lines += ["", f"![{title}]({name}.png)"]
        with writing(where, "the page"):
            where.with_suffix(".md").write_text("\n".join([*lines, ""]), encoding="utf-8")
    orders = groupby(rows, lambda row: operator(row.order).name)
    picture(title, {of: {row.quantity: row for row in found} for of, found in orders}, where)


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


#: a reference between its points: the spline of fifth degree
smooth = partial(make_interp_spline, k=5)
