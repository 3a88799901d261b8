"""A shock along an elastic half space, faster than its waves."""

import numpy as np

from fsipetsc.studies.verdicts import Compared, Curve, Expected, Measured, Solve, kinked
from fsipetsc.studies.verify.data import reference

#: (block, unknown, column of the reference, low and high X, low and high Y) of plateaus at t = 0.5
PLATEAUS = (
    ("gas", "rho", "rho", 0.15, 0.3, 0.05, 0.15),
    ("gas", "T", "T", 0.15, 0.3, 0.05, 0.15),
    ("half space", "v", "solid v", 0.0, 0.25, -0.06, 0.01),
    ("half space", "v", "solid v behind P", -0.02, 0.06, -0.25, -0.18),
)
#: spacings of all orders
COARSE = 1 / 20, 1 / 40


def measure(solve: Solve, order: int, h: float) -> Measured:
    table = reference("superseismic")
    run = solve("superseismic", order, h)
    errors = {"gas": run.errors["fluid"]["combined"], "solid": run.errors["solid"]["combined"]}
    for name, unknown, column, low, high, below, above in PLATEAUS:
        layer = run.blocks[name]
        X, Y = np.meshgrid(layer.X, layer.Y)
        inside = (X > low) & (X < high) & (Y > below) & (Y < above)
        mean = layer.frame(-1)[unknown][inside].mean()
        errors[f"plateau, {column}"] = Compared(mean, table[column][0])
    solid = run.blocks["half space"]
    x, ours = solid.X, solid.frame(-1)["v"][-1]
    steps, face = np.array([x[0], 0.5, 0.5, x[-1]]), table["solid v"][0] * np.array([1, 1, 0, 0])
    return Measured(errors, Curve(("X on the face", "v of the face"), x, ours, steps, face))


SOURCE = "verify/superseismic.py, after Banks, Henshaw, Schwendeman (2012)"
QUICK = {4: COARSE}
FULL = {2: COARSE, 4: (*COARSE, 1 / 80), 6: COARSE, 8: COARSE}
WHY = (
    "jumps have the order 1 in the mean, in the linear solid p/(p + 1); plateaus: a cell of the way"
    " 0.5 of the shock"
)


def expected(quantity: str, order: int, h: float) -> Expected:
    """The gas has shocks, the solid jumps that do not steepen."""
    if quantity.startswith("plateau"):
        return Expected(1.0, h / 0.5)
    return Expected(kinked(order) if quantity == "solid" else 1.0)
