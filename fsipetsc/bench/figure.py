"""The picture of a benchmark: cost per point, where the time goes, speed-up, and what the model expects of many ranks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.bench.cost_model import Model, bandwidth, message, moved_bytes, scaling
from fsipetsc.bench.table import BenchStudy
from fsipetsc.errors import FileError
from fsipetsc.output.plots.style import BLACK, BLUE, GREY, ORANGE, ORDERS, RED, STYLE, drawing, legend_above
from fsipetsc.output.plots.titles import set_title
from fsipetsc.scheme.runge_kutta import STAGES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHARES = {"arithmetic": BLUE, "exchange": RED, "PETSc": GREY, "Python": ORANGE}
_GRIDS = ("#9ecae1", "#6baed6", "#3182bd", "#08519c", "#08306b")


def draw(study: BenchStudy, model: Model | None, path: Path) -> Path | None:
    """Draw the picture at PATH; None without matplotlib. FileError if it cannot be written."""
    try:
        matplotlib = drawing()
        from matplotlib.figure import Figure
    except ModuleNotFoundError:
        return None
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(9.6, 7.2))
        axes = figure.subplots(2, 2)
        _cost(axes[0, 0], study)
        _parts(axes[0, 1], study)
        _speed_up(axes[1, 0], study, model)
        _expected(axes[1, 1], study, model)
        place = ", ".join(str(study.about[name]) for name in ("processor", "date") if name in study.about)
        set_title(figure, "what a time step of rod costs" + (f"  ({place})" if place else ""))
        try:
            figure.savefig(path)
        except OSError as error:
            raise FileError(f"{path}: cannot write the picture: {error.strerror or error}") from error
    return path


def _cost(axes: Axes, study: BenchStudy) -> None:
    """Time per point and right-hand side over the number of points, on one rank."""
    for order in study.orders:
        rows, (color, marker) = study.at(order, study.ranks[0]), ORDERS[order]
        points = [r.points for r in rows]
        axes.loglog(points, [r.ns for r in rows], color=color, marker=marker, markersize=4, label=f"order {order}")
        other = np.array([1e3 * r.yardstick / (STAGES * r.points) for r in rows])
        if np.isfinite(other).any():
            axes.loglog(points, other, color=color, marker=marker, markersize=3, linestyle=":", linewidth=1)
    points = np.geomspace(min(r.points for r in study.rows), max(r.points for r in study.rows), 40)
    traffic = [1e3 * moved_bytes() / bandwidth(study, study.ranks[0], n) / STAGES for n in points]
    axes.loglog(points, traffic, color=GREY, linestyle="--", label="memory traffic at triad speed")
    if any(np.isfinite(r.yardstick) for r in study.rows):
        axes.plot([], [], color=BLACK, linestyle=":", label="yardstick, dotted")
    axes.set_xlabel("points")
    axes.set_ylabel("ns per point and right-hand side")
    axes.set_title(f"cost on {_ranks(study.ranks[0])}", loc="left")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * (high / low) ** 0.35)  # room for the legend
    axes.legend(loc="upper right", ncols=2)


def _parts(axes: Axes, study: BenchStudy) -> None:
    """Shares of a step, a bar for each grid and number of ranks, one order."""
    order = 4 if 4 in study.orders else study.orders[0]
    rows = study.at(order)
    labels = [f"{_short(r.points)}\n{r.ranks}" for r in rows]
    below = np.zeros(len(rows))
    for name, color in SHARES.items():
        values = np.array([max(0.0, r.shares()[name]) for r in rows])
        axes.bar(range(len(rows)), values, 0.8, below, color=color, label=name)
        below += values
    axes.set_xticks(range(len(rows)), labels, fontsize=8)
    axes.set_xlabel("points, and below them the ranks")
    axes.set_ylabel("percent of a step")
    axes.set_ylim(0, max(100.0, below.max()))
    axes.grid(False)
    axes.set_title(f"where a step goes, order {order}", loc="left", pad=18)
    legend_above(axes, side="right", columns=4, columnspacing=1.0, handlelength=1.0)


def _speed_up(axes: Axes, study: BenchStudy, model: Model | None) -> None:
    """Speed-up over one rank against the points, measured and as the model has it."""
    for order in study.orders:
        color, marker = ORDERS[order]
        for ranks in study.ranks[1:]:
            rows = study.at(order, ranks)
            points = [r.points for r in rows]
            axes.semilogx(points, [r.speedup for r in rows], color=color, marker=marker, markersize=4, linestyle="-")
            if model is not None:
                alone = {r.points: model.step(study, order, r.share, 1) for r in study.at(order, 1)}
                modelled = [alone.get(r.points, np.nan) / model.step(study, order, r.share, ranks) for r in rows]
                axes.semilogx(points, modelled, color=color, linestyle=":", linewidth=1)
    if len(study.ranks) > 1:
        axes.axhline(1.0, color=BLACK, linewidth=0.8)
        most = study.ranks[-1]
        axes.set_title(f"speed-up on {' and '.join(map(str, study.ranks[1:]))} ranks", loc="left")
        axes.set_ylim(0, max(1.1 * most, axes.get_ylim()[1]))
        axes.plot([], [], color=BLACK, marker="o", markersize=4, label="measured")
        axes.plot([], [], color=BLACK, linestyle=":", label="model")
        axes.legend(loc="lower right")
    else:
        axes.set_title("speed-up: only one number of ranks was measured", loc="left")
    axes.set_xlabel("points")
    axes.set_ylabel("speed-up over one rank")


def _expected(axes: Axes, study: BenchStudy, model: Model | None) -> None:
    """Speed-up on up to 1,000 ranks, by the model."""
    axes.set_title("expected of more ranks, by the model, order 4", loc="left")
    axes.set_xlabel("ranks")
    axes.set_ylabel("speed-up over one rank")
    if model is None:
        return
    order = 4 if 4 in study.orders else study.orders[0]
    ranks = sorted({round(x) for x in np.geomspace(1, 1000, 40)})
    for color, points in zip(_GRIDS[1:], (10_000, 100_000, 1_000_000, 10_000_000)):
        table = scaling(model, study, order, 1 / round(points / 6), ranks, message(model, study))
        axes.loglog(list(table), [speed for _, speed, _ in table.values()], color=color, label=f"{_short(points)} points")
    axes.loglog([1, 1000], [1, 1000], color=BLACK, linewidth=0.8, linestyle="--", label="ideal")
    axes.legend()


def _short(points: int) -> str:
    if points >= 995_000:
        return f"{points / 1e6:.3g}M"
    return f"{points / 1e3:.3g}k" if points >= 995 else str(points)


def _ranks(count: int) -> str:
    return f"{count} rank{'s' * (count > 1)}"
