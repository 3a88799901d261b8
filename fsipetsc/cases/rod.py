"""An elastic rod falls into a compressible gas and bounces (Sec. 5.2): fluid | solid | fluid.

A wall stands at the lower end of the domain, the upper end is open. The paper does not give the
initial state of the gas: at rest at 1e5 Pa and 300 K is inferred from its figures (one cycle ends
at t = 0.90-0.91), and the rod starts under the stress -p0, so that only gravity disturbs the rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.boundaries import Open, Wall
from fsipetsc.cases.materials import gas_of, material_options, solid_of
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "rod"
SUMMARY = "an elastic rod falls into a compressible gas and bounces (Sec. 5.2)"


def _below_the_rod(value: float) -> str | None:
    return None if value < 1 else "a number below 1"


def _above_the_rod(value: float) -> str | None:
    return None if value > 2 else "a number above 2"


OPTIONS = (
    *material_options(
        fluid_mu=0.5,
        fluid_kappa=0.7,
        fluid_gamma=1.4,
        fluid_R=8.3145 / 0.029,
        solid_modulus=1e5,
        solid_kappa=0.5,
        solid_density=2700.0,
        solid_alpha=1.0,
        solid_gruneisen=0.0,
    ),
    Option("rod_gravity", "float", -10.0, "m/s2", "body force per mass on the rod"),
    Option("rod_p0", "float", 1e5, "Pa", "initial pressure of the gas", check="positive"),
    Option("rod_T0", "float", 300.0, "K", "initial temperature", check="positive"),
    Option("rod_wall", "float", 0.0, "m", "position of the lower wall", check=_below_the_rod),
    Option("rod_top", "float", 6.0, "m", "position of the open upper end", check=_above_the_rod),
)
#: interfaces and grids are the paper's
DEFAULTS = {
    **{"fsi_h": 0.0125, "fsi_order": 4, "ts_max_time": 3.0, "fsi_output_dt": 0.05},
    "fsi_coupling": "projection",
}


def build(opt: Mapping[str, Any]) -> Problem:
    """The rod between X = 1 and X = 2."""
    gas = gas_of(opt)
    rod = solid_of(opt, force=opt["rod_gravity"])
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
