"""What is recorded at each step, in any dimension: interfaces, balances, the time step. In two
dimensions the deflection of interfaces, too.
"""

from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.checks import counted
from fsipetsc.errors import InputError
from fsipetsc.output.file_layout import columns_of
from fsipetsc.output.plots import style
from fsipetsc.output.plots.style import FigureBase
from fsipetsc.output.quantities import Quantity
from fsipetsc.output.reader import Run
from fsipetsc.output.units import unit_of, written
from fsipetsc.scheme.conservation_check import Drifts
from fsipetsc.scheme.observables import SERIES

Array = np.ndarray

INTERFACE_POINTS = (0.25, 0.5, 0.75)  # of an interface, whose deflection is drawn as a curve
DEPARTURE = "relative departure"
#: a logarithmic axis spans so much at most
SPAN = 1e8


class Panel(NamedTuple):
    """Curves over time with one axis: names -> (nsteps,), over t; logarithmic: of their sizes."""

    label: str
    unit: str
    t: Array
    curves: dict[str, Array]
    logarithmic: bool = False


def panels(run: Run) -> dict[str, list[Panel]]:
    """What there is to draw of interfaces, of ledgers, and of the steps.

    Of interfaces how they move, in two dimensions first the one that moves most, then what holds
    there. Of ledgers by how much has departed what must be kept, then the ledgers. Of steps the
    largest of some each, for those before a saved time share what is left.
    """
    found: dict[str, list[Panel]] = {"interfaces": [], "ledgers": [], "steps": []}
    interfaces, ledgers, steps = found.values()
    if run.dimension == 2 and run.nframes > 1:
        lines = [run.interface(k) for k in range(len(run.interfaces))]
        for line in sorted(lines, key=lambda line: -np.nanmax(np.abs(line.displacement))):
            points = [round(part * (len(line.s) - 1)) for part in INTERFACE_POINTS]
            curves = {f"s = {line.s[point]:.3g}": line.displacement[:, point] for point in points}
            interfaces.append(Panel(f"deflection,\n{line.name}", "m", run.time, curves))
    t = run.series.get("t", np.empty(0))
    if len(t) < 2:
        return found
    if departed := departures(run):
        ledgers.append(Panel(DEPARTURE, "", t, departed, logarithmic=True))
    for name, one in SERIES.items():
        if one.label and name in run.series:
            label, values, start = one.label.replace("*", name[-1]), run.series[name], 0.0
            if name == "x_interface" or label.startswith("change"):
                start = np.asarray(run.summary.get(f"initial_{name}", values[0]))
            names = columns_of(run.header).get(one.of, [name])
            curves = dict(zip(names, (values - start).reshape(len(t), -1).T))
            unit, apart = written(unit_of(name, run)), name.startswith("residual")
            found["interfaces" if one.of == "interface" else "ledgers"].append(
                Panel(label, unit, t, curves, logarithmic=apart)
            )
    at, dt = envelope(t, run.series["dt"], len(t) // 4)
    steps.append(Panel("time step", "s", at, {"dt": dt}))
    return found


def probed(run: Run, quantities: Sequence[Quantity], places: Sequence[Any]) -> list[Panel]:
    """What nodes nearest to places of the reference map have in the saved frames. InputError."""
    if any(len(at) != run.dimension for at in places):
        raise InputError(f"-probes: expected {counted(run.dimension, 'number')} for each place")
    panels = [Panel(q.title, q.unit, run.time, {}) for q in quantities if places]
    for (panel, q), at in product(zip(panels, quantities), places):
        layers = [layer for layer in run.layers if layer.kind in q.labels]
        away = [np.linalg.norm(layer.places - at, axis=-1) for layer in layers]
        layer, near = min(zip(layers, away), key=lambda of: of[1].min())
        frames = ({"X": layer.X, **layer.frame(k)} for k in range(run.nframes))
        values = [q.values(layer.kind, of).flat[np.argmin(near)] for of in frames]
        panel.curves["at " + ", ".join(f"{x:.4g}" for x in at)] = np.array(values)
    return panels


def departures(run: Run) -> dict[str, Array]:
    """Name of what must not change in this run -> its relative departure, (nsteps,)."""
    laws, prefix = run.header.get("laws"), "initial_"
    initial = {k.removeprefix(prefix): v for k, v in run.summary.items() if k.startswith(prefix)}
    if not laws or not initial:
        return {}
    series, before = run.series, run.series["t"][0] - run.series["dt"][0]
    if not before > 0.5 * run.series["dt"][0]:
        return Drifts(laws, initial).go_on(series)
    # it goes on from another result, which has what came in before: from its first step on
    initial |= {name: series[name][0] for name in initial if name in series}
    later = {name: values[1:] for name, values in series.items()}
    found = Drifts(laws, initial).go_on(later)
    return {name: np.concatenate([[0.0], values]) for name, values in found.items()}


def draw(figure: FigureBase, run: Run, panels: list[Panel], columns: int) -> None:
    """Panels on a figure, so many beside each other."""
    for axes, panel in zip(style.panels(figure, len(panels), columns).flat, panels):
        some = slice(None, None, max(1, len(panel.t) // style.MAX_POINTS))
        axes.set_prop_cycle(**style.CURVES)
        for name, values in panel.curves.items():
            t, shown = panel.t[some], values[some]
            if panel.logarithmic:
                t, shown = envelope(panel.t, np.abs(values))
                shown = np.where(shown > 0, shown, np.nan)
            axes.plot(t, shown, label=name)
        if panel.logarithmic:
            axes.set_yscale("log")
            axes.set_ylim(bottom=max(axes.get_ylim()[0], axes.get_ylim()[1] / SPAN))
        if panel.label == "time step":
            axes.set_ylim(bottom=0.0)
        style.label_y(axes, style.labelled(run, panel.label, panel.unit))
        if len(panel.curves) > 1 or panel.logarithmic:
            style.legend_above(axes)  # else its one name says nothing
        style.time_axis(axes, run)


def envelope(t: Array, values: Array, parts: int = 300) -> tuple[Array, Array]:
    """The largest value in each of so many equal parts of the steps, and its time."""
    pieces = np.array_split(np.arange(len(t)), max(1, min(parts, len(t))))
    at = np.array([piece[np.argmax(values[piece])] for piece in pieces])
    return t[at], values[at]
