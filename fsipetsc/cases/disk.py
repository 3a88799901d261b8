"""A disk of St. Venant and Kirchhoff's solid that spins in gas, in two dimensions.

The disk is five blocks, one in the middle and four around it; three of them meet at each corner of
that in the middle. Four blocks of gas go on to a round vessel. At the start the disk spins as a
rigid body and is free of stress under the pressure of the gas, so it widens and swings; a gas with
viscosity is carried along. With -disk_power the edge is at rest at first, and the motion is smooth:
verify/disk.py solves it in the radius alone. The grid of the gas is wound up with the disk: a run
must end well before half a turn.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import NoSlip, Slip
from fsipetsc.blocks.maps import Places, annulus
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.cases.materials import elastic_of, gas_of
from fsipetsc.checks import Fields
from fsipetsc.options import Option

NAME = "disk"
SUMMARY = "an elastic disk of five blocks that spins in gas"

OPTIONS = (
    Option("disk_spin", float, 0.8, "1/s", "angular velocity of the disk at the start"),
    Option("disk_power", int, 0, "", "spin is times (1 - R^2)^power", check="nonnegative"),
    Option("fluid_mu", float, 0.0, "Pa s", "viscosity; 0: the gas slips", check="nonnegative"),
    Option("fluid_kappa", float, 0.0, "W/(m K)", "conductivity of the gas", check="nonnegative"),
    Option("solid_density", float, 2.0, "kg/m3", "density of the disk", check="positive"),
    Option("solid_mu", float, 1.0, "Pa", "mu_e of the disk", check="positive"),
    Option("solid_lambda", float, 1.5, "Pa", "lambda_e of the disk", check="nonnegative"),
)
DEFAULTS = {"fsi_h": 0.05, "fsi_order": 4, "ts_max_time": 1.25, "fsi_output_dt": 0.025}

#: radii [m] of the disk and of the vessel
RADIUS, VESSEL = 1.0, 2.2
#: half the side of the square of the block in the middle, before it bulges [m], and by how much
HALF, BULGE = 0.45, 0.25


def middle(xi: Places) -> Places:
    """The block in the middle: a square whose sides bulge."""
    s, t = (2.0 * x - 1.0 for x in xi)
    wider = [1.0 + BULGE * (1.0 - across**2 / 2.0) for across in (t, s)]
    return HALF * s * wider[0], HALF * t * wider[1]


def side(quarter: int) -> Any:
    """The map of a block between the middle and the edge of the disk; axes: outwards, around."""
    c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarter]

    def places(xi: Places) -> Places:
        inner, angle = middle((1.0 + 0.0 * xi[0], xi[1])), np.pi / 4.0 * (2.0 * xi[1] - 1.0)
        outer = RADIUS * np.cos(angle), RADIUS * np.sin(angle)
        x, y = ((1.0 - xi[0]) * a + xi[0] * b for a, b in zip(inner, outer))
        return c * x - s * y, s * x + c * y

    return places


def build(opt: Mapping[str, Any]) -> BlockProblem:
    """The disk and the gas around it."""
    gas, solid = gas_of(opt), elastic_of(opt, law="svk")

    def cells(length: float) -> int:
        return max(2 * opt["fsi_order"], round(length / opt["fsi_h"]))  # the operators want these

    def spinning(X: np.ndarray, Y: np.ndarray) -> Fields:
        # 1 - R^2 is round-off at the edge, and below 0 there
        spin = opt["disk_spin"] * np.abs(1.0 - X * X - Y * Y) ** opt["disk_power"]
        return -spin * Y, spin * X, 1.0 + 0.0 * X, X, Y

    def still(X: np.ndarray, Y: np.ndarray) -> Fields:
        return 1.0 + 0.0 * X, 0.0 * X, 0.0 * X, 1.0 + 0.0 * X

    around, across = cells(2.0 * HALF), cells(RADIUS - HALF)
    blocks = [Block("middle", solid, middle, (around, around), spinning)]
    for k, name in enumerate(("right", "top", "left", "bottom")):
        angles = np.pi / 4.0 * (2.0 * k - 1.0), np.pi / 4.0 * (2.0 * k + 1.0)
        ring = annulus(RADIUS, VESSEL, angles)
        blocks += [
            Block(f"disk {name}", solid, side(k), (across, around), spinning),
            Block(f"gas {name}", gas, ring, (cells(VESSEL - RADIUS), around), still),
        ]
    wall = NoSlip() if gas.mu > 0 else Slip()
    faces = {(block.name, 0, 1): wall for block in blocks if block.kind == "fluid"}
    return BlockProblem(tuple(blocks), faces, units="none")
