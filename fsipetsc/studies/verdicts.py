"""What `verify` and `convergence` say of errors on grids: observed orders, verdicts, tables and
pictures.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import groupby
from math import log, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from fsipetsc.checks import Array
from fsipetsc.operators.sbp import operator
from fsipetsc.output.plots.style import ORDERS, STYLE, save, set_title
from fsipetsc.studies.tables import text_table

#: how far an observed order may be below what is expected
SLACK = 0.4
#: errors, relative ones, that may be round-off
ROUND_OFF = 1e-12
#: relative differences of grids that resolve a solution are smaller
RESOLVED = 0.1
#: orders that are looked for where grids are compared with each other
LEAST, MOST = -4.0, 16.0
#: verdict -> of several rows
VERDICTS = {"converges": "converge", "holds": "hold", "falls short": "fall short"}
#: columns of a table of rows, and of one where order and grids are told above it
HEAD = ("quantity", "order", "grid spacings", "errors", "observed orders", "expected", "verdict")
SHORT_HEAD = (HEAD[0], *HEAD[3:])
#: columns of their CSV file
COLUMNS = "case quantity order h ranks value reference source error rate verdict".split()


class Curve(NamedTuple):
    """To be drawn: ours at x, the reference at x_reference. labels: of the axes, with units."""

    labels: tuple[str, str]
    x: Array
    ours: Array
    x_reference: Array
    reference: Array


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


#: an error, or the number that is compared
Found = float | Compared


class Expected(NamedTuple):
    """What theory, or somebody else, says of a quantity; None where they say nothing.

    order: of the errors between the two finest grids; error: at most, on the finest grid.
    """

    order: float | None = None
    error: float | None = None

    def __str__(self) -> str:
        said = (self.order, "order {:.3g}"), (self.error, "error {:.2g}")
        return " or ".join(text.format(value) for value, text in said if value is not None)

    def verdict(self, observed: float, error: float) -> str:
        """ "converges", "holds", or "falls short" of both."""
        if self.order is not None and observed >= self.order - SLACK:
            return "converges"
        return "holds" if self.error is not None and error <= self.error else "falls short"


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
    spacings: tuple[float, ...]
    found: tuple[Found, ...]
    expected: Expected
    between: bool = False

    @property
    def errors(self) -> tuple[float, ...]:
        """The error on each grid."""
        return tuple(one.error if isinstance(one, Compared) else one for one in self.found)

    @property
    def observed(self) -> tuple[float, ...]:
        """Orders between neighbouring errors; nan where one is 0, or both are round-off."""
        h, found = self.spacings, []
        for k, (a, b) in enumerate(zip(self.errors, self.errors[1:])):
            if not (min(a, b) > 0.0 and max(a, b) > ROUND_OFF):
                found.append(nan)
            elif self.between:
                found.append(order_of_differences(log(a / b), *h[k : k + 3]))
            else:
                found.append(log(a / b) / log(h[k] / h[k + 1]))
        return tuple(found)

    @property
    def verdict(self) -> str:
        """That of what is expected; differences that are not small fall short in any case."""
        if self.between and not self.errors[-1] <= RESOLVED:
            return "falls short"
        return self.expected.verdict(self.observed[-1] if self.observed else nan, self.errors[-1])

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


def told(rows: Sequence[Row]) -> str:
    """Return a table for each order."""
    tables = []
    for (order, _), group in groupby(rows, lambda row: (row.order, row.spacings)):
        cells = [row.cells for row in group]
        body = text_table(SHORT_HEAD, [(cell[0], *cell[3:]) for cell in cells])
        tables.append(f"{operator(order).name}, h = {cells[0][2]}\n{body}")
    return "\n\n".join(tables)


def tally(rows: Sequence[Row]) -> str:
    """Return how often there is each verdict."""
    counts = Counter(row.verdict for row in rows)
    return ", ".join(f"{counts[word]} {text}" for word, text in VERDICTS.items())


def order_of_differences(ratio: float, first: float, second: float, third: float) -> float:
    """p with (first^p - second^p) / (second^p - third^p) = exp(ratio); NaN where there is none."""

    def found(p: float) -> float:
        a, b = np.log(first / second), np.log(second / third)
        one, two = (np.expm1(p * a), -np.expm1(-p * b)) if p else (a, b)
        return float(np.log(one / two))

    there = found(LEAST) <= ratio <= found(MOST)
    return brentq(lambda p: found(p) - ratio, LEAST, MOST) if there else nan


def picture(
    title: str, panels: Mapping[str, Sequence[Row]], path: Path, curve: Curve | None = None
) -> list[Path]:
    """A panel of errors for the rows of each heading, and one of a curve over its reference.

    Returns the file, none without matplotlib or without rows. FileError.
    """
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError:
        return []
    if not any(panels.values()):
        return []
    with matplotlib.rc_context({**STYLE, "savefig.dpi": 80}):
        count = len(panels) + bool(curve)
        figure = Figure(figsize=(2.0 + 5.0 * count, 4.2), layout="constrained")
        axes = list(figure.subplots(1, count, squeeze=False)[0])
        if curve:
            beside = axes.pop(0)
            thick = {"color": "0.6", "linewidth": 3, "label": "reference"}
            beside.plot(curve.x_reference, curve.reference, **thick)
            beside.plot(curve.x, curve.ours, ".", markersize=4, label="computed")
            beside.set(xlabel=curve.labels[0], ylabel=curve.labels[1])
            beside.legend()
        for panel, (heading, rows) in zip(axes, panels.items(), strict=True):
            _errors(panel, rows)
            panel.set_title(heading, loc="left")
        axes[0].set_ylabel("errors")
        set_title(figure, title)
        return [save(figure, path)]


def _errors(axes: Any, rows: Sequence[Row]) -> None:
    """Errors over the grid spacing; a logarithmic axis has no place for 0. Of one quantity the
    orders have colours, and that of the last refinement is in brackets; else quantities have.
    """
    from matplotlib import colormaps

    names, orders = (list(dict.fromkeys(of)) for of in zip(*[row[1:3] for row in rows]))
    for row in rows:
        color, marker = ORDERS[row.order][:2]
        rate = f"  ({row.observed[-1]:.1f})" if np.isfinite(row.observed[-1:]).any() else ""
        label = operator(row.order).name + rate
        if len(names) > 1:
            k = names.index(row.quantity)
            color = colormaps["tab20"]((2 * k + k // 10) % 20)
            label = row.quantity if row.order == orders[0] else ""
        errors = np.where(np.array(row.errors) > 0.0, row.errors, np.nan)
        look = {"color": color, "marker": marker, "markersize": 4, "label": label}
        axes.loglog(row.spacings[: len(errors)], errors, **look)
    for order in orders if len(names) > 1 else ():
        axes.plot([], [], ORDERS[order][1], color="black", label=operator(order).name)
    spacings = sorted({h for row in rows for h in row.spacings})
    axes.set_xlabel("grid spacing h")
    axes.set_xticks([], minor=True)
    axes.set_xticks(spacings, [f"{h:.4g}" for h in spacings], fontsize=8)
    axes.legend(fontsize="x-small", loc="upper left", bbox_to_anchor=(1.0, 1.0))
