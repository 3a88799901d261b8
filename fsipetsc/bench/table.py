"""The numbers of a benchmark: a row for each order, grid and number of ranks; text and CSV."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fsipetsc.errors import FileError
from fsipetsc.operators.sbp import operator
from fsipetsc.scheme.runge_kutta import STAGES

if TYPE_CHECKING:
    from fsipetsc.bench.plane import PlaneRow

NAN = math.nan
#: columns of other grids and forms of the gas, which benchmarks of earlier versions do not have
FORMS = ("stretched", "entropy")


@dataclass
class Row:
    """One order and grid on a number of ranks. Times are of a step, in µs; NaN where nothing was measured.

    points: active ones; share: the most of them on a rank. steps: of a sample. step: median of the samples, best: the
    shortest. inner, ends, exchange, petsc: parts of a step, see fsipetsc.bench.measure; call: of
    entering compiled code, a part of what is left for Python; reduction: one of those in exchange. yardstick: the
    other program's step; ratio: ours by its, in pairs made one after the other, median. speedup: of ours on one rank
    by this one, likewise. bound: what the memory traffic of a step takes at the bandwidth of STREAM's triad. sends:
    messages of a step, the most on a rank. reductions: over all ranks, or turns at their mailboxes. doubles: of memory of
    the solver, all ranks. stretched, entropy: time per point and step of nearly gas alone, on one rank, on stretched grids in
    divergence and in entropy form, by that on rigid ones, see fsipetsc.bench.measure.compare.
    """

    order: int
    h: float
    points: int
    ranks: int
    share: int
    steps: int
    step: float
    best: float
    inner: float
    ends: float
    exchange: float
    reduction: float
    petsc: float
    call: float
    bound: float
    sends: int
    reductions: int
    doubles: int
    yardstick: float = NAN
    ratio: float = NAN
    speedup: float = NAN
    stretched: float = NAN
    entropy: float = NAN

    @property
    def ns(self) -> float:
        """Time per point and evaluation of the right-hand side [ns]."""
        return 1e3 * self.step / (STAGES * self.points)

    @property
    def arithmetic(self) -> float:
        """Of a step [µs]: all that is computed."""
        return self.inner + self.ends

    @property
    def python(self) -> float:
        """What is left of the shortest sample of a step [µs]."""
        return self.best - self.arithmetic - self.exchange - self.petsc

    def shares(self) -> dict[str, float]:
        """Parts of a step in percent of the shortest sample."""
        parts = {"arithmetic": self.arithmetic, "exchange": self.exchange, "PETSc": self.petsc, "Python": self.python}
        return {name: 100 * value / self.best for name, value in parts.items()}


@dataclass
class BenchStudy:
    """All rows, and facts about the machine and the program: name -> number. plane: fsipetsc.bench.plane.PlaneRow."""

    rows: list[Row] = field(default_factory=list)
    facts: dict[str, float] = field(default_factory=dict)
    about: dict[str, str] = field(default_factory=dict)
    plane: list[PlaneRow] = field(default_factory=list)

    def at(self, order: int | None = None, ranks: int | None = None) -> list[Row]:
        """Rows of an order, of a number of ranks, or of both, from coarse to fine."""
        chosen = (r for r in self.rows if order in (None, r.order) and ranks in (None, r.ranks))
        return sorted(chosen, key=lambda r: (r.order, r.points, r.ranks))

    @property
    def orders(self) -> list[int]:
        """Orders there are."""
        return sorted({row.order for row in self.rows})

    @property
    def ranks(self) -> list[int]:
        """Numbers of ranks there are."""
        return sorted({row.ranks for row in self.rows})

    def save(self, path: Path) -> None:
        """Write PATH (rows) and, beside it, NAME-facts.csv. FileError if that is impossible."""
        try:
            with path.open("w", newline="", encoding="utf-8") as file:
                names = [f.name for f in fields(Row)]
                writer = csv.DictWriter(file, [*names, "ns_per_point_and_rhs", "python"], lineterminator="\n")
                writer.writeheader()
                for row in self.rows:
                    values = {name: _text(value) for name, value in asdict(row).items()}
                    writer.writerow({**values, "ns_per_point_and_rhs": _text(row.ns), "python": _text(row.python)})
            with _facts_path(path).open("w", newline="", encoding="utf-8") as file:
                plain = csv.writer(file, lineterminator="\n")
                plain.writerow(["name", "value"])
                plain.writerows((name, _text(value)) for name, value in {**self.about, **self.facts}.items())
        except OSError as error:
            raise FileError(f"{path}: cannot write the table: {error.strerror or error}") from error


def load(path: Path) -> BenchStudy:
    """A study that was saved. FileError if it cannot be read."""
    kinds = kinds_of(Row)
    try:
        study = BenchStudy()
        with path.open(newline="", encoding="utf-8") as file:
            for line in csv.DictReader(file):
                named = {name: kind for name, kind in kinds.items() if name in line or name not in FORMS}
                study.rows.append(Row(**{name: kind(line[name] or "nan") for name, kind in named.items()}))
        with _facts_path(path).open(newline="", encoding="utf-8") as file:
            for line in csv.DictReader(file):
                try:
                    study.facts[line["name"]] = float(line["value"])
                except ValueError:
                    study.about[line["name"]] = line["value"]
        return study
    except OSError as error:
        raise FileError(f"{path}: cannot read the benchmark: {error.strerror or error}") from error
    except (KeyError, ValueError, TypeError) as error:
        raise FileError(f"{path}: is not the table of a benchmark: {error}") from error


def kinds_of(row: type) -> dict[str, type]:
    """Name of a row's number or text -> its type."""
    return {f.name: {"int": int, "float": float, "str": str}[str(f.type)] for f in fields(row)}


def _facts_path(path: Path) -> Path:
    return path.with_name(f"{path.stem}-facts.csv")


def _text(value: object) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return str(value)


Columns = Sequence[tuple[str, str, Callable[[Any], object]]]
#: columns of the table: heading, format, number
COLUMNS: Columns = (
    ("order", "{}", lambda r: operator(r.order).name),
    ("points", "{:d}", lambda r: r.points),
    ("ranks", "{:d}", lambda r: r.ranks),
    ("µs/step", "{:.4g}", lambda r: r.step),
    ("ns/pt/RHS", "{:.3g}", lambda r: r.ns),
    ("arithm.", "{:.0f} %", lambda r: r.shares()["arithmetic"]),
    ("exchange", "{:.0f} %", lambda r: r.shares()["exchange"]),
    ("PETSc", "{:.0f} %", lambda r: r.shares()["PETSc"]),
    ("Python", "{:.0f} %", lambda r: r.shares()["Python"]),
    ("triad µs", "{:.3g}", lambda r: r.bound),
    ("yardst. µs", "{:.4g}", lambda r: r.yardstick),
    ("× yardst.", "{:.2f}", lambda r: r.ratio),
    ("speed-up", "{:.2f}", lambda r: r.speedup),
    ("stretched", "{:.2f}", lambda r: r.stretched),
    ("entropy", "{:.2f}", lambda r: r.entropy),
)


def cells(row: Row | PlaneRow, columns: Columns = COLUMNS) -> list[str]:
    """A row as texts, in the order of the columns."""
    return [entry(form, get(row)) for _, form, get in columns]


def entry(form: str, value: object) -> str:
    """A number as text; a dash where there is none."""
    return "–" if isinstance(value, float) and math.isnan(value) else form.format(value)


def heading(columns: Columns = COLUMNS) -> str:
    """The line above the rows, for the terminal."""
    return "  ".join(f"{name:>{_width(name)}}" for name, _, _ in columns)


def line(row: Row | PlaneRow, columns: Columns = COLUMNS) -> str:
    """A row for the terminal."""
    return "  ".join(f"{text:>{_width(name)}}" for text, (name, _, _) in zip(cells(row, columns), columns))


def _width(name: str) -> int:
    return max(len(name), 7)


def markdown(names: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown, numbers to the right."""
    lines = [f"| {' | '.join(names)} |", f"|{'|'.join(['---:'] * len(names))}|"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])
