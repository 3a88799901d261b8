"""The options of `python -m fsipetsc stability`, and the problem that they, or a case, describe. Cheap to import."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from fsipetsc.cases import load_case
from fsipetsc.errors import InputError
from fsipetsc.options import above_one, groups
from fsipetsc.options.option import Option

if TYPE_CHECKING:
    from fsipetsc.analysis.stability_state import Constant

ORDERS = (2, 4, 6, 8)


def _orders(values: tuple[int, ...]) -> str | None:
    return None if set(values) <= set(ORDERS) else "orders out of 2,4,6,8"


def _fractions(values: tuple[float, ...]) -> str | None:
    return None if all(0 <= value <= 1 for value in values) else "numbers from 0 to 1"


def _half(value: float) -> str | None:
    return None if 0 <= value <= 0.5 else "a number from 0 to 0.5"


_ORDERS = Option("fsi_orders", "ints", ORDERS, "", "interior orders of the SBP operators", check=_orders)
_POINTS = Option(
    *("stability_points", int, 32, "", "points of each of the two layers; of a case in 2-D, at most so many"),
    check="positive",
)
_WAVES = (
    Option(
        *("stability_symbols", "floats", (0.0, 0.2, 0.6, 1.0), ""),
        help="wave numbers, as fractions of the greatest that D knows",
        check=_fractions,
    ),
    Option("stability_k", "floats", None, "1/m", "wave numbers themselves, instead of -stability_symbols", check="nonnegative"),
)
#: what two dimensions do not have
OF_ONE_DIMENSION = (
    *("solid_stretch", "solid_eos", "solid_stress", "solid_gruneisen", "fsi_coupling", "fsi_viscous", "fsi_output"),
)
#: and what is of two alone
OF_TWO_DIMENSIONS = ("stability_symbols", "stability_k", "stability_x", "solid_shear", "solid_heat")
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
        Option(
            *("solid_eos", str, "ideal", "", "pressure p = G rho epsilon, or none as in the elastic solid"),
            choices=("ideal", "elastic"),
        ),
        Option("solid_stress", float, 0.0, "Pa", "stress sigma at rest; with -solid_eos ideal it fixes G"),
        Option(
            *("solid_gruneisen", float, None, "", "G; then -solid_stress follows from the balance with the gas"),
            check="nonnegative",
        ),
    ),
    "Discretisation": (
        Option(
            *("fsi_coupling", str, "energy", "", "treatment of the interface"),
            choices=("conservative", "energy", "projection", "traditional"),
        ),
        Option("fsi_viscous", str, "wide", "", "second derivatives: D twice, or narrow ones", ("wide", "narrow")),
        _ORDERS,
        Option("fsi_order", int, None, "", "one order alone, instead of -fsi_orders", ORDERS),
        Option("fsi_h", float, 0.03125, "m", "grid spacing", check="positive"),
        _POINTS,
    ),
    "Two dimensions": (
        Option("stability_plane", bool, False, "", "gas over a solid in two dimensions, by wave number along them"),
        *_WAVES,
        Option("solid_shear", float, 0.25, "", "mu_e over K", check=_half),
        Option("solid_heat", str, "elastic", "", "beside an elastic energy, or the work of stresses", ("elastic", "coupled")),
    ),
    "Sweep": (
        Option("sweep", bool, False, "", "all combinations of the ratios below"),
        Option(
            *("density_ratios", "floats", (1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0, 1000.0), ""),
            help="m0 over the density of the gas, instead of -solid_density; alpha m0 keeps its value",
            check="positive",
        ),
        Option(
            *("stiffness_ratios", "floats", (1e-2, 1e-1, 1.0, 10.0, 100.0), ""),
            help="K over the pressure of the gas, instead of -solid_modulus",
            check="positive",
        ),
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
        *("stability_interface", int, 0, "", "interface of the case, counted from the left, or from below"),
        check="nonnegative",
    ),
    Option("stability_X", float, None, "m", "in 2-D, where it is; default: in the middle of the interface"),
    *(*_WAVES, _POINTS, _ORDERS),
    *SECTIONS["Sweep"],
)


def named(arguments: Sequence[str]) -> bool:
    """Whether the arguments of the command begin with a case."""
    return bool(arguments) and not arguments[0].startswith("-")


def sections(arguments: Sequence[str]) -> dict[str, tuple[Option, ...]]:
    """Heading -> options for -help: with a case those of the case."""
    return groups(load_case(arguments[0]), FOR_CASES) if named(arguments) else SECTIONS


def orders(opt: Mapping[str, Any]) -> tuple[int, ...]:
    """The orders that are asked for."""
    return (opt["fsi_order"],) if opt["fsi_order"] else tuple(opt["fsi_orders"])


def check(opt: Mapping[str, Any]) -> None:
    """Raise InputError if a layer has too few points for an operator."""
    from fsipetsc.operators import operator

    for order in orders(opt):
        op = operator(order)
        least = max(4, op.min_points)
        if opt["stability_points"] < least:
            raise InputError(f"-stability_points {opt['stability_points']}: the {op.name} operator needs {least}")


def constant_state(opt: Mapping[str, Any]) -> Constant:
    """The state at rest that the options describe. InputError if gas and solid cannot balance."""
    from fsipetsc.analysis.stability_state import Constant
    from fsipetsc.materials.fluid import Fluid
    from fsipetsc.materials.line_solid import Solid

    gas = Fluid(opt["fluid_mu"], opt["fluid_kappa"], opt["fluid_gamma"], opt["fluid_R"])
    T = opt["fluid_T"]
    rho = opt["fluid_rho"] if opt["fluid_p"] is None else opt["fluid_p"] / (gas.R * T)
    solid = Solid(opt["solid_modulus"], opt["solid_kappa"], opt["solid_density"], opt["solid_alpha"])
    return Constant(gas, replace(solid, gruneisen=_gruneisen(opt, gas.R * rho * T)), rho, T, opt["solid_stretch"])


def _gruneisen(opt: Mapping[str, Any], p: float) -> float:
    stress, given = opt["solid_stress"], opt["solid_gruneisen"]
    if opt["solid_eos"] == "elastic":
        if given or stress not in (0.0, -p):
            raise InputError(f"-solid_eos elastic: the stress at rest is -p = {-p:g} Pa, and there is no G")
        return 0.0
    if given is not None:
        if stress:
            raise InputError("-solid_gruneisen and -solid_stress: one of them follows from the other; give one")
        return given
    if stress <= -p:
        raise InputError(f"-solid_stress {stress:g}: must be above -p = {-p:g} Pa, so that the solid has a pressure")
    return (p + stress) * opt["solid_stretch"] / (opt["solid_density"] * opt["solid_alpha"] * opt["fluid_T"])


def swept(state: Constant, density_ratio: float, stiffness_ratio: float) -> Constant:
    """The same state with another density and stiffness of the solid; alpha m0 keeps its value.

    So do the pressures, if Grüneisen's law is that of the solid.
    """
    solid = state.solid
    m0 = density_ratio * state.rho
    changed = replace(solid, m0=m0, K=stiffness_ratio * state.p, alpha=solid.alpha * solid.m0 / m0)
    return replace(state, solid=changed)
