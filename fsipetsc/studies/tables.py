"""What the commands of this folder share: work on all ranks, tables, and of errors on grids the
observed orders, verdicts and pictures.
"""

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from functools import partial
from importlib.util import find_spec
from itertools import groupby
from math import log, nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import operator
from fsipetsc.options import read_options, read_table
from fsipetsc.output.file_layout import check_folder, writing
from fsipetsc.output.plots.style import STYLE, save, set_title
from fsipetsc.process.launch import start_petsc
from fsipetsc.process.together import Comm, together, wait_asleep

#: how far an observed order may be below what is expected
SLACK = 0.4
#: errors, relative ones, that may be round-off
ROUND_OFF = 1e-12
#: relative differences of grids that resolve a solution are smaller
RESOLVED = 0.1
#: orders that are looked for where grids are compared with each other
LEAST, MOST = -4.1, 16.0
#: columns of a table of rows, and of their CSV file
HEAD = ("quantity", "order", "grid spacings", "errors", "observed orders", "expected", "verdict")
COLUMNS = "case quantity order h ranks value reference source error rate verdict".split()


class Study:
    """A command of this folder as it runs on all ranks of comm. Making one, and all methods but
    ``say``, are collective.

    words: arguments of the command. options: heading -> its options, or with a case those beside
    the case's. name: of its CSV file if none is given. opt: the options in force; given: those that
    were given; path: of the CSV file. InputError, FileError.
    """

    def __init__(
        self, comm: Comm, words: Sequence[str], options: Any, name: str = "", case: Any = None
    ) -> None:
        self.comm, self.given = comm, start_petsc(words, comm)
        if case is None:
            self.opt = read_table(options, self.given)
        else:
            self.opt = read_options(case, self.given, options)
            if self.opt["fsi_restart"] is not None:
                raise InputError("-fsi_restart: this command begins with the data of the case")
        target = self.opt["fsi_output"] if case is None or "fsi_output" in self.given else name
        self.path = Path(re.sub(r"\.(csv|h5|png)$", "", target) + ".csv")
        check_folder(self.path)

    def say(self, text: str) -> None:
        """Print on rank 0; nothing with -fsi_quiet."""
        if self.comm.rank == 0 and not self.opt["fsi_quiet"]:
            print(text, flush=True)

    def save(self, head: Sequence[str], rows: Iterable[Sequence[object]], about: str = "") -> None:
        """Write a table of rank 0; about: a first line, which begins with #. FileError."""

        def write() -> None:
            with writing(self.path, "the table"), self.path.open("w", encoding="utf-8") as file:
                file.write(f"# {about}\n" if about else "")
                csv.writer(file, lineterminator="\n").writerows([head, *rows])

        self.on_first(write)

    def table(self, head: Sequence[str], rows: Sequence[Sequence[object]], spec: str) -> None:
        """Print and write a table of rank 0; spec: format of the numbers that are printed."""
        cells = [[format(v, spec) if isinstance(v, float) else v for v in row] for row in rows]
        self.say(text_table(head, cells))
        self.save(head, rows)
        self.say(f"\nsaved {self.path}")

    def on_first(self, action: Callable[[], Any]) -> Any:
        """action() on rank 0, while the others sleep: what it gives there, None elsewhere. FsiError
        of rank 0 on all.
        """
        here = self.comm.rank == 0
        return together(self.comm, action if here else lambda: None, asleep=True)

    def share(self, tasks: Sequence[Any], one: Callable[[Any], Any]) -> list[Any]:
        """one(task) of all tasks on every rank; each computes its share. FsiError."""
        rank, size = self.comm.rank, self.comm.size
        shares = self.comm.allgather(together(self.comm, lambda: list(map(one, tasks[rank::size]))))
        return [shares[i % size][i // size] for i in range(len(tasks))]

    @contextmanager
    def results_folder(self) -> Iterator[Path]:
        """A new folder beside the table, for results that are removed in the end."""
        where = {"dir": self.path.parent, "prefix": f"{self.path.stem}-"}
        made = partial(TemporaryDirectory, **where, ignore_cleanup_errors=True)
        with self.on_first(made) or nullcontext() as folder:
            yield Path(self.comm.bcast(folder))
            wait_asleep(self.comm)  # other ranks may still read


def text_table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Columns that end below each other, two blanks apart."""
    cells = [head, *([str(cell) for cell in row] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells)]
    lines = ["  ".join(map(str.rjust, line, widths)) for line in cells]
    return "\n".join(line.rstrip() for line in lines)


def listed_in(allowed: Sequence[int]) -> Callable[[Sequence[int]], str | None]:
    """Return the check of an option: some of the allowed numbers."""
    words = f"numbers out of {','.join(map(str, allowed))}"
    return lambda values: None if values and set(values) <= set(allowed) else words


class Compared(NamedTuple):
    """A number beside its reference. size: what their distance is divided by; None: by the
    reference.
    """

    value: complex
    reference: complex
    size: float | None = None

    @property
    def error(self) -> float:
        """The distance from the reference over the size."""
        size = abs(self.reference) if self.size is None else self.size
        return abs(self.value - self.reference) / size


class Expected(NamedTuple):
    """What theory, or somebody else, says of a quantity; None where they say nothing.

    order: of the errors between the two finest grids; error: at most, on the finest grid.
    """

    order: float | None = None
    error: float | None = None

    def __str__(self) -> str:
        said = (self.order, "order {:.3g}"), (self.error, "error {:.2g}")
        return " or ".join(text.format(value) for value, text in said if value is not None)


def round_off(steps: float) -> float:
    """The largest relative error of a number that is rounded once in each of so many steps."""
    return steps * 2.0**-52


def closures(order: int) -> int:
    """The order of errors with operators of this order, where the solution is smooth: the closures
    are exact to a degree of half of it, and errors have one order more."""
    return order // 2 + 1


def kinked(order: int, smoothness: float = 1.0) -> float:
    """The order of errors with operators of order p where waves are s times differentiable in the
    norm of the errors: s p/(p + 1), from the dispersion of the shortest of them (P. Brenner, V.
    Thomee, L. Wahlbin, Besov Spaces and Applications to Difference Methods, 1975), at most that of
    closures. In the mean s is 1 for a jump, in the maximum for a kink.
    """
    return min(closures(order), smoothness * order / (order + 1))


class Row(NamedTuple):
    """A quantity at an order on each grid: errors, or the numbers that are compared.

    between: the numbers are differences of each grid from the next finer one.
    """

    entry: str
    quantity: str
    order: int
    spacings: Sequence[float]
    found: Sequence[float | Compared]
    expected: Expected
    between: bool = False

    @property
    def errors(self) -> list[float]:
        """The error on each grid."""
        return [one.error if isinstance(one, Compared) else one for one in self.found]

    @property
    def observed(self) -> list[float]:
        """Orders between neighbouring errors; nan where one is 0, or both are round-off."""
        h, found = self.spacings, []
        for k, (a, b) in enumerate(zip(self.errors, self.errors[1:])):
            if not (min(a, b) > 0.0 and max(a, b) > ROUND_OFF):
                found.append(nan)
            elif self.between:
                found.append(order_of_differences(a / b, *h[k : k + 3]))
            else:
                found.append(log(a / b) / log(h[k] / h[k + 1]))
        return found

    @property
    def verdict(self) -> str:
        """ "converges" with the expected order, "holds" below the expected error, or "falls short"
        of both; differences that are not small fall short in any case.
        """
        (order, most), error = self.expected, self.errors[-1]
        if self.between and not error <= RESOLVED:
            return "falls short"
        if order is not None and self.observed and self.observed[-1] >= order - SLACK:
            return "converges"
        return "holds" if most is not None and error <= most else "falls short"

    def lines(self, ranks: int, source: str) -> list[list[object]]:
        """Of a CSV file, under COLUMNS: one for each grid; norms of errors have no value and no
        reference."""
        found, about, rates = [], [self.entry, self.quantity, self.order], ("", *self.observed)
        for h, one, error, rate in zip(self.spacings, self.found, self.errors, rates):
            pair = [f"{v:.12g}" for v in one[:2]] if isinstance(one, Compared) else ["", ""]
            found.append([*about, h, ranks, *pair, source, error, rate, self.verdict])
        return found

    @property
    def cells(self) -> tuple[str, ...]:
        """The words of a table under HEAD."""
        numbers = (self.spacings, ".4g"), (self.errors, ".2e"), (self.observed, ".2f")
        lists = [", ".join(format(v, spec) for v in values) for values, spec in numbers]
        return self.quantity, str(self.order), *lists, str(self.expected), self.verdict


def order_of_differences(ratio: float, first: float, second: float, third: float) -> float:
    """p with (first^p - second^p) / (second^p - third^p) = ratio; nan where there is none."""

    def excess(p: float) -> float:
        return (first**p - second**p) / (second**p - third**p) - ratio

    there = excess(LEAST) * excess(MOST) < 0.0
    return float(brentq(excess, LEAST, MOST)) if there else nan


def told(rows: Sequence[Row]) -> str:
    """Return a table for each order."""
    tables = []
    for order, group in groupby(rows, lambda row: row.order):
        cells = [row.cells for row in group]
        body = text_table((HEAD[0], *HEAD[3:]), [(cell[0], *cell[3:]) for cell in cells])
        tables.append(f"{operator(order).name}, h = {cells[0][2]}\n{body}")
    return "\n\n".join(tables)


def picture(title: str, panels: Mapping[str, Mapping[str, Row]], path: Path) -> None:
    """Errors over grid spacings: a panel for each heading, a line for each label in it; nothing
    without matplotlib or without rows. FileError.
    """
    if not any(panels.values()) or find_spec("matplotlib") is None:
        return
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context({**STYLE, "savefig.dpi": 80}):
        figure = Figure(figsize=(2.0 + 5.0 * len(panels), 4.2), layout="constrained")
        places = figure.subplots(1, len(panels), squeeze=False)[0]
        for axes, (heading, rows) in zip(places, panels.items(), strict=True):
            colors = "tab10" if len(rows) <= 10 else "tab20"
            axes.set_prop_cycle(color=matplotlib.colormaps[colors].colors)
            for label, row in rows.items():
                # a logarithmic axis has no place for 0
                errors = np.where(np.array(row.errors) > 0.0, row.errors, np.nan)
                axes.loglog(row.spacings[: len(errors)], errors, "o-", markersize=4, label=label)
            axes.set(title=heading, xlabel="grid spacing h", ylabel="errors")
            spacings = sorted({h for row in rows.values() for h in row.spacings})
            axes.set_xticks([], minor=True)
            axes.set_xticks(spacings, [f"{h:.4g}" for h in spacings], fontsize=8)
            axes.legend(fontsize="x-small", loc="upper left", bbox_to_anchor=(1.0, 1.0))
        set_title(figure, title)
        save(figure, path)
