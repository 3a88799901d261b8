"""The numbers of a convergence study: errors, observed orders and cost, as text and CSV.

Without an exact solution grids are compared with each other: fields at the end, at the nodes that
all grids have in common, series at SAMPLES equal distances of time. A difference is the norm in
force (L1 or L2) of the mean over these, over the largest range on the finest grid of all fields of
its unit in layers of its kind.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from fsipetsc.checks import counted
from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import operator
from fsipetsc.output.differences import common_nodes, summed
from fsipetsc.output.quantities import unit_of
from fsipetsc.output.reader import Run
from fsipetsc.studies.tables import save_csv, text_table, texts
from fsipetsc.studies.verdicts import ROUND_OFF, Expected, closures

#: names of the cost in the summary of a result
COST = "points", "steps", "rhs_evaluations", "wall_time"
#: orders that are looked for where grids are compared with each other
LEAST, MOST = -4.0, 16.0
#: times at which series are compared
SAMPLES = 10
#: series that are of the steps or of the method, not of the solution
NO_SOLUTION = "t", "dt", "least_J", "J_error", "lost_energy"


@dataclass
class Study:
    """Runs of one case over orders and grids, NaN where a run has failed or not been made.

    hs: grid spacings [m], coarse to fine. t: time of comparison [s]. exact: errors are from the
    exact solution, and groups are kinds of layers; else grid j is compared with the next finer one,
    groups are layers and "series", and errors relative. units: as in fsipetsc.problem.Problem.
    failures: (order, h) -> message. errors: (group, name) -> (orders, grids). cost: name -> the
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
    errors: dict[tuple[str, str], np.ndarray] = field(default_factory=dict)
    cost: dict[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.cost = {name: self._empty() for name in COST}

    def _empty(self) -> np.ndarray:
        return np.full((len(self.orders), len(self.hs)), np.nan)

    def put(self, i: int, j: int, errors: Mapping[str, Mapping[str, float]]) -> None:
        """Keep the errors of the run with order i and grid j."""
        for group, values in errors.items():
            for name, value in values.items():
                self.errors.setdefault((group, name), self._empty())[i, j] = value

    def rates(self, group: str, name: str = "combined") -> np.ndarray:
        """Observed orders, (orders, grids); NaN for the first grid, and the last of compared grids.

        Of errors e_j ~ h_j^p p is log(e_j-1 / e_j) / log(h_j-1 / h_j), of differences it solves
        e_j-1 / e_j = (h_j-1^p - h_j^p) / (h_j^p - h_j+1^p).
        """
        e, h = self.errors[group, name], np.array(self.hs)
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

    def row(self, i: int, j: int) -> str:
        """The cost of a run as it has been made."""
        start = f"{operator(self.orders[i]).name}  h = {self.hs[j]:<9.6g}"
        failure = self.failures.get((self.orders[i], self.hs[j]))
        if failure:
            return f"{start}  failed: {failure}"
        points, steps, _, time = (self.cost[name][i, j] for name in COST)
        return f"{start}{points:>8.0f} points{steps:>8.0f} steps{time:>9.2f} s"

    def table(self, i: int) -> str:
        """Of order i: a line for each error, its observed orders, and a verdict.

        The order expected is that of smooth solutions; what has come down to round-off holds.
        """
        names = [f"{h:g}" for h in self.hs]
        if not self.exact:
            names = [f"{a}-{b}" for a, b in zip(names, names[1:])]
        head = [operator(self.orders[i]).name, "h =", *names, *["order"] * (len(names) - 1)]
        expected, rows = Expected(closures(self.orders[i]), ROUND_OFF), []
        for (group, name), errors in self.errors.items():
            rates = self.rates(group, name)[i, 1 : len(names)]
            numbers = [*texts(errors[i, : len(names)], ".1e"), *texts(rates, ".2f")]
            verdict = expected.verdict(rates[-1] if len(rates) else nan, errors[i, len(names) - 1])
            rows.append([group, "all" if name == "combined" else name, *numbers, verdict])
        return text_table([*head, "verdict"], rows)

    def save(self, path: Path) -> Path:
        """Write a line per run: order, grid, cost, errors, observed orders. FileError."""
        what = "errors" if self.exact else "relative differences from the next grid"
        about = f"{self.case}, {what} in {self.norm} at {self.time}, {counted(self.ranks, 'rank')}"
        columns = dict(self.cost)
        columns |= {f"{group}/{name}": errors for (group, name), errors in self.errors.items()}
        columns |= {f"order {group}/{name}": self.rates(group, name) for group, name in self.errors}
        rows = []
        for i, order in enumerate(self.orders):
            for j, h in enumerate(self.hs):
                numbers = [values[i, j] for values in columns.values()]
                rows.append([order, operator(order).name, repr(h), *texts(numbers, ".9g")])
        return save_csv(path, ["order", "operator", "h", *columns], rows, about)


def order_of_differences(ratio: float, first: float, second: float, third: float) -> float:
    """p with (first^p - second^p) / (second^p - third^p) = exp(ratio); NaN where there is none."""

    def found(p: float) -> float:
        a, b = np.log(first / second), np.log(second / third)
        one, two = (np.expm1(p * a), -np.expm1(-p * b)) if p else (a, b)
        return float(np.log(one / two))

    there = found(LEAST) <= ratio <= found(MOST)
    return brentq(lambda p: found(p) - ratio, LEAST, MOST) if there else float("nan")


def differences(runs: Sequence[Run], norm: str) -> Iterator[dict[str, dict[str, float]]]:
    """Of each run but the last, from coarse to fine: group -> name -> relative difference from the
    next one; and "combined", their mean. InputError where there is no node in common.
    """
    values, power = _common_values(runs), {"L1": 1, "L2": 2}[norm]
    kinds = {layer.name: layer.kind for layer in runs[0].layers}

    # of which kind of layer and unit; what has no known unit has one of its own
    sort = {key: (kinds.get(key[0], key[0]), unit_of(key[1]) or key[1]) for key in values}
    ranges: dict[tuple[str, str], float] = {}
    for key, found in values.items():
        ranges[sort[key]] = max(ranges.get(sort[key], 0.0), _range(found[-1]))
    for j in range(len(runs) - 1):
        errors: dict[str, dict[str, float]] = {}
        for (group, name), found in values.items():
            gap = np.abs(found[j + 1] - found[j]) / (ranges[sort[group, name]] or 1.0)
            gap = gap[np.isfinite(gap)]
            mean = float(np.mean(gap**power) ** (1 / power)) if gap.size else np.nan
            errors.setdefault(group, {})[name] = mean
        for own in errors.values():
            every = np.array(list(own.values()))
            own["combined"] = float(np.nanmean(every**power) ** (1 / power))
        yield errors


def _common_values(runs: Sequence[Run]) -> dict[tuple[str, str], list[np.ndarray]]:
    """(group, name) -> values of each run at what all have in common. InputError."""
    found: dict[tuple[str, str], list[np.ndarray]] = {}
    for k, layer in enumerate(runs[0].layers):
        layers = [run.layers[k] for run in runs]
        pairs = [common_nodes(layer, other, []) for other in layers]
        if any(pair is None for pair in pairs):
            raise InputError(
                f"layer '{layer.name}': no node of the coarsest grid is on all others; "
                "-fsi_hs takes grids with common nodes, as in -fsi_hs 0.1,0.05,0.025"
            )
        axes = [_in_all(axis) for axis in zip(*(zip(*pair) for pair in pairs if pair is not None))]
        for name in layer.fields:
            ends = [other.frame(-1)[name] for other in layers]
            found[layer.name, name] = [
                end[np.ix_(*(axis[j] for axis in axes))] for j, end in enumerate(ends)
            ]
    times = runs[0].time[1:]
    for name in runs[0].series:
        if name not in NO_SOLUTION and not name.startswith("residual_"):
            values = [summed(r, name)[np.isin(r.series["t"], times)] for r in runs]
            if len({v.shape for v in values}) == 1 and values[0].size:
                found["series", name] = values
    return found


def _in_all(pairs: Any) -> list[np.ndarray]:
    """Of one axis: numbers of the nodes that all grids have; pairs: (of the coarsest, of each)."""
    common = pairs[0][0]
    for first, _ in pairs:
        common = np.intersect1d(common, first)
    return [second[np.searchsorted(first, common)] for first, second in pairs]


def _range(values: np.ndarray) -> float:
    """The largest less the smallest value; the largest size where that is round-off."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0
    largest, span = float(np.abs(known).max()), float(np.ptp(known))
    return span if span > 1e-9 * largest else largest
