"""What is recorded at each step, in any dimension: interfaces, balances, the time step."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fsipetsc.output.plots.scales import SMALL, is_si, logarithmic, scaled, time_axis, time_scale
from fsipetsc.output.plots.style import GREY, MAX_POINTS, SERIES, legend_above, line_look
from fsipetsc.output.reader import Run
from fsipetsc.scheme.conservation_check import drifts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase

Array = np.ndarray

#: series of interfaces -> label, unit; residuals: by how much a condition is missed
AT_INTERFACES = {
    "u_interface": ("velocity u", "m/s"),
    "sigma_interface": ("stress σ", "Pa"),
    "T_interface": ("temperature T", "K"),
    "residual_u": ("|residual|, velocity", "m/s"),
    "residual_stress": ("|residual|, stress", "Pa"),
    "residual_T": ("|residual|, temperature", "K"),
    "residual_flux": ("|residual|, heat flux", "W/m²"),
}
#: series -> label, unit of integrals in one dimension, whether less what it is at the start
LEDGERS = {
    "mass": ("change of mass", "kg/m²", True),
    "energy": ("change of energy", "J/m²", True),
    "momentum": ("momentum", "kg/(m s)", False),
    "force": ("force of ends and body", "Pa", False),
    "momentum_x": ("change of momentum x", "kg/(m s)", True),
    "momentum_y": ("change of momentum y", "kg/(m s)", True),
    "momentum_z": ("change of momentum z", "kg/(m s)", True),
    "entropy": ("change of entropy", "J/(m² K)", True),
    "least_J": ("least J", "", False),
    "J_error": ("departure of J", "", False),
}
#: the same units in two and in three dimensions
_UNITS = {
    "kg/m²": ("kg/m", "kg"),
    "J/m²": ("J/m", "J"),
    "kg/(m s)": ("kg/s", "kg m/s"),
    "J/(m² K)": ("J/(m K)", "J/K"),
}


class Panel(NamedTuple):
    """Curves over time with one axis: names -> (nsteps,).

    beside: size of the values beside which round-off is nothing; logarithmic: sizes.
    """

    label: str
    unit: str
    curves: dict[str, Array]
    beside: float = 0.0
    logarithmic: bool = False


def interface_panels(run: Run) -> Iterator[Panel]:
    """How interfaces move, how long solids are between two of them, and what holds there."""
    x = run.series.get("x_interface")
    if x is not None:
        yield Panel("displacement of the interface", "m", _columns(run, x - x[0]))
        inside = range(1, len(run.layers) - 1) if x.shape[1] == len(run.layers) - 1 else ()
        solids = [i for i in inside if run.layers[i].kind == "solid"]
        if solids:
            lengths = {run.layers[i].name: x[:, i] - x[:, i - 1] for i in solids}
            yield Panel("length of the solid", "m", lengths)
    for name, (label, unit) in AT_INTERFACES.items():
        if name in run.series:
            values = _columns(run, run.series[name])
            yield Panel(label, unit, values, logarithmic=name.startswith("residual"))


def _columns(run: Run, values: Array) -> dict[str, Array]:
    """The name of each interface -> its column of a series."""
    return dict(zip(run.interfaces, values.reshape(len(values), -1).T))


def ledger_panels(run: Run) -> Iterator[Panel]:
    """Mass, energy, momentum, entropy, J, and by how much what must be kept has departed."""
    if any(departures(run)):
        yield Panel("relative departure", "", departures(run), logarithmic=True)
    for name, (label, unit, change) in LEDGERS.items():
        if name not in run.series:
            continue
        values = run.series[name]
        start = np.asarray(run.summary.get(f"initial_{name}", values[0])) if change else np.zeros(1)
        blocks = [x.name for x in run.layers if name != "mass" or x.kind == "fluid"]
        curves = dict(zip(blocks, (values - start).reshape(len(values), -1).T))
        unit = (unit, *_UNITS.get(unit, (unit, unit)))[run.dimension - 1]
        yield Panel(label, unit, curves, beside=1e-3 * float(np.abs(start).max()))


def departures(run: Run) -> dict[str, Array]:
    """Name of what must not change in this run -> its relative departure, (nsteps,)."""
    laws, prefix = run.header.get("laws"), "initial_"
    initial = {k.removeprefix(prefix): v for k, v in run.summary.items() if k.startswith(prefix)}
    return drifts(laws, initial, run.series) if laws and initial and len(run.series["t"]) else {}


def draw_panels(figure: FigureBase, run: Run, panels: list[Panel], columns: int = 3) -> None:
    """All of them on a figure."""
    rows = -(-len(panels) // columns)
    grid = figure.subplots(rows, min(columns, len(panels)), squeeze=False)
    for axes, panel in zip(grid.flat, panels):
        draw_panel(axes, run, panel)
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)


def draw_panel(axes: Axes, run: Run, panel: Panel) -> None:
    """One of them, with a legend above where there are several curves."""
    time, t = time_scale(run), run.series["t"]
    if panel.logarithmic:
        for k, (name, values) in enumerate(panel.curves.items()):
            at, largest = envelope(time(t), np.abs(values))
            axes.plot(at, np.where(largest > 0, largest, np.nan), **line_look(k), label=name)
        if panel.label == "relative departure" and run.options.get("fsi_check"):
            axes.axhline(run.options["fsi_check"], color=GREY, linestyle=":", label="-fsi_check")
        logarithmic(axes)
        unit = f"  [{panel.unit}]" if panel.unit and is_si(run) else ""
        axes.set_ylabel(panel.label + unit)
    else:
        start = np.array([values[0] for values in panel.curves.values()])
        curves = panel.curves.values()
        scale = scaled(run, panel.label, panel.unit, *curves, start=start, beside=panel.beside)
        some = slice(None, None, max(1, len(t) // MAX_POINTS))
        for k, (name, values) in enumerate(panel.curves.items()):
            axes.plot(time(t[some]), scale(values[some]), **line_look(k), label=name)
        axes.set_ylabel(scale.label.replace(", ", ",\n", 1))
    if len(panel.curves) > 1 or panel.logarithmic:
        legend_above(axes)
    time_axis(axes, run)


def envelope(t: Array, values: Array, parts: int = 300) -> tuple[Array, Array]:
    """The largest value in each of so many equal parts of the steps, and its time."""
    pieces = np.array_split(np.arange(len(t)), max(1, min(parts, len(t))))
    at = np.array([piece[np.argmax(values[piece])] for piece in pieces])
    return t[at], values[at]


def draw_steps(axes: Axes, run: Run) -> None:
    """Length of the steps, before what bounded them.

    The largest of some steps each: those before a saved time share what is left.
    """
    t, dt = envelope(run.series["t"], run.series["dt"], len(run.series["t"]) // 4)
    scale, time = scaled(run, "time step", "s", dt), time_scale(run)
    axes.plot(time(t), scale(dt), **line_look(0), marker="." if len(t) < 10 else "")
    axes.set_ylabel(scale.label)
    if np.ptp(dt) < SMALL * dt.max():
        middle = scale(0.5 * (dt.max() + dt.min()))
        axes.set_ylim((1 - SMALL) * middle, (1 + SMALL) * middle)
    limits = run.summary.get("limits", ())
    ends = [*(t for t, _ in limits), run.series["t"][-1]]
    kinds = list(dict.fromkeys(what for _, what in limits))
    for (begin, what), until in zip(limits, ends[1:]):
        color = (GREY, *SERIES[1:])[kinds.index(what) % len(SERIES)]
        look = {"color": color, "alpha": 0.3, "linewidth": 0, "label": what}
        axes.axvspan(time(begin), time(until), **look)
    legend_above(axes)
    time_axis(axes, run)
