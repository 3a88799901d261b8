"""Cases and entries on grids: errors, observed orders, verdicts, pictures."""

import csv
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from importlib.resources import files
from importlib.util import find_spec
from itertools import count, groupby, pairwise
from math import log, nan
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.cases import case_of, load_case
from fsipetsc.checks import Array
from fsipetsc.errors import ComputationError, InputError, RanksError
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.options import defaults
from fsipetsc.output import drawing
from fsipetsc.output.reader import Run, open_run
from fsipetsc.process.together import Comm, together

#: how far an observed order may be below what is expected
SLACK = 0.4
#: relative errors that may be round-off
ROUND_OFF = 1e-12
#: columns of a table of rows, and of their CSV file
HEAD = ("quantity", "order", "grid spacings", "errors", "observed orders", "expected", "verdict")
COLUMNS = "case quantity order h ranks value reference source error rate verdict".split()


class Row(NamedTuple):
    """Errors of a quantity at an order of the operators, from the coarsest grid to the finest.

    What theory, or somebody else, says of it, or None: rate, the order of the errors between the
    two finest grids; most, the largest error on the finest grid. pairs: on each grid the number
    that is compared and its reference, or (). Errors may be differences from the next finer grid.
    """

    quantity: str
    order: int
    spacings: Sequence[float]
    errors: Sequence[float]
    rate: float | None = None
    most: float | None = None
    pairs: Sequence[tuple[complex, ...]] = ()

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

    def lines(self, case: str, ranks: int, source: str) -> list[list[object]]:
        """Lines of a CSV file under COLUMNS, one for each grid."""
        about, found, rates = (case, self.quantity, self.order), [], ("", *self.observed)
        pairs = self.pairs or [()] * len(self.errors)
        for h, pair, error, rate in zip(self.spacings, pairs, self.errors, rates):
            words = [f"{value:.12g}" for value in pair] or ["", ""]
            found.append([*about, h, ranks, *words, source, error, rate, self.verdict])
        return found

    @property
    def cells(self) -> tuple[str, ...]:
        """The words of a table under HEAD."""
        numbers = (self.spacings, ".4g"), (self.errors, ".2e"), (self.observed, ".2f")
        lists = [", ".join(format(v, spec) for v in values) for values, spec in numbers]
        return self.quantity, str(self.order), *lists, self.expected, self.verdict


def picture(title: str, rows: Sequence[Row], path: Path) -> None:
    """Errors over grid spacings: a panel for each order, a line for each quantity; nothing without
    matplotlib or rows. FileError.
    """
    if not rows or find_spec("matplotlib") is None:
        return
    import matplotlib
    from matplotlib.figure import Figure

    panels = [(order, list(some)) for order, some in groupby(rows, lambda row: row.order)]
    with matplotlib.rc_context({**drawing.STYLE, "savefig.dpi": 80}):
        columns, lines = min(3, len(panels)), -(-len(panels) // 3)
        figure = Figure(figsize=(2.0 + 5.0 * columns, 4.2 * lines), layout="constrained")
        places = drawing.panels(figure, len(panels), columns)
        for axes, (order, of_order) in zip(places, panels, strict=True):
            for row in of_order:
                # a logarithmic axis has no place for 0
                errors = np.where(np.array(row.errors) > 0.0, row.errors, np.nan)
                h = row.spacings[: len(errors)]
                axes.loglog(h, errors, "o-", markersize=4, label=row.quantity)
            axes.set(title=OPERATORS[order].name, xlabel="grid spacing h", ylabel="errors")
            spacings = sorted({h for row in of_order for h in row.spacings})
            axes.set_xticks([], minor=True)
            axes.set_xticks(spacings, [f"{h:.4g}" for h in spacings], fontsize=8)
            axes.legend(fontsize="x-small", loc="upper left", bbox_to_anchor=(1.0, 1.0))
        drawing.set_title(figure, title)
        drawing.save(figure, path)


class Trial:
    """A case or an entry at an order of the operators, with a grid spacing h. Results go to
    ``folder``.

    found: quantity -> its error, (number, reference) or (), and rate and most of its Row.
    """

    def __init__(self, comm: Comm, folder: Path, order: int, h: float) -> None:
        self.comm, self.order, self.h = comm, order, h
        self.paths = (str(folder / f"{order}-{h!r}-{k}.h5") for k in count())
        self.found: dict[str, tuple[float, tuple[complex, ...], Any, Any]] = {}

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
            with suppress(*[RanksError] * (size > 1)):
                try:
                    together(self.comm, action, asleep=True)
                except RanksError:
                    raise
                except (ComputationError, InputError) as error:
                    told = str(error).partition(REMAINS)[0]  # the rest is removed with the others
                    words = f"order {self.order}, h = {self.h:g}: {told}"
                    raise type(error)(words) from None
                break
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
        self.found[quantity] = norm, (), order, error

    def compare(
        self, quantity: str, value: Any, reference: Any, order: Any = None, error: Any = None
    ) -> None:
        """Note a number, its relative distance from a reference, and what is expected of this."""
        apart = float(abs(value - reference) / abs(reference))
        self.found[quantity] = apart, (value, reference), order, error


def rows_of(trials: Sequence[Trial]) -> list[Row]:
    """The rows of trials at one order, from the coarsest grid to the finest."""
    rows, spacings = [], [trial.h for trial in trials]
    for quantity, (*_, rate, most) in trials[-1].found.items():
        errors, pairs, *_ = zip(*(trial.found[quantity] for trial in trials))
        rows.append(Row(quantity, trials[-1].order, spacings, errors, rate, most, pairs))
    return rows


#: all entries by name, in the order of the table, once their files are imported: the function
#: ``measure``, and the grids of the levels ``quick`` and ``full``, order of the operators ->
#: spacings [m], coarse to fine
ENTRIES: dict[str, Any] = {}
#: order of the operators -> cells in a length
Cells = Mapping[int, Sequence[int]]


def entry(quick: Cells, full: Cells, length: float = 1.0) -> Callable[[Any], Any]:
    """Make a function of a Trial an entry of its own name; problems/NAME.md says the rest."""

    def grids(cells: Cells) -> dict[int, list[float]]:
        return {order: [length / n for n in some] for order, some in cells.items()}

    def registered(measure: Any) -> Any:
        levels = {"quick": grids(quick), "full": grids(full)}
        ENTRIES[measure.__name__] = SimpleNamespace(measure=measure, **levels)
        return measure

    return registered


def reference(name: str) -> dict[str, Array]:
    """Columns of references/NAME.csv; lines that begin with # say units and source."""
    text = (files("fsipetsc.studies.verify") / "references" / f"{name}.csv").read_text("utf-8")
    table = csv.reader(line for line in text.splitlines() if not line.startswith("#"))
    return {head: np.array([float(v) for v in column]) for head, *column in zip(*table)}
