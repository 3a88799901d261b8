"""Convergence of a case without an exact solution: its grids, compared with each other.

Fields are compared at the end, at the nodes that all grids have in common, series at SAMPLES equal
distances of time. A difference is the norm in force (L1 or L2) of the mean over these, over the
largest range on the finest grid of all fields of its unit in layers of its kind.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from fsipetsc.analysis.convergence_table import ConvergenceStudy
from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import operator
from fsipetsc.output.as_xarray import FIELDS, INTEGRALS
from fsipetsc.output.differences import common_nodes
from fsipetsc.output.reader import Run

#: times at which series are compared
SAMPLES = 10
#: series that are of the steps or of the method, not of the solution
NO_SOLUTION = "t", "dt", "least_J", "J_error", "lost_energy", "energy_face", "heat_face"
#: a relative difference of the two finest grids that is too much, and one that is little enough
#: whatever the order; the part of the order that is too little
COARSE, FINE, SLOW = 0.1, 1e-3, 0.5


def differences(runs: Sequence[Run], norm: str) -> Iterator[dict[str, dict[str, float]]]:
    """Of each run but the last, from coarse to fine: group -> name -> relative difference from the
    next one; and "combined", their mean. InputError where there is no node in common.
    """
    values, power = _common_values(runs), {"L1": 1, "L2": 2}[norm]
    kinds = {layer.name: layer.kind for layer in runs[0].layers}

    def sort(group: str, name: str) -> tuple[str, str]:
        """Kind of layer and unit; what the tables do not name has a unit of its own."""
        return kinds.get(group, group), {**FIELDS, **INTEGRALS}.get(name, (name, ""))[0]

    ranges: dict[tuple[str, str], float] = {}
    for group, names in values.items():
        for name, found in names.items():
            of = sort(group, name)
            ranges[of] = max(ranges.get(of, 0.0), _range(found[-1]))
    for j in range(len(runs) - 1):
        errors: dict[str, dict[str, float]] = {}
        for group, names in values.items():
            own = errors[group] = {}
            for name, found in names.items():
                gap = np.abs(found[j + 1] - found[j]) / (ranges[sort(group, name)] or 1.0)
                gap = gap[np.isfinite(gap)]
                own[name] = float(np.mean(gap**power) ** (1 / power)) if gap.size else np.nan
            every = np.array(list(own.values()))
            own["combined"] = float(np.nanmean(every**power) ** (1 / power))
        yield errors


def _common_values(runs: Sequence[Run]) -> dict[str, dict[str, list[np.ndarray]]]:
    """Group -> name -> values of each run at what all have in common. InputError."""
    found: dict[str, dict[str, list[np.ndarray]]] = {}
    for k, layer in enumerate(runs[0].layers):
        layers = [run.layers[k] for run in runs]
        pairs = [common_nodes(layer, other, []) for other in layers]
        if any(pair is None for pair in pairs):
            raise InputError(
                f"layer '{layer.name}': no node of the coarsest grid is on all others; "
                "-fsi_hs takes grids with common nodes, as in -fsi_hs 0.1,0.05,0.025"
            )
        axes = [_in_all(axis) for axis in zip(*(zip(*pair) for pair in pairs if pair is not None))]
        own = found[layer.name] = {}
        for name in layer.fields:
            ends = [other.frame(-1)[name] for other in layers]
            own[name] = [end[np.ix_(*(axis[j] for axis in axes))] for j, end in enumerate(ends)]
    times = runs[0].time[1:]
    for name in runs[0].series:
        if name not in NO_SOLUTION and not name.startswith("residual_"):
            values = [run.series[name][np.isin(run.series["t"], times)] for run in runs]
            if len({v.shape for v in values}) == 1 and values[0].size:
                found.setdefault("series", {})[name] = values
    return found


def _in_all(pairs: Any) -> list[np.ndarray]:
    """Of one axis: numbers of the nodes that all grids have; pairs: (of the coarsest, of each)."""
    common = pairs[0][0]
    for first, _ in pairs:
        common = np.intersect1d(common, first)
    return [second[np.searchsorted(first, common)] for first, second in pairs]


def _range(values: np.ndarray) -> float:
    """The largest less the smallest value; the largest size where that is round-off."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0
    largest, span = float(np.abs(known).max()), float(np.ptp(known))
    return span if span > 1e-9 * largest else largest


def unresolved(table: ConvergenceStudy, i: int) -> list[str]:
    """A line for each layer whose grids differ by much, or come together slowly."""
    lines, op = [], operator(table.orders[i])
    expected = table.orders[i] // 2 + 1  # closures have half the order
    for group in sorted(table.errors.keys() - {"series"}):
        errors, rate = table.errors[group], table.rates(group)[i, -2]
        fields = {name: np.nan_to_num(e[i, -2]) for name, e in errors.items() if name != "combined"}
        worst, last = max(fields, key=lambda name: fields[name]), errors["combined"][i, -2]
        if last > COARSE:
            part = f"{100 * fields[worst]:.0f} %"
            why = f"in {worst} the two finest grids differ by {part} of its range"
        elif last > FINE and not rate >= SLOW * expected:
            seen = f"of order {rate:.1f}" if np.isfinite(rate) else "of no order"
            why = f"its grids come together {seen}, {worst} last, where {op.name} has {expected}"
        else:
            continue
        lines.append(f"layer '{group}' is not resolved: {why}")
    return lines
