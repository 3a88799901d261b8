"""A disk of St. Venant and Kirchhoff's solid that spins in gas, in two dimensions.

The disk is five blocks, one in the middle and four around it; three of them meet at each corner of
that in the middle. Four blocks of gas go on to a round vessel. At the start the disk spins as a
rigid body and is free of stress under the pressure of the gas, so it widens and swings; a gas with
viscosity is carried along. With -disk_power the edge is at rest at first, and the motion is smooth:
verify/disk.py solves it in the radius alone. The grid of the gas is wound up with the disk: a run
must end well before half a turn.
"""

import numpy as np

from fsipetsc import Block, BlockProblem, Option
from fsipetsc.blocks.maps import Map, Places, annulus
from fsipetsc.cases.common import Opt, cells_of, constant, elastic_of, gas_of, materials, wall_for
from fsipetsc.checks import Array

OPTIONS = (
    Option("disk_spin", float, 0.8, "1/s", "angular velocity of the disk at the start"),
    Option("disk_power", int, 0, "", "p of the factor (1 - R^2)^p of spin", check="nonnegative"),
    *materials(fluid_mu=0.0, fluid_kappa=0.0, solid_density=2.0, solid_mu=1.0, solid_lambda=1.5),
)
DEFAULTS = {"fsi_h": 0.05, "ts_max_time": 1.25, "fsi_output_dt": 0.025}

#: radii [m] of the disk and of the vessel, half the side of the block in the middle
RADIUS, VESSEL, HALF = 1.0, 2.2, 0.45


def centre(half: float) -> Map:
    """The block in the middle of a disk: a square, whose sides, twice ``half``, bulge."""

    def places(xi):
        s, t = (2.0 * x - 1.0 for x in xi)
        wider = [1.0 + 0.25 * (1.0 - across**2 / 2.0) for across in (t, s)]
        return half * s * wider[0], half * t * wider[1]

    return places


def quarter(q: int, radius: float, half: float) -> Map:
    """A block between the one in the middle and the edge; axes: outwards, around. 0: right, 1: top
    …"""
    c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[q]

    def places(xi):
        inner, angle = centre(half)((1.0 + 0.0 * xi[0], xi[1])), np.pi / 4.0 * (2.0 * xi[1] - 1.0)
        x, y = between(xi[0], inner, (radius * np.cos(angle), radius * np.sin(angle)))
        return c * x - s * y, s * x + c * y

    return places


def between(s: Array, inner: Places, outer: Places) -> Places:
    """Return places straight from one curve to the other."""
    return tuple((1.0 - s) * a + s * b for a, b in zip(inner, outer))


def build(opt: Opt) -> BlockProblem:
    gas, solid = gas_of(opt), elastic_of(opt, law="svk")

    def spinning(X, Y):
        # 1 - R^2 is round-off at the edge, and below 0 there
        spin = opt["disk_spin"] * np.abs(1.0 - X * X - Y * Y) ** opt["disk_power"]
        return -spin * Y, spin * X, 1.0 + 0.0 * X, X, Y

    around, across = cells_of(opt, 2.0 * HALF), cells_of(opt, RADIUS - HALF)
    outside, still = cells_of(opt, VESSEL - RADIUS), constant(1.0, 0.0, 0.0, 1.0)
    blocks = [Block("middle", solid, centre(HALF), (around, around), spinning)]
    for q, name in enumerate(("right", "top", "left", "bottom")):
        ring = annulus(RADIUS, VESSEL, (np.pi / 4 * (2.0 * q - 1.0), np.pi / 4 * (2.0 * q + 1.0)))
        shape = quarter(q, RADIUS, HALF), (across, around)
        blocks.append(Block(f"disk {name}", solid, *shape, spinning))
        blocks.append(Block(f"gas {name}", gas, ring, (outside, around), still))
    faces = {(block.name, 0, 1): wall_for(gas) for block in blocks if block.kind == "fluid"}
    return BlockProblem(tuple(blocks), faces, units="none")
