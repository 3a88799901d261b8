"""A gas and a solid of different temperatures suddenly in contact."""

import numpy as np

from fsipetsc import Fluid, FluidLayer, Problem, Solid, SolidLayer, Wall, clamped
from fsipetsc.studies.verdicts import Array, Compared, Curve, Expected, Measured, Solve, closures
from fsipetsc.studies.verify.data import largest, reference, smooth

JUMP, BEGIN, END = 0.01, 10.0, 20.0


def measure(solve: Solve, order: int, h: float) -> Measured:
    table = reference("heat")
    gas, U = Fluid(0.001, 0.0063, 1.4, 1.0), float(table["contact u"][0])
    T_gas, u_gas = (smooth(table["chi"], table[name]) for name in ("gas T", "gas u"))
    T_solid = smooth(table["X"], table["solid T"])

    def in_gas(x: Array, t: float = BEGIN) -> list[Array]:
        chi, root = np.clip(x / np.sqrt(t), 0.0, table["chi"][-1]), np.sqrt(t)
        return [1.0 / T_gas(chi), u_gas(chi) / root, T_gas(chi)]

    def in_solid(X: Array, t: float = BEGIN) -> list[Array]:
        T = T_solid(np.clip(X / np.sqrt(t), table["X"][0], 0.0))
        return [0.0 * X, 0.0 * X - 1.0, T, X]

    solid = Solid(20.0, 0.00225, 1.0 / (0.25 * 0.995), 0.625)
    wall = Wall(
        lambda t: 2.0 + 2.0 * U * (np.sqrt(BEGIN + t) - np.sqrt(BEGIN)),
        velocity=lambda t: U / np.sqrt(BEGIN + t),
    )
    problem = Problem(
        layers=(
            SolidLayer("solid", solid, (-2.0, 0.0), in_solid),
            FluidLayer("gas", gas, (0.0, 2.0), in_gas),
        ),
        left=clamped(T=0.995),
        right=wall,
        units="none",
    )
    cold, warm = (layer.frame(-1) for layer in solve(problem, order, h, END - BEGIN).layers)
    x, T = warm["x"], warm["T"]
    errors = {
        "gas": largest(T - in_gas(x, END)[2]) / JUMP,
        "solid": largest(cold["T"] - in_solid(cold["x"], END)[2]) / JUMP,
        "interface": Compared(T[0], table["contact T"][0], JUMP),
    }
    labels = "x", "T of the gas"
    return Measured(errors, Curve(labels, x, T, table["chi"] * np.sqrt(END), table["gas T"]))


SOURCE = "verify/heat.py (similarity in the gas, error function in the solid)"
QUICK = {4: (1 / 40, 1 / 80)}
FULL = {order: (1 / 20, 1 / 40, 1 / 80) for order in (2, 4, 6)}
WHY = (
    "order s + 1; errors: the similarity solution has no pressure, but gas that is slowed down by"
    " du/dt over the length 2 has 2 rho du/dt"
)


def expected(quantity: str, order: int, h: float) -> Expected:
    """Orders, down to the warmth of that pressure, at first, where density and p are about 1."""
    slowed = 0.5 * abs(reference("heat")["contact u"][0]) / BEGIN**1.5
    return Expected(closures(order), 0.4 / 1.4 * 2.0 * slowed / JUMP)
