"""A gas and a solid of different temperatures suddenly in contact."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fsipetsc.verify.entry import Array, Bound, Curve, Entry, Measured, reference, smooth

TEXT = """
A gas (γ = 1.4, R = 1, c_v = 2.5, κ = 0.0063, viscosity 0.001) of T = 1.005 in x > 0 and
a solid of T = 0.995 in x < 0 touch at t = 0, both under the pressure 1. In the literature the
second medium is a gas, too, of γ = 5/3, c_v = 0.375 and κ = 0.00225. Here it is a solid with the
same conductivity and the same heat per volume: density 4.02010050251 (that of the gas), specific
heat 0.625 = γ c_v (as the gas is under a constant pressure), K = 2 μ_e + λ_e = 20, no strain at
first. Error functions in both give 1.00163 at the interface. The reference is the similarity
solution for a gas whose density follows its temperature: 1.00163540681.

A run begins at t = 10 from this solution and ends at t = 20; -2 < X < 2, the solid clamped at 0.995
and the gas before an adiabatic wall that moves as the gas far away, 2 + 2 U (√t - √10), U =
-8.04218939626e-5. Errors are the largest of T, over the jump 0.01. In gas and interface they stay
above about 1e-5: the pressure, which sound brings about, differs from 1 by as much.
"""
JUMP, BEGIN, END = 0.01, 10.0, 20.0


def measure(solve: Callable[..., Any], order: int, h: float) -> Measured:
    """Largest errors of T in gas, solid and at the interface, over the jump."""
    from fsipetsc.boundaries import Wall, clamped
    from fsipetsc.materials.fluid import Fluid
    from fsipetsc.materials.line_solid import Solid
    from fsipetsc.problem import FluidLayer, Problem, SolidLayer

    table = reference("heat")
    gas, U = Fluid(0.001, 0.0063, 1.4, 1.0), float(table["contact u"][0])
    T_gas, u_gas = (smooth(table["chi"], table[name]) for name in ("gas T", "gas u"))
    T_solid = smooth(table["X"], table["solid T"])

    def in_gas(x: Array, t: float) -> list[Array]:
        chi, root = np.clip(x / np.sqrt(t), 0.0, table["chi"][-1]), np.sqrt(t)
        return [1.0 / T_gas(chi), u_gas(chi) / root, T_gas(chi)]

    def in_solid(X: Array, t: float) -> list[Array]:
        T = T_solid(np.clip(X / np.sqrt(t), table["X"][0], 0.0))
        return [0.0 * X, 0.0 * X - 1.0, T, X]

    solid = Solid(20.0, 0.00225, 1.0 / (0.25 * 0.995), 0.625)
    wall = Wall(
        lambda t: 2.0 + 2.0 * U * (np.sqrt(BEGIN + t) - np.sqrt(BEGIN)),
        velocity=lambda t: U / np.sqrt(BEGIN + t),
    )
    problem = Problem(
        layers=(
            SolidLayer("solid", solid, (-2.0, 0.0), lambda X: in_solid(X, BEGIN)),
            FluidLayer("gas", gas, (0.0, 2.0), lambda x: in_gas(x, BEGIN)),
        ),
        left=clamped(T=0.995),
        right=wall,
        units="none",
    )
    given = {"ts_max_time": END - BEGIN, "fsi_output_dt": END - BEGIN}
    with solve(problem, fsi_order=order, fsi_h=h, **given) as run:
        cold, warm = (layer.frame(-1) for layer in run.layers)
    x, X, T, T_s = warm["x"].ravel(), cold["x"].ravel(), warm["T"].ravel(), cold["T"].ravel()
    apart = {"gas": T - in_gas(x, END)[2], "solid": T_s - in_solid(X, END)[2]}
    apart["interface"] = T[0] - table["contact T"][0]
    errors = {name: float(np.abs(error).max()) / JUMP for name, error in apart.items()}
    words = "x", "T of the gas"
    return Measured(errors, Curve(words, x, T, table["chi"] * np.sqrt(END), table["gas T"]))


ENTRY = Entry(
    name="sudden_contact",
    title="Gas and solid of different temperatures suddenly in contact",
    source="verify/heat.py (similarity in the gas, error function in the solid)",
    text=TEXT,
    levels={
        "quick": {4: (1 / 40, 1 / 80)},
        "full": {order: (1 / 20, 1 / 40, 1 / 80) for order in (2, 4, 6)},
    },
    measure=measure,
    # measured on the finest quick grid: 3.3e-5, 4.4e-5, 1.9e-5
    bounds={
        **{("gas", 4): Bound(error=1e-4), ("interface", 4): Bound(error=6e-5)},
        ("solid", 4): Bound(2.7, 1.5e-4),
    },
)
