"""Taylor and Green's vortex in three dimensions, without viscosity."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fsipetsc.verify.entry import Array, Bound, Curve, Entry, Measured, reference

TEXT = """
Gas of γ = 1.4, R = 1, inviscid, in a cube of the period 2 π along each axis, at first

    u = (sin x cos y cos z, -cos x sin y cos z, 0),   T = T₀,
    ρ = 1 + ((cos 2x + cos 2y) (cos 2z + 2)) / (16 T₀).

* *kept*: T₀ = 100/1.4 (Mach number 0.1), two-point flux (`-fsi_convection entropy`), no
  dissipation, end time 5, when the smallest grids have long lost the solution: largest changes of
  mass over itself, of energy over the kinetic energy π³ at first, and of the entropy ∫ρ s over the
  mass. The differences keep all three; RK4 does not quite keep the entropy. The reference is 0
* *u, v, w*: T₀ = 2500/1.4 (Mach number 0.02) at t = 1, against a fluid of constant density, by
  Fourier series: the largest error on the line y = π/4, z = π/8, at 16 nodes. Compressibility
  adds about the Mach number squared, 4e-4

`h` = 2 π/n. Both begin from the same velocities; the density follows the pressure of the fluid of
constant density, which keeps sound low.
"""
PERIOD = 2.0 * np.pi


def cube(n: int, warm: float) -> Any:
    """The problem of n nodes along each axis."""
    from fsipetsc.blocks.block import Block
    from fsipetsc.blocks.maps import rectangle
    from fsipetsc.blocks.problem import BlockProblem
    from fsipetsc.materials.fluid import Fluid

    def start(x: Array, y: Array, z: Array) -> list[Array]:
        p = (np.cos(2 * x) + np.cos(2 * y)) * (np.cos(2 * z) + 2.0) / 16.0
        u, v = np.sin(x) * np.cos(y) * np.cos(z), -np.cos(x) * np.sin(y) * np.cos(z)
        return [1.0 + p / warm, u, v, 0.0 * x, warm + 0.0 * x]

    space, gas = rectangle((0.0, 0.0, 0.0), (PERIOD,) * 3), Fluid(0.0, 0.0, 1.4, 1.0)
    return BlockProblem((Block("gas", gas, space, (n,) * 3, start, periodic=(True,) * 3),), {})


def measure(solve: Callable[..., Any], order: int, h: float) -> Measured:
    """Changes of what is kept, and errors of velocities."""
    n, given = round(PERIOD / h), {"fsi_order": order, "fsi_convection": "entropy"}
    given["fsi_dissipation"] = -1.0
    with solve(cube(n, 100 / 1.4), ts_max_time=5.0, fsi_output_dt=5.0, **given) as run:
        series = {k: np.asarray(run.series[k]).ravel() for k in ("mass", "energy", "entropy")}
    sizes = {"mass": series["mass"][0], "energy": np.pi**3, "entropy": series["mass"][0]}
    errors = {f"{k} kept": float(np.abs(v - v[0]).max() / sizes[k]) for k, v in series.items()}
    table = reference("taylor_green")
    with solve(cube(n, 2500 / 1.4), ts_max_time=1.0, fsi_output_dt=1.0, **given) as run:
        frame = {name: np.asarray(run.layers[0].frame(-1)[name]) for name in ("x", "u", "v", "w")}
    line = frame["u"].shape[0] // 16, frame["u"].shape[1] // 8
    ours = {name: v.reshape(n, n, n)[line][:: n // 16] for name, v in frame.items()}
    errors |= {name: float(np.abs(ours[name] - table[name]).max()) for name in "uvw"}
    words = "x", "w at y = π/4, z = π/8, t = 1"
    return Measured(errors, Curve(words, ours["x"], ours["w"], table["x"], table["w"]))


ENTRY = Entry(
    name="taylor_green",
    title="Taylor and Green's vortex in three dimensions, without viscosity",
    source="verify/taylor_green.py (Fourier series, constant density); conservation laws",
    text=TEXT,
    levels={
        "quick": {4: (PERIOD / 16,)},
        "full": {k: (PERIOD / 16, PERIOD / 32) for k in (2, 4, 6)},
    },
    measure=measure,
    # conservation: measured 1e-15, 2e-12, 3e-12; velocities 2.5e-3, 3.9e-3, 7.8e-3 with 16 nodes
    bounds={
        **{(f"{kept} kept", 4): Bound(error=2e-11) for kept in ("mass", "energy", "entropy")},
        **{("u", 4): Bound(error=5e-3), ("v", 4): Bound(error=8e-3), ("w", 4): Bound(error=0.015)},
    },
)
