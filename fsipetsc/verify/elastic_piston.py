"""Receding and advancing elastic piston."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fsipetsc.verify.entry import Bound, Curve, Entry, Measured, reference, smooth

TEXT = """
An elastic rod, -0.5 < X < 0, moves as it must for its end to be at F(t) = -t⁴/4 (receding) or
t⁴/4 (advancing), against a gas between F(t) and a wall at x = 1.5, at rest at first.

* gas: perfect, γ = 1.4, R = 1, ρ = 0.1 and p = 0.1/1.4 at rest (speed of sound 1), inviscid
* solid: linear elastic, density 1, λ + 2μ = 4 (wave speed c = 2), free of strain under the pressure
  at rest
* left end of the rod: its pressure is that of the exact solution; end time 0.7
* `h` is the spacing of both grids; that of the gas is uniform between F(t) and 1.5

Gas: u = F'(s), c = 1 + 0.2 u along x = F(s) + (1 + 1.2 F'(s)) (t - s), ρ = 0.1 c⁵, T = c²/1.4.
Solid: displacement f(t - X/c) + g(t + X/c), f' = (F' + q/c)/2, g' = (F' - q/c)/2, q = p - p₀.
Errors are the largest at all nodes, Courant number 0.4. Third derivatives jump at the fronts, so
that no order shows more than about 3 in the maximum. Bounds of the receding piston: the errors of
the paper's second-order scheme (cgmp) at h = 1/40 and 1/320, quoted: 3.16e-5 and 5.98e-7 (ρ),
3.17e-4 and 5.98e-6 (u), 9.04e-5 and 1.71e-6 (T), 3.00e-5 and 3.90e-7 (stress). The constants of its
solid could not be read; those above are ours.
"""
PLACE = 0.7**4 / 4
#: errors of the paper's second-order scheme at h = 1/40 and 1/320, quoted
QUOTED = {
    "rho": (3.16e-5, 5.98e-7),
    "u": (3.17e-4, 5.98e-6),
    "T": (9.04e-5, 1.71e-6),
    "stress": (3.00e-5, 3.90e-7),
}
WAYS = {"receding": -1.0, "advancing": 1.0}
P = 0.1 / 1.4


def measure(solve: Callable[..., Any], order: int, h: float) -> Measured:
    """Largest errors of both ways."""
    table, errors = reference("elastic_piston"), {}
    for way, sign in WAYS.items():
        with solve("elastic_piston", piston_way=way, fsi_order=order, fsi_h=h, fsi_cfl=0.4) as run:
            rod, gas = (layer.frame(-1) for layer in run.layers)
            X = np.asarray(run.layers[0].X).ravel()
        s = (gas["x"].ravel() - sign * PLACE) / (1.5 - sign * PLACE)
        for name in ("rho", "u", "T"):
            exact = smooth(table["s"], table[f"{way}_{name}"])(s)
            errors[f"{way}, {name}"] = float(np.abs(gas[name].ravel() - exact).max())
        ours = rod["sigma"].ravel() + P
        exact = smooth(table["X"], table[f"{way}_stress"])(X)
        errors[f"{way}, stress"] = float(np.abs(ours - exact).max())
    words = "X, label in the rod", "stress - stress at rest"
    return Measured(errors, Curve(words, X, ours, table["X"], table["advancing_stress"]))


def _bounds() -> dict[tuple[str, int], Bound]:
    found = {(f"{way}, {name}", 2): Bound(1.8) for way in WAYS for name in ("rho", "u", "T")}
    for name, (coarse, fine) in QUOTED.items():
        for order in (4, 6, 8):
            found[f"receding, {name}", order] = Bound(at={1 / 40: coarse, 1 / 320: fine})
    return found


ENTRY = Entry(
    name="elastic_piston",
    title="Elastic piston that recedes and advances",
    source="verify/elastic_piston.py, after Banks, Henshaw, Schwendeman (2012)",
    text=TEXT,
    levels={
        "quick": {4: (1 / 20, 1 / 40)},
        "full": {order: (1 / 40, 1 / 80, 1 / 160, 1 / 320) for order in (2, 4, 6, 8)},
    },
    measure=measure,
    bounds=_bounds(),
)
