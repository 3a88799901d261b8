"""Draws Figs. 8 to 11 of the paper from the results of scripts/reproduce:
figures.py DIRECTORY [NOTE].

DIRECTORY holds rod.h5, closeup-ORDER-H.h5 for the orders 2, 4, 6 on two grids, and reference.h5;
the PNG files go there too. NOTE is added to the titles. Fluid blue, solid red; the coarser grid of
Fig. 11 light blue and pink.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import fsipetsc
from fsipetsc.operators.sbp import OPERATORS
from fsipetsc.output.drawing import BLACK, COLORS, STYLE, set_title
from fsipetsc.output.reader import Run

COARSE = {"fluid": "#56b4e9", "solid": "#cc79a7"}
LETTERS = "abcd"


def main(directory: str, note: str = "") -> None:
    """Draw all of them."""
    folder, note = Path(directory), f"  ({note})" if note else ""
    with matplotlib.rc_context(STYLE), fsipetsc.open_run(folder / "rod.h5") as rod:
        what = f"{OPERATORS[rod.options['fsi_order']].name}, h = {rod.options['fsi_h']:g} m{note}"
        for number, name, label in ((8, "T", "temperature T  [K]"), (9, "u", "velocity u  [m/s]")):
            title = f"Fig. {number}: {label.split('  ')[0]}, {what}"
            save(profiles(rod, name, label), folder / f"fig{number:02d}.png", title)
        save(positions(rod), folder / "fig10.png", f"Fig. 10: interfaces and length, {what}")
        figure, text = closeup(folder)
        save(figure, folder / "fig11.png", f"Fig. 11: {text}{note}")


def save(figure: Figure, path: Path, title: str) -> None:
    """Write a figure with its title."""
    set_title(figure, title)
    figure.savefig(path)
    print(path)


def curves(run: Run, frame: int, name: str) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Kind of layer, x and values."""
    for layer in run.layers:
        fields = layer.frame(frame)
        yield layer.kind, fields["x"], fields[name]


def profiles(run: Run, name: str, label: str) -> Figure:
    """A field at the four times saved (Figs. 8, 9)."""
    figure = Figure(figsize=(7.6, 5.2))
    frames = [run.at(t) for t in run.options["fsi_output_times"]]
    grid = figure.subplots(2, 2, sharex=True, sharey=True)
    for k, (axes, frame) in enumerate(zip(grid.flat, frames)):
        for kind, x, values in curves(run, frame, name):
            axes.plot(x, values, color=COLORS[kind], label=kind)
        axes.set_title(f"({LETTERS[k]})  t = {run.time[frame]:g} s", loc="left")
        axes.set_xlim(0, 6)
        if k % 2 == 0:
            axes.set_ylabel(label)
        if k > 1:
            axes.set_xlabel("x  [m]")
    entries = dict(zip(*reversed(figure.axes[0].get_legend_handles_labels())))
    figure.axes[1].legend(entries.values(), entries.keys(), loc="upper right", ncols=2)
    return figure


def positions(run: Run) -> Figure:
    """Positions of the interfaces and length of the rod over time (Fig. 10)."""
    figure = Figure(figsize=(7.6, 3.4))
    left, right = figure.subplots(1, 2)
    t, x = run.series["t"][::20], run.series["x_interface"][::20]
    left.plot(t, x[:, 0], color=BLACK, label="lower interface")
    left.plot(t, x[:, 1], color=BLACK, linestyle="--", label="upper interface")
    left.set_ylabel("position x  [m]")
    left.set_ylim(0, 2.4)
    left.legend(loc="lower right")
    right.plot(t, x[:, 1] - x[:, 0], color=COLORS["solid"])
    right.set_ylabel("length of the rod  [m]")
    for axes in (left, right):
        axes.set_xlabel("t  [s]")
        axes.set_xlim(0, t[-1])
    return figure


def closeup(folder: Path) -> tuple[Figure, str]:
    """Velocity near the lower interface for three orders on two grids, over the reference
    (Fig. 11); and the title.
    """
    paths = folder.glob("closeup-*.h5")
    grids = sorted({float(path.stem.split("-")[2]) for path in paths}, reverse=True)
    figure = Figure(figsize=(9.6, 3.8))
    with fsipetsc.open_run(folder / "reference.h5") as run:
        reference, opt = list(curves(run, -1, "u")), run.options
        x_I = run.layers[1].frame(-1)["x"][0]
    for axes, order in zip(figure.subplots(1, 3, sharex=True, sharey=True), (2, 4, 6)):
        for _, x, u in reference:
            axes.plot(x, u, color="black", linewidth=1.0, zorder=5, label="reference")
        for h, colors in zip(grids, (COARSE, COLORS)):
            with fsipetsc.open_run(folder / f"closeup-{order}-{h:g}.h5") as run:
                for kind, x, u in curves(run, -1, "u"):
                    style = {"marker": ".", "markersize": 4, "linewidth": 1.0}
                    label = f"{kind}, h = {h:g} m"
                    axes.plot(x, u, color=colors[kind], **style, label=label)
        near(axes, reference, x_I)
        axes.set_title(OPERATORS[order].name, loc="left")
        axes.set_xlabel("x  [m]")
    figure.axes[0].set_ylabel("velocity u  [m/s]")
    entries = dict(zip(*reversed(figure.axes[0].get_legend_handles_labels())))
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=5)
    name = f"reference {OPERATORS[opt['fsi_order']].name}, h = {opt['fsi_h']:g} m"
    return figure, f"velocity at the lower interface, t = {opt['ts_max_time']:g} s; {name}"


def near(axes: Axes, reference: list[tuple[str, np.ndarray, np.ndarray]], x_I: float) -> None:
    """Limits of the closeup: 0.2 m on either side of the interface."""
    axes.set_xlim(x_I - 0.2, x_I + 0.2)
    shown = np.concatenate([u[np.abs(x - x_I) < 0.2] for _, x, u in reference])
    margin = 0.25 * (shown.max() - shown.min())
    axes.set_ylim(shown.min() - margin, shown.max() + margin)


if __name__ == "__main__":
    main(*sys.argv[1:])
