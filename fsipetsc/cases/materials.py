"""The options of the built-in cases about one gas and one solid, and the materials they make."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.options import Option, above_one

_GRUNEISEN = "pressure of the solid p = G rho epsilon; 0: elastic"
#: name -> unit, meaning, check
_KNOWN = {
    "fluid_mu": ("Pa s", "viscosity of the gas", "nonnegative"),
    "fluid_kappa": ("W/(m K)", "heat conductivity of the gas", "nonnegative"),
    "fluid_gamma": ("", "ratio of the specific heats of the gas", above_one),
    "fluid_R": ("J/(kg K)", "gas constant over molar mass", "positive"),
    "solid_modulus": ("Pa", "2 mu_e + lambda_e of the solid", "positive"),
    "solid_kappa": ("W/(m K)", "heat conductivity of the solid", "nonnegative"),
    "solid_density": ("kg/m3", "density m0 of the solid in its reference state", "positive"),
    "solid_alpha": ("J/(kg K)", "specific heat of the solid", "positive"),
    "solid_mu": ("Pa", "mu_e of the solid", "positive"),
    "solid_lambda": ("Pa", "lambda_e of the solid", "nonnegative"),
    "solid_gruneisen": ("", _GRUNEISEN, "nonnegative"),
}


def material_options(conducting: bool = False, **defaults: float) -> tuple[Option, ...]:
    """Options with their defaults; a case leaves some out. conducting: no conductivity is 0."""
    options = []
    for name, value in defaults.items():
        unit, meaning, check = _KNOWN[name]
        check = "positive" if conducting and "kappa" in name else check
        options.append(Option(name, float, value, unit, meaning, check=check))
    return tuple(options)


def gas_of(opt: Mapping[str, Any], gamma: float = 1.4, R: float = 1.0) -> Fluid:
    """The gas of a case; gamma, R: where they are no options."""
    both = opt.get("fluid_gamma", gamma), opt.get("fluid_R", R)
    return Fluid(opt["fluid_mu"], opt["fluid_kappa"], *both)


def solid_of(opt: Mapping[str, Any], force: float = 0.0) -> Solid:
    """The solid of a case; force [m/s2] on it."""
    conducted, pressing = opt.get("solid_kappa", 0.0), opt.get("solid_gruneisen", 0.0)
    numbers = opt["solid_modulus"], conducted, opt["solid_density"], opt["solid_alpha"]
    return Solid(*numbers, force, pressing)


def elastic_of(opt: Mapping[str, Any], p_ref: float = 1.0, **law: str) -> ElasticSolid:
    """The solid of a case of blocks, of specific heat 1; p_ref [Pa], law: see ElasticSolid."""
    numbers = opt["solid_mu"], opt["solid_lambda"], 0.0, opt["solid_density"], 1.0
    return ElasticSolid(*numbers, p_ref=p_ref, heat="elastic", **law)
