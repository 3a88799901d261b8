"""A quantity over x at some times."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.output.plots.frames import at_times, moment
from fsipetsc.output.plots.quantities import Quantity
from fsipetsc.output.plots.scales import NOTHING, axis_label, extremes, scaled, value_at_rest
from fsipetsc.output.plots.style import COLORS, legend_above
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Layer, Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = np.ndarray
PANELS = 4
FLAT = 0.1  # a frame that is nearer to rest than this part of the extreme shows nothing


def draw(figure: Figure, run: Run, quantity: Quantity, times: Sequence[float] | None) -> None:
    """A panel for each of the times, or for those of `frames`."""
    chosen, extreme = (at_times(run, times), None) if times else frames(run, quantity)
    columns = 1 if len(chosen) == 1 else 2 if len(chosen) <= 4 else 3
    rows = -(-len(chosen) // columns)
    figure.set_size_inches(max(5.0, 3.6 * columns), 0.6 + 2.5 * rows)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    curves = {frame: list(_curves(run, quantity, frame)) for frame in chosen}
    start = np.concatenate([y for _, _, y in _curves(run, quantity, 0)])
    drawn = (y for some in curves.values() for _, _, y in some)
    scale = scaled(run, quantity.label, quantity.unit, *drawn, start=start)
    for axes, frame in zip(grid.flat, chosen):
        for kind, x, y in curves[frame]:
            axes.plot(x, scale(y), color=COLORS[kind], label=kind)
        note = ", extreme" if frame == extreme else ""
        axes.set_title(moment(run, frame) + note, loc="left")
    for axes in grid.flat[len(chosen) :]:
        axes.set_visible(False)
    kinds = {kind for some in curves.values() for kind, _, _ in some}
    grid[0, 0].set_xlim(domain(run, kinds))
    scale.limit(grid[0, 0])
    figure.supxlabel(axis_label(run, "x", "m"), fontsize=9)
    figure.supylabel(scale.label, fontsize=9)
    set_title(figure, of_run(run, quantity.title))
    if len(kinds) > 1:
        _legend(grid[0, -1], grid[0, 0])


def frames(run: Run, quantity: Quantity, count: int = PANELS) -> tuple[list[int], int | None]:
    """Frames worth a panel, and which of them has the value furthest from rest (None if nothing ever happens).

    They are evenly spaced between the first in which something is to be seen and the last; that with the extreme takes the
    place of the nearest of them.
    """
    values = [v for layer in run.layers if (v := quantity.values(layer)) is not None]
    low, high = extremes(*values)
    rest = value_at_rest(high - low, *(v[0] for v in values))
    departure = np.max([np.nanmax(np.abs(v - rest).reshape(len(v), -1), axis=1) for v in values], axis=0)
    extreme = int(np.argmax(departure))
    if not departure[extreme] > NOTHING * max(abs(low), abs(high)):
        return [run.nframes - 1], None
    begin = np.flatnonzero(departure > FLAT * departure[extreme])[0]
    chosen = at_times(run, np.linspace(run.time[begin], run.time[-1], count).tolist())
    if extreme not in chosen:
        chosen.remove(min(chosen, key=lambda frame: abs(run.time[frame] - run.time[extreme])))
    return sorted({*chosen, extreme}), extreme


def domain(run: Run, kinds: set[str] | frozenset[str] = frozenset({"fluid", "solid"})) -> tuple[float, float]:
    """From the left end to the right one of the layers of these kinds, at all times.

    The last point of a gas at its outer end may be a ghost point, up to a spacing beyond the end: the innermost that it has
    been at is less than a step of the end away from it. One that goes further is the end itself, and moves.
    """
    shown = [layer for layer in run.layers if layer.kind in kinds]
    first, last = np.nanmin(shown[0].x, axis=1), np.nanmax(shown[-1].x, axis=1)
    left = np.nanmax(first) if shown[0] is run.layers[0] and _may_be_ghost(run, shown[0], first) else np.nanmin(first)
    right = np.nanmin(last) if shown[-1] is run.layers[-1] and _may_be_ghost(run, shown[-1], last) else np.nanmax(last)
    return float(left), float(right)


def _may_be_ghost(run: Run, layer: Layer, x: Array) -> bool:
    spacing = float(layer.X[1] - layer.X[0])
    return layer.kind == "fluid" and len(run.layers) > 1 and float(np.nanmax(x) - np.nanmin(x)) < 1.001 * spacing


def _curves(run: Run, quantity: Quantity, frame: int) -> Iterator[tuple[str, Array, Array]]:
    """Kind, x and values of the layers that have the quantity."""
    for layer in run.layers:
        values = quantity.values(layer, frame)
        if values is not None:
            yield layer.kind, layer.frame(frame)["x"], values


def _legend(place: Axes, source: Axes) -> None:
    """One entry per kind of layer, above the panel at the top right, beside its title."""
    handles, labels = source.get_legend_handles_labels()
    entries = dict(zip(labels, handles))
    legend_above(place, entries.values(), entries.keys(), side="right", columns=len(entries))
