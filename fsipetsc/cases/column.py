"""A column of five layers, solid | gas | solid | gas | solid: a pulse in the first gas runs through all of them.

The outer solids are clamped, so nothing leaves: the mass of both gases, the total energy and, with the impulse of the two ends,
the momentum stay what they are, to round-off with the conservative coupling.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.boundaries import clamped
from fsipetsc.options import Option
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.solid import Solid
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "column"
SUMMARY = "solid | gas | solid | gas | solid: a pulse runs through five layers"

OPTIONS = (
    Option("fluid_mu", "float", 0.01, "Pa s", "viscosity of the gases", check="nonnegative"),
    Option("fluid_kappa", "float", 0.03, "W/(m K)", "heat conductivity of the gases", check="nonnegative"),
    Option("solid_modulus", "float", 20.0, "Pa", "2 mu_e + lambda_e of the solids", check="positive"),
    Option("solid_kappa", "float", 0.02, "W/(m K)", "heat conductivity of the solids", check="nonnegative"),
    Option("solid_density", "float", 2.0, "kg/m3", "density m0 of the solids at rest", check="positive"),
    Option("solid_alpha", "float", 1.0, "J/(kg K)", "specific heat of the solids", check="positive"),
    Option("column_pulse", "float", 0.5, "", "overpressure in the middle of the first gas, over p0", check="nonnegative"),
)
DEFAULTS = {"fsi_h": 0.025, "fsi_order": 4, "ts_max_time": 4.0, "fsi_output_dt": 0.05}

P0, T0 = 1.0, 1.0
NAMES = ("bottom", "lower gas", "plate", "upper gas", "top")
#: the plate is thin
X = (0.0, 1.0, 2.0, 2.5, 3.5, 4.5)


def build(opt: Mapping[str, Any]) -> Problem:
    """All at rest under p0 but for the pulse."""
    gas = Fluid(opt["fluid_mu"], opt["fluid_kappa"], gamma=1.4, R=1.0)
    solid = Solid(opt["solid_modulus"], opt["solid_kappa"], opt["solid_density"], opt["solid_alpha"])

    def pulse(X_g: np.ndarray) -> list[np.ndarray]:
        compressed = (1 + opt["column_pulse"] * np.exp(-(((X_g - 1.5) / 0.12) ** 2))) ** (1 / gas.gamma)
        return [P0 / (gas.R * T0) * compressed, 0 * X_g, T0 * compressed ** (gas.gamma - 1)]

    def gas_at_rest(X_g: np.ndarray) -> list[np.ndarray]:
        return [0 * X_g + P0 / (gas.R * T0), 0 * X_g, 0 * X_g + T0]

    def at_rest(X_s: np.ndarray) -> list[np.ndarray]:
        return [0 * X_s, 0 * X_s - P0, 0 * X_s + T0, X_s]

    layers = []
    for k, name in enumerate(NAMES):
        if k % 2 == 0:
            layers.append(SolidLayer(name, solid, X[k : k + 2], at_rest))
        else:
            layers.append(FluidLayer(name, gas, X[k : k + 2], pulse if k == 1 else gas_at_rest))
    return Problem(tuple(layers), clamped(), clamped(), units="none")
