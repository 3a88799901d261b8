"""A shock runs over a cylinder in a channel: an elastic one that flies, or a rigid one.

The cylinder has radius 0.5 and is at the origin; the gas before the shock has density 1.4 and
pressure 1, so the unit of velocity is its speed of sound. Four blocks of gas go from the circle
to the four sides of the channel, four of the solid from a square centre block to the circle. All
corners of blocks in the solid are points where three blocks meet.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import Condition, Open, Outflow, Slip
from fsipetsc.blocks.maps import Map, Mapped, Places
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.cases.riemann import GasState, behind_shock
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.operators.sbp import operator
from fsipetsc.options import Option, above_one

NAME = "cylinder"
SUMMARY = "a shock runs over an elastic or a rigid cylinder, in two dimensions"

OPTIONS = (
    Option("cylinder_mach", float, 2.0, "", "Mach number of the shock", check=above_one),
    Option("cylinder_wall", str, "elastic", "", "what the cylinder is", ("rigid", "elastic")),
    Option("solid_modulus", float, 40.0, "", "2 mu_e + lambda_e over p", check="positive"),
    Option("solid_density", float, 10.0, "", "of it over that of the gas", check="positive"),
)
DEFAULTS = {
    **{"fsi_h": 1 / 32, "fsi_order": 4, "ts_max_time": 2.0, "fsi_output_dt": 0.05},
    **{"fsi_shock": 1.0, "fsi_dissipation": 1.0},
}

AHEAD, GAMMA = GasState(1.4, 0.0, 1.0), 1.4
RADIUS, CORE, START = 0.5, 0.22, -1.0
#: corners of the channel, that of quarter q and the next: right, upper, left, lower side
CORNERS = np.array([(2.5, -1.5), (2.5, 1.5), (-1.5, 1.5), (-1.5, -1.5)])


def build(opt: Mapping[str, Any]) -> BlockProblem:
    """Axis 0 of the blocks around goes outwards, axis 1 around."""
    gas = Fluid(0.0, 0.0, GAMMA, AHEAD.p / AHEAD.rho)
    K, density = opt["solid_modulus"] * AHEAD.p, opt["solid_density"] * AHEAD.rho
    law = "neo-hookean"
    solid = ElasticSolid(K / 4, K / 2, 0.0, density, 1.0, AHEAD.p, law, heat="elastic")
    behind, _ = behind_shock(gas, AHEAD, opt["cylinder_mach"])
    hot = behind.p / (gas.R * behind.rho)

    def flow(X: np.ndarray, Y: np.ndarray) -> list[np.ndarray]:
        values = (behind.rho, AHEAD.rho), (behind.u, 0.0), (0.0, 0.0), (hot, 1.0)
        return [np.where(X < START, hit, still) for hit, still in values]

    def rest(X: np.ndarray, Y: np.ndarray) -> list[np.ndarray]:
        return [0.0 * X, 0.0 * X, np.ones_like(X), X, Y]

    least, h = operator(opt["fsi_order"]).min_points - 1, opt["fsi_h"]
    around, within, outside = (
        max(round(length / h), least) for length in (np.pi / 2 * RADIUS, RADIUS - CORE, 1.25)
    )
    inflow = Open(behind.rho, (behind.u, 0.0), hot)
    sides = Outflow(AHEAD.p), Slip(name="ceiling"), inflow, Slip(name="floor")
    elastic = opt["cylinder_wall"] == "elastic"
    blocks = [Block("core", solid, Mapped(core, 2), (around, around), rest)] if elastic else []
    faces: dict[tuple[str, int, int], Condition] = {}
    for q, side in enumerate(sides):
        if elastic:
            blocks.append(Block(f"solid {q + 1}", solid, in_solid(q), (within, around), rest))
        else:
            faces[f"gas {q + 1}", 0, 0] = Slip(name="cylinder")
        blocks.append(Block(f"gas {q + 1}", gas, in_gas(q), (outside, around), flow))
        faces[f"gas {q + 1}", 0, 1] = side
    return BlockProblem(tuple(blocks), faces, units="none")


def core(xi: Places) -> Places:
    """A square whose sides are bent outwards."""
    x, y = (2.0 * s - 1.0 for s in xi)
    return CORE * x * (1.25 - 0.125 * y * y), CORE * y * (1.25 - 0.125 * x * x)


def in_solid(q: int) -> Map:
    """From the core to the circle; quarter 0 is on the right, 1 above."""

    def places(xi: Places) -> Places:
        c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[q]
        x, y = core((1.0 + 0.0 * xi[1], xi[1]))
        return between(xi[0], (c * x - s * y, s * x + c * y), circle(q, xi[1]))

    return Mapped(places, 2)


def in_gas(q: int) -> Map:
    """From the circle to a side of the channel."""

    def places(xi: Places) -> Places:
        ends = zip(CORNERS[q], CORNERS[(q + 1) % 4])
        return between(xi[0], circle(q, xi[1]), tuple((1 - xi[1]) * a + xi[1] * b for a, b in ends))

    return Mapped(places, 2)


def circle(q: int, along: np.ndarray) -> Places:
    """The arc of quarter q."""
    angle = np.pi / 4 * (2.0 * along - 1.0 + 2.0 * q)
    return RADIUS * np.cos(angle), RADIUS * np.sin(angle)


def between(s: np.ndarray, inner: Places, outer: Places) -> Places:
    """Straight from one curve to the other."""
    x, y = ((1.0 - s) * a + s * b for a, b in zip(inner, outer))
    return x, y
