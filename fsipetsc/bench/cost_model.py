"""A model of the cost of a step, fitted to a benchmark, and what it says of more ranks.

    T = overhead + n work(order) + overlap n moved / bandwidth(n) + latency rounds(P)

n: points of the rank that has most. work: of a point, where all is in a cache. moved: bytes between memory and caches of
a point in a step; bandwidth: of the triad on as many bytes as the rank's state has, all ranks at once; overlap: how much
of that is not hidden behind the arithmetic. rounds: messages one after the other in a step, a reduction over P ranks
being log2 P of them, as in a tree. The five constants are not negative and make the relative errors least.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fsipetsc.bench.table import BenchStudy, Row
from fsipetsc.cases import load_case
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.options import defaults
from fsipetsc.parallel.layout import make_grids
from fsipetsc.parallel.partition import Extent, partition
from fsipetsc.stepping.counts import step_traffic

#: unknowns of a point of the rod, on the average over gas (3) and solid (4)
UNKNOWNS = 19 / 6
#: reductions and exchanges with neighbours of a step
REDUCTIONS, EXCHANGES = 5, 4


def moved_bytes() -> float:
    """Bytes that a step moves for a point between memory and caches."""
    return 8 * UNKNOWNS * sum(step_traffic())


def bandwidth(study: BenchStudy, ranks: int, points: float) -> float:
    """Bandwidth [bytes/µs] of a rank, fetched and written, for the state of so many points; between what was measured."""
    measured = {
        int(name.split()[2]): value
        for name, value in study.facts.items()
        if name.startswith("triad ") and int(name.split()[1]) == ranks
    }
    if not measured:
        known = sorted({int(name.split()[1]) for name in study.facts if name.startswith("triad ")})
        if not known:
            return math.nan
        return bandwidth(study, max([k for k in known if k <= ranks], default=known[0]), points)
    sizes = sorted(measured)
    # in the triad a written line is fetched first: 32 bytes move where it counts 24
    values = [1e3 * 4 / 3 * measured[size] for size in sizes]
    return float(np.exp(np.interp(math.log(max(points, 1) * state_bytes()), np.log(sizes), np.log(values))))


def state_bytes() -> float:
    """Bytes of a point in the arrays that a step works on: three work areas, sum and PETSc's solution."""
    return 5 * 8 * UNKNOWNS


def bound(study: BenchStudy, ranks: int, share: int) -> float:
    """Time [µs] that the memory traffic of a step takes."""
    return share * moved_bytes() / bandwidth(study, ranks, share)


def rounds(ranks: int, reductions: int = REDUCTIONS, exchanges: int = EXCHANGES) -> float:
    """Messages of a step that wait for each other, if a reduction is a tree."""
    return 0.0 if ranks == 1 else reductions * math.ceil(math.log2(ranks)) + exchanges


@dataclass(frozen=True)
class Model:
    """overhead [µs], work [µs per point] of each order, overlap, latency [µs]; error: of the fit, relative, rms."""

    overhead: float
    work: dict[int, float]
    overlap: float
    latency: float
    error: float

    def step(self, study: BenchStudy, order: int, share: int, ranks: int, latency: float | None = None) -> float:
        """Time of a step [µs]; latency: another one than the fitted."""
        wait = (self.latency if latency is None else latency) * rounds(ranks)
        return self.overhead + share * self.work[order] + self.overlap * bound(study, ranks, share) + wait


def fit(study: BenchStudy) -> Model | None:
    """The model that fits a study best; None if there are too few rows or scipy is missing."""
    try:
        from scipy.optimize import nnls
    except ModuleNotFoundError:
        return None
    rows, orders = study.rows, study.orders
    if len(rows) < len(orders) + 3:
        return None
    lines = []
    for row in rows:
        work = [float(row.share) if row.order == order else 0.0 for order in orders]
        memory = bound(study, row.ranks, row.share)
        lines.append([1.0, *work, 0.0 if math.isnan(memory) else memory, _rounds(row)])
    matrix, steps = np.array(lines), np.array([row.step for row in rows])
    # columns of one size: points and microseconds differ by orders of magnitude
    scaled = matrix / steps[:, None]
    size = np.where(scaled.any(axis=0), np.linalg.norm(scaled, axis=0), 1.0)
    found = nnls(scaled / size, np.ones(len(rows)))[0] / size
    error = float(np.sqrt(np.mean((scaled @ found - 1.0) ** 2)))
    works = dict(zip(orders, map(float, found[1:-2])))
    return Model(float(found[0]), works, float(found[-2]), float(found[-1]), error)


def _rounds(row: Row) -> float:
    return rounds(row.ranks, row.reductions, EXCHANGES if row.sends else 0)


def shares(order: int, h: float) -> Callable[[int], int]:
    """ranks -> points of the rank that has most, as the balanced partition deals out the rod; InputError if it cannot."""
    case = load_case("rod")
    problem, op = case.build(defaults(case)), OPERATORS[order]
    grids = make_grids(problem, op, h, 16, "rigid")
    extents = [
        Extent(layer.kind, grid.n, grid.hi - grid.lo + 1, k == 0) for k, (layer, grid) in enumerate(zip(problem.layers, grids))
    ]

    def largest(ranks: int) -> int:
        owned = np.zeros(ranks)
        for extent, pieces in zip(extents, partition(extents, ranks, "balanced", max(2 * op.reach, 6, op.rows + 1))):
            first = extent.n - extent.active if extent.spare_left else 0
            for rank, begin, end in pieces:
                owned[rank] += max(0, min(end, first + extent.active) - max(begin, first))
        return int(owned.max())

    return largest


def message(model: Model, study: BenchStudy) -> float:
    """Latency [µs] of a message between the ranks of this machine; as fitted, where none was measured by itself."""
    return study.facts.get("message latency", model.latency)


def half_speed(model: Model, order: int, ranks: int, latency: float) -> float:
    """Points per rank at which messages take as long as the work."""
    return latency * rounds(ranks) / model.work[order] if model.work[order] else math.inf


def scaling(model: Model, study: BenchStudy, order: int, h: float, ranks: Sequence[int], latency: float | None = None):
    """Rank count -> (step [µs], speed-up, efficiency) as the model sees it, as far as the grid can feed the ranks."""
    from fsipetsc.errors import InputError

    largest, table = shares(order, h), {}
    alone = model.step(study, order, largest(1), 1)
    for count in ranks:
        try:
            step = model.step(study, order, largest(count), count, latency)
        except InputError:
            break
        table[count] = step, alone / step, alone / step / count
    return table


def relative_errors(model: Model, study: BenchStudy) -> list[tuple[Row, float]]:
    """Row and (model - measured) / measured."""
    return [(row, model.step(study, row.order, row.share, row.ranks) / row.step - 1) for row in study.rows]
