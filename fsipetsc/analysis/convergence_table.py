"""The numbers of a convergence study: errors, observed orders and cost, as text and CSV."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fsipetsc.analysis.spectra import bisect
from fsipetsc.analysis.tables import save_csv, text_table
from fsipetsc.checks import counted
from fsipetsc.operators.sbp import operator

#: names of the cost in the summary of a result
COST = "points", "steps", "rhs_evaluations", "wall_time"
#: orders that are looked for where grids are compared with each other
LEAST, MOST = -4.0, 16.0
#: a relative difference of grids that is none
ROUND_OFF = 1e-12
#: Table 1 of the paper: kind of layer -> order -> exponent in L2 between the two finest grids
TABLE_1 = {"fluid": {8: 4.9, 6: 4.7, 4: 2.4, 2: 1.6}, "solid": {8: 4.3, 6: 4.1, 4: 2.6, 2: 1.8}}


@dataclass
class ConvergenceStudy:
    """Runs of one case over orders and grids, NaN where a run has failed or not been made.

    hs: grid spacings [m], coarse to fine. t: time of comparison [s]. exact: errors are from the
    exact solution, and groups are kinds of layers; else grid j is compared with the next finer one,
    groups are layers and "series", and errors relative. units: as in fsipetsc.problem.Problem.
    failures: (order, h) -> message. errors: group -> name -> (orders, grids). cost: name -> the
    same, of the names in COST; the wall time [s] is that of the time loop.
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
    cost: dict[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.cost = {name: self._empty() for name in COST}

    def _empty(self) -> np.ndarray:
        return np.full((len(self.orders), len(self.hs)), np.nan)

    def put(self, i: int, j: int, errors: Mapping[str, Mapping[str, float]]) -> None:
        """Keep the errors of the run with order i and grid j."""
        for group, values in errors.items():
            for name, value in values.items():
                self.errors.setdefault(group, {}).setdefault(name, self._empty())[i, j] = value

    def rates(self, group: str, name: str = "combined") -> np.ndarray:
        """Observed orders, (orders, grids); NaN for the first grid, and the last of compared grids.

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
    def wall_time(self) -> np.ndarray:
        """Of the time loops [s], (orders, grids)."""
        return self.cost["wall_time"]

    def columns(self) -> Iterator[tuple[str, str]]:
        """(group, name) of every error."""
        return ((group, name) for group, names in self.errors.items() for name in names)

    def row(self, i: int, j: int) -> str:
        """The cost of a run as it has been made."""
        start = f"{operator(self.orders[i]).name}  h = {self.hs[j]:<9.6g}"
        failure = self.failures.get((self.orders[i], self.hs[j]))
        if failure:
            return f"{start}  failed: {failure}"
        points, steps, _, time = (self.cost[name][i, j] for name in COST)
        return f"{start}{points:>8.0f} points{steps:>8.0f} steps{time:>9.2f} s"

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

    def beside_table_1(self) -> str:
        """Table 1 of the paper, and the exponents of a study of mms on two grids or more."""
        orders = sorted(self.orders, reverse=True)
        rows = []
        for kind, paper in TABLE_1.items():
            rates = self.rates(kind)[:, -1]
            ours = [f"{rates[self.orders.index(order)]:.1f}" for order in orders]
            rows += [(kind, "paper", *(paper[order] for order in orders)), ("", "ours", *ours)]
        head = ["", "", *(operator(order).name for order in orders)]
        grids = f"h = {self.hs[-2]:g} and {self.hs[-1]:g}"
        return (
            "Table 1 of the paper, exponents between the two finest grids, and ours between "
            f"{grids}\n{text_table(head, rows)}"
        )

    def save(self, path: Path) -> Path:
        """Write a line per run: order, grid, cost, errors, observed orders. FileError."""
        what = "errors" if self.exact else "relative differences from the next grid"
        about = f"{self.case}, {what} in {self.norm} at {self.time}, {counted(self.ranks, 'rank')}"
        columns = dict(self.cost)
        columns |= {f"{group}/{name}": self.errors[group][name] for group, name in self.columns()}
        columns |= {f"order {g}/{name}": self.rates(g, name) for g, name in self.columns()}
        rows = []
        for i, order in enumerate(self.orders):
            for j, h in enumerate(self.hs):
                numbers = [values[i, j] for values in columns.values()]
                rows.append([order, operator(order).name, repr(h), *_texts(numbers, ".9g")])
        return save_csv(path, ["order", "operator", "h", *columns], rows, about)


def order_of_differences(ratio: float, first: float, second: float, third: float) -> float:
    """p with (first^p - second^p) / (second^p - third^p) = exp(ratio); NaN where there is none."""

    def found(p: float) -> float:
        a, b = np.log(first / second), np.log(second / third)
        one, two = (np.expm1(p * a), -np.expm1(-p * b)) if p else (a, b)
        return float(np.log(one / two))

    there = found(LEAST) <= ratio <= found(MOST)
    return bisect(lambda p: found(p) > ratio, LEAST, MOST) if there else float("nan")


def _texts(values: Any, spec: str) -> list[str]:
    """Numbers for a table; nothing where there is none."""
    return [format(value, spec) if np.isfinite(value) else "" for value in values]
