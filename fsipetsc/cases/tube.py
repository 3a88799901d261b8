"""Sod's shock tube in a plane: along X, across Y, or across Y into an elastic layer.

Along X and across Y the gas of high pressure is on the left, or below; halfway the gas of low
pressure begins. Walls all around let it slip, so that what is computed of one is that of the
other with X and Y exchanged. `elastic` has an elastic layer in the place of the upper half, as
the case `shock` has a rod. The exact solution is that of fsipetsc.cases.riemann, for where
nothing varies along X the law `log` is that of the rod. The tube is periodic there.

The exact solution is that without viscosity and conduction, until a wave comes to an end. Errors
are in L1, in which a shock has order 1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from fsipetsc.blocks.conditions import Clamped, Slip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.cases.riemann import GasState, GasWave, pressure_between
from fsipetsc.cases.shock import DENSE, GAMMA, LOW, R, Solution
from fsipetsc.checks import Fields
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.options import Option

NAME = "tube"
SUMMARY = "a shock tube in a plane, along X, across Y or into an elastic layer: exact solution"

OPTIONS = (
    Option("tube_problem", str, "elastic", "", "along X, Y, into a layer", ("x", "y", "elastic")),
    Option("tube_width", float, 0.25, "m", "of the tube, 1 or 2 long", check="positive"),
    Option("solid_modulus", float, 4.0, "Pa", "2 mu_e + lambda_e = 4 mu_e", check="positive"),
    Option("solid_density", float, 0.5, "kg/m3", "of the layer", check="positive"),
)
DEFAULTS = {
    **{"fsi_h": 0.01, "fsi_order": 4, "ts_max_time": 0.15, "fsi_output_dt": 0.05, "fsi_norm": "L1"},
    **{"fsi_shock": 1.0, "fsi_dissipation": 1.0},
}
#: the gas of high pressure in Sod's problem
HIGH = GasState(DENSE, 0.0, 1.0)


def sod(gas: Fluid) -> Callable[[np.ndarray, float], tuple[np.ndarray, ...]]:
    """(rho, u, T) at (x, t) of Sod's problem between two halves of a gas, split at x = 0.

    What goes to the right is what goes to the left, seen in a mirror.
    """
    left, right = GasWave(gas, HIGH), GasWave(gas, GasState(LOW.rho, -LOW.u, LOW.p))
    p = pressure_between(left.velocity, lambda p: -right.velocity(p))
    interface = float(left.velocity(p))

    def at(x: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        if t <= 0.0:
            rho, u, p_at = (np.where(x < 0.0, a, b) for a, b in zip(HIGH, LOW, strict=True))
        else:
            here, there = left.at(p, x / t), right.at(p, -x / t)
            both = zip(here, (there.rho, -there.u, there.p), strict=True)
            rho, u, p_at = (np.where(x / t < interface, a, b) for a, b in both)
        return rho, u, p_at / (rho * gas.R)

    return at


def build(opt: Mapping[str, Any]) -> BlockProblem:
    """The gas from 0 to 1, the layer from 1 to 2."""
    return _elastic(opt) if opt["tube_problem"] == "elastic" else _alone(opt)


def _alone(opt: Mapping[str, Any]) -> BlockProblem:
    gas, width, along = Fluid(0.0, 0.0, GAMMA, R), opt["tube_width"], opt["tube_problem"] == "x"
    tube = sod(gas)

    def exact(X: np.ndarray, Y: np.ndarray, t: float = 0.0) -> Fields:
        rho, u, T = tube((X if along else Y) - 0.5, t)
        return (rho, u, 0.0 * u, T) if along else (rho, 0.0 * u, u, T)

    return layers(
        Layer("gas", gas, (0.0, width if along else 1.0), exact, sides=Slip(), exact=exact),
        along=((0.0, 1.0 if along else width),),
        lower=Slip(),
        upper=Slip(),
        h=opt["fsi_h"],
        order=opt["fsi_order"],
        units="none",
    )


def _elastic(opt: Mapping[str, Any]) -> BlockProblem:
    gas, K, density = Fluid(0.0, 0.0, GAMMA, R), opt["solid_modulus"], opt["solid_density"]
    solution = Solution(gas, Solid(K, 0.0, density, 1.0), HIGH)
    solid = ElasticSolid(K / 4, K / 2, 0.0, density, 1.0, p_ref=LOW.p)

    def in_gas(X: np.ndarray, Y: np.ndarray, t: float = 0.0) -> Fields:
        rho, v, T = solution.in_gas(Y, t)
        return rho, 0.0 * v, v, T

    def in_solid(X: np.ndarray, Y: np.ndarray, t: float = 0.0) -> Fields:
        v, _, T, y = solution.in_solid(Y, t)
        return 0.0 * v, v, T, X, y

    return layers(
        Layer("gas", gas, (0.0, 1.0), in_gas, exact=in_gas),
        Layer("layer", solid, (1.0, 2.0), in_solid, exact=in_solid),
        along=((0.0, opt["tube_width"]),),
        lower=Slip(),
        upper=Clamped(),
        h=opt["fsi_h"],
        order=opt["fsi_order"],
        notes=solution.notes(),
        units="none",
    )
