"""A pressure pulse under an elastic plate: gas | plate, a wall below, the ambient pressure above.

The pulse spreads, bends the plate upwards, and comes back from the wall. With blast_kind shock
it is a disc of one pressure, which sends a shock out from the start: that needs -fsi_shock and
-fsi_dissipation. The plate is held at its sides against X alone, so these are planes of symmetry.
"""

import numpy as np

from fsipetsc import BlockProblem, Option
from fsipetsc.blocks.conditions import Free, NoSlip, Roller, Slip
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases.common import (
    Opt,
    at_rest,
    elastic_of,
    gas_of,
    materials,
    pressure_pulse,
    stack,
)

OPTIONS = (
    *materials(fluid_mu=0.002, fluid_kappa=0.003, solid_density=5.0, solid_modulus=40.0),
    *materials(solid_law=("log", "neo-hookean", "svk")),
    Option("blast_kind", str, "pulse", "", "smooth, or a disc with a jump", ("pulse", "shock")),
    Option("blast_height", float, 1.0, "Pa", "overpressure; else p is 1", check="nonnegative"),
)
DEFAULTS = {"fsi_h": 0.03125, "ts_max_time": 2.0, "fsi_output_dt": 0.05}
#: of the pulse [m]
WIDTH = 0.15


def build(opt: Opt) -> BlockProblem:
    """The gas between Y = 0 and 1, the plate above it, free of stress under the pressure 1."""
    gas = gas_of(opt)
    plate = elastic_of(opt, kappa_e=0.01, law=opt["solid_law"], heat="coupled")
    pulse = pressure_pulse(gas, opt["blast_height"], 0.5, 0.5, WIDTH)

    def disc(X, Y):
        """The disc is twice as hot as what is around it."""
        inside = ((X - 0.5) ** 2 + (Y - 0.5) ** 2) / WIDTH**2 < 1.0
        p, T = np.where(inside, 1.0 + opt["blast_height"], 1.0), np.where(inside, 2.0, 1.0)
        return [p / T, 0.0 * X, 0.0 * X, T]

    start = disc if opt["blast_kind"] == "shock" else pulse
    return stack(
        opt,
        Layer("gas", gas, (0.0, 1.0), start, sides=Slip()),
        Layer("plate", plate, (1.0, 1.25), at_rest(), sides=Roller()),
        along=((0.0, 1.0),),
        lower=NoSlip(),
        upper=Free(1.0),
    )
