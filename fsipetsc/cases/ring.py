"""An elastic ring with gas inside and outside, in two dimensions: gas | ring | gas, around a core.

The gas reaches from a rigid core to a rigid vessel. It slips along both and along the ring where it
has no viscosity. All begins at rest but for a pulse of pressure in the gas inside. The ring is free
of stress under the pressure of the gas. Its small motions are known exactly: see the command
`modes`.
"""

import numpy as np

from fsipetsc import Block, BlockProblem, Option
from fsipetsc.blocks.conditions import Free
from fsipetsc.blocks.maps import annulus
from fsipetsc.cases import common
from fsipetsc.cases.common import Opt, cells_of, elastic_of, gas_of, materials

OPTIONS = (
    Option("ring_gas", bool, True, "", "gas inside and outside; else the ring is in a vacuum"),
    Option("ring_pulse", float, 0.5, "Pa", "overpressure; else p is 1", check="nonnegative"),
    Option("ring_around", int, None, "", "cells around; default: by -fsi_h", check="positive"),
    *materials(fluid_mu=0.0, fluid_kappa=0.0, solid_density=2.0),
    *materials(solid_mu=1.0, solid_lambda=1.5, solid_law=("neo-hookean", "log", "svk")),
)
DEFAULTS = {"fsi_h": 0.025, "fsi_order": 6, "ts_max_time": 3.0, "fsi_output_dt": 0.05}

#: radii [m] of the core, of the ring, of the vessel
CORE, INNER, OUTER, VESSEL = 0.4, 1.0, 1.3, 2.0
#: where the pulse is, and how wide [m]
MIDDLE, WIDTH = 0.7, 0.2


def build(opt: Opt) -> BlockProblem:
    """Axes of the blocks run outwards and around."""
    around = opt["ring_around"] or max(24, 8 * round(2.0 * np.pi * INNER / (32.0 * opt["fsi_h"])))
    gas = gas_of(opt)
    solid = elastic_of(opt, 1.0 if opt["ring_gas"] else 0.0, law=opt["solid_law"])

    def block(name, material, inner, outer, initial):
        shape = annulus(inner, outer), (cells_of(opt, outer - inner), around)
        return Block(name, material, *shape, initial, periodic=(False, True))

    blocks = (block("ring", solid, INNER, OUTER, common.at_rest()),)
    faces = {("ring", 0, 0): Free(), ("ring", 0, 1): Free()}
    if opt["ring_gas"]:
        still = common.constant(1.0, 0.0, 0.0, 1.0)
        pulse = common.pressure_pulse(gas, opt["ring_pulse"], MIDDLE, 0.0, WIDTH)
        inside = block("inside", gas, CORE, INNER, pulse)
        blocks = (inside, *blocks, block("outside", gas, OUTER, VESSEL, still))
        faces = {("inside", 0, 0): common.wall_for(gas), ("outside", 0, 1): common.wall_for(gas)}
    return BlockProblem(blocks, faces, units="none")
