"""One page that tells what happened in a run: fields over space and time, interfaces, energy, balances, what bounds steps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.output.plots import balances, interfaces, profiles, reason, space_time, whole
from fsipetsc.output.plots.frames import at_times, check_drawable, moment
from fsipetsc.output.plots.maps import page as of_maps
from fsipetsc.output.plots.quantities import PROFILES, SPACE_TIME, Quantity
from fsipetsc.output.plots.scales import named, scaled, time_axis
from fsipetsc.output.plots.steps import draw_steps
from fsipetsc.output.plots.style import BLACK, SMALL_LEGEND, legend_above, shade, thin
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase

WIDTH, PANELS = 11.0, 2.8  # inches: of the page, and the height of the lowest row
MAPS = 4.0  # height of maps over x and t
TIMES = 4  # profiles that are drawn where there are too few frames for a map


def draw(
    figure: Figure,
    run: Run,
    fields: Sequence[str] = (),
    times: Sequence[float] = (),
    *,
    faults: list[str],
) -> None:
    """The page, on a figure of its own. fields: names of what is shown, times: of profiles or maps; InputError for others.

    faults: gets what of a damaged result could not be drawn.
    """
    check_drawable(run)
    below = list(whole(iter(panels(run)), faults, "panels"))
    find = of_maps.maps_of if run.dimension == 2 else _profiles_or_maps
    height, above = MAPS, lambda part: None
    try:
        height, above = find(run, fields, times) if run.nframes else (0.01, above)
    except InputError:
        raise
    except Exception as error:
        faults.append(f"fields ({reason(error)})")
    figure.set_size_inches(WIDTH, 0.6 + height + PANELS * bool(below))
    figure.set_layout_engine("constrained", w_pad=0.08, h_pad=0.06)
    parts = figure.subfigures(1 + bool(below), 1, height_ratios=[height, PANELS][: 1 + bool(below)], squeeze=False)[:, 0]
    attempt(partial(above, parts[0]), faults, "fields")
    if below:
        for axes, panel in zip(parts[1].subplots(1, len(below), squeeze=False)[0], below):
            attempt(partial(panel, axes), faults, panel.func.__name__.strip("_"))
    set_title(figure, of_run(run, _story(run)))


def attempt(action: Callable[[], None], faults: list[str], what: str) -> None:
    """Draw something; of damaged numbers there is no end to what may be wrong with them."""
    try:
        action()
    except Exception as error:
        faults.append(f"{what} ({reason(error)})")


def panels(run: Run) -> list[Callable[[Axes], None]]:
    """What there is to be drawn below."""
    found: list[Callable[[Axes], None]] = []
    if run.dimension == 2:
        found += of_maps.panels(run)
    elif "x_interface" in run.series and len(run.series["t"]) > 1:
        found.append(partial(_interfaces, run=run))
    if len(run.series.get("t", ())) < 2:
        return found
    if "energy" in run.series:
        found.append(partial(_energy, run=run))
    if balances.departures(run):
        found.append(partial(_departures, run=run))
    return [*found, partial(_steps, run=run)]


def _story(run: Run) -> str:
    steps = f"{run.summary['steps']:,} steps" if "steps" in run.summary else f"{len(run.series.get('t', ()))} steps so far"
    end = moment(run, -1) if run.nframes else "no frame"
    return f"{end}, {steps}"


def _profiles_or_maps(run: Run, fields: Sequence[str], times: Sequence[float]) -> tuple[float, Callable[[FigureBase], None]]:
    """Height and drawing function of what stands above: maps over x and t, profiles for given times or where frames are few."""
    there = [quantity for quantity in PROFILES if any(quantity.of(layer.kind) for layer in run.layers)]
    named(fields, [quantity.name for quantity in there])
    chosen = [q for q in there if q.name in fields] if fields else [q for q in SPACE_TIME if q in there]
    if times or run.nframes <= TIMES:
        return MAPS - 0.8, partial(_profiles, run=run, quantities=chosen, times=times)
    return MAPS, partial(space_time.draw_maps, run=run, quantities=chosen)


def _profiles(figure: FigureBase, run: Run, quantities: Sequence[Quantity], times: Sequence[float]) -> None:
    """A panel for each quantity, a line for each time, the later the darker."""
    frames = at_times(run, times) if times else list(range(run.nframes))
    for axes, quantity in zip(figure.subplots(1, len(quantities), sharex=True, squeeze=False)[0], quantities):
        curves(axes, [run], quantity, [frames])
    _legend(figure.axes[-1], 12, columns=4)


def curves(axes: Axes, runs: Sequence[Run], quantity: Quantity, frames: Sequence[Sequence[int]]) -> None:
    """A quantity over x at frames of each of the runs; the second run dashed."""
    drawn = [
        (number, frame, layer.frame(frame)["x"], quantity.values(layer, frame))
        for number, (run, some) in enumerate(zip(runs, frames))
        for frame in some
        for layer in run.layers
        if quantity.of(layer.kind)
    ]
    run, count = runs[0], max(len(some) for some in frames)
    at_start = [v for layer in run.layers if (v := quantity.values(layer, 0)) is not None]
    scale = scaled(run, quantity.label, quantity.unit, *(y for *_, y in drawn), start=np.concatenate(at_start))
    seen = set()
    for number, frame, x, y in drawn:
        place = list(frames[number]).index(frame)
        label = f"t = {runs[number].time[frame]:.4g}" if number == 0 and frame not in seen else None
        seen |= {frame} if number == 0 else set()
        axes.plot(x, scale(y), linestyle="-" if number == 0 else "--", linewidth=1.2, color=shade(place, count), label=label)
    axes.set_xlim(profiles.domain(run))
    axes.set_ylabel(scale.label)
    axes.set_xlabel(profiles.axis_label(run, "x", "m"))
    scale.limit(axes)


def _interfaces(axes: Axes, run: Run) -> None:
    interfaces.positions(axes, run)
    time_axis(axes, run)
    _legend(axes)


def _energy(axes: Axes, run: Run) -> None:
    """What the energy of all layers has changed by."""
    values = run.series["energy"]
    start = run.summary["initial_energy"] if "initial_energy" in run.summary else values[0]
    unit = "J/m" if run.dimension == 2 else "J/m²"
    scale, some = scaled(run, "change of energy", unit, values - start), thin(len(values))
    axes.plot(run.series["t"][some], scale(values - start)[some], color=BLACK, linewidth=1.0)
    axes.set_ylabel(scale.label)
    scale.limit(axes)
    time_axis(axes, run)


def _departures(axes: Axes, run: Run) -> None:
    balances.draw_departures(axes, run)
    _legend(axes)


def _steps(axes: Axes, run: Run) -> None:
    draw_steps(axes, run)


def _legend(axes: Axes, most: int = 5, columns: int = 1) -> None:
    """Above the panel, in so many columns."""
    handles, labels = axes.get_legend_handles_labels()
    if len(labels) > most:
        handles, labels = handles[:most], [*labels[: most - 1], f"{labels[most - 1]}, …"]
    if handles:
        legend_above(axes, handles, labels, columns=columns, **SMALL_LEGEND)
