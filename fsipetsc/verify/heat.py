"""Heat in gas and solid: sudden contact, a slab with a flux, conjugate heat at an interface."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fsipetsc.verify.entry import Array, Bound, Curve, Entry, Measured, reference, smooth

TEXT = """
*Contact.* A gas (γ = 1.4, R = 1, c_v = 2.5, κ = 0.0063, viscosity 0.001) of T = 1.005 in x > 0 and
a solid of T = 0.995 in x < 0 touch at t = 0, both under the pressure 1. In the literature the
second medium is a gas, too, of γ = 5/3, c_v = 0.375 and κ = 0.00225. Here it is a solid with the
same conductivity and the same heat per volume: density 4.02010050251 (that of the gas), specific
heat 0.625 = γ c_v (as the gas is under a constant pressure), K = 2 μ_e + λ_e = 20, no strain at
first. Error functions in both give 1.00163 at the interface, and so does the density of the gas
that follows its temperature (1.00163541). A run begins at t = 10 from this exact solution and ends
at t = 20; -2 < X < 2, the solid clamped at 0.995; at the right an adiabatic wall that
moves as the gas far away, 2 + 2 U (√t - √10), U = -8.04218939626e-5. Errors are the largest, over
the jump 0.01. They stay above about 1e-5, as sound makes the pressure differ from 1.

*Slab.* 0 < X < 1, density, specific heat and K = 1, κ = 0.1, T = 1 at X = 0, flux 0.1 cos(2 π t)
into it at X = 1; from the periodic solution over one period. Largest error.

*Mode.* Solid -1 < X < 0 (density 2, specific heat 1, K = 20, κ = 0.3) and gas 0 < x < 1 (γ = 1.4,
R = 1, viscosity 0.02, κ = 0.1, p = ρ = 1) between a clamp and a wall, T = 1 at both: the slowest
thermal mode of size 1e-7, of which exp(-0.18413327753 t) is left at t = 1. Largest error of T in
both, over its size.
"""
JUMP, T0, BEGIN, END = 0.01, 1.0, 10.0, 20.0


def contact(solve: Callable[..., Any], order: int, h: float, table: dict[str, Array]) -> Any:
    """(largest errors in gas, solid, at the interface; x and T of the gas), over the jump."""
    from fsipetsc.boundaries import Wall, clamped
    from fsipetsc.materials.fluid import Fluid
    from fsipetsc.materials.line_solid import Solid
    from fsipetsc.problem import FluidLayer, Problem, SolidLayer

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
    in_both = T - in_gas(x, END)[2], T_s - in_solid(X, END)[2], T[0] - table["contact T"][0]
    return [float(np.abs(error).max()) / JUMP for error in in_both], x, T


def slab(solve: Callable[..., Any], order: int, h: float, table: dict[str, Array]) -> float:
    """Largest error."""
    from fsipetsc.boundaries import clamped, free
    from fsipetsc.materials.line_solid import Solid
    from fsipetsc.problem import Problem, SolidLayer

    T = smooth(table["x"], table["slab T"])
    solid = SolidLayer("slab", Solid(1.0, 0.1, 1.0, 1.0), (0.0, 1.0), lambda X: (0, 0, T(X), X))
    ends = clamped(T=1.0), free(heat_flux=lambda t: 0.1 * np.cos(2.0 * np.pi * t))
    problem = Problem((solid,), *ends, units="none")
    with solve(problem, fsi_order=order, fsi_h=h, ts_max_time=1.0, fsi_output_dt=1.0) as run:
        frame = run.layers[0].frame(-1)
    return float(np.abs(frame["T"] - T(frame["x"])).max())


def mode(solve: Callable[..., Any], order: int, h: float, table: dict[str, Array]) -> float:
    """Largest error over the size."""
    with solve("heat", fsi_order=order, fsi_h=h) as run:
        solid, gas = (layer.frame(-1) for layer in run.layers)
    left, errors = np.exp(table["mode s"][0]), []
    for frame, name, x in ((solid, "mode solid", solid["x"] + 1.0), (gas, "mode gas", gas["x"])):
        exact = smooth(table["x"], table[name])(np.clip(x, 0.0, 1.0))
        errors.append(np.abs((frame["T"] - T0) / 1e-7 - left * exact).max())
    return float(max(errors))


def measure(solve: Callable[..., Any], order: int, h: float) -> Measured:
    """Errors of the three."""
    table = reference("heat")
    (gas, solid, interface), x, T = contact(solve, order, h, table)
    errors = {"contact, gas": gas, "contact, solid": solid, "contact, interface": interface}
    errors |= {"slab": slab(solve, order, h, table), "mode": mode(solve, order, h, table)}
    root = np.sqrt(END)
    curve = Curve(("x", "T of the gas"), x, T, table["chi"] * root, table["gas T"])
    return Measured(errors, curve)


ENTRY = Entry(
    name="heat",
    title="Heat: sudden contact, slab with a flux, conjugate heat at an interface",
    source="verify/heat.py (similarity, error functions, Chebyshev collocation)",
    text=TEXT,
    levels={
        "quick": {4: (1 / 40, 1 / 80)},
        "full": {k: (1 / 20, 1 / 40, 1 / 80) for k in (2, 4, 6)},
    },
    measure=measure,
    bounds={},
)
