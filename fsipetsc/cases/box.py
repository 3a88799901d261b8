"""A closed box: gas | solid | gas between two adiabatic walls. Mass and total energy must stay.

The gas on the left is hotter and under a higher pressure than that on the right; within the solid
stress and temperature go smoothly from one to the other. So the solid is pushed to the right,
swings between two cushions of gas and conducts heat. At the walls and interfaces the initial state
is flat to the sixth derivative, so that it satisfies all conditions there (u = 0, sigma = -p, T
continuous, no heat flux) and keeps satisfying them as time goes on.

Invariants: the mass of each gas, the total energy int e dx + int m0 (u^2/2 + alpha T) dX, and for
each particle of the solid sigma - K ln x_X, from (2.1b) and x_t = u. The first three change by what
the interfaces and walls do to the closure rows, at the order of these; the last one at the two ends
of the solid only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from fsipetsc.boundaries import Wall
from fsipetsc.cases.materials import gas_of, material_options, solid_of
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "box"
SUMMARY = "gas | solid | gas in a closed box, which conserves mass and energy"

OPTIONS = (
    *material_options(
        **{"fluid_mu": 0.01, "fluid_kappa": 0.03, "fluid_gamma": 1.4, "fluid_R": 1.0},
        **{"solid_modulus": 20.0, "solid_kappa": 0.02, "solid_density": 2.0},
        **{"solid_alpha": 1.0, "solid_gruneisen": 0.0},
    ),
    Option("box_p_left", float, 2.2, "Pa", "pressure on the left at first", check="positive"),
    Option("box_p_right", float, 2.0, "Pa", "pressure on the right at first", check="positive"),
    Option("box_T_left", float, 5.0, "K", "temperature on the left at first", check="positive"),
    Option("box_T_right", float, 4.0, "K", "temperature on the right at first", check="positive"),
)
DEFAULTS = {"fsi_h": 0.0125, "fsi_order": 4, "ts_max_time": 2.0, "fsi_output_dt": 0.05}

#: walls and interfaces
X = (0.0, 1.0, 2.0, 3.0)


def smooth_step(z: np.ndarray) -> np.ndarray:
    """Polynomial that goes from 0 at z = 0 to 1 at z = 1, flat to the sixth derivative at both."""
    return z**7 * np.polyval([924, -6006, 16380, -24024, 20020, -9009, 1716], z)


def build(opt: Mapping[str, Any]) -> Problem:
    """The solid between X = 1 and X = 2, the walls at 0 and 3."""
    gas = gas_of(opt)
    solid = solid_of(opt)
    p, T = (opt["box_p_left"], opt["box_p_right"]), (opt["box_T_left"], opt["box_T_right"])

    def at_rest(side: int) -> Callable[[np.ndarray], list[np.ndarray]]:
        return lambda X: [np.full(X.shape, v) for v in (p[side] / (gas.R * T[side]), 0.0, T[side])]

    def between(X_s: np.ndarray) -> list[np.ndarray]:
        right = smooth_step(X_s - X[1])
        p_s, T_s = p[0] + (p[1] - p[0]) * right, T[0] + (T[1] - T[0]) * right
        return [np.zeros_like(X_s), solid.pressure(T_s, 1.0) - p_s, T_s, X_s]

    return Problem(
        layers=(
            FluidLayer("left", gas, X[0:2], at_rest(0)),
            SolidLayer("solid", solid, X[1:3], between),
            FluidLayer("right", gas, X[2:4], at_rest(1)),
        ),
        left=Wall(X[0]),
        right=Wall(X[3]),
        units="none",
    )
