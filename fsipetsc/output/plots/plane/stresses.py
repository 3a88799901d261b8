"""The stresses within solids, which in a map of all layers may be too thin to see."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fsipetsc.output.plots.plane.maps import bar, chosen_frames, colors, mesh, outline
from fsipetsc.output.plots.plane.quantities import MAPS, STRESSES
from fsipetsc.output.plots.scales import axis_label, extremes, unit_of
from fsipetsc.output.plots.titles import of_run, set_title
from fsipetsc.output.reader import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

THIN = 0.25  # height over width, below which a solid is drawn higher than it is


def draw(figure: Figure, run: Run, times: Sequence[float] | None) -> None:
    """A column for each of the stresses, a row for each time and solid; what is thin is drawn higher than it is."""
    chosen = chosen_frames(run, MAPS[0].gas, MAPS[0].solid, times)
    solids = [layer for layer in run.layers if layer.kind == "solid"]
    rows = [(frame, layer) for layer in solids for frame in chosen]
    figure.set_size_inches(3.3 * len(STRESSES), 1.6 + 1.25 * len(rows))
    grid = figure.subplots(len(rows), len(STRESSES), sharex=True, sharey=len(solids) == 1, squeeze=False)
    higher = False
    for column, quantity in enumerate(STRESSES):
        own = colors(run, quantity, chosen)
        for axes, (frame, layer) in zip(grid[:, column], rows):
            fields = layer.frame(frame)
            picture = mesh(axes, layer, fields, own, frame)
            outline(axes, fields["x"], fields["y"])
            axes.grid(visible=False)
            x, y = extremes(layer["x"]), extremes(layer["y"])
            thin = y[1] - y[0] < THIN * (x[1] - x[0])
            higher |= thin
            axes.set(xlim=x, ylim=y, aspect="auto" if thin else "equal")
            if column == 0:
                name = f"{layer.name}, " if len(solids) > 1 else ""
                axes.set_title(f"{name}t = {run.time[frame]:.4g}{unit_of(run, 's')}", loc="left")
        bar(figure, picture, own, list(grid[:, column]))
    figure.supxlabel(axis_label(run, "x", "m"), fontsize=9)
    figure.supylabel(axis_label(run, "y", "m"), fontsize=9)
    set_title(figure, of_run(run, f"stresses in the solid{', drawn higher than it is' if higher else ''}"))
