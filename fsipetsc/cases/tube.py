"""A shock tube, Sod's, in a plane: along X, across Y, or across Y into an elastic layer.

Along X and across Y the gas of high pressure is on the left, or below; halfway the gas of low
pressure begins. Walls all around let it slip, so that what is computed of one is that of the
other with X and Y exchanged. `elastic` has an elastic layer in the place of the upper half, as
the case `shock` has a rod, and is periodic along X. The exact solution is that of
fsipetsc.cases.riemann: where nothing varies along X the law `log` is that of the rod.
"""

from collections.abc import Callable

import numpy as np

from fsipetsc import BlockProblem, Fluid, Option, Solid
from fsipetsc.blocks.conditions import Clamped, Slip
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases.common import SHOCKS, Opt, materials, stack
from fsipetsc.cases.riemann import GasState, GasWave, pressure_between
from fsipetsc.cases.shock import DENSE, GAMMA, LOW, R, Solution
from fsipetsc.checks import Array
from fsipetsc.materials.solid import ElasticSolid

OPTIONS = (
    Option("tube_problem", str, "elastic", "", "along X, Y, into a layer", ("x", "y", "elastic")),
    *materials(solid_modulus=4.0, solid_density=0.5),
)
DEFAULTS = {"fsi_h": 0.01, "ts_max_time": 0.15, "fsi_output_dt": 0.05, "fsi_norm": "L1", **SHOCKS}
#: the gas of high pressure in Sod's problem; width of the tube, which is 1 or 2 long
HIGH, WIDTH = GasState(DENSE, 0.0, 1.0), 0.25


def sod(gas: Fluid) -> Callable[[Array, float], tuple[Array, ...]]:
    """(rho, u, T) at (x, t) of Sod's problem between two halves of a gas, split at x = 0.

    What goes to the right is what goes to the left, seen in a mirror.
    """
    left, right = GasWave(gas, HIGH), GasWave(gas, LOW)
    p = pressure_between(left.velocity, lambda p: -right.velocity(p))
    interface = left.velocity(p)

    def at(x, t):
        here, there = left.at(p, x, t), right.at(p, -x, t)
        both = zip(here, (there.rho, -there.u, there.p), strict=True)
        rho, u, p_at = (np.where(x < interface * t, a, b) for a, b in both)
        return rho, u, p_at / (rho * gas.R)

    return at


def build(opt: Opt) -> BlockProblem:
    """The gas from 0 to 1, the layer from 1 to 2."""
    gas = Fluid(0.0, 0.0, GAMMA, R)
    if opt["tube_problem"] != "elastic":
        along, tube = opt["tube_problem"] == "x", sod(gas)
        length, height = (1.0, WIDTH) if along else (WIDTH, 1.0)

        def exact(X, Y, t=0.0):
            rho, u, T = tube((X if along else Y) - 0.5, t)
            return (rho, u, 0.0 * u, T) if along else (rho, 0.0 * u, u, T)

        alone = Layer("gas", gas, (0.0, height), exact, sides=Slip(), exact=exact)
        return stack(opt, alone, along=((0.0, length),), lower=Slip(), upper=Slip())
    rod = Solid(opt["solid_modulus"], 0.0, opt["solid_density"], 1.0)
    solution = Solution(gas, rod, HIGH)
    layer = ElasticSolid(rod.K / 4, rod.K / 2, 0.0, rod.m0, 1.0, p_ref=LOW.p)

    def in_gas(X, Y, t=0.0):
        rho, v, T = solution.in_gas(Y, t)
        return rho, 0.0 * v, v, T

    def in_solid(X, Y, t=0.0):
        v, _, T, y = solution.in_solid(Y, t)
        return 0.0 * v, v, T, X, y

    return stack(
        opt,
        Layer("gas", gas, (0.0, 1.0), in_gas, exact=in_gas),
        Layer("layer", layer, (1.0, 2.0), in_solid, exact=in_solid),
        along=((0.0, WIDTH),),
        lower=Slip(),
        upper=Clamped(),
        notes=solution.notes(),
    )
