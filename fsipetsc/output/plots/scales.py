"""Units and ranges: prefixes, powers of ten, and small waves as the difference from rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fsipetsc.output.reader import Run

Array = np.ndarray

#: a quantity that varies by less than this part of itself is drawn as the difference from rest; by less than this, not at all
SMALL, NOTHING = 0.02, 1e-12
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_TAKE_PREFIX = {"Pa": True, "s": True, "m": False, "m/s": False, "K": False}  # unit -> also k, M, G
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Scale:
    """How values are drawn: factor (value − rest); label names unit and rest. constant: the value, if it is one."""

    label: str
    factor: float = 1.0
    rest: float = 0.0
    constant: float | None = None

    def __call__(self, values: Array) -> Array:
        return self.factor * (values - self.rest)

    def limit(self, axes: Axes) -> None:
        """Keep round-off about a constant from filling the axis."""
        if self.constant is not None:
            drawn = self.factor * (self.constant - self.rest)
            margin = 0.1 * abs(drawn) or 1.0
            axes.set_ylim(drawn - margin, drawn + margin)


def scaled(run: Run, label: str, unit: str, *arrays: Array, start: Array | None = None) -> Scale:
    """The scale for a picture of all these values; unit: SI. start: those at the start; small changes are drawn without it."""
    rest = 0.0
    low, high = extremes(*arrays)
    largest, constant = max(abs(low), abs(high)), None
    if high - low <= NOTHING * largest:
        constant = low
    elif start is not None and high - low < SMALL * largest:
        rest = value_at_rest(high - low, start)
        label += f", less {rest:.12g}{unit_of(run, unit)}"
        largest = max(abs(low - rest), abs(high - rest))
    size, shown = _unit(unit if is_si(run) else "", largest)
    return Scale(f"{label}  [{shown}]" if shown else label, 1.0 / size, rest, constant)


def value_at_rest(span: float, *start: Array) -> float:
    """The median of the values at the start, rounded to a tenth or less of the span that is going to be shown."""
    known = np.concatenate([np.ravel(values[np.isfinite(values)]) for values in start])
    if not known.size:
        return 0.0
    middle = float(np.median(known))
    return round(middle, 1 - int(np.floor(np.log10(span)))) if span > 0 else middle


def extremes(*arrays: Array) -> tuple[float, float]:
    """Smallest and largest of all finite values; 0, 0 if there are none."""
    finite = np.concatenate([np.ravel(values[np.isfinite(values)]) for values in arrays]) if arrays else np.empty(0)
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)


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


def unit_of(run: Run, unit: str) -> str:
    """The unit behind a number, with its blank; nothing if the case is dimensionless."""
    return f" {unit}" if is_si(run) else ""


def axis_label(run: Run, label: str, unit: str) -> str:
    """The label of an axis without prefix."""
    return f"{label}  [{unit}]" if is_si(run) else label


def time_axis(axes: Axes, run: Run) -> None:
    """The horizontal axis, from the start of the run: the series begin after the first step."""
    t = run.series["t"]
    axes.set_xlim(run.time[0] if run.nframes else t[0], t[-1])
    axes.set_xlabel(axis_label(run, "t", "s"))


def logarithmic(axes: Axes, most: int = 8) -> None:
    """A logarithmic vertical axis of whole decades, of so many at most; lines without positive values leave it empty."""
    heights = [np.asarray(line.get_ydata(), float) for line in axes.lines]
    positive = np.concatenate([values[values > 0] for values in heights]) if heights else np.empty(0)
    if not positive.size:
        axes.set_yticks([])
        axes.text(0.5, 0.5, "exactly 0", transform=axes.transAxes, ha="center", va="center")
        return
    low, high = np.floor(np.log10(positive.min())), np.ceil(np.log10(positive.max()))
    high = max(high, low + 1)
    axes.set_yscale("log")
    axes.set_ylim(10.0 ** max(low, high - most), 10.0**high)
    axes.yaxis.set_minor_formatter(lambda value, place: "")  # of one decade they would be written, too


def named(fields: Sequence[str], known: Sequence[str]) -> None:
    """InputError for a name of a field that there is not."""
    for name in fields:
        if name not in known:
            raise InputError(f"-fields {name}: expected some of {', '.join(known)}")
