"""The stresses within solids, which in a map of all layers may be too thin to see."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fsipetsc.output.plots.frames import moment
from fsipetsc.output.plots.maps.panels import bar, chosen_frames, colors, few_ticks, mesh, outline, together
from fsipetsc.output.plots.maps.quantities import STRESSES
from fsipetsc.output.plots.scales import axis_label, extremes
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import BlockLayer, Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

THIN = 0.25  # height over width, below which a solid is drawn higher than it is


def draw(figure: Figure, run: Run, times: Sequence[float] | None) -> None:
    """A column for each of the stresses, a row for each time and solid; what is thin is drawn higher than it is."""
    chosen = chosen_frames(run, STRESSES[0], STRESSES[0], times)
    solids = [layer for layer in run.layers if layer.kind == "solid"]
    rows = [(frame, layer) for layer in solids for frame in chosen]
    heights = [min(1.0, max(THIN, height(layer))) for _, layer in rows]
    figure.set_size_inches(3.3 * len(STRESSES), 1.5 + sum(0.35 + 2.6 * share for share in heights))
    width = min(3.0, 2.6 / max(map(height, solids)))
    together(figure, width)
    grid = figure.subplots(len(rows), len(STRESSES), sharex=True, sharey=len(solids) == 1, squeeze=False, height_ratios=heights)
    higher = False
    for column, quantity in enumerate(STRESSES):
        own = colors(run, quantity, chosen)
        for axes, (frame, layer) in zip(grid[:, column], rows):
            fields = layer.frame(frame)
            picture = mesh(axes, layer, fields, own, frame)
            outline(axes, layer, fields)
            axes.grid(visible=False)
            thin = height(layer) < THIN
            higher |= thin
            axes.set(xlim=extremes(layer["x"]), ylim=extremes(layer["y"]), aspect="auto" if thin else "equal")
            if column == 0:
                name = f"{layer.name}, " if len(solids) > 1 else ""
                axes.set_title(name + moment(run, frame), loc="left")
        bar(figure, picture, own, list(grid[:, column]), 3)
    few_ticks(grid[0, 0], width)
    figure.supxlabel(axis_label(run, "x", "m"), fontsize=9)
    figure.supylabel(axis_label(run, "y", "m"), fontsize=9)
    set_title(figure, of_run(run, f"stresses in the solid{', drawn higher than it is' if higher else ''}"))


def height(layer: BlockLayer) -> float:
    """Of all that the layer ever covers, over its width."""
    (left, right), (low, high) = extremes(layer["x"]), extremes(layer["y"])
    return (high - low) / (right - left)
