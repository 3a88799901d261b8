"""What a time step costs in two dimensions: a gas beneath a solid, both squares of n columns and rows, periodic in X.

Whole steps are timed as in one dimension (fsipetsc.bench.measure), on one rank and on several, in turn with those of another
program where there is one. Beside them on one rank the kernels, in loops over the same state: the right-hand side of either
layer and the look at its points after a step. What is left of a step is Python, PETSc and what they do at interfaces.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from itertools import product
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import numpy as np
from mpi4py import MPI

from fsipetsc.bench import square
from fsipetsc.bench.measure import Stand, clock
from fsipetsc.bench.table import NAN, cells, heading, kinds_of, line, markdown
from fsipetsc.bench.yardstick import PlaneYardstick
from fsipetsc.errors import FileError
from fsipetsc.operators.sbp import operator
from fsipetsc.options import defaults
from fsipetsc.scheme.runge_kutta import STAGES
from fsipetsc.stepping.plane.fused import WARM

if TYPE_CHECKING:
    from fsipetsc.bench.study import Bench

@dataclass
class PlaneRow:
    """One order, form and grid on a number of ranks; NaN where nothing was measured.

    n: columns and rows of a layer. step: of a whole step [us], median of the samples; best: the shortest. gas, solid: of a
    right-hand side, per point of the layer [ns]; look: after a step, mean of both. doubles: of memory per point, all ranks.
    yardstick: the other program's step [us]; ratio: ours by it, median of pairs. speedup: of ours on one rank by this one.
    """

    order: int
    form: str
    n: int
    ranks: int
    steps: int
    step: float
    best: float
    doubles: float
    gas: float = NAN
    solid: float = NAN
    look: float = NAN
    yardstick: float = NAN
    ratio: float = NAN
    speedup: float = NAN

    @property
    def left(self) -> float:
        """What kernels do not take of the shortest step [us]."""
        return self.best - 1e-3 * self.n**2 * (STAGES * (self.gas + self.solid) + 2 * self.look)


COLUMNS = (
    ("order", "{}", lambda r: operator(r.order).name),
    ("form", "{}", lambda r: r.form),
    ("n", "{}", lambda r: r.n),
    ("ranks", "{}", lambda r: r.ranks),
    ("µs/step", "{:.4g}", lambda r: r.step),
    ("gas ns", "{:.1f}", lambda r: r.gas),
    ("solid ns", "{:.1f}", lambda r: r.solid),
    ("look ns", "{:.1f}", lambda r: r.look),
    ("left µs", "{:.0f}", lambda r: r.left),
    ("yardst. µs", "{:.4g}", lambda r: r.yardstick),
    ("× yardst.", "{:.2f}", lambda r: r.ratio),
    ("speed-up", "{:.2f}", lambda r: r.speedup),
    ("doubles/pt", "{:.1f}", lambda r: r.doubles),
)


def table(rows: Iterable[PlaneRow]) -> str:
    """All rows in Markdown."""
    return markdown([name for name, _, _ in COLUMNS], [cells(row, COLUMNS) for row in rows])


def save(rows: Iterable[PlaneRow], path: Path) -> None:
    """As CSV. FileError."""
    try:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, [f.name for f in fields(PlaneRow)], lineterminator="\n")
            writer.writeheader()
            for row in rows:
                writer.writerow({k: "" if isinstance(v, float) and math.isnan(v) else v for k, v in asdict(row).items()})
    except OSError as error:
        raise FileError(f"{path}: cannot write the table: {error.strerror or error}") from error


def load(path: Path) -> list[PlaneRow]:
    """Rows that were saved. FileError."""
    kinds = kinds_of(PlaneRow)
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return [PlaneRow(**{k: kind(row[k] or "nan") for k, kind in kinds.items()}) for row in csv.DictReader(file)]
    except (OSError, KeyError, ValueError) as error:
        raise FileError(f"{path}: is not the table of a benchmark in two dimensions: {error}") from error


def measure(bench: Bench, yardstick: PlaneYardstick | None) -> list[PlaneRow]:
    """All rows, on rank 0. Collective."""
    bench.say(heading(COLUMNS))
    rows: list[PlaneRow] = []
    opt = bench.opt
    forms = square.FORMS if opt["bench_form"] == "all" else (opt["bench_form"],)
    for order, form, n in product(opt["bench_orders"], forms, opt["bench_squares"]):
        chosen = {"fsi_order": order, "fsi_h": 1.0 / n, "fsi_partition": opt["fsi_partition"], **square.FORMS[form][0]}
        options = {**defaults(square), **chosen}
        stands = {r: bench.team(r, lambda comm: Stand(square, options, comm, bench.say)) for r in bench.ranks}  # noqa: B023
        found = _rows(bench, stands, yardstick, order, form, n)
        for row in found:
            bench.say(line(row, COLUMNS))
        rows += found
        for stand in stands.values():
            if stand is not None:
                stand.destroy()
    return rows


def _rows(
    bench: Bench, stands: Mapping[int, Stand | None], yardstick: PlaneYardstick | None, order: int, form: str, n: int
) -> list[PlaneRow]:
    first, seconds = min(stands), bench.opt["bench_seconds"]
    for ranks, stand in stands.items():  # what is made once is made before
        bench.team(ranks, lambda comm: stand.steps(WARM + 1))  # noqa: B023
    steps = bench.world.bcast(bench.team(first, lambda comm: stands[first].sample(seconds)))
    samples: dict[int, list[float]] = {ranks: [] for ranks in stands}
    other: list[float] = []
    for _ in range(bench.opt["bench_repeats"]):
        for ranks, stand in stands.items():
            samples[ranks].append(bench.team(ranks, lambda comm: stand.steps(steps)))  # noqa: B023
        if bench.world.bcast(yardstick is not None):
            other.append(bench.alone(lambda: yardstick.step(order, n, steps, square.FORMS[form][1])))
    rows = []
    for ranks, stand in stands.items():
        kernels = bench.team(ranks, lambda comm: _kernels(stand, seconds) if comm.size == 1 else {})  # noqa: B023
        doubles = bench.team(ranks, lambda comm: comm.allreduce(stand.state.path.doubles) / stand.state.points)  # noqa: B023
        if bench.world.rank:
            continue
        mine = samples[ranks]
        row = PlaneRow(order, form, n, ranks, steps, median(mine), min(mine), doubles, **kernels)
        if other and ranks == 1:
            row.yardstick, row.ratio = median(other), median(a / b for a, b in zip(mine, other, strict=True))
        if ranks > 1 and 1 in samples:
            row.speedup = median(a / b for a, b in zip(samples[1], mine, strict=True))
        rows.append(row)
    return rows


def _kernels(stand: Stand, seconds: float) -> dict[str, float]:
    """Time per point [ns] of the right-hand sides and of the look, on one rank."""
    looks, found = [], {}
    for name, part in zip(("gas", "solid"), stand.state.path.layers, strict=True):
        points = np.prod(part.own.shape[:2])
        for action, to in ((lambda: part.evaluate(0.0), found), (part.look, looks)):  # noqa: B023
            took = 1e3 * clock(MPI.COMM_SELF, lambda count: [action() for _ in range(count)], seconds / 4) / points  # noqa: B023
            to.append(took) if to is looks else to.update({name: took})
    return {**found, "look": sum(looks) / len(looks)}
