"""Layers of gas (g) and solid (s) in any sequence, between walls or clamped; gases have pulses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.boundaries import Wall, clamped
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "layers"
SUMMARY = "any sequence of layers"
OPTIONS = (
    Option("layers", "str", "gsgsg", "", "g for a gas, s for a solid, from left to right"),
    Option("layers_gruneisen", "float", 0.0, "", "p = G rho epsilon in the solids"),
    Option("layers_moving", "bool", False, "", "the left wall is pushed in"),
)
DEFAULTS = {"fsi_h": 0.05, "fsi_order": 4, "ts_max_time": 1.0, "fsi_output_dt": 0.5}


def build(opt: Mapping[str, Any]) -> Problem:
    """Layers of length 1; the gases have the pressure 1 but for a pulse."""
    gas = Fluid(0.01, 0.03, 1.4, 1.0)
    solid = Solid(20.0, 0.02, 2.0, 1.0, gruneisen=opt["layers_gruneisen"])
    layers: list[FluidLayer | SolidLayer] = []
    for k, kind in enumerate(opt["layers"]):

        def pulse(X: np.ndarray, middle: float = k + 0.4) -> list[np.ndarray]:
            return [1 + 0.2 * np.exp(-60 * (X - middle) ** 2), 0 * X, 1 + 0 * X]

        def at_rest(X: np.ndarray) -> list[np.ndarray]:
            return [0 * X, 0 * X + solid.pressure(1.0, 1.0) - 1.0, 1 + 0 * X, X]

        X = float(k), float(k + 1)
        layers.append(
            FluidLayer(f"gas {k}", gas, X, pulse)
            if kind == "g"
            else SolidLayer(f"bar {k}", solid, X, at_rest)
        )
    place = (lambda t: 0.05 * t * t) if opt["layers_moving"] else 0.0
    left = Wall(place) if opt["layers"][0] == "g" else clamped()
    right = Wall(float(len(layers))) if opt["layers"][-1] == "g" else clamped()
    return Problem(tuple(layers), left, right, units="none")
