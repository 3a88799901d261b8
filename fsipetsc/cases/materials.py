"""The options of the built-in cases about one gas and one solid, and the materials that they make."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.options import Option, above_one

#: each with a default that a case replaces
_KNOWN = (
    Option("fluid_mu", float, 0.0, "Pa s", "viscosity of the gas", check="nonnegative"),
    Option("fluid_kappa", float, 0.0, "W/(m K)", "heat conductivity of the gas", check="nonnegative"),
    Option("fluid_gamma", float, 1.4, "", "ratio of the specific heats of the gas", check=above_one),
    Option("fluid_R", float, 1.0, "J/(kg K)", "gas constant over molar mass", check="positive"),
    Option("solid_modulus", float, 1.0, "Pa", "2 mu_e + lambda_e of the solid", check="positive"),
    Option("solid_kappa", float, 0.0, "W/(m K)", "heat conductivity of the solid", check="nonnegative"),
    Option("solid_density", float, 1.0, "kg/m3", "density m0 of the solid in its reference state", check="positive"),
    Option("solid_alpha", float, 1.0, "J/(kg K)", "specific heat of the solid", check="positive"),
    Option("solid_gruneisen", float, 0.0, "", "pressure of the solid p = G rho epsilon; 0: elastic", check="nonnegative"),
)


def material_options(conducting: bool = False, **defaults: float) -> tuple[Option, ...]:
    """Options by name with their defaults; those that a case does not name are left out. conducting: no conductivity is 0."""
    known = {option.name: option for option in _KNOWN}
    if conducting:
        known |= {name: replace(known[name], check="positive") for name in ("fluid_kappa", "solid_kappa")}
    return tuple(replace(known[name], default=default) for name, default in defaults.items())


def gas_of(opt: Mapping[str, Any], gamma: float = 1.4, R: float = 1.0) -> Fluid:
    """The gas of a case; gamma, R: where they are no options."""
    return Fluid(opt["fluid_mu"], opt["fluid_kappa"], opt.get("fluid_gamma", gamma), opt.get("fluid_R", R))


def solid_of(opt: Mapping[str, Any], force: float = 0.0) -> Solid:
    """The solid of a case; force [m/s2] on it."""
    conducted, pressing = opt.get("solid_kappa", 0.0), opt.get("solid_gruneisen", 0.0)
    return Solid(opt["solid_modulus"], conducted, opt["solid_density"], opt["solid_alpha"], force, pressing)
