"""Taylor and Green's vortex in three dimensions, without viscosity."""

from typing import Any

import numpy as np

from fsipetsc import Block, BlockProblem, Fluid
from fsipetsc.blocks.maps import rectangle
from fsipetsc.studies.verdicts import Array, Bound, Curve, Measured, Solve, expect
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
    """Changes of what is kept, and errors of velocities."""
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
QUICK = {4: (PERIOD / 16,)}
FULL = {k: (PERIOD / 16, PERIOD / 32) for k in (2, 4, 6)}
# conservation: measured 1e-15, 4e-12, 3e-12; velocities 2.5e-3, 3.9e-3, 7.8e-3 with 16 nodes at
# order 4, 9e-4 with 32; order 2 has 1.97, 2.03, 1.73; the others come down to compressibility
BOUNDS = {
    **expect(("mass kept", "energy kept", "entropy kept"), (2, 4, 6), error=2e-11),
    **{**expect("uvw", (2,), 1.6), **expect("uvw", (6,), error=5e-4)},
    ("u", 4): Bound(error=5e-3, at={PERIOD / 32: 4e-4}),
    ("v", 4): Bound(error=8e-3, at={PERIOD / 32: 1e-3}),
    ("w", 4): Bound(error=0.015, at={PERIOD / 32: 1e-3}),
}
