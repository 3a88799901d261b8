"""Grids of a case that are compared with each other, where no exact solution is known.

Fields are compared at the end, at the nodes that all grids have in common, series at SAMPLES equal
distances of time. A difference is the norm in force (L1 or L2) of the mean over these, over the
largest range on the finest grid of all fields of its unit in layers of its kind.
"""

from collections.abc import Iterator, Sequence
from functools import reduce

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.output.differences import common_nodes, summed
from fsipetsc.output.quantities import unit_of
from fsipetsc.output.reader import Run

#: times at which series are compared
SAMPLES = 10
#: series that are of the steps or of the method, not of the solution
NO_SOLUTION = "t", "dt", "least_J", "J_error", "lost_energy"


def differences(runs: Sequence[Run], norm: str) -> Iterator[dict[str, dict[str, float]]]:
    """Of each run but the last, from coarse to fine: group -> name -> relative difference from the
    next one; and "combined", their mean. InputError where there is no node in common.
    """
    values, power = _common_values(runs), {"L1": 1, "L2": 2}[norm]
    kinds = {layer.name: layer.kind for layer in runs[0].layers}

    # of which kind of layer and unit; what has no known unit has one of its own
    sort = {key: (kinds.get(key[0], key[0]), unit_of(key[1]) or key[1]) for key in values}
    ranges: dict[tuple[str, str], float] = {}
    for key, found in values.items():
        ranges[sort[key]] = max(ranges.get(sort[key], 0.0), _range(found[-1]))
    for j in range(len(runs) - 1):
        errors: dict[str, dict[str, float]] = {}
        for (group, name), found in values.items():
            gap = np.abs(found[j + 1] - found[j]) / (ranges[sort[group, name]] or 1.0)
            gap = gap[np.isfinite(gap)]
            mean = float(np.mean(gap**power) ** (1 / power)) if gap.size else np.nan
            errors.setdefault(group, {})[name] = mean
        for own in errors.values():
            every = np.array(list(own.values()))
            own["combined"] = float(np.nanmean(every**power) ** (1 / power))
        yield errors


def _common_values(runs: Sequence[Run]) -> dict[tuple[str, str], list[np.ndarray]]:
    """(group, name) -> values of each run at what all have in common. InputError."""
    found: dict[tuple[str, str], list[np.ndarray]] = {}
    for k, layer in enumerate(runs[0].layers):
        layers = [run.layers[k] for run in runs]
        pairs = [common_nodes(layer, other, []) for other in layers]
        if any(pair is None for pair in pairs):
            raise InputError(
                f"layer '{layer.name}': no node of the coarsest grid is on all others; "
                "-fsi_hs takes grids with common nodes, as in -fsi_hs 0.1,0.05,0.025"
            )
        known = [pair for pair in pairs if pair is not None]
        every = reduce(np.intersect1d, [first for first, _ in known])
        nodes = [second[np.searchsorted(first, every)] for first, second in known]
        for name in layer.fields:
            ends = [other.frame(-1)[name].ravel() for other in layers]
            found[layer.name, name] = [end[of] for end, of in zip(ends, nodes)]
    times = runs[0].time[1:]
    for name in runs[0].series:
        if name not in NO_SOLUTION and not name.startswith("residual_"):
            values = [summed(r, name)[np.isin(r.series["t"], times)] for r in runs]
            if len({v.shape for v in values}) == 1 and values[0].size:
                found["series", name] = values
    return found


def _range(values: np.ndarray) -> float:
    """The largest less the smallest value; the largest size where that is round-off."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0
    largest, span = float(np.abs(known).max()), float(np.ptp(known))
    return span if span > 1e-9 * largest else largest
