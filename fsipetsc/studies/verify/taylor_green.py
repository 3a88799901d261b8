"""Taylor and Green's vortex in three dimensions, without viscosity."""

from typing import Any

import numpy as np

from fsipetsc import Block, BlockProblem, Fluid
from fsipetsc.blocks.maps import rectangle
from fsipetsc.studies.verdicts import Array, Curve, Expected, Measured, Solve, round_off
from fsipetsc.studies.verify.data import largest, reference

PERIOD = 2.0 * np.pi


def cube(n: int, warm: float, mu: float = 0.0) -> Any:
    """The problem of n nodes along each axis; warm: R T at first; mu: viscosity."""

    def start(x: Array, y: Array, z: Array) -> list[Array]:
        p = (np.cos(2 * x) + np.cos(2 * y)) * (np.cos(2 * z) + 2.0) / 16.0
        u, v = np.sin(x) * np.cos(y) * np.cos(z), -np.cos(x) * np.sin(y) * np.cos(z)
        return [1.0 + p / warm, u, v, 0.0 * x, warm + 0.0 * x]

    space, gas = rectangle((0.0, 0.0, 0.0), (PERIOD,) * 3), Fluid(mu, 3.5 * mu / 0.71, 1.4, 1.0)
    return BlockProblem((Block("gas", gas, space, (n,) * 3, start, periodic=(True,) * 3),), {})


def measure(solve: Solve, order: int, h: float) -> Measured:
    n, given = round(PERIOD / h), {"fsi_convection": "entropy", "fsi_dissipation": -1.0}
    run = solve(cube(n, 100 / 1.4), order, h, 5.0, **given)
    series = {k: run.series[k].ravel() for k in ("mass", "energy", "entropy")}
    sizes = {"mass": series["mass"][0], "energy": np.pi**3, "entropy": series["mass"][0]}
    errors = {f"{k} kept": largest(v - v[0]) / sizes[k] for k, v in series.items()}
    table = reference("taylor_green")
    frame = solve(cube(n, 2500 / 1.4), order, h, 1.0, **given).layers[0].frame(-1)
    ours = {name: frame[name][n // 16, n // 8, :: n // 16] for name in "xuvw"}
    errors |= {name: largest(ours[name] - table[name]) for name in "uvw"}
    labels = "x", "w at y = π/4, z = π/8, t = 1"
    return Measured(errors, Curve(labels, ours["x"], ours["w"], table["x"], table["w"]))


SOURCE = "verify/taylor_green.py (Fourier series, constant density); conservation laws"
QUICK = {6: (PERIOD / 16, PERIOD / 32)}
FULL = {2: QUICK[6], 4: (*QUICK[6], PERIOD / 48), 6: QUICK[6]}
WHY = (
    "order p, of RK4 4; errors: the Mach number squared; of what is kept round-off of 2000"
    " steps, of all energy over the kinetic one"
)


def expected(quantity: str, order: int, h: float) -> Expected:
    """Orders inside, down to compressibility; round-off of what is kept."""
    if quantity in "uvw":
        return Expected(order, 0.02**2)
    if quantity == "entropy kept":
        return Expected(4.0, round_off(2000))
    # density 1, temperature 100/1.4, cv 2.5, in the volume 8 pi^3, over pi^3
    return Expected(error=round_off(2000) * (8 * 2.5 * 100 / 1.4 if quantity[0] == "e" else 1.0))
