"""Regular reflection of an oblique shock from a rigid wall."""

import numpy as np

from fsipetsc.studies.verdicts import Compared, Curve, Measured, Solve, of_order
from fsipetsc.studies.verify.data import reference


def measure(solve: Solve, order: int, h: float) -> Measured:
    table = reference("oblique")
    frame = solve("oblique", order, h, 4.0, oblique_wall="rigid").layers[0].frame(-1)
    x, y, p = frame["x"], frame["y"], frame["p"]
    falls, rises = np.tan(table["angle"][1:])
    behind = y < (x - 1.0 / falls) * rises
    exact = np.where(behind, table["p"][2], np.where(y > 1.0 - x * falls, *table["p"][1::-1]))
    wall = np.abs(y) < 1e-9
    plateau = wall & (x > 2.4) & (x < 2.8)
    errors = {
        "p, mean of errors": np.abs(p - exact).mean() / table["p"][0],
        "p on the wall": Compared(p[plateau].mean(), table["p"][2]),
    }
    labels = "x", "p on the wall"
    return Measured(errors, Curve(labels, x[wall], p[wall], x[wall], exact[wall]))


SOURCE = "verify/oblique.py (conservation laws across both shocks)"
QUICK = {4: (1 / 16, 1 / 32)}
FULL = {k: (1 / 16, 1 / 32, 1 / 64) for k in (2, 4, 6)}
WHY = "behind captured shocks errors have the order 1"
expected = of_order(lambda order: 1.0)
