"""What differs between two results: the largest difference of each field and series."""

import math
import os
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from fsipetsc.checks import Array
from fsipetsc.output.quantities import unit_of
from fsipetsc.output.reader import Layer, Run, open_run
from fsipetsc.scheme.observables import GAIN, SERIES


class Difference(NamedTuple):
    """How far one field or series of two results is apart.

    Attributes:
        name: "layer: field", or the name of the series.
        largest: largest absolute difference, in the unit of the field; inf where one of the two is
            no number; 0.0: the same bits, but for the sign of 0.
        scale: largest absolute value of the two results, in the common part; `compare` takes the
            largest of all fields and series with this unit, but for times.
        place: where `largest` is, in words.
    """

    name: str
    largest: float
    scale: float
    place: str

    @property
    def relative(self) -> float:
        """`largest` over the scale."""
        return self.largest / self.scale if self.scale else self.largest

    @property
    def ulp(self) -> float:
        """`largest` in units in the last place of the scale."""
        return self.largest / float(np.spacing(self.scale))


class Comparison(NamedTuple):
    """What differs between two results.

    Attributes:
        differences: of each field and series that both have.
        notes: what cannot be compared.
        options: name -> the two values, of the options that differ.
    """

    differences: tuple[Difference, ...]
    notes: tuple[str, ...]
    options: dict[str, tuple[object, object]]

    @property
    def equal(self) -> bool:
        """Whether every number that one of the two has is in both, with the same bits."""
        return not self.notes and all(found.largest == 0.0 for found in self.differences)


def compare(
    first: Run | str | os.PathLike[str], second: Run | str | os.PathLike[str]
) -> Comparison:
    """Compare all fields in the frames, and all series in the steps, that two results have at equal
    times. FileError if one of them cannot be read.

    Args:
        first: a result, or its path.
        second: the other one.
    """
    a, b = (of if isinstance(of, Run) else open_run(of) for of in (first, second))
    notes = list[str]()
    found = [*_of_layers(a, b, notes), *_of_series(a, b, notes)]
    names = sorted({*a.options, *b.options} - {"fsi_output"})
    pairs = {name: (a.options.get(name), b.options.get(name)) for name in names}
    changed = {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}
    return Comparison(tuple(_on_one_scale(found)), tuple(notes), changed)


def diff(first: str, second: str) -> str:
    """Return what the command prints. FileError."""
    comparison = compare(first, second)
    different = [found for found in comparison.differences if found.largest > 0.0]
    lines = [f"{'':30}{'largest':>12}{'relative':>12}{'ulp':>12}"] if different else []
    for found in different:
        numbers = f"{found.largest:12.3e}{found.relative:12.2e}{found.ulp:12.3g}"
        lines.append(f"{found.name:30}{numbers}   {found.place}")
    count = len(comparison.differences)
    equal = f"{count - len(different)} of {count} fields and series are equal, bit for bit"
    lines.append(equal if count else "no field and no series could be compared")
    lines += [f"note: {note}" for note in comparison.notes]
    for name, pair in comparison.options.items():
        one, two = ("none" if value is None else value for value in pair)
        lines.append(f"option -{name}: {one} and {two}")
    return "\n".join(lines)


def _on_one_scale(found: list[Difference]) -> Iterator[Difference]:
    """Return the differences with one scale for all that has one unit: fields of pure round-off get
    that of other fields, velocities at least sqrt(p/rho). Times and what has no unit keep theirs.
    """
    scales, units = dict[str, float](), [unit_of(one.name.rpartition(": ")[2]) for one in found]
    units = [one.name if unit in ("", "s") else unit for one, unit in zip(found, units)]
    for unit, one in zip(units, found):
        scales[unit] = max(scales.get(unit, 0.0), one.scale)
    if density := scales.get("kg m-3"):
        scales["m s-1"] = max(scales["m s-1"], math.sqrt(scales["Pa"] / density))
    return (one._replace(scale=scales[unit]) for unit, one in zip(units, found))


def _difference(name: str, a: Array, b: Array, times: Array, places: Array | None) -> Difference:
    """Compare arrays (times, nodes or columns); two NaNs are equal. places: of the nodes."""
    gap = np.where((a == b) | (np.isnan(a) & np.isnan(b)), 0.0, np.abs(a - b))
    gap = np.where(np.isnan(gap), np.inf, gap)
    scale = max(float(np.abs(v[np.isfinite(v)]).max(initial=0.0)) for v in (a, b))
    step, k = np.unravel_index(np.argmax(gap), gap.shape)
    at = f", column {k}" * (a.shape[1] > 1)
    if places is not None:
        at = f", X = {', '.join(f'{x:.6g}' for x in places[k])}"
    return Difference(name, float(gap[step, k]), scale, f"t = {times[step]:.6g}{at}")


def _common(a: Array, b: Array, what: str, notes: list[str]) -> tuple[Array, Array, Array]:
    """Return the times that are in both, and their numbers in either."""
    times, in_a, in_b = np.intersect1d(a, b, return_indices=True)
    if not len(times) == len(a) == len(b):
        notes.append(f"{len(a)} and {len(b)} {what}, {len(times)} of them at the same times")
    return times, in_a, in_b


def _both(a: Iterable[str], b: Iterable[str], what: str, notes: list[str]) -> list[str]:
    """Return the names that are in both; the others are noted."""
    if alone := sorted({*a} ^ {*b}):
        notes.append(f"{what} in one of them only: {', '.join(alone)}")
    return [name for name in a if name not in alone]


def _of_layers(a: Run, b: Run, notes: list[str]) -> Iterator[Difference]:
    times, in_a, in_b = _common(a.time, b.time, "frames", notes)
    for name in _both(a.blocks, b.blocks, "layer", notes) if len(times) else ():
        layer, other = a.blocks[name], b.blocks[name]
        here, there = common_nodes(layer, other, notes)
        places = layer.places.reshape(-1, len(layer.shape))[here]
        fields = _both(layer.fields, other.fields, f"{name}: field", notes)
        for field in fields if len(here) else ():
            one = layer[field][in_a].reshape(len(times), -1)[:, here]
            two = other[field][in_b].reshape(len(times), -1)[:, there]
            if layer.shape != other.shape:  # active parts of two grids end at other nodes
                one, two = np.where(np.isnan(one) | np.isnan(two), np.nan, (one, two))
            yield _difference(f"{name}: {field}", one, two, times, places)


def _of_series(a: Run, b: Run, notes: list[str]) -> Iterator[Difference]:
    names = _both(a.series, b.series, "series", notes)
    t, other_t = (run.series.get("t", np.empty(0)) for run in (a, b))
    times, in_a, in_b = _common(t, other_t, "steps", notes)
    for name in names if len(times) else ():
        one, two = (of.reshape(len(of), -1) for of in (a.series[name], b.series[name]))
        if one.shape[1] != two.shape[1]:
            notes.append(f"series {name} has {one.shape[1]} and {two.shape[1]} columns")
        elif len(times) == len(t) == len(other_t) or SERIES[name].kind != GAIN:
            yield _difference(name, one[in_a], two[in_b], times, None)


def common_nodes(a: Layer, b: Layer, notes: list[str]) -> tuple[Array, Array]:
    """Return numbers of the nodes of either layer that are at the same places; note other grids."""
    one, two = (layer.places.reshape(-1, len(layer.shape)) for layer in (a, b))
    within = 1e-9 * np.ptp(one, axis=0).max() if one.size else 1.0
    if a.shape == b.shape and np.allclose(one, two, rtol=0.0, atol=within):
        return np.arange(len(one)), np.arange(len(two))
    from scipy.spatial import KDTree

    apart, nearest = KDTree(two).query(one, distance_upper_bound=within)
    here = np.flatnonzero(np.isfinite(apart))
    count = f"{len(here)} common nodes are compared"
    notes.append(f"layer {a.name!r} has {a.size} and {b.size}: {count}")
    return here, nearest[here]
