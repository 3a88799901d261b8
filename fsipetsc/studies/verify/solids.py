"""Entries of `verify` about solids that are much deformed."""

from itertools import product
from typing import Any

import numpy as np

from fsipetsc import Block, BlockProblem
from fsipetsc.blocks.conditions import Clamped, Free
from fsipetsc.checks import Array
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.studies.verdicts import Curve, Expected, kinked, round_off
from fsipetsc.studies.verify.entry import (
    Measured,
    Solve,
    entry,
    joined,
    largest,
    reference,
    smooth,
)


@entry(
    source="verify/disk.py (reduced to the radius; spectral Galerkin method)",
    why="order s in the maximum, the degree to which closures are exact where blocks are joined",
    full={4: (0.1, 0.05, 0.025), 6: (0.05, 0.025)},
    quick={4: (0.05, 0.025)},
)
def spinning_disk(solve: Solve, order: int, h: float) -> Measured:
    """A St. Venant-Kirchhoff disk in gas."""
    table, errors = reference("spinning_disk"), {}
    for density in (0.5, 2.0, 20.0):
        given = {"disk_spin": 2.0, "disk_power": 4, "solid_density": density}
        layers = solve("disk", order, h, 0.5, **given).layers
        solids = [layer for layer in layers if layer.kind == "solid"]
        first, last = (joined(layer.frame(k) for layer in solids) for k in (0, -1))

        def exact(name, R, density=density):
            return smooth(table["R"], table[f"{name} {density:g}"])(R)

        X, v = first["x"] + 1j * first["y"], last["u"] + 1j * last["v"]
        z = X * (exact("real", abs(X)) + 1j * exact("imag", abs(X)))
        v_exact = X * (exact("v_real", abs(X)) + 1j * exact("v_imag", abs(X)))
        errors[f"place, density {density:g}"] = largest(last["x"] + 1j * last["y"] - z)
        errors[f"velocity, density {density:g}"] = largest(v - v_exact)
    R, labels = table["R"], ("R", f"speed in the disk of density {density:g}")
    exact_speed = R * np.hypot(exact("v_real", R), exact("v_imag", R))
    curve = Curve(labels, abs(X), abs(v), R, exact_speed)
    return Measured(errors, Expected(order // 2), curve)


#: angular velocity; stresses and laws of solids alone
RATE = 2.0 * np.pi
STRESSES, LAWS = ("s_xx", "s_xy", "s_yy"), ("neo-hookean", "svk")


def curved(xi: tuple[Array, ...]) -> tuple[Array, Array]:
    bump = 0.05 * np.sin(2.0 * np.pi * xi[0]) * np.sin(2.0 * np.pi * xi[1])
    return xi[0] + bump, xi[1] - bump


def square(law: str, h: float, start: Any, side: Any, forcing: Any = None) -> Any:
    """Return a solid with one condition at all sides."""
    solid, n = ElasticSolid(1.0, 1.5, 0.0, 1.0, 1.0, law=law, heat="elastic"), round(1.0 / h)
    block = Block("solid", solid, curved, (n, n), start, forcing=forcing)
    faces = {("solid", axis, side_of): side for axis in (0, 1) for side_of in (0, 1)}
    return BlockProblem((block,), faces, units="none")


def stretched(solve: Solve, order: int, h: float, law: str, how: str) -> float:
    """Return the error of the stress in shear or extension."""

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


def rotated(solve: Solve, order: int, h: float) -> tuple[float, float]:
    """Errors of place and stress of a square that is driven around once."""

    def force(X: Array, Y: Array, t: float) -> list[Array]:
        c, s = np.cos(RATE * t), np.sin(RATE * t)
        x, y = X - 0.5, Y - 0.5
        return [-(RATE**2) * (c * x - s * y), -(RATE**2) * (s * x + c * y), 0.0, 0.0, 0.0]

    start = lambda X, Y: (-RATE * (Y - 0.5), RATE * (X - 0.5), 1.0, X, Y)  # noqa: E731
    solid = solve(square(LAWS[0], h, start, Free(), force), order, h, 1.0).layers[0]
    first, last = solid.frame(0), solid.frame(-1)
    place = max(largest(last[x] - first[x]) for x in "xy")
    return place, max(largest(last[name]) for name in STRESSES)


@entry(
    source="verify/large_deformation.py (derivatives of the energy by complex steps)",
    why="stiff springs between nodes bring RK4 down to its stage order + 1 = 2 in stresses, one"
    " more in places; waves with kinks have p/(p + 1) in the maximum; errors: round-off of"
    " differences over h in 8/h steps, of the heat in 60,000 steps",
    full={k: (1 / 16, 1 / 32, 1 / 64) for k in (2, 4, 6)},
    quick={4: (1 / 12, 1 / 24)},
)
def large_deformation(solve: Solve, order: int, h: float) -> Measured:
    """Solids alone: simple shear, extension, rotation, energy of vibration."""
    errors: dict[str, Any] = {}
    for law, how in product(LAWS, ("shear", "extension")):
        errors[f"{how}, {law}"] = stretched(solve, order, h, law, how)
    expected = dict.fromkeys(errors, Expected(error=round_off(8.0 / h) / h))
    errors["rotation, place"], errors["rotation, stress"] = rotated(solve, order, h)
    start = lambda X, Y: (0.1 * np.sin(np.pi * (X - 0.5)), 0.0, 1.0, X, Y)  # noqa: E731
    run = solve(square(LAWS[0], h, start, Free()), order, h, 122.0)
    energy, heat = run.series["energy"], run.layers[0].frame(-1)["T"] - 1.0
    errors["energy, total"] = largest(energy - energy[0]) / 0.0025
    errors["energy, heat"] = largest(heat) / 0.005
    expected |= {"rotation, place": Expected(3.0), "rotation, stress": Expected(2.0)}
    expected["energy, total"] = Expected(error=round_off(60_000) / 0.0025)
    expected["energy, heat"] = Expected(kinked(order))
    return Measured(errors, expected)
