"""What the built-in cases share: options of materials, states at rest, stacks of layers."""

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

from fsipetsc import BlockProblem, ElasticSolid, Fluid, Layer, Option, Solid, layers
from fsipetsc.cases import named
from fsipetsc.checks import Array
from fsipetsc.operators.sbp import OPERATORS

#: the options in force
Opt = Mapping[str, Any]
#: defaults of cases with shocks
SHOCKS = {"fsi_shock": 1.0, "fsi_dissipation": 1.0}

#: name -> unit, meaning, choices, check
_KNOWN = {
    "fluid_mu": ("Pa s", "viscosity of the gas", None, "nonnegative"),
    "fluid_kappa": ("W/(m K)", "heat conductivity of the gas", None, "nonnegative"),
    "fluid_gamma": ("", "ratio of the specific heats of the gas", None, "above 1"),
    "fluid_R": ("J/(kg K)", "gas constant over molar mass", None, "positive"),
    "solid_modulus": ("Pa", "2 mu_e + lambda_e of the solid", None, "positive"),
    "solid_kappa": ("W/(m K)", "heat conductivity of the solid", None, "nonnegative"),
    "solid_density": ("kg/m3", "density m0 of the solid in its reference state", None, "positive"),
    "solid_alpha": ("J/(kg K)", "specific heat of the solid", None, "positive"),
    "solid_mu": ("Pa", "mu_e of the solid", None, "positive"),
    "solid_lambda": ("Pa", "lambda_e of the solid", None, "nonnegative"),
    "solid_gruneisen": ("", "p of the solid over rho epsilon; 0: elastic", None, "nonnegative"),
}


def case(defaults: Mapping[str, Any], *options: Option) -> Callable[[Any], Any]:
    """Make a case of its function build, which has its name and tells what it is about."""
    about = {"OPTIONS": options, "DEFAULTS": dict(defaults)}
    return lambda build: named(SimpleNamespace(**about, build=build), build.__name__, build)


def materials(**defaults: Any) -> tuple[Option, ...]:
    """Options with their defaults. solid_law: the laws that are allowed, first the default."""

    def option(name: str, value: Any) -> Option:
        if name == "solid_law":
            return Option(name, str, value[0], "", "law of the solid", value)
        return Option(name, float, value, *_KNOWN[name])

    return tuple(map(option, defaults, defaults.values()))


def gas_of(opt: Opt, R: float = 1.0) -> Fluid:
    """Return the gas of a case; R: where it is no option."""
    mu, kappa = opt.get("fluid_mu", 0.0), opt.get("fluid_kappa", 0.0)
    return Fluid(mu, kappa, opt.get("fluid_gamma", 1.4), opt.get("fluid_R", R))


def solid_of(opt: Opt, force: float = 0.0) -> Solid:
    """Return the solid of a case of layers; force [m/s2] on it."""
    K, kappa_e, m0 = opt["solid_modulus"], opt.get("solid_kappa", 0.0), opt["solid_density"]
    return Solid(K, kappa_e, m0, opt["solid_alpha"], force, opt.get("solid_gruneisen", 0.0))


def elastic_of(opt: Opt, p_ref: float = 1.0, **more: Any) -> ElasticSolid:
    """The solid of a case of blocks, of solid_mu and solid_lambda; else of K, as K/4 and K/2."""
    K = opt.get("solid_modulus", 0.0)
    lame = opt.get("solid_mu", K / 4), opt.get("solid_lambda", K / 2)
    others = {"kappa_e": 0.0, "alpha": 1.0, "heat": "elastic", **more}
    return ElasticSolid(*lame, m0=opt["solid_density"], p_ref=p_ref, **others)


def constant(*values: float) -> Callable[..., Any]:
    """A function of any place with these values."""
    return lambda *X: values


def at_rest(T: float = 1.0) -> Callable[..., Any]:
    """Initial data of a solid block: no velocity, the temperature T [K], places as in the map."""
    return lambda *X: (*(0.0 for _ in X), T, *X)


def line_at_rest(sigma: float, T: float) -> Callable[[Array], Any]:
    """Initial data of a solid layer under the stress sigma [Pa], of the temperature T [K]."""
    return lambda X: (0.0, sigma, T, X)


def cells_of(opt: Opt, *lengths: float) -> list[int]:
    """Cells of the size of -fsi_h along each length, and at least as many as the operators need."""
    least = OPERATORS[opt["fsi_order"]].min_points - 1
    return [max(round(length / opt["fsi_h"]), least) for length in lengths]


def stack(opt: Opt, *members: Layer, units: str = "none", **more: Any) -> BlockProblem:
    """Layers on the grid that the options ask for; more: as of fsipetsc.blocks.layers.layers."""
    return layers(*members, h=opt["fsi_h"], order=opt["fsi_order"], units=units, **more)
