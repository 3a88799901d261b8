"""A shock runs over a cylinder in a channel: an elastic one that flies, or a rigid one.

The cylinder has radius 0.5 and is at the origin; the gas before the shock has density 1.4 and
pressure 1, so the unit of velocity is its speed of sound. Four blocks of gas go from the circle
to the four sides of the channel, four of the solid from a square centre block to the circle.
"""

import numpy as np

from fsipetsc import Block, BlockProblem, Option
from fsipetsc.blocks.conditions import Outflow, Slip
from fsipetsc.blocks.maps import Map
from fsipetsc.cases.common import SHOCKS, Opt, at_rest, beside_gas, cells_of, elastic_of, gas_of
from fsipetsc.cases.disk import between, centre, quarter
from fsipetsc.cases.riemann import GasState, shock_in_plane
from fsipetsc.options import above_one

OPTIONS = (
    Option("cylinder_mach", float, 2.0, "", "Mach number of the shock", check=above_one),
    Option("cylinder_wall", str, "elastic", "", "what the cylinder is", ("rigid", "elastic")),
    *beside_gas(40.0),
)
DEFAULTS = {"fsi_h": 1 / 32, "ts_max_time": 2.0, "fsi_output_dt": 0.05, **SHOCKS}

AHEAD = GasState(1.4, 0.0, 1.0)
RADIUS, CORE, START = 0.5, 0.22, -1.0
#: corners of the channel, that of quarter q and the next: right, upper, left, lower side
CORNERS = np.array([(2.5, -1.5), (2.5, 1.5), (-1.5, 1.5), (-1.5, -1.5)])


def in_gas(q: int) -> Map:
    """From the circle to a side of the channel; quarter 0 is on the right, 1 above."""

    def places(xi):
        angle = np.pi / 4 * (2.0 * xi[1] - 1.0 + 2.0 * q)
        circle = RADIUS * np.cos(angle), RADIUS * np.sin(angle)
        ends = zip(CORNERS[q], CORNERS[(q + 1) % 4])
        return between(xi[0], circle, tuple((1 - xi[1]) * a + xi[1] * b for a, b in ends))

    return places


def build(opt: Opt) -> BlockProblem:
    """Axis 0 of the blocks around goes outwards, axis 1 around."""
    gas = gas_of(opt, R=AHEAD.p / AHEAD.rho)
    solid = elastic_of(opt, AHEAD.p, AHEAD.rho, law="neo-hookean")
    flow, inflow, _ = shock_in_plane(gas, AHEAD, opt["cylinder_mach"], START)
    lengths = np.pi / 2 * RADIUS, RADIUS - CORE, 1.25
    around, within, outside = (cells_of(opt, length) for length in lengths)
    sides = Outflow(AHEAD.p), Slip(name="ceiling"), inflow, Slip(name="floor")
    elastic, rest = opt["cylinder_wall"] == "elastic", at_rest()
    blocks = [Block("core", solid, centre(CORE), (around, around), rest)] if elastic else []
    faces = {}
    for q, side in enumerate(sides):
        name = f"gas {q + 1}"
        if elastic:
            map = quarter(q, RADIUS, CORE)
            blocks.append(Block(f"solid {q + 1}", solid, map, (within, around), rest))
        else:
            faces[name, 0, 0] = Slip(name="cylinder")
        blocks.append(Block(name, gas, in_gas(q), (outside, around), flow))
        faces[name, 0, 1] = side
    return BlockProblem(tuple(blocks), faces, units="none")
