"""What is recorded at each step, in any dimension: interfaces, balances, the time step."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fsipetsc.output.plots.scales import SMALL, logarithmic, scaled, time_axis, time_scale
from fsipetsc.output.plots.style import (
    BLUE, GREEN, GREY, MAX_POINTS, ORANGE, PURPLE, RED, legend_above, line_look,
)  # fmt: skip
from fsipetsc.output.reader import Run
from fsipetsc.scheme.conservation_check import drifts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase

Array = np.ndarray

#: series of interfaces -> label, unit
AT_INTERFACES = {
    "u_interface": ("velocity u", "m/s"),
    "sigma_interface": ("stress σ", "Pa"),
    "T_interface": ("temperature T", "K"),
}
#: series -> by how much a condition at the interfaces is missed
RESIDUALS = {
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
_PER_LENGTH = {"kg/m²": "kg/m", "J/m²": "J/m", "kg/(m s)": "kg/s", "J/(m² K)": "J/(m K)"}
_IN_ALL = {"kg/m²": "kg", "J/m²": "J", "kg/(m s)": "kg m/s", "J/(m² K)": "J/K"}
_UNITS = {1: {}, 2: _PER_LENGTH, 3: _IN_ALL}


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
    """Where the interfaces are, how long solids are between two of them, what holds there."""
    if "x_interface" in run.series:
        x = run.series["x_interface"]
        yield _moved("position of the interface", "displacement of the interface", _columns(run, x))
        inside = range(1, len(run.layers) - 1) if x.shape[1] == len(run.layers) - 1 else ()
        solids = {run.layers[i].name: x[:, i] - x[:, i - 1] for i in inside if run.layers[i].kind == "solid"}
        if solids:
            yield _moved("length of the solid", "change of length of the solid", solids)
    for name, (label, unit) in AT_INTERFACES.items():
        if name in run.series:
            yield Panel(label, unit, _columns(run, run.series[name]))
    for name, (label, unit) in RESIDUALS.items():
        if name in run.series:
            yield Panel(label, unit, _columns(run, run.series[name]), logarithmic=True)


def _moved(label: str, change: str, curves: dict[str, Array]) -> Panel:
    """The curves, or, if they vary little over time, less their first values."""
    span = max(np.ptp(values) for values in curves.values())
    if span >= SMALL * max(np.abs(values).max() for values in curves.values()):
        return Panel(label, "m", curves)
    return Panel(change, "m", {name: values - values[0] for name, values in curves.items()})


def _columns(run: Run, values: Array) -> dict[str, Array]:
    """The name of each interface -> its column of a series."""
    columns = values.reshape(len(values), -1).T
    names = run.interfaces if len(run.interfaces) == len(columns) else map(str, range(len(columns)))
    return dict(zip(names, columns))


def ledger_panels(run: Run) -> Iterator[Panel]:
    """Mass, energy, momentum, entropy, J, and by how much what must be kept has departed."""
    if any(departures(run)):
        yield Panel("relative departure", "", departures(run), logarithmic=True)
    for name, (label, unit, change) in LEDGERS.items():
        if name not in run.series:
            continue
        values = run.series[name]
        start = np.asarray(run.summary.get(f"initial_{name}", values[0])) if change else np.zeros(1)
        curves = {name: values - start}
        if values.ndim > 1:
            blocks = [x.name for x in run.layers if name != "mass" or x.kind == "fluid"]
            curves = dict(zip(blocks, (values - start).T))
        unit = _UNITS[run.dimension].get(unit, unit)
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
            axes.plot(*envelope(time(t), np.abs(values)), **line_look(k), label=name)
        if panel.label == "relative departure" and run.options.get("fsi_check"):
            axes.axhline(run.options["fsi_check"], color=GREY, linestyle=":", label="-fsi_check")
        logarithmic(axes)
        axes.set_ylabel(f"{panel.label}{f'  [{panel.unit}]' if panel.unit and _si(run) else ''}")
    else:
        start = np.array([values[0] for values in panel.curves.values()])
        scale = scaled(
            run, panel.label, panel.unit, *panel.curves.values(), start=start, beside=panel.beside
        )
        some = slice(None, None, max(1, len(t) // MAX_POINTS))
        for k, (name, values) in enumerate(panel.curves.items()):
            axes.plot(time(t[some]), scale(values[some]), **line_look(k), label=name)
        scale.limit(axes)
        axes.set_ylabel(scale.label.replace(", ", ",\n", 1))
    if len(panel.curves) > 1 or panel.logarithmic:
        legend_above(axes)
    time_axis(axes, run)


def _si(run: Run) -> bool:
    return run.header.get("units", "SI") == "SI"


def envelope(t: Array, values: Array, bins: int = 300) -> tuple[Array, Array]:
    """The largest value above 0 in each of so many equal parts of the steps, and its time."""
    parts = np.array_split(np.arange(len(t)), min(bins, len(t)))
    at = np.array([part[np.argmax(values[part])] for part in parts])
    return t[at], np.where(values[at] > 0, values[at], np.nan)


def draw_steps(axes: Axes, run: Run) -> None:
    """Length of the steps, without those that end at a saved time, before what bounded them."""
    free = unhurried(run)
    t, dt = run.series["t"][free], run.series["dt"][free]
    scale, time = scaled(run, "time step", "s", dt), time_scale(run)
    some = slice(None, None, max(1, len(t) // MAX_POINTS))
    axes.plot(time(t[some]), scale(dt[some]), **line_look(0))
    axes.set_ylabel(scale.label)
    if np.ptp(dt) < SMALL * dt.max():
        middle = scale(0.5 * (dt.max() + dt.min()))
        axes.set_ylim((1 - SMALL) * middle, (1 + SMALL) * middle)
    limits = run.summary.get("limits", ())
    ends = [*(t for t, _ in limits), run.series["t"][-1]]
    colors = dict(zip(dict.fromkeys(what for _, what in limits), (GREY, ORANGE, BLUE, GREEN, PURPLE, RED)))
    for (begin, what), until in zip(limits, ends[1:]):
        look = {"color": colors.get(what, GREY), "alpha": 0.3, "linewidth": 0}
        axes.axvspan(time(begin), time(until), **look, label=what)
    legend_above(axes)
    time_axis(axes, run)


def unhurried(run: Run) -> Array:
    """(nsteps,) False for the two steps before a saved time, which share what was left."""
    t = run.series["t"]
    free = np.ones(len(t), bool)
    ends = np.searchsorted(t, run.time * (1 - 1e-12))
    ends = ends[ends < len(t)]
    free[ends] = free[np.maximum(ends - 1, 0)] = False
    return free if free.sum() > len(free) // 10 else np.ones_like(free)
