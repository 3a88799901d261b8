"""A pressure pulse under an elastic plate: gas | plate, a wall below, the ambient pressure above.

The pulse spreads, bends the plate upwards, and comes back from the wall. With blast_kind shock
it is a disc of one pressure, which sends a shock out from the start: that needs -fsi_shock and
-fsi_dissipation. The plate is free of stress under the ambient pressure, held at its sides
against X alone, so the sides are planes of symmetry: a row of plates and pulses without end.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.blocks.conditions import Free, NoSlip, Roller, Slip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.options import Option

NAME = "blast"
SUMMARY = "a pressure pulse under an elastic plate, in two dimensions"

OPTIONS = (
    Option("fluid_mu", float, 0.002, "Pa s", "viscosity of the gas", check="nonnegative"),
    Option("fluid_kappa", float, 0.003, "W/(m K)", "conductivity of the gas", check="nonnegative"),
    Option("solid_density", float, 5.0, "kg/m3", "density of the plate", check="positive"),
    Option("solid_modulus", float, 40.0, "Pa", "2 mu_e + lambda_e = 4 mu_e", check="positive"),
    Option("solid_law", str, "log", "", "law of the plate", ("log", "neo-hookean", "svk")),
    Option("blast_kind", str, "pulse", "", "smooth, or a disc with a jump", ("pulse", "shock")),
    Option("blast_height", float, 1.0, "Pa", "overpressure, over 1", check="nonnegative"),
    Option("blast_width", float, 0.15, "m", "of the pulse", check="positive"),
)
DEFAULTS = {"fsi_h": 0.03125, "fsi_order": 4, "ts_max_time": 2.0, "fsi_output_dt": 0.05}


def build(opt: Mapping[str, Any]) -> BlockProblem:
    """The gas between Y = 0 and 1, the plate above it."""
    gas = Fluid(opt["fluid_mu"], opt["fluid_kappa"], 1.4, 1.0)
    K, density = opt["solid_modulus"], opt["solid_density"]
    plate = ElasticSolid(K / 4, K / 2, 0.01, density, 1.0, p_ref=1.0, law=opt["solid_law"])

    def pulse(X: np.ndarray, Y: np.ndarray) -> list[np.ndarray]:
        """Of pressure; the entropy is the same everywhere."""
        squared = ((X - 0.5) ** 2 + (Y - 0.5) ** 2) / opt["blast_width"] ** 2
        p = 1.0 + opt["blast_height"] * np.exp(-squared)
        rho = p ** (1.0 / gas.gamma)
        return [rho, 0.0 * X, 0.0 * X, p / rho]

    def disc(X: np.ndarray, Y: np.ndarray) -> list[np.ndarray]:
        """Twice as hot as what is around it."""
        inside = (X - 0.5) ** 2 + (Y - 0.5) ** 2 < opt["blast_width"] ** 2
        p, T = np.where(inside, 1.0 + opt["blast_height"], 1.0), np.where(inside, 2.0, 1.0)
        return [p / T, 0.0 * X, 0.0 * X, T]

    def rest(X: np.ndarray, Y: np.ndarray) -> list[np.ndarray]:
        return [0.0 * X, 0.0 * X, np.ones_like(X), X, Y]

    start = disc if opt["blast_kind"] == "shock" else pulse
    return layers(
        Layer("gas", gas, (0.0, 1.0), start, sides=Slip()),
        Layer("plate", plate, (1.0, 1.25), rest, sides=Roller()),
        along=((0.0, 1.0),),
        lower=NoSlip(),
        upper=Free(1.0),
        h=opt["fsi_h"],
        order=opt["fsi_order"],
        units="none",
    )
