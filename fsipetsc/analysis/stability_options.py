"""The options of `python -m fsipetsc stability`. Cheap to import."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fsipetsc.analysis.tables import listed_in
from fsipetsc.errors import InputError
from fsipetsc.options import above_one
from fsipetsc.options.option import Option

ORDERS = (2, 4, 6, 8)


def _positive(name: str, kind: Any, default: Any, unit: str, words: str) -> Option:
    return Option(name, kind, default, unit, words, check="positive")


def _nonnegative(name: str, kind: Any, default: Any, unit: str, words: str) -> Option:
    return Option(name, kind, default, unit, words, check="nonnegative")


_DENSITIES = "m0 over the density of the gas, instead of -solid_density; alpha m0 keeps its value"
_STIFFNESSES = "K over the pressure of the gas, instead of -solid_modulus"
_POINTS = "points of each of the two layers"
_COUPLINGS = ("conservative", "energy", "projection", "traditional")
_EOS = "pressure p = G rho epsilon that balances the gas, or none: sigma = -p of the gas"
_POWERS = tuple(10.0**k for k in range(-3, 4))
SECTIONS: dict[str, tuple[Option, ...]] = {
    "Gas": (
        _positive("fluid_rho", float, 1.0, "kg/m3", "density of the gas at rest"),
        _positive("fluid_T", float, 1.0, "K", "temperature, of the solid too"),
        Option("fluid_gamma", float, 1.4, "", "ratio of the specific heats", check=above_one),
        _positive("fluid_R", float, 1.0, "J/(kg K)", "gas constant over molar mass"),
        _nonnegative("fluid_mu", float, 0.01, "Pa s", "viscosity"),
        _nonnegative("fluid_kappa", float, 0.03, "W/(m K)", "heat conductivity of the gas"),
    ),
    "Solid": (
        _positive("solid_density", float, 1.0, "kg/m3", "density m0 in the reference state"),
        _positive("solid_modulus", float, 1.0, "Pa", "K = 2 mu_e + lambda_e"),
        _positive("solid_alpha", float, 2.5, "J/(kg K)", "specific heat"),
        _nonnegative("solid_kappa", float, 0.02, "W/(m K)", "heat conductivity of the solid"),
        Option("solid_eos", str, "ideal", "", _EOS, ("ideal", "elastic")),
    ),
    "Discretisation": (
        Option("fsi_coupling", str, "energy", "", "treatment of the interface", _COUPLINGS),
        Option("fsi_viscous", str, "wide", "", "D twice, or narrow ones", ("wide", "narrow")),
        Option("fsi_order", int, None, "", "one order alone, instead of -fsi_orders", ORDERS),
        _positive("fsi_h", float, 0.03125, "m", "grid spacing"),
    ),
    "Grids": (
        _positive("stability_points", int, 32, "", _POINTS),
        Option("fsi_orders", "ints", ORDERS, "", "interior orders", check=listed_in(ORDERS)),
    ),
    "Sweep": (
        Option("sweep", bool, False, "", "all combinations of the ratios below"),
        _positive("density_ratios", "floats", _POWERS, "", _DENSITIES),
        _positive("stiffness_ratios", "floats", _POWERS[1:-1], "", _STIFFNESSES),
    ),
    "Output": (
        Option("fsi_output", str, None, "", "table of a sweep, without suffix"),
        Option("fsi_quiet", bool, False, "", "print nothing but errors"),
        Option("fsi_debug", bool, False, "", "show the Python traceback of an error"),
    ),
}

def sections(arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Heading -> options for -help."""
    return SECTIONS


def orders(opt: Mapping[str, Any]) -> tuple[int, ...]:
    """The orders that are asked for. InputError if a layer has too few points for an operator."""
    from fsipetsc.operators import operator

    found = (opt["fsi_order"],) if opt["fsi_order"] else tuple(opt["fsi_orders"])
    for op in map(operator, found):
        least, points = max(4, op.min_points), opt["stability_points"]
        if points < least:
            raise InputError(f"-stability_points {points}: the {op.name} operator needs {least}")
    return found
