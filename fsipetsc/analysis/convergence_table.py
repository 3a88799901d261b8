"""The numbers of a convergence study: errors, observed orders and cost over orders and grids; as text, CSV and HDF5."""

from __future__ import annotations

import csv
import io
import itertools
import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.operators.sbp import operator

FORMAT, VERSION = "fsipetsc convergence study", 1
#: by dimension, what is compared in each kind of layer; the last is all of them together
NAMES = {
    1: {"fluid": ("rho", "u", "T", "combined"), "solid": ("u", "sigma", "T", "x", "combined")},
    2: {"fluid": ("rho", "u", "v", "T", "combined"), "solid": ("u", "v", "T", "x", "y", "combined")},
}
_COST = ("points", "steps", "evaluations", "wall_time")


@dataclass
class ConvergenceStudy:
    """Runs of one case over orders and grids, NaN where a run has failed or not been made.

    hs: grid spacings [m], coarse to fine. t: time of comparison [s]. errors: kind -> name -> (orders, grids).
    points, steps, evaluations of the right-hand side, wall_time of the time loop [s]: (orders, grids).
    failures: (order, h) -> message. options: in force, without order and grid spacing. units: as in
    fsipetsc.problem.Problem. dimension: of the problem, 1 or 2.
    """

    case: str
    t: float
    orders: tuple[int, ...]
    hs: tuple[float, ...]
    ranks: int
    options: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    failures: dict[tuple[int, float], str] = field(default_factory=dict)
    units: str = "SI"
    dimension: int = 1

    def __post_init__(self) -> None:
        shape, self._names = (len(self.orders), len(self.hs)), NAMES[self.dimension]
        self.errors = {kind: {name: np.full(shape, np.nan) for name in names} for kind, names in self._names.items()}
        for name in _COST:
            setattr(self, name, np.full(shape, np.nan))

    def put(self, i: int, j: int, outcome: Any) -> None:
        """Keep the outcome of the run with order i and grid j (fsipetsc.stepping.solve.Outcome)."""
        for kind, values in outcome.errors.items():  # of the layers that there are
            for name in self._names[kind]:
                self.errors[kind][name][i, j] = values[name]
        for name in _COST:
            getattr(self, name)[i, j] = getattr(outcome, name)

    def rates(self, kind: str, name: str = "combined") -> np.ndarray:
        """Observed orders log(e_j-1 / e_j) / log(h_j-1 / h_j), (orders, grids); NaN for the first grid."""
        e, h = self.errors[kind][name], np.array(self.hs)
        rates = np.full(e.shape, np.nan)
        with np.errstate(divide="ignore", invalid="ignore"):
            rates[:, 1:] = np.log(e[:, :-1] / e[:, 1:]) / np.log(h[:-1] / h[1:])
        return rates

    @property
    def norm(self) -> str:
        """That of the errors."""
        return self.options.get("fsi_norm", "L2")

    @property
    def time(self) -> str:
        """The time of comparison, as text."""
        return f"t = {self.t:g}" + " s" * (self.units == "SI")

    @property
    def cost(self) -> np.ndarray:
        """Wall time per point and step [µs], (orders, grids)."""
        return 1e6 * self.wall_time / (self.points * self.steps)

    def columns(self) -> Iterator[tuple[str, str]]:
        """(kind, name) of every error."""
        return ((kind, name) for kind, names in self._names.items() for name in names)

    # ------------------------------------------------------------------ text

    def head(self, i: int) -> str:
        """The lines above the rows of order i."""
        groups = "".join(f"{kind:^{9 * len(names)}}" for kind, names in self._names.items())
        names = "".join(f"{'all' if name == 'combined' else name:>9}" for _, name in self.columns())
        title = f"{operator(self.orders[i]).name:<24}{groups}".rstrip()
        return f"{title}\n{'h':<10}{'points':>7}{'steps':>7}{names}{'µs/pt/st':>9}{'wall s':>8}"

    def row(self, i: int, j: int) -> str:
        """Grid j of order i: errors and cost, and in a second line the observed orders."""
        start = f"{self.hs[j]:<10.6g}"
        failure = self.failures.get((self.orders[i], self.hs[j]))
        if failure:
            return f"{start}  failed: {failure}"
        start += f"{self.points[i, j]:>7.0f}{self.steps[i, j]:>7.0f}"
        errors = [self.errors[kind][name][i, j] for kind, name in self.columns()]
        values = "".join(f"{error:>9.1e}" if np.isfinite(error) else f"{'':>9}" for error in errors)
        lines = [f"{start}{values}{self.cost[i, j]:>9.3f}{self.wall_time[i, j]:>8.2f}"]
        rates = [self.rates(kind, name)[i, j] for kind, name in self.columns()]
        if np.isfinite(rates).any():
            lines.append((" " * 24 + "".join(f"{rate:>9.2f}" if np.isfinite(rate) else f"{'':>9}" for rate in rates)).rstrip())
        return "\n".join(lines)

    def summary(self) -> str:
        """Observed orders of all errors together, a line per order, the refinements from coarse to fine."""
        pairs = [f"{a:g}→{b:g}" for a, b in zip(self.hs, self.hs[1:])]
        width = max([8, *map(len, pairs)]) + 2
        lines = ["observed orders of all errors together", f"{'':<12}" + "".join(f"{pair:>{width}}" for pair in pairs)]
        for kind in self._names:
            rates = self.rates(kind)
            if not np.isfinite(self.errors[kind]["combined"]).any():
                continue
            for i, order in enumerate(self.orders):
                values = "".join(f"{rate:>{width}.2f}" for rate in rates[i, 1:])
                lines.append(f"{kind:<7}{operator(order).name:<5}{values}")
        return "\n".join(lines)

    # ------------------------------------------------------------------ files

    def csv(self) -> str:
        """One line per run: order, grid, cost, errors, observed orders (empty where there is none)."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        names = [f"{kind}_{name}" for kind, name in self.columns()]
        cost = ["points", "steps", "rhs_evaluations", "wall_s", "us_per_point_and_step"]
        writer.writerow(["order", "operator", "h", *cost, *names, *(f"rate_{name}" for name in names)])
        for i, order in enumerate(self.orders):
            for j, h in enumerate(self.hs):
                counts = [self.points[i, j], self.steps[i, j], self.evaluations[i, j]]
                times = [self.wall_time[i, j], self.cost[i, j]]
                errors = [self.errors[kind][name][i, j] for kind, name in self.columns()]
                rates = [self.rates(kind, name)[i, j] for kind, name in self.columns()]
                row = [*(_text(v, "d") for v in counts), *(_text(v, ".6g") for v in times)]
                row += [*(_text(v, ".8e") for v in errors), *(_text(v, ".4f") for v in rates)]
                writer.writerow([order, operator(order).name, repr(h), *row])
        return out.getvalue()

    def save(self, path: Path) -> Path | None:
        """Write PATH as HDF5 and, beside it, as CSV. FileError if that is impossible.

        An earlier file of this name, with its CSV, is kept under another one, which is returned.
        """
        try:
            kept = _keep(path)
            with h5py.File(path, "w") as file:
                file.attrs["format"], file.attrs["version"] = FORMAT, VERSION
                file.attrs["case"], file.attrs["t"], file.attrs["ranks"] = self.case, self.t, self.ranks
                file.attrs["units"], file.attrs["dimension"] = self.units, self.dimension
                file["orders"], file["h"] = self.orders, self.hs
                for kind, name in self.columns():
                    file[f"errors/{kind}/{name}"] = self.errors[kind][name]
                    file[f"rates/{kind}/{name}"] = self.rates(kind, name)
                for name in _COST:
                    file[name] = getattr(self, name)
                file["us_per_point_and_step"] = self.cost
                file["options"], file["versions"] = json.dumps(dict(self.options)), json.dumps(dict(self.versions))
                file["failures"] = json.dumps([[*key, text] for key, text in self.failures.items()])
            path.with_suffix(".csv").write_text(self.csv(), encoding="utf-8")
            return kept
        except OSError as error:
            raise FileError(f"{path}: cannot write the table: {error.strerror or error}") from error


def load(path: str | Path) -> ConvergenceStudy:
    """A study that was saved. FileError if it cannot be read."""
    try:
        with h5py.File(path, "r") as file:
            if file.attrs.get("format") != FORMAT:
                raise FileError(f"{path}: not a convergence study")
            study = ConvergenceStudy(
                str(file.attrs["case"]),
                float(file.attrs["t"]),
                tuple(map(int, file["orders"])),
                tuple(map(float, file["h"])),
                int(file.attrs["ranks"]),
                json.loads(file["options"].asstr()[()]),
                json.loads(file["versions"].asstr()[()]),
                {(order, h): text for order, h, text in json.loads(file["failures"].asstr()[()])},
                str(file.attrs.get("units", "SI")),
                int(file.attrs.get("dimension", 1)),
            )
            for kind, name in study.columns():
                study.errors[kind][name][:] = file[f"errors/{kind}/{name}"]
            for name in _COST:
                getattr(study, name)[:] = file[name]
            return study
    except OSError as error:
        raise FileError(f"{path}: {error.strerror or error}") from error


def _keep(path: Path) -> Path | None:
    """Rename an earlier file to the first free name NAME.1.h5, NAME.2.h5, …, and its CSV likewise."""
    if not path.exists():
        return None
    names = (path.with_name(f"{path.stem}.{k}{path.suffix}") for k in itertools.count(1))
    kept = next(name for name in names if not name.exists())
    path.rename(kept)
    with suppress(FileNotFoundError):
        path.with_suffix(".csv").rename(kept.with_suffix(".csv"))
    return kept


def _text(value: float, spec: str) -> str:
    """A number for a table; nothing if it is none."""
    return "" if not np.isfinite(value) else format(int(value) if spec == "d" else value, spec)
