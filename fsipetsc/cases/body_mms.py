"""A manufactured solution around a body, on curved, joined blocks that move, in two dimensions.

disk: a disk of five blocks in a square box of gas of four, axes turned against each other; three
blocks meet at corners. ring: gas | ring | gas, O-grids. With D a displacement, X material places
and labels of the gas,

    x = X + D(X, t),    D = .06 (sin(1.9 X + .7 Y + t), cos(1.3 X - 1.7 Y + 2t))
    velocity of the gas   u = D_t + b (.3 sin(1.4 X - .6 Y - t), .2 cos(.9 X + 1.5 Y + 2t))
    temperature of both   T = 1 + .15 sin(1.6 X - 1.1 Y + t)
    density of the gas    rho = 1 + .2 cos(1.2 X + 1.7 Y - t)

b = product of (R^2 - a^2)/(R^2 + a^2) over the radii a of interfaces. The grid of the gas is
blended along rays, so that its nodes have other labels at each time: X + D(X, t) is solved for X.
All unknowns are given on the outer walls, which move, too. See fsipetsc.cases.manufactured.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import Condition, Given
from fsipetsc.blocks.maps import Map, Mapped, Places, annulus
from fsipetsc.blocks.problem import BlockProblem, FaceName
from fsipetsc.cases.common import Opt, material_options
from fsipetsc.cases.disk import between, centre, quarter
from fsipetsc.cases.manufactured import QUARTER, TIME, Solution, Waves, cofactor, determinant, unit
from fsipetsc.checks import Array, Fields
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.options import Option

NAME = "body_mms"
SUMMARY = "a disk or a ring in gas on curved, joined blocks, a manufactured solution"

OPTIONS = (
    Option("body_shape", str, "disk", "", "nine blocks, or three rings", ("disk", "ring")),
    *material_options(fluid_mu=0.02, fluid_kappa=0.03, solid_kappa=0.05),
    *material_options(solid_law=("svk", "neo-hookean", "log", "linear")),
)
DEFAULTS = {"fsi_h": 1 / 16, "fsi_order": 4, "ts_max_time": 0.1, "fsi_output_dt": 0.1}

#: options in the order that the solution has them
MATERIALS = "fluid_mu", "fluid_kappa", "solid_kappa", "solid_law"
#: half the side of the box and of the block in the middle of the disk; radii of the rings
BOX, HALF, RINGS = 2.0, 0.45, (0.5, 1.0, 1.3, 2.0)
#: that solve X + D(X, t) = x to round-off
NEWTON_STEPS = 5


def phase(x: float, y: float, t: float, quarters: int = 0) -> Array:
    """Phase of cos(x X + y Y + t time); with quarters = 1 of the sine."""
    return np.array([x, 0, y, 0, 0]) + t * TIME - quarters * QUARTER


@dataclass(frozen=True)
class Around(Solution):
    """The solution around interfaces of these radii; gas inside the first one of two."""

    radii: tuple[float, ...] = (1.0,)

    def __post_init__(self) -> None:
        D = (0.06, phase(1.9, 0.7, 1.0, 1)), (0.06, phase(1.3, -1.7, 2.0))
        drift = (0.3, phase(1.4, -0.6, -1.0, 1)), (0.2, phase(0.9, 1.5, 2.0))
        T, rho = (1.0, [(0.15, phase(1.6, -1.1, 1.0, 1))]), (1.0, [(0.2, phase(1.2, 1.7, -1.0))])
        object.__setattr__(self, "displacement", Waves(*((0.0, [wave]) for wave in D)))
        object.__setattr__(self, "temperature", Waves(T))
        object.__setattr__(self, "of_gas", Waves(rho, *((0.0, [wave]) for wave in drift), T))

    def grid(self, where: Any) -> tuple[Array, Array, Array]:
        """x_X, w and w_X at labels, without eta: all gas moves with D."""
        D = self.displacement.at(where)
        return D.gradient + unit(D.gradient), D.rate, D.gradient_rate

    def bubble(self, where: Any) -> tuple[Array, Array]:
        """b and its gradient."""
        R, slope = where[0] ** 2 + where[1] ** 2, 0.0
        found = 1.0 + 0.0 * R
        for a in (radius**2 for radius in self.radii):
            b = (R - a) / (R + a)
            found, slope = found * b, slope * b + found * 2.0 * a / (R + a) ** 2
        return found, 2.0 * slope * np.stack(where[:2])

    def labels(self, X: Array, Y: Array, t: float) -> Fields:
        """Of nodes of the gas's grid, which is blended between walls and interfaces."""
        R, (first, last), inside = np.hypot(X, Y), (self.radii[0], self.radii[-1]), 0.0
        if len(self.radii) == 1:
            outer = BOX * R / np.maximum(abs(X), abs(Y))
        else:
            inside, outer = R <= first * (1.0 + 1e-12), RINGS[-1]
        low, high = np.where(inside, RINGS[0], last), np.where(inside, first, outer)
        s, x = (R - low) / (high - low), np.stack([X, Y])
        for weight, radius in ((1.0 - s, low), (s, high)):
            x = x + weight * self.displacement.at((X * radius / R, Y * radius / R, t)).value
        found = np.stack([X, Y])
        for _ in range(NEWTON_STEPS):
            D = self.displacement.at((*found, t))
            F, apart = D.gradient + unit(D.gradient), found + D.value - x
            found = found - np.einsum("ki...,k...->i...", cofactor(F), apart) / determinant(F)
        return tuple(found)

    def exact_gas(self, *where: Any) -> list[Array]:
        """At a node of the grid."""
        return super().exact_gas(*self.labels(*where), where[-1])

    def force_gas(self, *where: Any) -> list[Array]:
        """At a node of the grid."""
        return super().force_gas(*self.labels(*where), where[-1])

    def supplied(self, *where: Any) -> list[Array]:
        """The normal goes from the gas to the solid."""
        R = np.hypot(*where[:2])
        inner = len(self.radii) > 1 and R < 0.5 * sum(self.radii)
        return self.jump(where, np.where(inner, 1.0, -1.0) * np.stack(where[:2]) / R)


def turned(map: Map, times: int) -> Mapped:
    """The same places with the logical axes turned by so many right angles."""

    def places(xi: Places) -> Places:
        for _ in range(times):
            xi = xi[1], 1.0 - xi[0]
        return map(xi)

    return Mapped(places, 2)


def to_box(q: int) -> Map:
    """From the circle to a side of the box along rays."""

    def places(xi: Places) -> Places:
        angle, turn = np.pi / 4 * (2.0 * xi[1] - 1.0), np.pi / 2 * q
        side = BOX + 0.0 * angle, BOX * np.tan(angle)
        x, y = between(xi[0], (np.cos(angle), np.sin(angle)), side)
        return np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y

    return places


def build(opt: Opt) -> BlockProblem:
    """-fsi_h: of the side of each block, which is 1 in logical coordinates; a ring has four times
    as many cells around.
    """
    of_materials, disk = (opt[name] for name in MATERIALS), opt["body_shape"] == "disk"
    exact = Around(2, *of_materials, radii=(1.0,) if disk else RINGS[1:3])
    numbers = exact.mu_e, exact.lambda_e, exact.kappa_e, exact.m0, exact.alpha
    gas = Fluid(exact.mu, exact.kappa, exact.gamma, exact.R), exact.exact_gas, exact.force_gas
    solid = ElasticSolid(*numbers, law=exact.law), exact.exact_solid, exact.force_solid
    walls: Any = {"x": lambda *at: solid[1](*at)[3:], "velocity": lambda *at: solid[1](*at)[:2]}
    given = Given(exact.exact_gas, **walls)

    def block(name: str, map: Map, around: int = 1) -> Block:
        material, of, forcing = gas if name.startswith("gas") else solid
        n, more = round(1.0 / opt["fsi_h"]), {"exact": of, "periodic": (False, around > 1)}
        of_map = map, (n, around * n), lambda *X: of(*X, 0.0)
        return Block(name, material, *of_map, forcing=forcing, **more)

    faces: dict[FaceName, Condition]
    if disk:
        sides = (0, 1), (1, 1), (0, 0), (1, 0)  # of a block turned so often
        faces = {(f"gas {q}", *side): given for q, side in enumerate(sides)}
        blocks = [block("middle", centre(HALF))]
        for q in range(4):
            blocks.append(block(f"disk {q}", turned(quarter(q, 1.0, HALF), q + 1)))
            blocks.append(block(f"gas {q}", turned(to_box(q), q)))
    else:
        faces = {("gas inside", 0, 0): given, ("gas outside", 0, 1): given}
        rings = zip(("gas inside", "ring", "gas outside"), RINGS, RINGS[1:])
        blocks = [block(name, annulus(*radii), 4) for name, *radii in rings]
    return BlockProblem(tuple(blocks), faces, jumps=exact.supplied, units="none")
