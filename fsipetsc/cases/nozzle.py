"""A shock runs through an elastic nozzle, around an axis: gas inside, the wall, gas around it.

X is the place along the axis, Y the distance from it. The wall is clamped at both ends and wide at
these; the shock is reflected where it narrows, and what passes makes the wall swell. The gas before
the shock has density 1.4 and pressure 1, so the unit of velocity is its speed of sound.
"""

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Centre, Clamped, Outflow, Slip
from fsipetsc.blocks.maps import Map, off_axis
from fsipetsc.cases.common import SHOCKS, Opt, at_rest, beside_gas, constant, elastic_of, gas_of
from fsipetsc.cases.riemann import GasState, shock_in_plane
from fsipetsc.checks import Array
from fsipetsc.operators.sbp import operator
from fsipetsc.options import Option, above_one

OPTIONS = (
    Option("nozzle_mach", float, 1.5, "", "Mach number of the shock", check=above_one),
    *beside_gas(60.0),
)
DEFAULTS = {"fsi_h": 1 / 24, "ts_max_time": 2.5, "fsi_output_dt": 0.05, **SHOCKS}

AHEAD = GasState(1.4, 0.0, 1.0)
#: of the nozzle; radii at its ends and in the throat; thickness of the wall; radius of the vessel
LENGTH, WIDE, THROAT, THICKNESS, VESSEL = 3.0, 0.5, 0.3, 0.12, 1.2
#: where the shock is at first
START = 0.2


def radius(z: Array) -> Array:
    """Return the radius of the wall's inner side [m]."""
    return WIDE - (WIDE - THROAT) * np.sin(np.pi * z / LENGTH) ** 4


def between(low: float, high: float) -> Map:
    """From so far beyond the inner side of the wall to so far; high = 0: to the vessel."""

    def places(xi):
        z = LENGTH * xi[0]
        inner, outer = radius(z) + low, radius(z) + high if high else VESSEL
        return z, (1.0 - xi[1]) * inner + xi[1] * outer

    return places


def build(opt: Opt) -> BlockProblem:
    """Axis 0 of the blocks is along the axis, axis 1 away from it."""
    gas = gas_of(opt, R=AHEAD.p / AHEAD.rho)
    wall = elastic_of(opt, AHEAD.p, AHEAD.rho, law="neo-hookean")
    flow, inflow, _ = shock_in_plane(gas, AHEAD, opt["nozzle_mach"], START)
    least = operator(opt["fsi_order"]).min_points - 1
    widths = LENGTH, WIDE, THICKNESS, VESSEL - WIDE - THICKNESS
    along, inside, across, around = (max(round(w / opt["fsi_h"]), least) for w in widths)
    still = constant(AHEAD.rho, 0.0, 0.0, 1.0)
    core = off_axis(lambda xi: (LENGTH * xi[0], xi[1] * radius(LENGTH * xi[0])), inside)
    blocks = (
        Block("inside", gas, core, (along, inside), flow),
        Block("wall", wall, between(0.0, THICKNESS), (along, across), at_rest()),
        Block("around", gas, between(THICKNESS, 0.0), (along, around), still),
    )
    faces = {("inside", 1, 0): Centre(), ("around", 1, 1): Slip()}
    faces |= {("inside", 0, 0): inflow, ("inside", 0, 1): Outflow(AHEAD.p)}
    for side in (0, 1):
        faces |= {("wall", 0, side): Clamped(), ("around", 0, side): Slip()}
    return BlockProblem(blocks, faces, units="none", symmetry=1)
