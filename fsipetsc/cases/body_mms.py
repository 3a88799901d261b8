"""A manufactured solution around a body, on curved, joined blocks that move, in two dimensions.

disk: a disk of five blocks in a square box of gas of four, axes turned against each other; three
blocks meet at corners. panel: one block on the floor of a channel, held by its foot, five of gas
around it. With D a displacement, X material places and labels of the gas,

    x = X + D(X, t),    D = .06 (sin(1.9 X + .7 Y + t), cos(1.3 X - 1.7 Y + 2t))
    velocity of the gas   u = D_t + b (.3 sin(1.4 X - .6 Y - t), .2 cos(.9 X + 1.5 Y + 2t))
    temperature of both   T = 1 + .15 sin(1.6 X - 1.1 Y + t)
    density of the gas    rho = 1 + .2 cos(1.2 X + 1.7 Y - t)

b is 0 at interfaces: (R^2 - 1)/(R^2 + 1) around the disk of radius 1; at the panel the product of
the distances from its three sides. The grid of the gas is blended between walls and body, so
that its nodes have other labels at each time: X + D(X, t) is solved for X. All unknowns are given
on the outer walls, which move, too. See fsipetsc.cases.box_mms.
"""

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np

from fsipetsc import Block, BlockProblem, Option
from fsipetsc.blocks.block_problem import FaceName
from fsipetsc.blocks.conditions import Given
from fsipetsc.blocks.maps import Map, Places, rectangle
from fsipetsc.cases.box_mms import Solution, gradient, recorded
from fsipetsc.cases.common import Opt, materials
from fsipetsc.cases.disk import centre, quarter
from fsipetsc.checks import Array, Fields
from fsipetsc.equations.tensors import add_unit, apply_transposed, cofactor, determinant
from fsipetsc.equations.vectors import add, along, scale, sub
from fsipetsc.kernels.symbols import derivatives

OPTIONS = (
    Option("body_shape", str, "disk", "", "nine blocks, or six blocks", ("disk", "panel")),
    *materials(fluid_mu=0.02, fluid_kappa=0.03, solid_kappa=0.05),
    *materials(solid_law=("svk", "neo-hookean", "log", "linear")),
)
DEFAULTS = {"fsi_h": 1 / 16, "ts_max_time": 0.1, "fsi_output_dt": 0.1}

#: half the side of the box and of the block in the middle of the disk
BOX, HALF = 2.0, 0.45
#: X and Y of the edges of the blocks around the panel
COLUMNS, ROWS = (0.0, 1.0, 1.3, 2.5), (0.0, 0.7, 1.5)
#: that solve X + D(X, t) = x to round-off
NEWTON_STEPS = 5


class Body(Solution):
    """The solution around a body; grid(X, Y, t): displacements of nodes of the gas's grid, then
    their velocities.
    """

    grid: Callable[..., Fields]

    def __init__(self, opt: Opt) -> None:
        super().__init__(2, opt)
        self.material = recorded(3, lambda *at: self._with_rate(self.displacement(*at), at))
        self._newton = recorded(5, self._nearer)
        self._at_label, self._force_at_label = self.exact_gas, self.force_gas
        self.exact_gas = lambda *at: self._at_label(*self.labels(*at), at[-1])
        self.force_gas = lambda *at: self._force_at_label(*self.labels(*at), at[-1])

    def _with_rate(self, f: Any, at: Any) -> Any:
        return (*f, *derivatives(f, at[-1]))

    def displacement(self, *at: Any) -> Any:
        X, Y, t = at
        return 0.06 * np.sin(1.9 * X + 0.7 * Y + t), 0.06 * np.cos(1.3 * X - 1.7 * Y + 2.0 * t)

    def moved(self, *at: Any) -> Any:
        """The labels of all gas move with D."""
        return self.displacement(*at)

    def T(self, *at: Any) -> Any:
        X, Y, t = at
        return 1.0 + 0.15 * np.sin(1.6 * X - 1.1 * Y + t)

    def rho(self, *at: Any) -> Any:
        X, Y, t = at
        return 1.0 + 0.2 * np.cos(1.2 * X + 1.7 * Y - t)

    def drift(self, *at: Any) -> Any:
        """Return u - D_t, which is 0 at interfaces."""
        X, Y, t = at
        drift = 0.3 * np.sin(1.4 * X - 0.6 * Y - t), 0.2 * np.cos(0.9 * X + 1.5 * Y + 2.0 * t)
        return scale(self.b(X, Y), drift)

    def b(self, X: Any, Y: Any) -> Any:
        raise NotImplementedError

    def _nearer(self, X: Any, Y: Any, t: Any, x: Any, y: Any) -> Any:
        """A step of Newton's from the label (X, Y) to that of the place (x, y)."""
        D = self.displacement(X, Y, t)
        F, apart = add_unit(1.0, gradient(D, (X, Y))), sub(add((X, Y), D), (x, y))
        return along((X, Y), -1.0 / determinant(F), apply_transposed(cofactor(F), apart))

    def labels(self, X: Array, Y: Array, t: float) -> Fields:
        """The labels of the nodes of the gas's grid, by Newton's method."""
        D = self.grid(X, Y, t)
        x, found = (X + D[0], Y + D[1]), (X, Y)
        for _ in range(NEWTON_STEPS):
            found = self._newton(*found, t, *x)
        return found


class Disk(Body):
    def b(self, X: Any, Y: Any) -> Any:
        return (X * X + Y * Y - 1.0) / (X * X + Y * Y + 1.0)

    def grid(self, X: Array, Y: Array, t: float) -> Fields:
        """Nodes lie between both ends of a ray, at fixed parts of it."""
        R = np.sqrt(X * X + Y * Y)
        far = BOX * R / np.maximum(abs(X), abs(Y))
        s, ends = (R - 1.0) / (far - 1.0), (1.0 / R, far / R)
        inner, outer = (self.material(X * end, Y * end, t) for end in ends)
        return add(scale(1.0 - s, inner), scale(s, outer))

    def supplied(self, *at: Any) -> list[Array]:
        """The normal is along a ray."""
        X, Y, _ = at
        return self.jump(*at, *scale(-1.0 / np.sqrt(X * X + Y * Y), (X, Y)))


class Panel(Body):
    def b(self, X: Any, Y: Any) -> Any:
        return (X - COLUMNS[1]) * (X - COLUMNS[2]) * (Y - ROWS[1])

    def grid(self, X: Array, Y: Array, t: float) -> Fields:
        """Walls and joins stay straight; what the panel bends fades towards the edges opposite."""
        vertices = np.array(self.material(*np.meshgrid(COLUMNS, ROWS), t))

        def straight(X: Array, Y: Array) -> Array:
            along = [np.interp(X, COLUMNS, one) for one in np.eye(len(COLUMNS))]
            up = [np.interp(Y, ROWS, one) for one in np.eye(len(ROWS))]
            return np.einsum("nji,j...,i...->n...", vertices, up, along)

        edge = np.clip(X, *COLUMNS[1:3]), np.minimum(Y, ROWS[1])
        near = np.interp(X, COLUMNS, (0.0, 1.0, 1.0, 0.0)) * np.interp(Y, ROWS, (1.0, 1.0, 0.0))
        bent = np.array(self.material(*edge, t)) - straight(*edge)
        return tuple(straight(X, Y) + near * bent)

    def supplied(self, *at: Any) -> list[Array]:
        """The face of these nodes is the top if they have one Y."""
        X, Y, _ = at
        if np.ptp(Y) < np.ptp(X):
            return self.jump(*at, 0.0 * X, -1.0 + 0.0 * X)
        return self.jump(*at, np.sign(0.5 * sum(COLUMNS[1:3]) - X), 0.0 * X)


def turned(map: Map, times: int) -> Map:
    """The same places with the logical axes turned by so many right angles."""

    def places(xi: Places) -> Places:
        for _ in range(times):
            xi = xi[1], 1.0 - xi[0]
        return map(xi)

    return places


def to_box(q: int) -> Map:
    """Return the map from the circle to a side of the box along rays."""

    def places(xi: Places) -> Places:
        angle = np.pi / 4 * (2.0 * (xi[1] + q) - 1.0)
        ray = np.stack([np.cos(angle), np.sin(angle)])
        return tuple((1.0 - xi[0] + xi[0] * BOX / np.abs(ray).max(axis=0)) * ray)

    return places


def blocks_of(shape: str) -> tuple[dict[str, Map], list[FaceName]]:
    """Return maps by name, and the outer faces."""
    maps: dict[str, Map] = {}
    if shape == "disk":
        maps["middle"] = centre(HALF)
        for q in range(4):
            maps[f"disk {q}"] = turned(quarter(q, 1.0, HALF), q + 1)
            maps[f"gas {q}"] = turned(to_box(q), q)
        outer = (0, 1), (1, 1), (0, 0), (1, 0)  # of a block turned so often
        return maps, [(f"gas {q}", *face) for q, face in enumerate(outer)]
    faces = []
    for j, i in product(range(2), range(3)):
        name = "panel" if (i, j) == (1, 0) else f"gas {i}{j}"
        maps[name] = rectangle((COLUMNS[i], ROWS[j]), (COLUMNS[i + 1], ROWS[j + 1]))
        faces += [(name, 1, j), *([(name, 0, i // 2)] if i != 1 else [])]
    return maps, faces


def build(opt: Opt) -> BlockProblem:
    """-fsi_h: of the side of each block, which is 1 in logical coordinates."""
    exact: Body = (Panel if opt["body_shape"] == "panel" else Disk)(opt)
    gas = exact.fluid, exact.exact_gas, exact.force_gas
    solid = exact.body, exact.exact_solid, exact.force_solid
    walls: Any = {"x": lambda X, Y, t: add((X, Y), exact.grid(X, Y, t)[:2])}
    of_gas = Given(exact.exact_gas, **walls, velocity=lambda *at: exact.grid(*at)[2:])
    of_solid = Given(exact.exact_solid)

    def block(name: str, map: Map) -> Block:
        material, of, forcing = gas if name.startswith("gas") else solid
        n, start = round(1.0 / opt["fsi_h"]), lambda *X: of(*X, 0.0)
        return Block(name, material, map, (n, n), start, forcing, of)

    maps, outer = blocks_of(opt["body_shape"])
    faces = {face: of_gas if face[0].startswith("gas") else of_solid for face in outer}
    blocks = tuple(block(name, map) for name, map in maps.items())
    return BlockProblem(blocks, faces, jumps=exact.supplied, units="none")
