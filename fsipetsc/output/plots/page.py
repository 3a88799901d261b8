"""The pictures of a result, one by one or as a page that tells what happened."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.output.plots import fields, series, space_time
from fsipetsc.output.plots.quantities import Quantity, chosen, there
from fsipetsc.output.plots.scales import moment
from fsipetsc.output.plots.style import of_run, set_title
from fsipetsc.output.reader import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase

WIDTH = 10.8  # inches, of a figure
PANELS, MAPS = 2.8, 4.2  # inches, heights of a row of curves, of maps over x and t

#: height [inches], what is drawn on a figure of this height
Drawing = tuple[float, Callable[["FigureBase"], None]]


def pictures(
    run: Run, times: Sequence[float] = ()
) -> Iterator[tuple[str, Callable[[Figure], None]]]:
    """Name and drawing function of each picture that this run has the data for."""
    found: list[tuple[str, str, Drawing]] = []
    if run.nframes:
        found += [(q.name, q.title, at_times(run, q, times)) for q in there(run)]
    if run.dimension == 1 and run.nframes >= space_time.LEAST_FRAMES:
        found.append(("xt", "space and time", over_space_and_time(run, chosen(run, ()))))
    if run.dimension == 2 and run.interfaces and run.nframes > 1:
        drawing = 0.8 * MAPS * len(run.interfaces), partial(space_time.draw_interfaces, run=run)
        found.append(("interfaces", "interfaces", drawing))
    if len(run.series.get("t", ())) > 1:
        for name, title, find in (
            ("interfaces", "interfaces", series.interface_panels),
            ("ledgers", "ledgers", series.ledger_panels),
        ):
            if panels := list(find(run)):
                height = PANELS * -(-len(panels) // 3)
                draw = partial(series.draw_panels, run=run, panels=panels)
                found.append((name, title, (height, draw)))
        found.append(("steps", "time steps", (PANELS, partial(_alone, run=run))))
    for name, title, drawing in found:
        yield name, partial(_draw, run=run, title=title, drawings=[drawing])


def page(figure: Figure, run: Run, names: Sequence[str] = (), times: Sequence[float] = ()) -> None:
    """Fields over space and time, below them interfaces, energy, departures and steps.

    names: of the fields, times: of profiles or maps. InputError for a field that there is not.
    """
    quantities, drawings = chosen(run, names), []
    if run.dimension == 1 and not times and run.nframes >= space_time.LEAST_FRAMES:
        drawings.append(over_space_and_time(run, quantities))
    elif run.nframes:
        drawings += [at_times(run, quantity, times) for quantity in quantities]
    if below := list(_panels(run)):
        drawings.append((PANELS, partial(_below, panels=below)))
    steps = f"{len(run.series.get('t', ())):,} steps"
    end = moment(run, -1) if run.nframes else "no frame"
    _draw(figure, run, f"{end}, {steps}", drawings)


def _draw(figure: Figure, run: Run, title: str, drawings: Sequence[Drawing]) -> None:
    """Drawings below each other, and the title."""
    heights = [height for height, _ in drawings] or [1.0]
    figure.set_size_inches(WIDTH, 0.5 + sum(heights))
    parts = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    for part, (_, draw) in zip(parts, drawings):
        draw(part)
    set_title(figure, of_run(run, title))


def at_times(run: Run, quantity: Quantity, times: Sequence[float]) -> Drawing:
    """Profiles or maps."""
    view = fields.view_of(run, quantity, fields.frames_of(run, quantity, times))
    return fields.sizes(view)[2], partial(fields.draw, view=view)


def over_space_and_time(run: Run, quantities: Sequence[Quantity]) -> Drawing:
    """Maps over x and t."""
    return MAPS, partial(space_time.draw, run=run, quantities=quantities)


def _panels(run: Run) -> Iterator[Callable[[Axes], None]]:
    """What is drawn below the fields."""
    if run.dimension == 2 and run.interfaces and run.nframes > 1:
        lines = [run.interface(k) for k in range(len(run.interfaces))]
        moved = max(lines, key=lambda line: float(np.nanmax(np.abs(line.displacement))))
        yield partial(space_time.draw_deflection, run=run, line=moved)
    if len(run.series.get("t", ())) < 2:
        return
    ledgers = {panel.label: panel for panel in series.ledger_panels(run)}
    told = [ledgers.get(name) for name in ("change of energy", "relative departure")]
    for panel in filter(None, [*list(series.interface_panels(run))[:1], *told]):
        yield partial(series.draw_panel, run=run, panel=panel)
    yield partial(series.draw_steps, run=run)


def _below(figure: FigureBase, panels: Sequence[Callable[[Axes], None]]) -> None:
    for axes, draw in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels):
        draw(axes)


def _alone(figure: FigureBase, run: Run) -> None:
    series.draw_steps(figure.subplots(), run)
