"""An elastic rod falls into a compressible gas and bounces (Sec. 5.2): fluid | solid | fluid.

A wall stands at the lower end of the domain, the upper end is open. The paper does not give the initial state of
the gas: at rest at 1e5 Pa and 300 K is inferred from its figures (one cycle ends at t = 0.90-0.91), and the rod
starts under the stress -p0, so that only gravity disturbs the rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.boundaries import Open, Wall
from fsipetsc.options import Option
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.solid import Solid
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "rod"
SUMMARY = "an elastic rod falls into a compressible gas and bounces (Sec. 5.2)"


def _above_one(value: float) -> str | None:
    return None if value > 1 else "a number above 1"


def _below_the_rod(value: float) -> str | None:
    return None if value < 1 else "a number below 1"


def _above_the_rod(value: float) -> str | None:
    return None if value > 2 else "a number above 2"


OPTIONS = (
    Option("fluid_mu", "float", 0.5, "Pa s", "viscosity of the gas", check="nonnegative"),
    Option("fluid_kappa", "float", 0.7, "W/(m K)", "heat conductivity of the gas", check="nonnegative"),
    Option("fluid_gamma", "float", 1.4, "-", "ratio of the specific heats of the gas", check=_above_one),
    Option("fluid_R", "float", 8.3145 / 0.029, "J/(kg K)", "gas constant over molar mass", check="positive"),
    Option("solid_modulus", "float", 1e5, "Pa", "2 mu_e + lambda_e of the rod", check="positive"),
    Option("solid_kappa", "float", 0.5, "W/(m K)", "heat conductivity of the rod", check="nonnegative"),
    Option("solid_density", "float", 2700.0, "kg/m3", "density m0 of the rod at rest", check="positive"),
    Option("solid_alpha", "float", 1.0, "J/(kg K)", "specific heat of the rod", check="positive"),
    Option("solid_gruneisen", "float", 0.0, "-", "pressure of the rod p = G rho epsilon; 0: elastic", check="nonnegative"),
    Option("rod_gravity", "float", -10.0, "m/s2", "body force per mass on the rod"),
    Option("rod_p0", "float", 1e5, "Pa", "initial pressure of the gas", check="positive"),
    Option("rod_T0", "float", 300.0, "K", "initial temperature", check="positive"),
    Option("rod_wall", "float", 0.0, "m", "position of the lower wall, below 1", check=_below_the_rod),
    Option("rod_top", "float", 6.0, "m", "position of the open upper end, above 2", check=_above_the_rod),
)
#: interfaces and grids are the paper's
DEFAULTS = {
    **{"fsi_h": 0.0125, "fsi_order": 4, "ts_max_time": 3.0, "fsi_output_dt": 0.05},
    **{"fsi_coupling": "projection", "fsi_mapping": "rigid"},
}


def build(opt: Mapping[str, Any]) -> Problem:
    """The rod between X = 1 and X = 2."""
    gas = Fluid(opt["fluid_mu"], opt["fluid_kappa"], opt["fluid_gamma"], opt["fluid_R"])
    rod = Solid(
        opt["solid_modulus"],
        opt["solid_kappa"],
        opt["solid_density"],
        opt["solid_alpha"],
        opt["rod_gravity"],
        opt["solid_gruneisen"],
    )
    p0, T0 = opt["rod_p0"], opt["rod_T0"]

    def gas_at_rest(X: np.ndarray) -> list[np.ndarray]:
        return [np.full(X.shape, p0 / (gas.R * T0)), np.zeros(X.shape), np.full(X.shape, T0)]

    def rod_at_rest(X: np.ndarray) -> list[np.ndarray]:
        stress = rod.pressure(T0, 1.0) - p0  # balances the gas
        return [np.zeros(X.shape), np.full(X.shape, stress), np.full(X.shape, T0), X]

    return Problem(
        layers=(
            FluidLayer("below", gas, (opt["rod_wall"], 1.0), gas_at_rest),
            SolidLayer("rod", rod, (1.0, 2.0), rod_at_rest),
            FluidLayer("above", gas, (2.0, opt["rod_top"]), gas_at_rest),
        ),
        left=Wall(opt["rod_wall"]),
        right=Open(opt["rod_top"], p0, T0),
    )
