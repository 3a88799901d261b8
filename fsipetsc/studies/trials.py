"""The engine of this folder: options, cases on many grids, errors, orders, verdicts, tables."""

import csv
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from importlib.resources import files
from importlib.util import find_spec
from itertools import count, pairwise
from math import log, nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from fsipetsc import ComputationError, InputError, run
from fsipetsc.checks import Array
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.options import RUN, Option, read_options, read_table
from fsipetsc.output import drawing
from fsipetsc.output.file_layout import check_folder, writing
from fsipetsc.output.info import table
from fsipetsc.output.reader import Run
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import Comm, together

#: relative errors that may be round-off
ROUND_OFF = 1e-12
#: options of commands that take no case
USUAL = (
    Option("fsi_output", str, None, "", "name of the table NAME.csv; default: the command's name"),
    *(option for option in RUN if option.name == "fsi_quiet"),
)
#: columns of a table of rows, and of their CSV file
HEAD = ("quantity", "order", "grid spacings", "errors", "observed orders", "expected", "verdict")
COLUMNS = "case quantity order h ranks value reference source error rate verdict".split()


@dataclass
class Row:
    """Errors of a quantity at an order of the operators, from the coarsest grid to the finest.

    What theory, or somebody else, says of it, or None: rate, the order of the errors between the
    two finest grids; most, the largest error on the finest grid. pairs: of each grid the number
    that is compared and its reference, as text, if any is. Errors may be differences from the next
    grid.
    """

    quantity: str
    order: int
    rate: float | None = None
    most: float | None = None
    spacings: list[float] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    pairs: list[tuple[str, ...]] = field(default_factory=list)

    @property
    def expected(self) -> str:
        said = (self.rate, "order {:.3g}"), (self.most, "error {:.2g}")
        return " or ".join(text.format(value) for value, text in said if value is not None)

    @property
    def observed(self) -> list[float]:
        """Orders between neighbouring errors; nan where one is 0, or both are round-off."""
        found = []
        for (a, b), (h, finer) in zip(pairwise(self.errors), pairwise(self.spacings)):
            known = min(a, b) > 0.0 and max(a, b) > ROUND_OFF
            found.append(log(a / b) / log(h / finer) if known else nan)
        return found

    @property
    def verdict(self) -> str:
        """ "converges": at most 0.4 below the order; "holds": below the error; or "falls short"."""
        if self.rate is not None and self.observed and self.observed[-1] >= self.rate - 0.4:
            return "converges"
        return "holds" if self.most is not None and self.errors[-1] <= self.most else "falls short"

    @property
    def cells(self) -> tuple[str, ...]:
        """The words of a table under HEAD."""
        numbers = (self.spacings, ".4g"), (self.errors, ".2e"), (self.observed, ".2f")
        lists = [", ".join(format(v, spec) for v in values) for values, spec in numbers]
        return self.quantity, str(self.order), *lists, self.expected, self.verdict


def picture(title: str, rows: Sequence[Row], path: Path) -> None:
    """Draw errors over spacings: a panel for each quantity; not without matplotlib. FileError."""
    if not rows or find_spec("matplotlib") is None:
        return
    import matplotlib
    from matplotlib.figure import Figure

    names = [*dict.fromkeys(row.quantity for row in rows)]
    with matplotlib.rc_context({**drawing.STYLE, "savefig.dpi": 80}):
        size = 5.0 * min(3, len(names)), 4.2 * -(-len(names) // 3)
        figure = Figure(figsize=size, layout="constrained")
        for axes, name in zip(drawing.panels(figure, len(names), 3), names):
            some = [row for row in rows if row.quantity == name]
            for row in some:
                label = OPERATORS[row.order].name
                # a logarithmic axis has no place for 0
                axes.loglog(row.spacings, row.errors, "o-", nonpositive="mask", label=label)
            axes.set(title=name, xlabel="grid spacing h", ylabel="errors")
            spacings = sorted({h for row in some for h in row.spacings})
            axes.set_xticks([], minor=True)
            axes.set_xticks(spacings, [f"{h:.4g}" for h in spacings], fontsize=8)
            axes.legend()
        figure.suptitle(title, **drawing.TITLE)
        drawing.save(figure, path)


class Trial:
    """A case or an entry at an order of the operators and a spacing h; results go to ``folder``.

    rows: quantity -> its row, to which this grid is added.
    """

    def __init__(self, comm: Comm, folder: Path, order: int, h: float, rows: Any) -> None:
        self.comm, self.order, self.h, self.rows = comm, order, h, rows
        self.paths = (str(folder / f"{order}-{h!r}-{k}.h5") for k in count())

    def solve(self, what: Any, end: float | None = None, **options: Any) -> Run:
        """Run a case, or a problem, to its end or to another time, and return its result.
        Collective; FsiError; ComputationError and InputError name the grid.
        """
        from fsipetsc.stepping.run import REMAINS

        ending = {} if end is None else {"ts_max_time": end, "fsi_output_dt": end}
        own = {"fsi_order": self.order, "fsi_output": next(self.paths), "fsi_quiet": True}
        try:
            return run(what, comm=self.comm, **{"fsi_h": self.h, **ending, **options, **own})
        except (ComputationError, InputError) as error:
            told = str(error).partition(REMAINS)[0]  # the rest is removed with the others
            raise type(error)(f"order {self.order}, h = {self.h:g}: {told}") from None

    @property
    def closures(self) -> int:
        """The order of errors where solutions are smooth, one more than the closures' degree."""
        return self.order // 2 + 1

    def kinked(self, smoothness: float = 1.0) -> float:
        """The order of errors with operators of order p where waves are s times differentiable in
        the norm of the errors: s p/(p + 1), from the dispersion of the shortest of them (P.
        Brenner, V. Thomee, L. Wahlbin, Besov Spaces and Applications to Difference Methods, 1975),
        at most that of closures. In the mean s is 1 for a jump, in the maximum for a kink.
        """
        return min(self.closures, smoothness * self.order / (self.order + 1))

    def check(
        self, quantity: str, errors: Any, rate: Any = None, most: Any = None, power: int = 0
    ) -> Row:
        """Note the largest error, or the norm with this power, and what a ``Row`` expects of it."""
        size = np.abs(errors)
        row = self.rows.setdefault(quantity, Row(quantity, self.order, rate))
        row.spacings.append(self.h)
        row.errors.append(float(np.mean(size**power) ** (1 / power) if power else size.max()))
        row.most = most
        return row

    def compare(
        self, quantity: str, value: Any, reference: Any, rate: Any = None, most: Any = None
    ) -> None:
        """Note a number, its relative distance from a reference, and what is expected of this."""
        row = self.check(quantity, (value - reference) / abs(reference), rate, most)
        row.pairs.append((f"{value:.12g}", f"{reference:.12g}"))


def reference(name: str) -> dict[str, Array]:
    """Columns of references/NAME.csv; lines that begin with # say units and source."""
    text = (files("fsipetsc.studies.verify") / "references" / f"{name}.csv").read_text("utf-8")
    table = csv.reader(line for line in text.splitlines() if not line.startswith("#"))
    return {head: np.array([float(v) for v in column]) for head, *column in zip(*table)}


class Study:
    """A command of this folder as it runs on all ranks of comm. Making one, and all methods but
    ``say``, are collective.

    words: arguments of the command. options: its own, beside those of a case. name: of its CSV file
    if none is given. opt: the options in force; given: those that were given; path: of the CSV
    file. InputError, FileError.
    """

    def __init__(
        self, comm: Comm, words: Sequence[str], options: Any, name: str, case: Any = None
    ) -> None:
        self.comm, self.given = comm, start_petsc(words, comm)
        os.environ.pop("PETSC_OPTIONS", None)  # which is in them; trials have options of their own
        if case is None:
            self.opt = read_table({"": options}, self.given)
        else:
            self.opt = read_options(case, self.given, options)
            if self.opt["fsi_restart"] is not None:
                raise InputError("-fsi_restart: this command begins with the data of the case")
        target = self.given.get("fsi_output", name)
        self.path = Path(re.sub(r"\.(csv|h5|png)$", "", target) + ".csv")
        check_folder(self.path)
        self.lines: list[list[object]] = []  # of the table, so far

    def say(self, text: str) -> None:
        """Print on rank 0; nothing with -fsi_quiet."""
        if self.comm.rank == 0 and not self.opt["fsi_quiet"]:
            print(text, flush=True)

    def save(self, head: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
        """Write a table of rank 0. FileError."""

        def write() -> None:
            with writing(self.path, "the table"), self.path.open("w", encoding="utf-8") as file:
                csv.writer(file, lineterminator="\n").writerows([head, *rows])

        self.on_first(write)

    def table(self, head: Sequence[str], rows: Sequence[Sequence[object]], spec: str) -> None:
        """Print and write a table of rank 0; spec: format of the numbers that are printed."""
        cells = [[format(v, spec) if isinstance(v, float) else v for v in row] for row in rows]
        self.say(table([head, *cells], str.rjust))
        self.save(head, rows)
        self.say(f"\nsaved {self.path}")

    def trials(self, grids: Mapping[int, Sequence[float]]) -> Iterator[list[Trial]]:
        """Yield the trials of each order (-> spacings); their results are in a temporary folder."""
        where, prefix = self.path.parent, f"{self.path.stem}-"
        made = self.on_first(lambda: TemporaryDirectory(dir=where, prefix=prefix))
        with made or nullcontext() as folder:
            folder = Path(self.comm.bcast(folder))
            for order, spacings in grids.items():
                rows: dict[str, Row] = {}
                yield [Trial(self.comm, folder, order, h, rows) for h in spacings]
            self.comm.Barrier()  # other ranks may still read

    def add(
        self, case: str, source: str, rows: Sequence[Row], costs: Mapping[str, Sequence[Any]] = {}
    ) -> None:
        """Print rows, and write the table with them, a line for each grid; costs: more columns."""
        for row in rows:
            about, rates = (case, row.quantity, row.order), ("", *row.observed)
            for i, (h, error) in enumerate(zip(row.spacings, row.errors)):
                pair = row.pairs[i] if row.pairs else ("", "")
                line = *about, h, self.comm.size, *pair, source, error, rates[i]
                self.lines.append([*line, row.verdict, *(of[i] for of in costs.values())])
        self.save([*COLUMNS, *costs], self.lines)
        if rows:
            self.say(table([HEAD, *(row.cells for row in rows)], str.rjust))

    def on_first(self, action: Callable[[], Any], ranks: int = 1) -> Any:
        """action() on the first ranks while the others sleep, and get None; FsiError on all."""
        return together(self.comm, action if self.comm.rank < ranks else lambda: None, asleep=True)
