"""Heat in a slab with a flux, and conjugate heat at the wall of a gas."""

import numpy as np

from fsipetsc import Problem, Solid, SolidLayer, clamped, free
from fsipetsc.studies.verdicts import Array, Bound, Measured, Solve, expect
from fsipetsc.studies.verify.data import largest, reference, smooth


def slab(solve: Solve, order: int, h: float, table: dict[str, Array]) -> float:
    """Largest error."""
    T = smooth(table["x"], table["slab T"])
    solid = SolidLayer("slab", Solid(1.0, 0.1, 1.0, 1.0), (0.0, 1.0), lambda X: (0, 0, T(X), X))
    ends = clamped(T=1.0), free(heat_flux=lambda t: 0.1 * np.cos(2.0 * np.pi * t))
    problem = Problem((solid,), *ends, units="none")
    frame = solve(problem, order, h, 1.0).layers[0].frame(-1)
    return largest(frame["T"] - T(frame["x"]))


def mode(solve: Solve, order: int, h: float, table: dict[str, Array]) -> float:
    """Largest error over the size."""
    solid, gas = (layer.frame(-1) for layer in solve("heat", order, h).layers)
    left, errors = np.exp(table["mode s"][0]), []
    for frame, name, x in ((solid, "mode solid", solid["x"] + 1.0), (gas, "mode gas", gas["x"])):
        exact = smooth(table["x"], table[name])(np.clip(x, 0.0, 1.0))
        errors.append(largest((frame["T"] - 1.0) / 1e-7 - left * exact))
    return max(errors)


def measure(solve: Solve, order: int, h: float) -> Measured:
    """Errors of both."""
    table = reference("heat")
    return Measured({f.__name__: f(solve, order, h, table) for f in (slab, mode)})


SOURCE = "verify/heat.py (Chebyshev collocation)"
QUICK = {4: (1 / 20, 1 / 40, 1 / 80)}
FULL = {order: (1 / 20, 1 / 40, 1 / 80) for order in (2, 4, 6)}
# theory: 2, 3, 4; measured 1.98, 3.11, 2.89 (3.6 with h = 1/160) and 1.97, 2.97, 4.19
BOUNDS = {
    **expect(("slab", "mode"), (2,), 1.8),
    **{**expect(("slab", "mode"), (4, 6), 2.7), ("mode", 6): Bound(3.7)},
}
