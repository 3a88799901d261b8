"""A wall that moves drives gas against an elastic layer, behind which more gas lies.

gas | solid | gas. The wall on the left moves in by `piston_stroke` and comes to rest, x = stroke
sin^2(pi t / (2 time)) up to t = time, so smoothly that the gas is compressed nearly without a loss.
The layer is pushed over and swings. The grids of both gases are stretched; the mass of each stays
what it is to round-off, and the energy of all grows by the work of the wall.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, pi, sin
from typing import Any

import numpy as np

from fsipetsc.boundaries import Wall
from fsipetsc.cases.materials import gas_of, material_options, solid_of
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "piston"
SUMMARY = "a wall that moves drives gas against an elastic layer: gas | solid | gas"

OPTIONS = (
    *material_options(
        **{"fluid_mu": 1.8e-5, "fluid_kappa": 0.026, "solid_modulus": 1e7, "solid_kappa": 0.2},
        **{"solid_density": 100.0, "solid_alpha": 1000.0},
    ),
    Option(
        *("piston_stroke", float, 0.3, "m", "way of the wall"),
        check=lambda way: None if way < 0.9 else "a number below 0.9",
    ),
    Option("piston_time", "float", 0.02, "s", "time that it takes", check="positive"),
)
DEFAULTS = {"fsi_h": 0.0125, "fsi_order": 4, "ts_max_time": 0.04, "fsi_output_dt": 5e-4}

P0, T0 = 1e5, 300.0
X = (0.0, 1.0, 1.2, 2.2)


def build(opt: Mapping[str, Any]) -> Problem:
    """The layer between X = 1 and X = 1.2, everything at rest under P0."""
    gas = gas_of(opt, R=287.0)
    solid = solid_of(opt)
    stroke, time = opt["piston_stroke"], opt["piston_time"]

    def place(t: float) -> float:
        return stroke * sin(0.5 * pi * min(max(t, 0.0), time) / time) ** 2

    def velocity(t: float) -> float:
        inside = 0.5 * pi * min(max(t, 0.0), time) / time
        return stroke * pi / time * sin(inside) * cos(inside)

    def at_rest(X_g: np.ndarray) -> list[np.ndarray]:
        return [0 * X_g + P0 / (gas.R * T0), 0 * X_g, 0 * X_g + T0]

    def layer(X_s: np.ndarray) -> list[np.ndarray]:
        return [0 * X_s, 0 * X_s - P0, 0 * X_s + T0, X_s]

    return Problem(
        layers=(
            FluidLayer("driven", gas, X[:2], at_rest),
            SolidLayer("layer", solid, X[1:3], layer),
            FluidLayer("behind", gas, X[2:], at_rest),
        ),
        left=Wall(place, velocity=velocity),
        right=Wall(X[3]),
    )
