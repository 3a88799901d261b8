"""Two results on a page: fields of both at the same times, interfaces, steps, and the largest differences as numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.options import OF_A_RUN
from fsipetsc.output.differences import compare
from fsipetsc.output.plots import reason, whole
from fsipetsc.output.plots.frames import check_drawable, moment
from fsipetsc.output.plots.maps.page import pairs_of, size_of
from fsipetsc.output.plots.maps.panels import bar, colors, domain, few_ticks, panel
from fsipetsc.output.plots.maps.quantities import Pair
from fsipetsc.output.plots.page import PANELS, WIDTH, attempt, curves
from fsipetsc.output.plots.quantities import PROFILES, SPACE_TIME
from fsipetsc.output.plots.scales import axis_label, extremes, named, scaled, time_axis
from fsipetsc.output.plots.steps import unhurried
from fsipetsc.output.plots.style import BLUE, ORANGE, SERIES, SMALL_LEGEND, bar_above, legend_above, thin
from fsipetsc.output.plots.titles import set_title
from fsipetsc.output.reader import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase

#: series whose differences are listed beside those of fields
_SERIES = "x_interface", "u_interface", "T_interface", "energy", "mass", "least_J"
TIMES, LISTED = 3, 12  # times in one dimension where none are given; differences that are listed


def draw(
    figure: Figure, a: Run, b: Run, fields: Sequence[str] = (), times: Sequence[float] = (), *, faults: list[str]
) -> None:
    """The page, on a figure of its own. InputError for results that have nothing in common, and as of ``page.draw``.

    faults: gets what of damaged results could not be drawn.
    """
    check_drawable(a)
    if a.dimension != b.dimension or not a.nframes or not b.nframes:
        raise InputError(f"plot -compare: {a.path} and {b.path}: expected two results of equal dimension, with frames")
    height, above = 0.01, lambda part: None
    try:
        height, above = (_maps if a.dimension == 2 else _profiles)(a, b, fields, frames(a, b, times))
    except InputError:
        raise
    except Exception as error:
        faults.append(f"fields ({reason(error)})")
    below = [*whole(_panels(a, b), faults, "panels"), partial(_differences, runs=(a, b))]
    figure.set_size_inches(WIDTH, 0.6 + height + PANELS)
    figure.set_layout_engine("constrained", w_pad=0.08, h_pad=0.06)
    parts = figure.subfigures(2, 1, height_ratios=[height, PANELS])
    attempt(partial(above, parts[0]), faults, "fields")
    panels = parts[1].subplots(1, len(below), width_ratios=[1] * (len(below) - 1) + [2], squeeze=False)[0]
    for axes, draw_on in zip(panels, below):
        attempt(partial(draw_on, axes), faults, draw_on.func.__name__.strip("_"))
    set_title(figure, f"{_name(a)} (lines) and {_name(b)} (dashed)" if a.dimension == 1 else f"{_name(a)} and {_name(b)}")


def _panels(a: Run, b: Run) -> Iterator[Callable[[Axes], None]]:
    """What there is to be drawn below, beside the differences; of a run without steps there are no series."""
    known = {name for name in a.series if all(len(run.series.get(name, ())) > 1 for run in (a, b))}
    if {"t", "x_interface"} <= known and a.dimension == 1 and a.interfaces and a.interfaces == b.interfaces:
        yield partial(_interfaces, runs=(a, b))
    if {"t", "dt"} <= known:
        yield partial(_steps, runs=(a, b))


def _name(run: Run) -> str:
    return Path(run.path).name


def frames(a: Run, b: Run, times: Sequence[float]) -> list[tuple[int, int]]:
    """Frames of both at the given times, or at some that both have; the nearest there are."""
    count = TIMES if a.dimension == 1 else 1
    common = np.intersect1d(a.time, b.time)
    start, end = max(a.time[0], b.time[0]), min(a.time[-1], b.time[-1])
    known = common if common.size > 1 else np.linspace(start, end, count + 1)
    wanted = times or [known[round(k * (len(known) - 1) / count)] for k in range(1, count + 1)]
    return sorted({(a.at(t), b.at(t)) for t in wanted})


def _profiles(
    a: Run, b: Run, fields: Sequence[str], chosen: Sequence[tuple[int, int]]
) -> tuple[float, Callable[[FigureBase], None]]:
    there = [q for q in PROFILES if all(any(q.of(layer.kind) for layer in run.layers) for run in (a, b))]
    named(fields, [quantity.name for quantity in there])
    shown = [q for q in there if (q.name in fields if fields else q in SPACE_TIME)]

    def above(figure: FigureBase) -> None:
        for axes, quantity in zip(figure.subplots(1, len(shown), sharex=True, squeeze=False)[0], shown):
            curves(axes, (a, b), quantity, list(zip(*chosen)))
        legend_above(figure.axes[-1], side="right", columns=3, fontsize=7)

    return 3.2, above


def _maps(
    a: Run, b: Run, fields: Sequence[str], chosen: Sequence[tuple[int, int]]
) -> tuple[float, Callable[[FigureBase], None]]:
    """The first result, the second, and the second less the first where their grids have as many points."""
    pairs, same = pairs_of(fields), alike(a, b)
    ranges = [extremes(*map(np.array, both)) for both in zip(domain(a), domain(b))]
    rows = [(pair, at) for pair in pairs for at in chosen]
    width, height = size_of(ranges, 10.2 / (2 + same))

    def above(figure: FigureBase) -> None:
        for part, (pair, (i, j)) in zip(figure.subfigures(len(rows), 1, squeeze=False)[:, 0], rows):
            grid = part.subplots(1, 2 + same, sharex=True, sharey=True)
            either = [colors(a, quantity, [i]) or colors(b, quantity, [j]) for quantity in (pair.gas, pair.solid)]
            scales = [found for found in either if found]
            drawn = []
            for axes, run, frame in ((grid[0], a, i), (grid[1], b, j)):
                drawn.append(panel(axes, run, frame, scales))
                axes.set_title(f"{_name(run)}, {moment(run, frame)}", loc="left", fontsize=8)
            for own, first, second in zip(scales, *drawn):
                bar(part, first or second, own, list(grid[:2]), 6)
            if same:
                _difference(part, grid[2], a, b, pair, (i, j))
            for axes in grid:
                axes.set(aspect="equal", xlim=ranges[0], ylim=ranges[1], xlabel=axis_label(a, "x", "m"))
            few_ticks(grid[0], width)
            grid[0].set_ylabel(axis_label(a, "y", "m"))

    return len(rows) * (height + 2.1), above


def alike(a: Run, b: Run) -> bool:
    """Whether the blocks of two results have the same names, kinds and numbers of points."""
    shapes = ([(layer.name, layer.kind, layer.shape) for layer in run.layers] for run in (a, b))
    return next(shapes) == next(shapes)


def _difference(figure: FigureBase, axes: Axes, a: Run, b: Run, pair: Pair, at: tuple[int, int]) -> None:
    """Second less first, of gases and of solids with a scale each."""
    axes.grid(visible=False)
    axes.set_title("second less first", loc="left", fontsize=8)
    for kind, quantity, colormap in (("fluid", pair.gas, "RdBu_r"), ("solid", pair.solid, "PuOr_r")):
        both = [(x, y) for x, y in zip(a.layers, b.layers) if x.kind == kind]
        gaps = [quantity.values(y, at[1]) - quantity.values(x, at[0]) for x, y in both]
        if not gaps:
            continue
        scale = scaled(a, quantity.label, quantity.unit, *gaps, start=np.zeros(1))
        most = max(float(np.nanmax(np.abs(scale(gap)))) for gap in gaps) or 1.0
        for (x, _), gap in zip(both, gaps):
            fields, look = x.frame(at[0]), {"cmap": colormap, "vmin": -most, "vmax": most}
            picture = axes.pcolormesh(fields["x"], fields["y"], scale(gap), shading="gouraud", rasterized=True, **look)
        bar_above(figure, picture, axes, scale.label, 3, aspect=24)


def _interfaces(axes: Axes, runs: Sequence[Run]) -> None:
    scale = scaled(runs[0], "position x of the interface", "m", *(run.series["x_interface"] for run in runs))
    for run, style in zip(runs, ("-", "--")):
        some = thin(len(run.series["t"]))
        for k, x in enumerate(run.series["x_interface"].T):
            axes.plot(run.series["t"][some], scale(x)[some], color=SERIES[k % len(SERIES)], linestyle=style, linewidth=1.2)
    axes.set_ylabel(scale.label)
    time_axis(axes, runs[0])


def _steps(axes: Axes, runs: Sequence[Run]) -> None:
    scale = scaled(runs[0], "time step", "s", *(run.series["dt"][unhurried(run)] for run in runs))
    for run, color, style in zip(runs, (BLUE, ORANGE), ("-", "--")):
        free = unhurried(run)
        t, dt = run.series["t"][free], run.series["dt"][free]
        some = thin(len(t))
        look = {"color": color, "linestyle": style, "linewidth": 1.0, "label": _name(run)}
        axes.plot(t[some], scale(dt)[some], **look)
    axes.set_ylabel(scale.label)
    legend_above(axes, **SMALL_LEGEND)
    time_axis(axes, runs[0])


def _differences(axes: Axes, runs: Sequence[Run]) -> None:
    """The largest differences and the options that differ, as text."""
    found = compare(runs[0].path, runs[1].path)
    telling = [d for d in found.differences if d.largest and (": " in d.name or d.name in _SERIES)]
    rows = sorted(telling, key=lambda d: -(d.largest / d.scale if d.scale else np.inf))
    title = f"{'largest difference':32}{'absolute':>10}{'relative':>10}"
    lines = [title if rows else "equal, bit for bit, in what both have"]
    lines += [f"{d.name:32.32}{d.largest:10.2e}{d.largest / d.scale if d.scale else np.nan:10.1e}" for d in rows[:LISTED]]
    lines += [f"and {len(rows) - LISTED} more (the command diff)"] * (len(rows) > LISTED)
    others = {name: pair for name, pair in found.options.items() if name not in OF_A_RUN}
    lines += [f"-{name}: {one}, {other}"[:60] for name, (one, other) in list(others.items())[:5]]
    lines += [note[:60] for note in found.notes[:2]]
    axes.axis("off")
    axes.text(0.0, 1.0, "\n".join(lines), transform=axes.transAxes, va="top", family="monospace", fontsize=6.5)
