"""Pictures of a result: fluid blue, solid red, over the Eulerian coordinate."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.errors import FileError, InputError
from fsipetsc.output.reader import Layer, Run, open_run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = np.ndarray

COLORS = {"fluid": "#1f5fbf", "solid": "#d0312d"}
INTERFACES = ("#222222", "#8a8a8a", "#b07aa1", "#59a14f")  # line colors of the interfaces, in turn
LINES = ("-", "--", "-.", ":")
STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.linewidth": 0.8,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 5),
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "figure.constrained_layout.use": True,
    "figure.constrained_layout.w_pad": 0.08,
    "savefig.dpi": 160,
}
MAX_POINTS = 20_000  # of a line; more cannot be seen


@dataclass(frozen=True)
class Quantity:
    """What a picture shows: name of the file, label and SI unit, and how it follows from the fields of a layer."""

    name: str
    label: str
    unit: str  # SI
    fluid: Callable[[dict[str, Array]], Array] | None
    solid: Callable[[dict[str, Array]], Array] | None
    colormap: str = "viridis"

    def of(self, kind: str) -> Callable[[dict[str, Array]], Array] | None:
        return self.fluid if kind == "fluid" else self.solid


def _field(name: str) -> Callable[[dict[str, Array]], Array]:
    return lambda fields: fields[name]


QUANTITIES = (
    Quantity("u", "velocity u", "m/s", _field("u"), _field("u"), "RdBu_r"),
    Quantity("T", "temperature T", "K", _field("T"), _field("T"), "inferno"),
    Quantity("p", "pressure p,  p − σ in the solid", "Pa", _field("p"), lambda f: f["p"] - f["sigma"]),
    Quantity("rho", "density ρ of the fluid", "kg/m³", _field("rho"), None),
)


def plot(
    path: str | os.PathLike[str],
    outdir: str | os.PathLike[str] = ".",
    times: Sequence[float] | None = None,
) -> list[Path]:
    """Draw a result; returns the PNG files, named after the result.

    times   of the profiles (the nearest saved frames are taken); by default four, from the first to the last

    Raises FileError if the result cannot be read or the pictures cannot be written, InputError without matplotlib.
    """
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError as error:
        raise InputError("plot: matplotlib is not installed (pip install matplotlib)") from error
    folder, written = Path(outdir), []
    with open_run(path) as run, matplotlib.rc_context(STYLE):
        for name, draw in _pictures(run, times):
            figure = Figure()
            draw(figure)
            target = folder / f"{Path(path).stem}-{name}.png"
            try:
                folder.mkdir(parents=True, exist_ok=True)
                figure.savefig(target)
            except OSError as error:
                raise FileError(f"{target}: cannot write the picture: {error.strerror}") from error
            written.append(target)
    return written


def _pictures(run: Run, times: Sequence[float] | None) -> Iterator[tuple[str, Callable[[Figure], None]]]:
    """Names and drawing functions of the pictures that this run has the data for."""
    if run.nframes:
        frames = _frames_to_show(run, times)
        for quantity in QUANTITIES:
            if any(quantity.of(layer.kind) for layer in run.layers):
                yield quantity.name, partial(_draw_profiles, run=run, quantity=quantity, frames=frames)
    if run.nframes > 4:
        yield "xt", lambda figure: _draw_space_time(figure, run)
    if len(run.series.get("t", ())) > 1:
        if "x_interface" in run.series:
            yield "interfaces", lambda figure: _draw_interfaces(figure, run)
        if any(name in run.series for name in _TRACES):
            yield "traces", lambda figure: _draw_traces(figure, run)
        yield "steps", lambda figure: _draw_steps(figure, run)


def _frames_to_show(run: Run, times: Sequence[float] | None) -> list[int]:
    if times is None:
        times = np.linspace(run.time[0], run.time[-1], 4)
    return sorted({run.at(t) for t in times})


# ---------------------------------------------------------------------- profiles


def _draw_profiles(figure: Figure, run: Run, quantity: Quantity, frames: Sequence[int]) -> None:
    columns = 1 if len(frames) == 1 else 2 if len(frames) <= 4 else 3
    rows = -(-len(frames) // columns)
    figure.set_size_inches(max(5.0, 3.6 * columns), 0.4 + 2.5 * rows)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    curves = {frame: list(_curves(run, quantity, frame)) for frame in frames}
    factor, label = _scaled(run, quantity.label, quantity.unit, *(y for some in curves.values() for _, _, y in some))
    for axes, frame in zip(grid.flat, frames):
        for kind, x, y in curves[frame]:
            axes.plot(x, factor * y, color=COLORS[kind], label=kind)
        axes.set_title(_time_text(run, run.time[frame]), loc="left")
    for axes in grid.flat[len(frames) :]:
        axes.set_visible(False)
    for axes in grid[:, 0]:
        axes.margins(x=0.02)
    figure.supxlabel(_label(run, "x", "m"), fontsize=9)
    figure.supylabel(label, fontsize=9)
    figure.suptitle(run.case, fontsize=10, x=0.01, ha="left", weight="bold")
    _figure_legend(figure, grid.flat[0])


def _curves(run: Run, quantity: Quantity, frame: int) -> Iterator[tuple[str, Array, Array]]:
    """Kind, x and values of the layers that have the quantity."""
    for layer in run.layers:
        value = quantity.of(layer.kind)
        if value is not None:
            fields = layer.frame(frame)
            yield layer.kind, fields["x"], value(fields)


def _figure_legend(figure: Figure, axes: Axes) -> None:
    """One entry per kind of layer, at the top right."""
    handles, labels = axes.get_legend_handles_labels()
    entries = dict(zip(labels, handles))
    figure.legend(entries.values(), entries.keys(), loc="upper right", ncols=len(entries), borderaxespad=0.2)


# ---------------------------------------------------------------------- space and time


def _draw_space_time(figure: Figure, run: Run) -> None:
    from matplotlib.ticker import MaxNLocator

    shown = QUANTITIES[:3]
    figure.set_size_inches(3.5 * len(shown), 4.2)
    figure.set_layout_engine("constrained", w_pad=0.12)
    grid = figure.subplots(1, len(shown), sharex=True, sharey=True)
    step = max(1, run.nframes // 500)
    for axes, quantity in zip(grid, shown):
        values = [_space_time_values(layer, quantity, step) for layer in run.layers]
        factor, label = _scaled(run, quantity.label, quantity.unit, *values)
        low, high = _limits(values, symmetric=quantity.colormap == "RdBu_r")
        for layer, own in zip(run.layers, values):
            stride = max(1, len(layer.X) // 1000)
            x = _refined(_without_gaps(layer)[::step, ::stride])
            t = np.broadcast_to(_refined(run.time[::step, None]), x.shape)
            own = np.ma.masked_invalid(factor * _refined(own[:, ::stride]))
            picture = axes.pcolormesh(x, t, own, cmap=quantity.colormap, vmin=factor * low, vmax=factor * high)
        for position in _interface_positions(run):
            axes.plot(*position, color="white", linewidth=1.6)
            axes.plot(*position, color="black", linewidth=0.7)
        axes.grid(visible=False)
        axes.set_xlabel(_label(run, "x", "m"))
        bar = figure.colorbar(picture, ax=axes, location="top", aspect=30, pad=0.02, label=label)
        bar.outline.set_visible(False)
        bar.locator = MaxNLocator(5)
    ends = [layer.x[np.isfinite(layer[layer.fields[0]])] for layer in run.layers]
    grid[0].set_xlim(min(x.min() for x in ends if x.size), max(x.max() for x in ends if x.size))
    grid[0].set_ylim(run.time[0], run.time[-1])
    grid[0].set_ylabel(_label(run, "t", "s"))


def _refined(rows: Array) -> Array:
    """Few frames, interpolated linearly in time at fixed X, so that they do not look like stairs."""
    parts = max(1, 200 // (len(rows) - 1))
    weight = (np.arange(parts) / parts)[:, None]
    before = np.where(np.isfinite(rows[:-1]), rows[:-1], rows[1:])  # points come and go at the ends of the fluids
    after = np.where(np.isfinite(rows[1:]), rows[1:], rows[:-1])
    between = before[:, None] * (1 - weight) + after[:, None] * weight
    return np.concatenate([between.reshape(-1, rows.shape[1]), rows[-1:]])


def _space_time_values(layer: Layer, quantity: Quantity, step: int) -> Array:
    fields = {name: layer[name][::step] for name in layer.fields}
    value = quantity.of(layer.kind)
    return value(fields) if value is not None else np.full_like(fields["x"], np.nan)


def _without_gaps(layer: Layer) -> Array:
    """The positions, continued by the grid where there are none: pictures need a place for what they do not show."""
    shift = layer.x - layer.X
    known = np.isfinite(shift)
    count = np.maximum(known.sum(axis=1, keepdims=True), 1)
    mean = np.where(known, shift, 0.0).sum(axis=1, keepdims=True) / count
    return np.where(known, layer.x, layer.X + mean)


def _limits(arrays: Iterable[Array], symmetric: bool) -> tuple[float, float]:
    finite = np.concatenate([values[np.isfinite(values)] for values in arrays])
    if not finite.size:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    if symmetric:
        high = max(abs(low), abs(high))
        low = -high
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _interface_positions(run: Run) -> Iterator[tuple[Array, Array]]:
    """Position and time of each interface over the saved frames."""
    if "x_interface" in run.series and len(run.series["t"]):
        inside = run.series["t"] <= run.time[-1]
        thin = _thin(inside.sum())
        for x in run.series["x_interface"][inside].T:
            yield x[thin], run.series["t"][inside][thin]


# ---------------------------------------------------------------------- interfaces


def _draw_interfaces(figure: Figure, run: Run) -> None:
    lengths = list(_lengths(run))
    figure.set_size_inches(7.2 if lengths else 4.8, 3.1)
    grid = figure.subplots(1, 1 + bool(lengths), squeeze=False)[0]
    _plot_per_interface(grid[0], run, run.series["x_interface"])
    grid[0].set_ylabel(_label(run, "position of the interface x", "m"))
    grid[0].legend()
    for axes in grid[1:]:
        for k, (name, t, length) in enumerate(lengths):
            axes.plot(t, length, color=COLORS["solid"], linestyle=LINES[k % len(LINES)], label=name)
        axes.set_ylabel(_label(run, "length of the solid", "m"))
        if len(lengths) > 1:
            axes.legend()
    for axes in grid:
        _time_axis(axes, run)


def _lengths(run: Run) -> Iterator[tuple[str, Array, Array]]:
    """Name, times and length of each solid layer: per step between two interfaces, per frame otherwise."""
    x = run.series["x_interface"]
    joints_known = x.ndim == 2 and x.shape[1] == len(run.layers) - 1
    thin = _thin(len(x))
    for i, layer in enumerate(run.layers):
        if layer.kind != "solid":
            continue
        if joints_known and 0 < i < len(run.layers) - 1:
            yield layer.name, run.series["t"][thin], (x[:, i] - x[:, i - 1])[thin]
        elif run.nframes > 1:
            yield layer.name, run.time, layer.x[:, -1] - layer.x[:, 0]


_TRACES = {
    "u_interface": ("velocity u", "m/s"),
    "sigma_interface": ("stress σ", "Pa"),
    "T_interface": ("temperature T", "K"),
}


def _draw_traces(figure: Figure, run: Run) -> None:
    names = [name for name in _TRACES if name in run.series]
    figure.set_size_inches(6.4, 0.5 + 1.9 * len(names))
    grid = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(grid, names):
        factor, label = _scaled(run, *_TRACES[name], run.series[name])
        _plot_per_interface(axes, run, factor * run.series[name])
        axes.set_ylabel(label)
    grid[0].set_title("at the interfaces", loc="left")
    grid[0].legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=4, borderaxespad=0.1)
    _time_axis(grid[-1], run)
    figure.align_ylabels(grid)


def _plot_per_interface(axes: Axes, run: Run, values: Array) -> None:
    thin = _thin(len(values))
    for k, column in enumerate(values.reshape(len(values), -1).T):
        name = run.interfaces[k] if k < len(run.interfaces) else f"interface {k + 1}"
        color = INTERFACES[k % len(INTERFACES)]
        axes.plot(run.series["t"][thin], column[thin], color=color, linestyle=LINES[k % len(LINES)], label=name)


# ---------------------------------------------------------------------- time steps and invariants


def _draw_steps(figure: Figure, run: Run) -> None:
    changes = list(_relative_changes(run))
    figure.set_size_inches(7.2 if changes else 4.8, 3.1)
    grid = figure.subplots(1, 1 + bool(changes), squeeze=False, sharex=True)[0]
    t, thin = run.series["t"], _thin(len(run.series["t"]))
    if "dt" in run.series:
        factor, label = _scaled(run, "time step", "s", run.series["dt"])
        grid[0].plot(t[thin], factor * run.series["dt"][thin], color="#333333", linewidth=1.0)
        grid[0].set_ylabel(label)
    for axes in grid[1:]:
        for name, values in changes:
            size = np.abs(values[thin])
            axes.semilogy(t[thin], np.where(size > 0, size, np.nan), linewidth=1.0, label=name)
        axes.set_ylabel("relative change since the start")
        axes.legend()
    for axes in grid:
        _time_axis(axes, run)


def _relative_changes(run: Run) -> Iterator[tuple[str, Array]]:
    fluids = [layer.name for layer in run.layers if layer.kind == "fluid"]
    if "mass" in run.series:
        masses = run.series["mass"].reshape(len(run.series["mass"]), -1)
        for name, mass, first in zip(fluids, masses.T, run.summary.get("initial_mass") or masses[0]):
            yield f"mass, {name}", mass / first - 1
    if "energy" in run.series:
        energy = run.series["energy"]
        yield "total energy", energy / (run.summary.get("initial_energy") or energy[0]) - 1


# ---------------------------------------------------------------------- small things

_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))


def _scaled(run: Run, label: str, unit: str, *arrays: Array) -> tuple[float, str]:
    """Factor for the values of a picture, and the label with the unit they then have; none if dimensionless."""
    if run.header.get("units", "SI") != "SI":
        return 1.0, label
    largest = max((float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0)) for values in arrays), default=0.0)
    size, prefix = 1.0, ""
    if unit in ("Pa", "s") and largest > 0 and not 0.1 <= largest < 1e3:
        size, prefix = next((entry for entry in _PREFIXES if largest >= entry[0]), _PREFIXES[-1])
    return 1.0 / size, f"{label}  [{prefix}{unit}]"


def _label(run: Run, label: str, unit: str) -> str:
    return _scaled(run, label, unit)[1]


def _time_axis(axes: Axes, run: Run) -> None:
    """The horizontal axis, from the start of the run: the series begin after the first step."""
    t = run.series["t"]
    axes.set_xlim(run.time[0] if run.nframes else t[0], t[-1])
    axes.set_xlabel(_label(run, "t", "s"))


def _time_text(run: Run, t: float) -> str:
    return f"t = {t:.4g} s" if run.header.get("units", "SI") == "SI" else f"t = {t:.4g}"


def _thin(n: int) -> slice:
    return slice(None, None, max(1, n // MAX_POINTS))
