"""An isentropic vortex on four curved blocks that move."""

from typing import Any

import numpy as np

from fsipetsc import Block, BlockProblem, Fluid
from fsipetsc.blocks.conditions import Given
from fsipetsc.checks import Array
from fsipetsc.studies.verdicts import Curve, Measured, Solve, closures, of_order
from fsipetsc.studies.verify.data import joined, reference, root_mean_square, smooth

GRIDS = 1 / 4, 1 / 8, 1 / 16
CENTRE, SPEED, END = (-0.3, -0.2), (0.5, 0.3), 1.0


def exact(X: Array, Y: Array, t: float = 0.0) -> list[Array]:
    """rho, u, v, T by the formulas of the text."""
    x, y = X - CENTRE[0] - SPEED[0] * t, Y - CENTRE[1] - SPEED[1] * t
    bell = np.exp(1.0 - x * x - y * y)
    swirl, q = 0.4 * np.sqrt(bell), 1.0 - 0.16 / 7.0 * bell
    return [q**2.5, SPEED[0] - swirl * y, SPEED[1] + swirl * x, q]


def moved(X: Array, Y: Array, t: float) -> list[Array]:
    """Places of the sides."""
    size = 0.3 * np.sin(2.0 * t)
    return [X + size * np.sin(np.pi * Y / 4 + 0.4), Y + size * np.sin(np.pi * X / 4)]


def blocks(n: int) -> Any:
    """The problem with n cells along each side."""
    gas, found, faces = Fluid(0.0, 0.0, 1.4, 1.0), [], {}
    side = Given(values=lambda X, Y, t: exact(*moved(X, Y, t), t), x=moved)
    for i, j in ((0, 0), (1, 0), (0, 1), (1, 1)):

        def place(xi: Any, i: int = i, j: int = j) -> list[Array]:
            a, b = 4.0 * (xi[0] + i - 1.0), 4.0 * (xi[1] + j - 1.0)
            p, q = np.pi * a / 2.0, np.pi * b / 2.0
            bumps = np.sin(p) * np.sin(q + 0.5), np.sin(p + 0.3) * np.sin(q)
            return [a + 0.15 * bumps[0], b + 0.15 * bumps[1]]

        found.append(Block(f"{i}{j}", gas, place, (n // 2, n // 2), exact))
        faces |= {(f"{i}{j}", 0, i): side, (f"{i}{j}", 1, j): side}
    return BlockProblem(tuple(found), faces, units="none")


def measure(solve: Solve, order: int, h: float) -> Measured:
    table = reference("gas")
    short = np.isfinite(table["r"])
    columns = {name: table[f"vortex {name}"][short] for name in ("rho", "u", "p")}
    of_r = {name: smooth(table["r"][short], column) for name, column in columns.items()}
    layers = solve(blocks(round(8.0 / h)), order, h, END).layers
    frame = joined(layer.frame(-1) for layer in layers)
    z = frame["x"] + 1j * frame["y"] - complex(*CENTRE) - complex(*SPEED) * END
    r, ours = abs(z), frame["u"] + 1j * frame["v"] - complex(*SPEED)
    apart = {
        "rho": frame["rho"] - of_r["rho"](r),
        "velocity": ours - 1j * z / np.maximum(r, 1e-300) * of_r["u"](r),
        "p": frame["p"] - of_r["p"](r),
    }
    errors = {name: root_mean_square(v) for name, v in apart.items()}
    return Measured(errors, Curve(("r", "p"), r, frame["p"], table["r"], table["vortex p"]))


SOURCE = "verify/gas.py (momentum along the radius)"
QUICK = {4: GRIDS[:2]}
FULL = {**{order: GRIDS for order in (2, 4, 6)}, 8: (1 / 8, 1 / 16, 1 / 32)}
WHY = "order s + 1; with 2/1 that of the dissipation, which takes first differences"
expected = of_order(lambda order: closures(order) if order > 2 else 1.0)
