"""The options of `python -m fsipetsc stability`. Cheap to import."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from fsipetsc.analysis.tables import listed_in
from fsipetsc.cases import load_case
from fsipetsc.errors import InputError
from fsipetsc.options import above_one, groups
from fsipetsc.options.option import Option

ORDERS = (2, 4, 6, 8)


def _to(most: float) -> Callable[[Any], str | None]:
    """Check of a number, or of some."""

    def check(values: float | Sequence[float]) -> str | None:
        every = values if isinstance(values, Sequence) else (values,)
        return None if all(0 <= value <= most for value in every) else f"numbers from 0 to {most:g}"

    return check


_ORDERS = Option("fsi_orders", "ints", ORDERS, "", "interior orders of the SBP operators", check=listed_in(ORDERS))
_POINTS = Option(
    *("stability_points", int, 32, "", "points of each of the two layers"), check="positive"
)
_SYMBOLS = "wave numbers, as fractions of the greatest that D knows"
_WAVES = (
    Option("stability_symbols", "floats", (0.0, 0.2, 0.6, 1.0), "", _SYMBOLS, check=_to(1.0)),
    Option("stability_k", "floats", None, "1/m", "wave numbers themselves, instead of -stability_symbols", check="nonnegative"),
)
_DENSITIES = "m0 over the density of the gas, instead of -solid_density; alpha m0 keeps its value"
_STIFFNESSES = "K over the pressure of the gas, instead of -solid_modulus"
_COUPLINGS = ("conservative", "energy", "projection", "traditional")
_EOS = "pressure p = G rho epsilon, or none as in the elastic solid"
#: what two dimensions do not have
OF_ONE_DIMENSION = ("solid_stretch", "solid_eos", "solid_stress", "solid_gruneisen", "fsi_coupling", "fsi_viscous")
#: and what is of two alone
OF_TWO_DIMENSIONS = ("stability_symbols", "stability_k", "solid_shear")
SECTIONS: dict[str, tuple[Option, ...]] = {
    "Gas": (
        Option("fluid_rho", float, 1.0, "kg/m3", "density of the gas at rest", check="positive"),
        Option("fluid_T", float, 1.0, "K", "temperature, of the solid too", check="positive"),
        Option("fluid_p", float, None, "Pa", "pressure of the gas, instead of -fluid_rho", check="positive"),
        Option("fluid_gamma", float, 1.4, "", "ratio of the specific heats", check=above_one),
        Option("fluid_R", float, 1.0, "J/(kg K)", "gas constant over molar mass", check="positive"),
        Option("fluid_mu", float, 0.01, "Pa s", "viscosity", check="nonnegative"),
        Option("fluid_kappa", float, 0.03, "W/(m K)", "heat conductivity of the gas", check="nonnegative"),
    ),
    "Solid": (
        Option("solid_density", float, 1.0, "kg/m3", "density m0 in the reference state", check="positive"),
        Option("solid_modulus", float, 1.0, "Pa", "K = 2 mu_e + lambda_e", check="positive"),
        Option("solid_alpha", float, 2.5, "J/(kg K)", "specific heat", check="positive"),
        Option("solid_kappa", float, 0.02, "W/(m K)", "heat conductivity of the solid", check="nonnegative"),
        Option("solid_stretch", float, 1.0, "", "x_X at rest", check="positive"),
        Option("solid_eos", str, "ideal", "", _EOS, ("ideal", "elastic")),
        Option("solid_stress", float, 0.0, "Pa", "stress sigma at rest; with -solid_eos ideal it fixes G"),
        Option(
            *("solid_gruneisen", float, None, "", "G; then -solid_stress follows from the balance with the gas"),
            check="nonnegative",
        ),
    ),
    "Discretisation": (
        Option("fsi_coupling", str, "energy", "", "treatment of the interface", _COUPLINGS),
        Option("fsi_viscous", str, "wide", "", "second derivatives: D twice, or narrow ones", ("wide", "narrow")),
        _ORDERS,
        Option("fsi_order", int, None, "", "one order alone, instead of -fsi_orders", ORDERS),
        Option("fsi_h", float, 0.03125, "m", "grid spacing", check="positive"),
        _POINTS,
    ),
    "Two dimensions": (
        Option("stability_plane", bool, False, "", "gas over a solid in two dimensions, by wave number along them"),
        *_WAVES,
        Option("solid_shear", float, 0.25, "", "mu_e over K", check=_to(0.5)),
    ),
    "Sweep": (
        Option("sweep", bool, False, "", "all combinations of the ratios below"),
        Option("density_ratios", "floats", (1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3), "", _DENSITIES, check="positive"),
        Option("stiffness_ratios", "floats", (1e-2, 0.1, 1.0, 10.0, 100.0), "", _STIFFNESSES, check="positive"),
    ),
    "Output": (
        Option("fsi_output", str, None, "", "files of a sweep, without suffix: stability-COUPLING if not given"),
        Option("fsi_quiet", bool, False, "", "print nothing but errors"),
        Option("fsi_debug", bool, False, "", "show the Python traceback of an error"),
    ),
}
#: of this command beside those of a case
FOR_CASES = (
    Option(
        *("stability_interface", int, 0, "", "interface of the case, counted from the left"), check="nonnegative"
    ),
    *(_POINTS, _ORDERS, *SECTIONS["Sweep"]),
)


def named(arguments: Sequence[str]) -> bool:
    """Whether the arguments of the command begin with a case."""
    return bool(arguments) and not arguments[0].startswith("-")


def sections(arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Heading -> options for -help: with a case those of the case."""
    return groups(load_case(arguments[0]), FOR_CASES) if named(arguments) else SECTIONS


def orders(opt: Mapping[str, Any]) -> tuple[int, ...]:
    """The orders that are asked for. InputError if a layer has too few points for an operator."""
    from fsipetsc.operators import operator

    found = (opt["fsi_order"],) if opt["fsi_order"] else tuple(opt["fsi_orders"])
    for op in map(operator, found):
        least = max(4, op.min_points)
        if opt["stability_points"] < least:
            raise InputError(f"-stability_points {opt['stability_points']}: the {op.name} operator needs {least}")
    return found
