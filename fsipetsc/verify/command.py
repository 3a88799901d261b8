"""The command `verify`: cases against references that other codes can be tested with, too."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from fsipetsc.analysis.tables import csv_target, printer, results_folder, save_csv, text_table
from fsipetsc.cases import load_case
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.options import RUN, Option, defaults, read_table
from fsipetsc.output.reader import open_run
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import together, wait_asleep
from fsipetsc.verify import ENTRIES
from fsipetsc.verify.entry import Entry, Measured, Row, rows_of

if TYPE_CHECKING:
    from mpi4py import MPI

_OF_RUN = ("fsi_quiet", "fsi_debug")
OPTIONS = (
    Option("verify_level", str, "quick", "", "how many grids and orders", ("quick", "full")),
    Option("verify_docs", str, None, "", "folder for a page and a picture of each entry"),
    Option("fsi_output", str, "verify", "", "base name of the table NAME.csv and the pictures"),
)
SECTIONS: dict[str, tuple[Option, ...]] = {
    "Verification": OPTIONS,
    "Run": tuple(option for option in RUN if option.name in _OF_RUN),
}
HEAD = ("entry", "quantity", "order", "errors, coarse to fine", "observed", "verdict")
COLUMNS = ("entry", "quantity", "order", "h", "error", "observed_order", "least_order")
COLUMNS += ("largest_error", "verdict", "source")


def verify(arguments: list[str], comm: MPI.Comm) -> None:
    """The command, with the arguments behind its name. Collective on comm.

    Raises InputError; ComputationError at the end where a row falls short; FileError.
    """
    names = []
    while len(names) < len(arguments) and not arguments[len(names)].startswith("-"):
        names.append(arguments[len(names)])
    opt = read_table(SECTIONS, start_petsc(arguments[len(names) :], comm))
    entries = [entry_of(name) for name in names or ENTRIES]
    path, say = csv_target(opt["fsi_output"]), printer(comm, opt)
    rows: list[Row] = []
    for entry in entries:
        say(f"{entry.title} ({entry.name}); reference: {entry.source}")
        found, last = run_entry(entry, opt["verify_level"], comm, path.parent)
        together(comm, lambda: None if comm.rank else _show(entry, found, last, opt, path))  # noqa: B023
        say((table(found) if found else "only with -verify_level full") + "\n")
        rows += found
    together(comm, lambda: None if comm.rank else save(rows, entries, path))
    wait_asleep(comm)
    hold, free = (sum(row.verdict == word for row in rows) for word in ("holds", "no bound"))
    short = len(rows) - hold - free
    say(f"{hold} of {len(rows)} rows hold, {free} have no bound; saved {path}")
    if short:
        raise ComputationError(f"{short} of {len(rows)} rows fall short of their bounds")


def entry_of(name: str) -> Entry:
    """The entry of this name. InputError."""
    if name not in ENTRIES:
        raise InputError(f"verify: there is no entry {name!r}: expected {', '.join(ENTRIES)}")
    entry: Entry = import_module(f"fsipetsc.verify.{name}").ENTRY
    return entry


def run_entry(
    entry: Entry, level: str, comm: MPI.Comm, beside: Path
) -> tuple[list[Row], Measured | None]:
    """Rows of an entry, and what its last run gave. Collective; FsiError. beside: where results are
    kept for a while.
    """
    rows: list[Row] = []
    measured = None
    with results_folder(comm, beside, "verify-") as folder:
        solve = _solver(comm, folder)
        for order, spacings in entry.levels[level].items():
            found = []
            for h in spacings:
                measured = entry.measure(solve, order, h)
                found.append(measured)
            rows += rows_of(entry, order, spacings, found)
    return rows, measured


def _solver(comm: MPI.Comm, folder: Path) -> Callable[..., Any]:
    """solve(case, **options): the opened result of a run; all ranks may read it.

    case: a name, or a problem.
    """
    from fsipetsc.stepping.run import run_case

    numbers = count()

    def solve(name: Any, **options: Any) -> Any:
        case = load_case(name) if isinstance(name, str) else _as_case(name)
        path = str(folder / f"{next(numbers)}.h5")
        opt = {**defaults(case), **options, "fsi_quiet": True, "fsi_output": path}
        run_case(case, opt, comm)
        return open_run(path)

    return solve


def _as_case(problem: Any) -> SimpleNamespace:
    """A case without options of its own; -fsi_h is the spacing of layers, not of blocks."""
    about = {"NAME": "problem", "SUMMARY": "", "OPTIONS": (), "DEFAULTS": {"fsi_h": 1.0}}
    return SimpleNamespace(**about, build=lambda opt: problem)


def table(rows: list[Row]) -> str:
    """The rows of an entry as text."""
    lines = []
    for row in rows:
        errors = " ".join(f"{error:.2e}" for error in row.errors)
        observed = " ".join(f"{order:.2f}" for order in row.observed)
        lines.append((row.entry, row.quantity, row.order, errors, observed, row.verdict))
    return text_table(HEAD, lines)


def save(rows: list[Row], entries: list[Entry], path: Path) -> None:
    """One line for each grid. FileError."""
    source, lines = {entry.name: entry.source for entry in entries}, []
    for row in rows:
        for k, (h, error) in enumerate(zip(row.spacings, row.errors)):
            observed = row.observed[k - 1] if k else ""
            bounds = row.bound.order, row.bound.largest(h, h == row.spacings[-1])
            words = row.entry, row.quantity, row.order, h, error, observed, *bounds
            lines.append((*words, row.verdict, source[row.entry]))
    save_csv(path, COLUMNS, lines)


def _show(
    entry: Entry, rows: list[Row], last: Measured | None, opt: Mapping[str, Any], path: Path
) -> None:
    """Picture, and a page if one is wanted. FileError."""
    from fsipetsc.verify.pages import page, picture

    where = path.with_name(f"{path.stem}-{entry.name}.png")
    if opt["verify_docs"]:
        folder = Path(opt["verify_docs"])
        where = folder / f"{entry.name}.png"
        page(entry, rows, folder)
    if rows:
        picture(entry, rows, last, where)
