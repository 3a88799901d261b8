"""Entries of the command `verify`: what they are, their references, and norms of their errors."""

import csv
from collections.abc import Callable, Iterable, Mapping
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from fsipetsc.checks import Array
from fsipetsc.studies.verdicts import Curve, Expected, Found

#: solve(case, order, h, end=None, **options) runs a case, given by its name or as a problem, to its
#: end or to another time, and returns its opened result; collective
Solve = Callable[..., Any]
#: order of the operators -> grid spacings, coarse to fine
Grids = Mapping[int, tuple[float, ...]]


class Measured(NamedTuple):
    """What a run gives.

    errors: quantity -> an error, or the number that is compared; expected: of the operators of this
    order, if this is the finest grid: of all quantities, or quantity -> Expected; curve: one of
    them as a picture shows it.
    """

    errors: Mapping[str, Found]
    expected: Expected | Mapping[str, Expected]
    curve: Curve | None = None


class Entry(NamedTuple):
    """An entry: its function of (solve, order, h), the source of its reference, why its errors are
    expected, which no run of this program says, and what the two levels take.
    """

    measure: Callable[[Solve, int, float], Measured]
    source: str
    why: str
    full: Grids
    quick: Grids


#: all entries by name, in the order of the table, once their files are imported
ENTRIES: dict[str, Entry] = {}


def entry(source: str, why: str, full: Grids, quick: Grids) -> Callable[[Any], Any]:
    """Make a function ``measure`` an entry of its own name."""

    def registered(measure: Any) -> Any:
        ENTRIES[measure.__name__] = Entry(measure, source, why, full, quick)
        return measure

    return registered


def problem(name: str) -> str:
    """Return problems/NAME.md: title, problem and parameters."""
    return files("fsipetsc.studies.verify").joinpath("problems", f"{name}.md").read_text("utf-8")


def reference(name: str) -> dict[str, Array]:
    """Columns of references/NAME.csv; lines that begin with # say units and source."""
    text = files("fsipetsc.studies.verify").joinpath("references", f"{name}.csv").read_text("utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    table = list(csv.reader(lines))
    return {head: np.array([float(v) for v in column]) for head, *column in zip(*table)}


def largest(errors: Any) -> float:
    """Return the norm of the maximum."""
    return float(np.abs(errors).max())


def root_mean_square(errors: Any) -> float:
    """Return the norm of the mean square."""
    return float(np.sqrt(np.mean(np.abs(errors) ** 2)))


def joined(frames: Iterable[Mapping[str, Array]]) -> dict[str, Array]:
    """Return the fields of several blocks as one array each."""
    parts = list(frames)
    return {name: np.concatenate([part[name].ravel() for part in parts]) for name in parts[0]}


def smooth(x: Array, y: Array) -> Callable[[Array], Array]:
    """Return a reference between its points: the spline of fifth degree."""
    return make_interp_spline(x, y, k=5)
