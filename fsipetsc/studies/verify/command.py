"""The command `verify`: cases against references that other codes can be tested with, too."""

import textwrap
from collections.abc import Callable
from functools import partial
from itertools import count, takewhile
from pathlib import Path
from typing import Any

from fsipetsc.cases import case_of, load_case
from fsipetsc.errors import ComputationError, InputError, RanksError
from fsipetsc.options import RUN, Option, defaults, read_table
from fsipetsc.output.file_layout import writing
from fsipetsc.output.reader import open_run
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import Comm, together
from fsipetsc.studies.tables import csv_target, on_first, printer, results_folder, save_csv
from fsipetsc.studies.verdicts import COLUMNS, HEAD, Expected, Row, picture, tally, told
from fsipetsc.studies.verify.entry import ENTRIES, Entry, Measured, Solve, problem

OPTIONS = (
    Option("verify_level", str, "quick", "", "how many grids and orders", ("quick", "full")),
    Option("verify_docs", str, None, "", "folder for a page and a picture of each entry"),
    Option("fsi_output", str, "verify", "", "base name of the table NAME.csv and the pictures"),
)
SECTIONS: dict[str, tuple[Option, ...]] = {
    "Verification": OPTIONS,
    "Run": tuple(option for option in RUN if option.name == "fsi_quiet"),
}


def verify(arguments: list[str], comm: Comm) -> None:
    """The command, with the arguments after its name. Collective on comm.

    Raises InputError; ComputationError at the end where a row falls short; FileError.
    """
    names = list(takewhile(lambda word: not word.startswith("-"), arguments))
    opt = read_table(SECTIONS, start_petsc(arguments[len(names) :], comm))
    every = entries()
    for name in names:
        if name not in every:
            raise InputError(f"verify: there is no entry {name!r}: expected {', '.join(every)}")
    path, say = csv_target(opt["fsi_output"]), printer(comm, opt)
    rows: list[Row] = []
    lines: list[Any] = []
    for name in names or every:
        entry = every[name]
        say(f"{_title(name)} ({name})\nreference: {entry.source}\nexpected: {entry.why}")
        found, last = run_entry(name, entry, opt["verify_level"], comm, path.parent)
        on_first(comm, partial(_show, name, entry, found, last, opt, path))
        lines += [line for row in found for line in row.lines(comm.size, entry.source)]
        save_csv(comm, path, COLUMNS, lines)  # and again after each entry
        say((told(found) if found else "only with -verify_level full") + "\n")
        rows += found
    say(f"{tally(rows)} of {len(rows)} rows; saved {path}")
    if short := sum(row.verdict == "falls short" for row in rows):
        raise ComputationError(f"{short} of {len(rows)} rows fall short of what is expected")


def entries() -> dict[str, Entry]:
    """Return all entries by name, in the order of the table. This starts PETSc."""
    from fsipetsc.studies.verify import coupled, gases, small_motions, solids  # noqa: F401

    return ENTRIES


def run_entry(
    name: str, entry: Entry, level: str, comm: Comm, beside: Path
) -> tuple[list[Row], Measured | None]:
    """Rows of an entry, and what its last run gave. Collective; FsiError. beside: where results are
    kept for a while.
    """
    rows: list[Row] = []
    measured = None
    with results_folder(comm, beside, "verify-") as folder:
        solve = _solver(comm, folder)
        for order, spacings in (entry.full if level == "full" else entry.quick).items():
            found = [entry.measure(solve, order, h) for h in spacings]
            measured = found[-1]
            for quantity in measured.errors:
                numbers, expected = tuple(one.errors[quantity] for one in found), measured.expected
                if not isinstance(expected, Expected):
                    expected = expected[quantity]
                rows.append(Row(name, quantity, order, spacings, numbers, expected))
    return rows, measured


def _solver(comm: Comm, folder: Path) -> Solve:
    """See fsipetsc.studies.verify.entry.Solve."""
    from fsipetsc.stepping.run import run_case

    numbers = count()

    def solve(what: Any, order: int, h: float, end: float | None = None, **options: Any) -> Any:
        case = load_case(what) if isinstance(what, str) else case_of(what)
        opt = {**defaults(case), "fsi_order": order, "fsi_h": h, "fsi_quiet": True}
        if end is not None:
            opt |= {"ts_max_time": end, "fsi_output_dt": end}
        opt |= {**options, "fsi_output": str(folder / f"{next(numbers)}.h5")}
        on_as_many(comm, lambda ranks: run_case(case, opt, ranks))
        return open_run(opt["fsi_output"])

    return solve


def on_as_many(comm: Comm, run: Callable[[Comm], None]) -> None:
    """run(ranks) on all ranks of comm or, where these are too many, on the first of them.
    Collective; FsiError.
    """
    for size in range(comm.size, 0, -1):
        ranks = comm.Split(int(comm.rank >= size), comm.rank)
        try:
            action = partial(run, ranks) if comm.rank < size else lambda: None
            return together(comm, action, asleep=True)
        except RanksError:
            if size == 1:
                raise
        finally:
            ranks.Free()


def _title(name: str) -> str:
    return problem(name).split("\n")[0].removeprefix("# ")


def _show(
    name: str, entry: Entry, rows: list[Row], last: Measured | None, opt: Any, path: Path
) -> None:
    """The picture, and FOLDER/NAME.md with problem, table and picture if wanted. FileError."""
    where = path.with_name(f"{path.stem}-{name}.png")
    if opt["verify_docs"]:
        folder = Path(opt["verify_docs"])
        where = folder / f"{name}.png"
        about = f"Reference: {entry.source}. Level: {opt['verify_level']}. Expected: {entry.why}."
        lines = [problem(name), *textwrap.wrap(about, 100), ""]
        if rows:
            table = [f"| {' | '.join(cells)} |" for cells in (HEAD, *(row.cells for row in rows))]
            lines += [table[0], "|---|---:|---|---|---|---|---|", *table[1:]]
            lines += ["", f"![{_title(name)}]({name}.png)", ""]
        else:
            lines += ["Only `-verify_level full` runs this.", ""]
        with writing(folder / f"{name}.md", "the page"):
            (folder / f"{name}.md").write_text("\n".join(lines), encoding="utf-8")
    picture(_title(name), {"": rows}, where, last.curve if last else None)
