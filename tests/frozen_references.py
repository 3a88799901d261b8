"""Results of the program before the block engine (tests/frozen, made by scripts/freeze), and how
near new ones must be.

The older code has one scheme in one dimension and one in two. The block engine differs from it in

volume flux g(i, l) = (a_i.v_l + a_l.v_i)/2, where the older code has the mean of a.v. The same in
one dimension and on grids at rest; on grids that move in two dimensions both differ by the scheme's
error. slip walls a constraint, N.u = 0, where the older code has the pressure as a flux and N.u
free: as much. interfaces one velocity by a force in each stage, where the older code shares
momentum after each stage; energy per mass is an unknown of solids, where the older code has the
temperature: errors of Runge-Kutta.

``TOLERANCES`` says for each reference what must agree and how well: relative to the largest value
of a field.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent / "frozen"

#: states of gas | solid whose rates are in rates.npz: mu, kappa, m0, heat, law, (convection,
#: dissipation), lower edge
RATES = {
    "slip": (0.0, 0.0, 1.0, "elastic", "log", ("entropy", 0.0), "NoSlip"),
    "slip-heat": (0.0, 0.03, 3.0, "coupled", "neo-hookean", ("entropy", 0.0), "Slip"),
    "stick": (0.02, 0.03, 0.01, "coupled", "svk", ("entropy", 0.0), "NoSlip"),
    "divergence": (0.02, 0.03, 50.0, "elastic", "log", ("divergence", 0.0), "NoSlip"),
    "dissipation": (0.0, 0.0, 1.0, "coupled", "log", ("entropy", 0.3), "NoSlip"),
    "open": (0.0, 0.0, 2.0, "coupled", "log", ("entropy", 0.0), "Open"),
}


@dataclass(frozen=True)
class Reference:
    """One result. fields: {layer: {field: array}} at the end, (n,) or (ny, nx), with X and Y;
    series: some of the steps; facts: errors, interfaces, steps, initial sums; arrays: all else.
    """

    command: str
    fields: dict
    series: dict
    facts: dict
    arrays: dict


def names():
    """Of all references."""
    return sorted(path.stem for path in FOLDER.glob("*.npz"))


def frozen(name):
    """The reference of this name."""
    with np.load(FOLDER / f"{name}.npz") as file:
        found = {key: file[key] for key in file.files}
    command, facts = str(found.pop("command")), json.loads(str(found.pop("facts", "{}")))
    fields, series, arrays = {}, {}, {}
    for key, value in found.items():
        first, _, last = key.rpartition("/")
        if name == "rates" or not first:
            arrays[key] = value
        elif first == "series":
            series[last] = value
        else:
            fields.setdefault(first, {})[last] = value
    return Reference(command, fields, series, facts, arrays)


def tolerance(name):
    """(what, how near, why) of a reference."""
    return next(rule[1:] for rule in TOLERANCES if fnmatch(name, rule[0]))


def scheme_error(coarse, fine):
    """{layer: {field: largest difference}} of two references at the points that both have: what the
    older scheme's own error is about.
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


STEPS = "with the same -ts_dt, the classical method and -fsi_convection entropy"
TWICE = "the references of two grids say what the scheme's error is (scheme_error)"
#: (names, what, how near, why), measured with the oracle where a number is called measured
TOLERANCES = (
    (
        *("rates", "all rates, of their largest, with the older volume flux", 1e-12),
        "measured 1e-14: the same formulas; new rates are to be held against the oracle",
    ),
    (
        *("column-entropy-*", "x 1e-10, T and p 1e-8, u 1e-6 of its largest", 1e-6),
        f"{STEPS}: measured 2e-12, 5e-11, 1e-7; interfaces by a force, e as an unknown",
    ),
    (
        *("box-entropy-*", "x 1e-10, T and p 1e-8, u 1e-6 of its largest", 1e-6),
        f"{STEPS}: measured 2e-12, 1e-10, 2e-8; the stress given at first is a prestress",
    ),
    (
        *("heat-entropy-*", "errors of both, to this part", 1e-2),
        f"{STEPS}: linear and nearly at rest; temperatures at ends are held",
    ),
    (
        *("piston-entropy-4", "x 1e-8, fields 1e-5 of their largest", 1e-5),
        f"{STEPS}: the wall's motion is given",
    ),
    (
        *("column-*", "x 1e-6, fields 3e-3 (2/1) or 5e-4 of their largest", 3e-3),
        "divergence form: the older one differentiates u and T, not entropy variables, and g U is"
        " not split: measured 1.5e-7, 1.3e-3 (2/1), 2e-4",
    ),
    (*("box-*", "x 1e-7, fields 1e-3 of their largest", 1e-3), "as column-*: measured 3e-10, 3e-5"),
    (
        *("heat-*", "errors of both, no larger than these, times", 1.5),
        "divergence form, as column-*",
    ),
    ("piston-*", "x 1e-5, fields 1e-2 of their largest", 1e-2, "as column-*"),
    (
        *("shock-*", "errors of both, no larger than these, times", 1.3),
        "sensor and dissipation of one dimension differ from those of two, which are the new ones",
    ),
    (
        *("plane_mms-*", "combined errors of gas and solid, to this part", 0.02),
        "the volume flux: measured 7e-4, 3e-3, 1.6e-3, 6e-4 at n = 16; with the older one 8 digits",
    ),
    (
        *("wave-viscous-*", "all fields, of their largest", 1e-11),
        "no slip walls, and a motion so small that the volume flux does not count: measured 2e-15"
        " of 1 after 200 steps, J 1e-13",
    ),
    (
        *("wave-slip-*", "s to 1e-5; solid 1e-4, gas 1e-2 of the largest disturbance", 1e-2),
        "the slip wall above: measured 1e-5 and 5e-3",
    ),
    (
        *("blast-*", "times scheme_error('blast-4-16', 'blast-4-32')", 1.5),
        f"slip walls at the sides; {TWICE}. Measured: plate 2e-6, gas 8e-3 of rho at the sides,"
        " where the new scheme has a fourth of the error of the older one (2.2e-3, 9.9e-3)",
    ),
    ("tube-*", "errors, no larger than these, times", 1.1, "slip walls; shocks as before"),
    (
        *("panel-*", "times scheme_error('panel-16', 'panel-32')", 2.0),
        f"three blocks of gas, joined, where the older one ended the panel in the wall; {TWICE}",
    ),
    (
        *("oblique-*", "times scheme_error('oblique-16', 'oblique-32')", 2.0),
        f"slip walls, dissipation; {TWICE}",
    ),
)
