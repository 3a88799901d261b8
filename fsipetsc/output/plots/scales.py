"""Units and ranges: prefixes, powers of ten, and small waves as the difference from rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fsipetsc.output.plots.style import MAPS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fsipetsc.output.reader import Run

Array = np.ndarray

#: what varies by less than this part of itself is drawn as the difference from rest
SMALL = 0.02
#: what varies by less than this part of the values of its unit is round-off
NOTHING = 1e-10
#: the largest value may be so much more than the 99.8th percentile before colours end there
ROBUST = 1.25

_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_TAKE_PREFIX = {"Pa": True, "s": True, "m": False, "m/s": False, "K": False}  # True: also k, M, G
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Scale:
    """How values are drawn: factor (value − rest).

    label names unit and rest; constant: the value, where all are equal but for round-off.
    """

    label: str
    unit: str = ""
    factor: float = 1.0
    rest: float = 0.0
    constant: float | None = None

    def __call__(self, values: Array) -> Array:
        if self.constant is not None:
            values = np.where(np.isfinite(values), self.constant, np.nan)
        return self.factor * (values - self.rest)


def scaled(
    run: Run, label: str, unit: str, *arrays: Array, start: Array | None = None, beside: float = 0.0
) -> Scale:
    """The scale for a picture of all these values.

    unit: SI. start: values at the start; small changes are drawn without these. beside: size of
    what has the same unit, beside which round-off is nothing.
    """
    rest, constant = 0.0, None
    low, high = extremes(*arrays)
    largest = max(abs(low), abs(high))
    si = is_si(run)
    if high - low <= NOTHING * max(largest, beside):
        constant = 0.0 if largest <= NOTHING * beside else 0.5 * (low + high)
        largest = abs(constant)
        label += ", constant" if constant else ", 0 but for round-off"
    elif start is not None and high - low < SMALL * largest:
        rest = value_at_rest(high - low, start)
        size, shown = _unit(unit if si else "", abs(rest))
        label += f", less {rest / size:.12g} {shown}".rstrip()
        largest = max(abs(low - rest), abs(high - rest))
    size, shown = _unit(unit if si else "", largest)
    return Scale(f"{label}  [{shown}]" if shown else label, shown, 1.0 / size, rest, constant)


def value_at_rest(span: float, start: Array) -> float:
    """The median of the values at the start, rounded to a tenth of the span that is shown."""
    known = start[np.isfinite(start)]
    middle = float(np.median(known)) if known.size else 0.0
    return round(middle, 1 - int(np.floor(np.log10(span)))) if span > 0 else middle


def extremes(*arrays: Array) -> tuple[float, float]:
    """Smallest and largest of all finite values; 0, 0 if there are none."""
    finite = [np.ravel(values[np.isfinite(values)]) for values in arrays]
    known = np.concatenate(finite) if finite else np.empty(0)
    return (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)


def colours(
    kind: str, scale: Scale, values: Array, start: Array, every: tuple[float, float]
) -> tuple[dict[str, Any], str]:
    """Arguments of pcolormesh for these values, and at which ends of its bar others lie beyond.

    White is the value at rest. Colours end at the 0.2nd and 99.8th percentile where a few points
    go far beyond these. values, start (flat) and every, the extremes of all that is drawn, are not
    scaled.
    """
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    known = scale(values[np.isfinite(values)])
    if scale.constant is not None or not known.size:
        middle = float(known[0]) if known.size else 0.0
        margin = 0.1 * abs(middle) or 1.0
        return {"cmap": MAPS[kind], "vmin": middle - margin, "vmax": middle + margin}, "neither"
    low, high = float(known.min()), float(known.max())
    rest = scale(np.float64(value_at_rest((high - low) / scale.factor, start)))
    rest = float(np.clip(rest, low, high))
    ends = np.percentile(known, (0.2, 99.8))
    down, up = (
        end if abs(most - rest) > ROBUST * abs(end - rest) > 0 else most
        for most, end in zip((low, high), ends)
    )
    part = 0.5 + 0.5 * np.linspace(down - rest, up - rest, 256) / max(up - rest, rest - down)
    look = {"cmap": ListedColormap(colormaps[MAPS[kind]](part)), "vmin": down, "vmax": up}
    below, above = scale(np.array(every)) - (down, up)
    slack = NOTHING * (up - down)
    beyond = below < -slack, above > slack
    return look, {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[beyond]


def _unit(unit: str, largest: float) -> tuple[float, str]:
    """(size in SI, name) of the unit in which the largest value is a handy number."""
    if 0.1 <= largest < 1e3 or largest == 0:
        return 1.0, unit
    if unit in _TAKE_PREFIX:
        if largest >= 1e3 and not _TAKE_PREFIX[unit]:
            return 1.0, unit
        size, prefix = next((entry for entry in _PREFIXES if largest >= entry[0]), _PREFIXES[-1])
        return size, prefix + unit
    if 1e-2 <= largest < 1e5:
        return 1.0, unit
    power = 3 * int(np.floor(np.log10(largest) / 3))
    return 10.0**power, f"10{str(power).translate(_SUPERSCRIPT)} {unit}".strip()


def is_si(run: Run) -> bool:
    """False if the case is dimensionless."""
    return run.header.get("units", "SI") == "SI"


def time_scale(run: Run) -> Scale:
    """The scale of times: ms or µs in short runs."""
    return scaled(run, "t", "s", np.append(run.time, run.series.get("t", ())[-1:]))


def moment(run: Run, frame: int) -> str:
    """When a frame is, as titles say it."""
    scale = time_scale(run)
    if not is_si(run):
        return f"t = {run.time[frame]:.4g}"
    return f"t = {scale(run.time[frame]):.4g} {scale.unit}"


def time_axis(axes: Axes, run: Run) -> None:
    """The horizontal axis from the start of the run: the series begin after the first step."""
    scale = time_scale(run)
    t = run.series["t"] if len(run.series.get("t", ())) else run.time
    axes.set_xlim(scale(run.time[0] if run.nframes else t[0]), scale(t[-1]))
    axes.set_xlabel(scale.label)


def logarithmic(axes: Axes, most: float = 1e8) -> None:
    """A logarithmic vertical axis, over a range of so much at most."""
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    axes.set_ylim(bottom=max(low, high / most))
