"""A shock tube with viscosity: the shock comes back through the boundary layer that it has left.

Gas of density 120 and 1.2 at the same temperature, at rest on both sides of X = 1/2, in a unit box
with adiabatic walls that the gas sticks to; the lower half, with a plane of symmetry above. p =
rho/gamma, so the speed of sound is 1 on both sides; viscosity 1/Re, Prandtl number 0.73 (V. Daru,
C. Tenaud, Comput. Fluids 30 (2001) 89; 38 (2009) 664). The run ends at t = 1.
"""

import numpy as np

from fsipetsc import BlockProblem, Fluid, Option
from fsipetsc.blocks.conditions import NoSlip, Slip
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases.common import SHOCKS, Opt, stack

OPTIONS = (Option("tube_reynolds", float, 200.0, "", "Reynolds number", check="positive"),)
DEFAULTS = {"fsi_h": 1 / 100, "ts_max_time": 1.0, "fsi_output_dt": 0.1, **SHOCKS}
GAMMA, PRANDTL, RHO, RATIO = 1.4, 0.73, 1.2, 100.0


def build(opt: Opt) -> BlockProblem:
    """The layer is the lower half of the box."""
    R, mu = 1.0 / GAMMA, 1.0 / opt["tube_reynolds"]
    gas = Fluid(mu, GAMMA / (GAMMA - 1.0) * R * mu / PRANDTL, GAMMA, R)

    def start(X, Y):
        """A node in the middle has half of the jump."""
        step = 0.5 * (1.0 + np.sign(np.round(X - 0.5, 9)))
        return RHO * (RATIO * (1.0 - step) + step), 0.0 * X, 0.0 * X, 1.0 + 0.0 * X

    half = Layer("gas", gas, (0.0, 0.5), start, sides=NoSlip())
    return stack(opt, half, along=((0.0, 1.0),), lower=NoSlip(), upper=Slip())
