"""Solids alone in large deformation: simple shear, extension, rotation, energy of vibration."""

from itertools import product
from typing import Any

import numpy as np

from fsipetsc import Block, BlockProblem
from fsipetsc.blocks.conditions import Clamped, Free
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.studies.verdicts import Array, Expected, Measured, Solve, kinked, round_off
from fsipetsc.studies.verify.data import largest, reference

RATE = 2.0 * np.pi
STRESSES = "s_xx", "s_xy", "s_yy"
LAWS, HOW, GRIDS = ("neo-hookean", "svk"), ("shear", "extension"), (1 / 16, 1 / 32, 1 / 64)


def curved(xi: tuple[Array, ...]) -> tuple[Array, Array]:
    bump = 0.05 * np.sin(2.0 * np.pi * xi[0]) * np.sin(2.0 * np.pi * xi[1])
    return xi[0] + bump, xi[1] - bump


def square(law: str, h: float, start: Any, side: Any, forcing: Any = None) -> Any:
    """The problem with one condition at all sides."""
    solid, n = ElasticSolid(1.0, 1.5, 0.0, 1.0, 1.0, law=law, heat="elastic"), round(1.0 / h)
    block = Block("solid", solid, curved, (n, n), start, forcing=forcing)
    faces = {("solid", axis, side_of): side for axis in (0, 1) for side_of in (0, 1)}
    return BlockProblem((block,), faces, units="none")


def stretched(solve: Solve, order: int, h: float, law: str, how: str) -> float:

    def speed(X: Array, Y: Array, t: float = 0.0) -> list[Array]:
        return [Y if how == "shear" else X, 0.0 * X]

    def place(X: Array, Y: Array, t: float) -> list[Array]:
        return [X + t * speed(X, Y)[0], Y]

    side = Clamped(x=place, velocity=speed)
    problem = square(law, h, lambda X, Y: (*speed(X, Y), 1.0, X, Y), side)
    frame = solve(problem, order, h, 1.0).layers[0].frame(-1)
    table, row = reference("large_deformation"), LAWS.index(law)
    exact = {name: table[f"{how} {name}"][row] for name in STRESSES}
    apart = max(largest(frame[name] - value) for name, value in exact.items())
    return apart / largest([*exact.values()])


def rotated(solve: Solve, order: int, h: float, law: str) -> tuple[float, float]:

    def force(X: Array, Y: Array, t: float) -> list[Array]:
        c, s = np.cos(RATE * t), np.sin(RATE * t)
        x, y = X - 0.5, Y - 0.5
        return [-(RATE**2) * (c * x - s * y), -(RATE**2) * (s * x + c * y), 0.0, 0.0, 0.0]

    start = lambda X, Y: (-RATE * (Y - 0.5), RATE * (X - 0.5), 1.0, X, Y)  # noqa: E731
    problem = square(law, h, start, Free(), force)
    solid = solve(problem, order, h, 1.0).layers[0]
    first, last = solid.frame(0), solid.frame(-1)
    place = max(largest(last[x] - first[x]) for x in "xy")
    return place, max(largest(last[name]) for name in STRESSES)


def measure(solve: Solve, order: int, h: float) -> Measured:
    errors: dict[str, float] = {}
    for law, how in product(LAWS, HOW):
        errors[f"{how}, {law}"] = stretched(solve, order, h, law, how)
    errors["rotation, place"], errors["rotation, stress"] = rotated(solve, order, h, LAWS[0])
    start = lambda X, Y: (0.1 * np.sin(np.pi * (X - 0.5)), 0.0, 1.0, X, Y)  # noqa: E731
    problem = square(LAWS[0], h, start, Free())
    run = solve(problem, order, h, 122.0)
    energy, heat = run.series["energy"], run.layers[0].frame(-1)["T"] - 1.0
    errors["energy, total"] = largest(energy - energy[0]) / 0.0025
    errors["energy, heat"] = largest(heat) / 0.005
    return Measured(errors)


SOURCE = "verify/large_deformation.py (derivatives of the energy by complex steps)"
QUICK = {4: (1 / 12, 1 / 24)}
FULL = {k: GRIDS for k in (2, 4, 6)}
WHY = (
    "stiff springs between nodes bring RK4 down to its stage order + 1 = 2 in stresses, one more in"
    " places; waves with kinks have p/(p + 1) in the maximum; errors: round-off of differences over"
    " h in 8/h steps, of the heat in 60,000 steps"
)


def expected(quantity: str, order: int, h: float) -> Expected:
    """Orders of the rotation and the heat; what is exact has round-off."""
    orders = {"rotation, place": 3.0, "rotation, stress": 2.0, "energy, heat": kinked(order)}
    total = quantity == "energy, total"
    rounded = round_off(60_000) / 0.0025 if total else round_off(8.0 / h) / h
    known = orders.get(quantity)
    return Expected(known, None if known else rounded)
