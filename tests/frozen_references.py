"""Results of the program before the block engine, in tests/frozen.

It had another volume flux, g(i, l) the mean of a.v, which differs by the scheme's error where grids
move; the pressure as a flux at slip walls, where there is a constraint now; and errors of
Runge-Kutta at interfaces. Two grids of the same problem say how large the scheme's error is.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent / "frozen"


@dataclass(frozen=True)
class Reference:
    """One result. fields: {layer: {field: array}} at the end, (ny, nx), with X and Y; facts: errors,
    interfaces, steps, initial sums.
    """

    command: str
    fields: dict
    facts: dict


def frozen(name):
    """The reference of this name."""
    with np.load(FOLDER / f"{name}.npz") as file:
        found = {key: file[key] for key in file.files}
    command, facts, fields = str(found.pop("command")), json.loads(str(found.pop("facts", "{}"))), {}
    for key, value in found.items():
        layer, _, field = key.rpartition("/")
        if layer not in ("", "series"):
            fields.setdefault(layer, {})[field] = value
    return Reference(command, fields, facts)


def scheme_error(coarse, fine):
    """{layer: {field: largest difference}} of two references at the points that both have: what the
    scheme's own error is about.
    """
    found = {}
    for layer, fields in frozen(coarse).fields.items():
        others, axes = frozen(fine).fields[layer], [a for a in ("Y", "X") if a in fields]
        common = [np.intersect1d(fields[a].round(9), others[a].round(9)) for a in axes]
        here = np.ix_(*(np.isin(fields[a].round(9), c) for a, c in zip(axes, common)))
        there = np.ix_(*(np.isin(others[a].round(9), c) for a, c in zip(axes, common)))
        found[layer] = {
            name: np.abs(values[here] - others[name][there]).max()
            for name, values in fields.items()
            if name not in ("X", "Y")
        }
    return found
