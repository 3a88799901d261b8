"""Gas alone in one dimension: Sod's shock tube, Shu and Osher's problem."""

from typing import Any

import numpy as np

from fsipetsc import Dirichlet, Fluid, FluidLayer, Problem, Wall
from fsipetsc.studies.verdicts import Array, Curve, Expected, Measured, Solve, kinked
from fsipetsc.studies.verify.data import reference

GAMMA = 1.4


def run_to(solve: Solve, end: float, start: Any, left: Any, order: int, h: float) -> Any:
    """The last frame of a gas between a left end and a wall as far from the middle."""
    layer = FluidLayer("gas", Fluid(0.0, 0.0, GAMMA, 1.0), (left.x, -left.x), start)
    problem = Problem((layer,), left, Wall(-left.x), units="none")
    return solve(problem, order, h, end, fsi_shock=1.4, fsi_dissipation=2.0).layers[0].frame(-1)


def measure(solve: Solve, order: int, h: float) -> Measured:
    table = reference("gas")

    def sod(x: Array) -> list[Array]:
        right = 0.5 * (1.0 + np.sign(np.round(x, 9)))
        rho, p = 1.0 - 0.875 * right, 1.0 - 0.9 * right
        return [rho, 0.0 * x, p / rho]

    ours, errors = run_to(solve, 0.2, sod, Wall(-0.5), order, h), {}
    for name in ("rho", "u", "p"):
        exact = np.interp(ours["x"], table["X"], table[f"sod {name}"])  # at points of the table
        errors[f"Sod, {name}"] = np.abs(ours[name] - exact).mean()
    state = 3.857143, 2.629369, 10.33333 / 3.857143

    def wavy(x: Array) -> list[Array]:
        still = 1.0 + 0.2 * np.sin(5.0 * x)
        ahead = still, 0.0 * x, 1.0 / still
        return [np.where(x < -4.0, value, v) for value, v in zip(state, ahead)]

    ours = run_to(solve, 1.8, wavy, Dirichlet(-5.0, lambda t: state), order, 5.0 * h)
    known = np.isfinite(table["x"])
    x, exact = table["x"][known], table["shu_osher rho"][known]
    found = np.interp(x, ours["x"], ours["rho"])
    errors["Shu-Osher, rho"] = np.abs(found - exact).mean()
    return Measured(errors, Curve(("x", "density, Shu-Osher"), ours["x"], ours["rho"], x, exact))


SOURCE = "verify/gas.py (Riemann's problem; fitted shock, Chebyshev collocation)"
QUICK = {4: (1 / 200, 1 / 400)}
FULL = {order: (1 / 100, 1 / 200, 1 / 400) for order in (2, 4, 6)}
WHY = "shocks, and what they leave behind, have the order 1 in the mean, contacts p/(p + 1)"


def expected(quantity: str, order: int, h: float) -> Expected:
    """Of the density the contact is worst."""
    return Expected(kinked(order) if quantity == "Sod, rho" else 1.0)
