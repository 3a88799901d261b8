"""Heat in a slab with a flux, and conjugate heat at the wall of a gas."""

import numpy as np

from fsipetsc import Problem, Solid, SolidLayer, clamped, free
from fsipetsc.studies.verdicts import Array, Expected, Measured, Solve, closures, round_off
from fsipetsc.studies.verify.data import largest, reference, smooth


def slab(solve: Solve, order: int, h: float, table: dict[str, Array]) -> float:
    T = smooth(table["x"], table["slab T"])
    solid = SolidLayer("slab", Solid(1.0, 0.1, 1.0, 1.0), (0.0, 1.0), lambda X: (0, 0, T(X), X))
    ends = clamped(T=1.0), free(heat_flux=lambda t: 0.1 * np.cos(2.0 * np.pi * t))
    problem = Problem((solid,), *ends, units="none")
    frame = solve(problem, order, h, 1.0).layers[0].frame(-1)
    return largest(frame["T"] - T(frame["x"]))


def mode(solve: Solve, order: int, h: float, table: dict[str, Array]) -> float:
    solid, gas = (layer.frame(-1) for layer in solve("heat", order, h).layers)
    left, errors = np.exp(table["mode s"][0]), []
    for frame, name, x in ((solid, "mode solid", solid["x"] + 1.0), (gas, "mode gas", gas["x"])):
        exact = smooth(table["x"], table[name])(np.clip(x, 0.0, 1.0))
        errors.append(largest((frame["T"] - 1.0) / 1e-7 - left * exact))
    return max(errors)


def measure(solve: Solve, order: int, h: float) -> Measured:
    table = reference("heat")
    return Measured({f.__name__: f(solve, order, h, table) for f in (slab, mode)})


SOURCE = "verify/heat.py (Chebyshev collocation)"
QUICK = {4: (1 / 20, 1 / 40, 1 / 80)}
FULL = {**dict.fromkeys((2, 4), (1 / 20, 1 / 40, 1 / 80)), 6: (1 / 40, 1 / 80, 1 / 160)}
WHY = "order s + 1; errors: round-off of 10,000 steps over the size 1e-7 of the mode"


def expected(quantity: str, order: int, h: float) -> Expected:
    """Orders, and what a small mode loses to round-off."""
    return Expected(closures(order), round_off(10_000) / 1e-7 if quantity == "mode" else None)
