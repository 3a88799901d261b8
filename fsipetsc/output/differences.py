"""What differs between two results: the largest difference of each field and series, in units in the last place, too."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fsipetsc.checks import Array
from fsipetsc.output.reader import Run, open_run


@dataclass(frozen=True)
class Difference:
    """Of one field or series.

    name       "layer: field", or the name of the series
    largest    largest absolute difference; inf where one of the two is no number; 0.0: the same bits, but for the sign of 0
    ulp        largest difference in units in the last place of the larger one of the two values
    scale      largest absolute value of the first result, in the common part
    place      where `largest` is, in words
    """

    name: str
    largest: float
    ulp: float
    scale: float
    place: str


@dataclass(frozen=True)
class Comparison:
    """notes: what cannot be compared, such as another grid; options: name -> the two values, where they differ."""

    differences: tuple[Difference, ...]
    notes: tuple[str, ...]
    options: dict[str, tuple[object, object]]

    @property
    def equal(self) -> bool:
        """Every number that the two have is in both, with the same bits."""
        return not self.notes and all(found.largest == 0.0 for found in self.differences)


def compare(first: str | os.PathLike[str], second: str | os.PathLike[str]) -> Comparison:
    """All fields in the frames, and all series in the steps, that two results have at the same times.

    Raises FileError if one of them cannot be read.
    """
    with open_run(first) as a, open_run(second) as b:
        notes: list[str] = []
        frames = _common(a.time, b.time, "frames", notes)
        steps = _common(_times(a), _times(b), "steps", notes)
        found = [*_of_layers(a, b, frames, notes), *_of_series(a, b, steps, notes)]
        names = sorted({*a.options, *b.options} - {"fsi_output"})
        values = {name: (a.options.get(name), b.options.get(name)) for name in names}
        return Comparison(tuple(found), tuple(notes), {name: pair for name, pair in values.items() if pair[0] != pair[1]})


def difference(name: str, a: Array, b: Array, times: Array) -> Difference:
    """Of two arrays of one shape, whose first index is that of `times`. Two values that are no numbers are equal."""
    both = np.isnan(a) & np.isnan(b)
    gap = np.where(both | (a == b), 0.0, np.abs(a - b))
    gap = np.where(np.isnan(gap), np.inf, gap)
    unit = np.spacing(np.maximum(np.abs(np.nan_to_num(a)), np.abs(np.nan_to_num(b))))
    finite = np.abs(a[np.isfinite(a)])
    scale = float(finite.max()) if finite.size else 0.0
    if not gap.size or not gap.any():
        return Difference(name, 0.0, 0.0, scale, "")
    where = np.unravel_index(np.argmax(gap), gap.shape)
    point = f", point {', '.join(map(str, where[1:]))}" if len(where) > 1 else ""
    return Difference(name, float(gap[where]), float((gap / unit).max()), scale, f"t = {times[where[0]]:.6g}{point}")


def table(comparison: Comparison) -> str:
    """As the command `diff` prints it."""
    lines = [f"{'':30}{'largest':>12}{'relative':>12}{'ulp':>12}"]
    equal = 0
    for found in comparison.differences:
        if found.largest == 0.0:
            equal += 1
            continue
        relative = f"{found.largest / found.scale:12.2e}" if found.scale else f"{'':12}"
        lines.append(f"{found.name:30}{found.largest:12.3e}{relative}{found.ulp:12.3g}   {found.place}")
    if equal == len(comparison.differences):
        lines.clear()
    lines.append(f"{equal} of {len(comparison.differences)} fields and series are equal, bit for bit")
    lines += [f"note: {note}" for note in comparison.notes]
    for name, (a, b) in comparison.options.items():
        lines.append(f"option -{name}: {a} and {b}")
    return "\n".join(lines)


def _times(run: Run) -> Array:
    return run.series["t"] if "t" in run.series else np.empty(0)


def _common(a: Array, b: Array, what: str, notes: list[str]) -> tuple[Array, Array, Array]:
    """Times that are in both, and where they are in either."""
    times, in_a, in_b = np.intersect1d(a, b, return_indices=True)
    if not len(times) == len(a) == len(b):
        notes.append(f"{len(a)} and {len(b)} {what}, {len(times)} of them at the same times")
    return times, in_a, in_b


def _of_layers(a: Run, b: Run, common: tuple[Array, Array, Array], notes: list[str]) -> Iterator[Difference]:
    times, in_a, in_b = common
    others = {layer.name: layer for layer in b.layers}
    notes += [f"layer {name!r} is in one of them only" for name in {layer.name for layer in a.layers} ^ set(others)]
    for layer in a.layers:
        other = others.get(layer.name)
        if other is None:
            continue
        notes += [f"{layer.name}: {field} is in one of them only" for field in sorted({*layer.fields} ^ {*other.fields})]
        for field in (field for field in layer.fields if field in other.fields):
            one, two = layer[field], other[field]
            if one.shape[1:] != two.shape[1:]:
                notes.append(f"layer {layer.name!r} has {layer.size} and {other.size}")
                break
            yield difference(f"{layer.name}: {field}", one[in_a], two[in_b], times)


def _of_series(a: Run, b: Run, common: tuple[Array, Array, Array], notes: list[str]) -> Iterator[Difference]:
    times, in_a, in_b = common
    notes += [f"series {name} is in one of them only" for name in sorted({*a.series} ^ {*b.series})]
    for name in (name for name in a.series if name in b.series):
        one, two = a.series[name][in_a], b.series[name][in_b]
        if one.shape != two.shape:
            notes.append(f"series {name} has the shapes {one.shape} and {two.shape}")
            continue
        yield difference(name, one, two, times)
