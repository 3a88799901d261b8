"""The engine of the commands of this folder: options, cases on grids of many spacings, errors,
observed orders, verdicts; tables and pictures of them.
"""

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from functools import partial
from importlib.resources import files
from importlib.util import find_spec
from itertools import count, pairwise
from math import log, nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from fsipetsc.cases import case_of, load_case
from fsipetsc.checks import Array
from fsipetsc.errors import ComputationError, InputError, RanksError
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.options import defaults, read_options, read_table
from fsipetsc.output import drawing
from fsipetsc.output.file_layout import check_folder, writing
from fsipetsc.output.info import table
from fsipetsc.output.reader import Run, open_run
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import Comm, done_asleep, together

#: how far an observed order may be below what is expected
SLACK = 0.4
#: relative errors that may be round-off
ROUND_OFF = 1e-12
#: columns of a table of rows, and of their CSV file
HEAD = ("quantity", "order", "grid spacings", "errors", "observed orders", "expected", "verdict")
COLUMNS = "case quantity order h ranks value reference source error rate verdict".split()


@dataclass
class Row:
    """Errors of a quantity at an order of the operators, from the coarsest grid to the finest.

    What theory, or somebody else, says of it, or None: rate, the order of the errors between the
    two finest grids; most, the largest error on the finest grid. pairs: of each grid the number
    that is compared and its reference, as text. Errors may be differences from the next grid.
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
        """ "converges" with the expected order, "holds" below the expected error, or "falls short"
        of both.
        """
        if self.rate is not None and self.observed and self.observed[-1] >= self.rate - SLACK:
            return "converges"
        return "holds" if self.most is not None and self.errors[-1] <= self.most else "falls short"

    @property
    def cells(self) -> tuple[str, ...]:
        """The words of a table under HEAD."""
        numbers = (self.spacings, ".4g"), (self.errors, ".2e"), (self.observed, ".2f")
        lists = [", ".join(format(v, spec) for v in values) for values, spec in numbers]
        return self.quantity, str(self.order), *lists, self.expected, self.verdict


def picture(title: str, rows: Sequence[Row], path: Path, by_order: bool = True) -> None:
    """Errors over grid spacings: a panel for each order, a line for each quantity, or the other way
    round; nothing without matplotlib or rows. FileError.
    """
    if not rows or find_spec("matplotlib") is None:
        return
    import matplotlib
    from matplotlib.figure import Figure

    panels = dict[str, dict[str, Row]]()
    for row in rows:
        names = OPERATORS[row.order].name, row.quantity
        panel, line = names if by_order else names[::-1]
        panels.setdefault(panel, {})[line] = row
    with matplotlib.rc_context({**drawing.STYLE, "savefig.dpi": 80}):
        columns, lines = min(3, len(panels)), -(-len(panels) // 3)
        figure = Figure(figsize=(2.0 + 5.0 * columns, 4.2 * lines), layout="constrained")
        places = drawing.panels(figure, len(panels), columns)
        for axes, (panel, some) in zip(places, panels.items(), strict=True):
            for line, row in some.items():
                # a logarithmic axis has no place for 0
                errors = np.where(np.array(row.errors) > 0.0, row.errors, np.nan)
                axes.loglog(row.spacings, errors, "o-", markersize=4, label=line)
            axes.set(title=panel, xlabel="grid spacing h", ylabel="errors")
            spacings = sorted({h for row in some.values() for h in row.spacings})
            axes.set_xticks([], minor=True)
            axes.set_xticks(spacings, [f"{h:.4g}" for h in spacings], fontsize=8)
            axes.legend(fontsize="x-small", loc="upper left", bbox_to_anchor=(1.0, 1.0))
        drawing.set_title(figure, title)
        drawing.save(figure, path)


class Trial:
    """A case or an entry at an order of the operators, with a grid spacing h. Results go to
    ``folder``.

    rows: quantity -> its row, to which this grid is added.
    """

    def __init__(self, comm: Comm, folder: Path, order: int, h: float, rows: Any) -> None:
        self.comm, self.order, self.h, self.rows = comm, order, h, rows
        self.paths = (str(folder / f"{order}-{h!r}-{k}.h5") for k in count())

    def solve(self, what: Any, end: float | None = None, **options: Any) -> Run:
        """Run a case, or a problem, to its end or to another time, and return its result. Too many
        ranks: the first of them run it. Collective; FsiError; ComputationError and InputError name
        the grid.
        """
        from fsipetsc.stepping.run import REMAINS, run_case

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
            try:
                together(self.comm, action, asleep=True)
                break
            except (ComputationError, InputError) as error:
                if size == 1 or not isinstance(error, RanksError):
                    told = str(error).partition(REMAINS)[0]  # the rest is removed with the others
                    words = f"order {self.order}, h = {self.h:g}: {told}"
                    raise type(error)(words) from None
        return together(self.comm, partial(open_run, opt["fsi_output"]))

    @property
    def closures(self) -> int:
        """The order of errors where the solution is smooth: the closures are exact to a degree of
        half the order of the operators, and errors have one order more."""
        return self.order // 2 + 1

    def kinked(self, smoothness: float = 1.0) -> float:
        """The order of errors with operators of order p where waves are s times differentiable in
        the norm of the errors: s p/(p + 1), from the dispersion of the shortest of them (P.
        Brenner, V. Thomee, L. Wahlbin, Besov Spaces and Applications to Difference Methods, 1975),
        at most that of closures. In the mean s is 1 for a jump, in the maximum for a kink.
        """
        return min(self.closures, smoothness * self.order / (self.order + 1))

    def check(
        self, quantity: str, errors: Any, order: Any = None, error: Any = None, power: int = 0
    ) -> None:
        """Note a norm of errors, the largest or that of the mean of |error|^power, and the order
        and the error that are expected.
        """
        size = np.abs(errors)
        norm = float(np.mean(size**power) ** (1 / power) if power else size.max())
        self._add(quantity, norm, order, error)

    def compare(
        self, quantity: str, value: Any, reference: Any, order: Any = None, error: Any = None
    ) -> None:
        """Note a number, its relative distance from a reference, and what is expected of this."""
        apart = float(abs(value - reference) / abs(reference))
        self._add(quantity, apart, order, error, f"{value:.12g}", f"{reference:.12g}")

    def _add(self, quantity: str, error: float, rate: Any, most: Any, *pair: str) -> None:
        row = self.rows.setdefault(quantity, Row(quantity, self.order))
        row.spacings.append(self.h)
        row.errors.append(error)
        row.pairs.append(pair or ("", ""))
        row.rate, row.most = rate, most


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
        self, comm: Comm, words: Sequence[str], options: Any, name: str = "", case: Any = None
    ) -> None:
        self.comm, self.given = comm, start_petsc(words, comm)
        if case is None:
            self.opt = read_table({"": options}, self.given)
        else:
            self.opt = read_options(case, self.given, options)
            if self.opt["fsi_restart"] is not None:
                raise InputError("-fsi_restart: this command begins with the data of the case")
        target = self.opt["fsi_output"] if case is None or "fsi_output" in self.given else name
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

    def measured(
        self, grids: Mapping[int, Sequence[float]], measure: Callable[[Trial], None]
    ) -> Iterator[list[Row]]:
        """Yield the rows of each order that a function makes of trials, on grids from coarse to
        fine: order -> spacings. Results are in a folder beside the table, which is removed.
        """
        where = {"dir": self.path.parent, "prefix": f"{self.path.stem}-"}
        made = partial(TemporaryDirectory, **where, ignore_cleanup_errors=True)
        with self.on_first(made) or nullcontext() as folder:
            folder = Path(self.comm.bcast(folder))
            for order, spacings in grids.items():
                rows: dict[str, Row] = {}
                for h in spacings:
                    measure(Trial(self.comm, folder, order, h, rows))
                yield [*rows.values()]
            done_asleep(self.comm.Ibarrier())  # other ranks may still read

    def add(
        self, case: str, source: str, rows: Sequence[Row], costs: Mapping[str, Sequence[Any]] = {}
    ) -> None:
        """Print rows, and write the table with them, a line for each grid; costs: more columns."""
        for row in rows:
            about, rates = (case, row.quantity, row.order), ("", *row.observed)
            for i, (h, error) in enumerate(zip(row.spacings, row.errors)):
                line = *about, h, self.comm.size, *row.pairs[i], source, error, rates[i]
                self.lines.append([*line, row.verdict, *(of[i] for of in costs.values())])
        self.save([*COLUMNS, *costs], self.lines)
        if rows:
            self.say(table([HEAD, *(row.cells for row in rows)], str.rjust))

    def on_first(self, action: Callable[[], Any]) -> Any:
        """action() on rank 0, while the others sleep: what it gives there, None elsewhere. FsiError
        of rank 0 on all.
        """
        here = self.comm.rank == 0
        return together(self.comm, action if here else lambda: None, asleep=True)
