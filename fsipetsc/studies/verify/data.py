"""Problems and references of entries of the command `verify`, and how errors are made of them."""

import csv
from collections.abc import Callable, Iterable, Mapping
from importlib.resources import files
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from fsipetsc.checks import Array


def problem(name: str) -> str:
    """problems/NAME.md: title, problem and parameters."""
    return files("fsipetsc.studies.verify").joinpath("problems", f"{name}.md").read_text("utf-8")


def reference(name: str) -> dict[str, Array]:
    """Columns of references/NAME.csv; lines that begin with # say units and source."""
    text = files("fsipetsc.studies.verify").joinpath("references", f"{name}.csv").read_text("utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    table = list(csv.reader(lines))
    return {head: np.array([float(v) for v in column]) for head, *column in zip(*table)}


def largest(errors: Any) -> float:
    """The norm of the maximum."""
    return float(np.abs(errors).max())


def root_mean_square(errors: Any) -> float:
    """The norm of the mean."""
    return float(np.sqrt(np.mean(np.abs(errors) ** 2)))


def joined(frames: Iterable[Mapping[str, Array]]) -> dict[str, Array]:
    """The fields of several blocks as one array each."""
    parts = list(frames)
    return {name: np.concatenate([part[name].ravel() for part in parts]) for name in parts[0]}


def smooth(x: Array, y: Array) -> Callable[[Array], Array]:
    """A reference between its points: the spline of fifth degree."""
    return make_interp_spline(x, y, k=5)
