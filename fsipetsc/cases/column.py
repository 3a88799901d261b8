"""A column of five layers, solid | gas | solid | gas | solid: a pulse runs through all of them.

The outer solids are clamped, so nothing leaves: the mass of both gases, the total energy and, with
the impulse of the two ends, the momentum stay what they are, to round-off with the conservative
coupling.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.boundaries import clamped
from fsipetsc.cases.materials import gas_of, material_options, solid_of
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "column"
SUMMARY = "solid | gas | solid | gas | solid: a pulse runs through five layers"

OPTIONS = (
    *material_options(
        **{"fluid_mu": 0.01, "fluid_kappa": 0.03, "solid_modulus": 20.0, "solid_kappa": 0.02},
        **{"solid_density": 2.0, "solid_alpha": 1.0},
    ),
    Option("column_pulse", float, 0.5, "", "overpressure over p0", check="nonnegative"),
)
DEFAULTS = {"fsi_h": 0.025, "fsi_order": 4, "ts_max_time": 4.0, "fsi_output_dt": 0.05}

P0, T0 = 1.0, 1.0
NAMES = ("bottom", "lower gas", "plate", "upper gas", "top")
#: the plate is thin
X = (0.0, 1.0, 2.0, 2.5, 3.5, 4.5)


def build(opt: Mapping[str, Any]) -> Problem:
    """All at rest under p0 but for the pulse."""
    gas = gas_of(opt)
    solid = solid_of(opt)

    def pulse(X_g: np.ndarray) -> list[np.ndarray]:
        p = 1 + opt["column_pulse"] * np.exp(-(((X_g - 1.5) / 0.12) ** 2))
        compressed = p ** (1 / gas.gamma)
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
