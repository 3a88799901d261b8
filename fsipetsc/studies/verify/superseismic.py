"""A shock along an elastic half space, faster than its waves."""

import numpy as np

from fsipetsc.studies.verdicts import Compared, Curve, Measured, Solve, expect
from fsipetsc.studies.verify.data import reference

#: (block, unknown, column of the reference, low and high X, low and high Y) of plateaus at t = 0.5
PLATEAUS = (
    ("gas", "rho", "rho", 0.15, 0.3, 0.05, 0.15),
    ("gas", "T", "T", 0.15, 0.3, 0.05, 0.15),
    ("half space", "v", "solid v", 0.0, 0.25, -0.06, 0.01),
    ("half space", "v", "solid v behind P", -0.02, 0.06, -0.25, -0.18),
)
#: spacings of all orders
COARSE, ORDERS = (1 / 20, 1 / 40), (2, 4, 6, 8)
#: largest errors of plateaus by h; of the temperature they are smaller
PLATEAU = {1 / 40: 0.07, 1 / 80: 0.02}
WARMTH = {1 / 40: 0.015, 1 / 80: 0.008}


def measure(solve: Solve, order: int, h: float) -> Measured:
    """Norms, and means over plateaus."""
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
BOUNDS = {
    **expect(("gas",), ORDERS, 0.7),
    **expect(("solid",), ORDERS, 0.5),
    **expect((f"plateau, {one[2]}" for one in PLATEAUS), ORDERS, at=PLATEAU),
    **expect(("plateau, T",), ORDERS, at=WARMTH),
}
