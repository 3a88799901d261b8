"""The numbers of a convergence study: errors, observed orders and cost over orders and grids; as text and CSV."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fsipetsc.analysis.tables import save_csv, text_table
from fsipetsc.errors import FileError
from fsipetsc.operators.sbp import operator

FORMAT = "fsipetsc convergence study"
#: name in a study -> name in its CSV and in the summary of a result
COST = {"points": "points", "steps": "steps", "evaluations": "rhs_evaluations", "wall_time": "wall_time"}
#: orders that are looked for where grids are compared with each other
LEAST, MOST = -4.0, 16.0
#: a relative difference of grids that is none
ROUND_OFF = 1e-12


@dataclass
class ConvergenceStudy:
    """Runs of one case over orders and grids, NaN where a run has failed or not been made.

    hs: grid spacings [m], coarse to fine. t: time of comparison [s]. errors: group -> name ->
    (orders, grids). exact: they are against the exact solution, and groups are kinds of layers; else
    grid j is compared with the next finer one, groups are layers and "series", and errors relative.
    points, steps, evaluations of the right-hand side, wall_time of the time loop [s]: (orders, grids).
    failures: (order, h) -> message. units: as in fsipetsc.problem.Problem.
    """

    case: str
    t: float
    orders: tuple[int, ...]
    hs: tuple[float, ...]
    ranks: int = 1
    norm: str = "L2"
    units: str = "SI"
    exact: bool = True
    failures: dict[tuple[int, float], str] = field(default_factory=dict)
    errors: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.early = False  # whether a run has ended before t
        self.points, self.steps, self.evaluations, self.wall_time = (self._empty() for _ in COST)

    def _empty(self) -> np.ndarray:
        return np.full((len(self.orders), len(self.hs)), np.nan)

    def put(self, i: int, j: int, cost: Mapping[str, float], errors: Mapping[str, Mapping[str, float]]) -> None:
        """Keep what is known of the run with order i and grid j."""
        for name in cost:
            getattr(self, name)[i, j] = cost[name]
        for group, values in errors.items():
            for name, value in values.items():
                self.errors.setdefault(group, {}).setdefault(name, self._empty())[i, j] = value

    def rates(self, group: str, name: str = "combined") -> np.ndarray:
        """Observed orders, (orders, grids); NaN for the first grid, and the last if grids are compared.

        Of errors e_j ~ h_j^p p is log(e_j-1 / e_j) / log(h_j-1 / h_j), of differences it solves
        e_j-1 / e_j = (h_j-1^p - h_j^p) / (h_j^p - h_j+1^p).
        """
        e, h = self.errors[group][name], np.array(self.hs)
        rates = np.full(e.shape, np.nan)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = np.log(e[:, :-1] / e[:, 1:])
        if self.exact:
            rates[:, 1:] = ratios / np.log(h[:-1] / h[1:])
        else:
            known = np.isfinite(ratios) & (e[:, :-1] > ROUND_OFF)
            for i, j in zip(*np.nonzero(known[:, : len(h) - 2])):
                rates[i, j + 1] = order_of_differences(ratios[i, j], *h[j : j + 3])
        return rates

    @property
    def time(self) -> str:
        """The time of comparison, as text."""
        return f"t = {self.t:g}" + " s" * (self.units == "SI")

    @property
    def cost(self) -> np.ndarray:
        """Wall time per point and step [µs], (orders, grids)."""
        return 1e6 * self.wall_time / (self.points * self.steps)

    def columns(self) -> Iterator[tuple[str, str]]:
        """(group, name) of every error."""
        return ((group, name) for group, names in self.errors.items() for name in names)

    # ------------------------------------------------------------------ text

    def row(self, i: int, j: int) -> str:
        """The cost of a run as it has been made."""
        start = f"{operator(self.orders[i]).name}  h = {self.hs[j]:<9.6g}"
        failure = self.failures.get((self.orders[i], self.hs[j]))
        if failure:
            return f"{start}  failed: {failure}"
        points, steps = self.points[i, j], self.steps[i, j]
        return f"{start}{points:>8.0f} points{steps:>8.0f} steps{self.wall_time[i, j]:>9.2f} s"

    def table(self, i: int) -> str:
        """Of order i: a line for each error, with its observed orders behind."""
        names = [f"{h:g}" for h in self.hs]
        if not self.exact:
            names = [f"{a}-{b}" for a, b in zip(names, names[1:])]
        head = [operator(self.orders[i]).name, "h =", *names, *["order"] * (len(names) - 1)]
        rows = []
        for group, name in self.columns():
            errors = self.errors[group][name][i, : len(names)]
            rates = self.rates(group, name)[i, 1 : len(names)]
            numbers = [*_texts(errors, ".1e"), *_texts(rates, ".2f")]
            rows.append([group, "all" if name == "combined" else name, *numbers])
        return text_table(head, rows)

    def summary(self) -> str:
        """Observed orders of all errors together, a line per order, the refinements from coarse to fine."""
        rows = [
            [group, operator(order).name, *_texts(self.rates(group)[i], ".2f")]
            for group in self.errors
            for i, order in enumerate(self.orders)
        ]
        head = ["observed orders of all errors together, at h =", "", *(f"{h:g}" for h in self.hs)]
        return text_table(head, rows)

    # ------------------------------------------------------------------ files

    def save(self, path: Path) -> Path:
        """Write a line per run: order, grid, cost, errors, observed orders (empty where there is none). FileError."""
        of_all = ("case", "t", "ranks", "norm", "units", "exact")
        failures = [[*key, text] for key, text in self.failures.items()]
        about = {"format": FORMAT, **{n: getattr(self, n) for n in of_all}, "failures": failures}
        names = [f"{group}/{name}" for group, name in self.columns()]
        head = ["order", "operator", "h", *COST.values(), "us_per_point_and_step"]
        rows = []
        for i, order in enumerate(self.orders):
            for j, h in enumerate(self.hs):
                cost = [getattr(self, name)[i, j] for name in COST]
                errors = [self.errors[g][n][i, j] for g, n in self.columns()]
                rates = [self.rates(g, n)[i, j] for g, n in self.columns()]
                numbers = [*_texts([*cost, self.cost[i, j]], ".9g"), *_texts(errors, ".9g")]
                rows.append([order, operator(order).name, repr(h), *numbers, *_texts(rates, ".4f")])
        return save_csv(path, [*head, *names, *(f"order {n}" for n in names)], rows, json.dumps(about))


def order_of_differences(ratio: float, first: float, second: float, third: float) -> float:
    """p with (first^p - second^p) / (second^p - third^p) = exp(ratio), by bisection; NaN where there is none."""

    def found(p: float) -> float:
        a, b = np.log(first / second), np.log(second / third)
        one, two = (np.expm1(p * a), -np.expm1(-p * b)) if p else (a, b)
        return float(np.log(one / two))

    low, high = LEAST, MOST
    if not found(low) <= ratio <= found(high):
        return float("nan")
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if found(middle) > ratio else (middle, high)
    return 0.5 * (low + high)


def load(path: str | Path) -> ConvergenceStudy:
    """A study that was saved. FileError if it cannot be read."""
    try:
        with open(path, encoding="utf-8", newline="") as file:
            about = json.loads(file.readline().removeprefix("#"))
            rows = list(csv.DictReader(file))
        if about.pop("format") != FORMAT:
            raise ValueError
    except OSError as error:
        raise FileError(f"{path}: {error.strerror or error}") from error
    except (ValueError, KeyError, AttributeError):
        raise FileError(f"{path}: not a convergence study") from None
    failures = {(order, h): text for order, h, text in about.pop("failures")}
    orders = tuple(dict.fromkeys(int(row["order"]) for row in rows))
    hs = tuple(dict.fromkeys(float(row["h"]) for row in rows))
    study = ConvergenceStudy(orders=orders, hs=hs, failures=failures, **about)
    for k, row in enumerate(rows):
        errors: dict[str, dict[str, float]] = {}
        for column in row:
            group, slash, name = column.partition("/")
            if slash and not column.startswith("order "):
                errors.setdefault(group, {})[name] = float(row[column] or "nan")
        cost = {name: float(row[column] or "nan") for name, column in COST.items()}
        study.put(*divmod(k, len(hs)), cost, errors)
    return study


def _texts(values: Any, spec: str) -> list[str]:
    """Numbers for a table; nothing where there is none."""
    return [format(value, spec) if np.isfinite(value) else "" for value in values]
