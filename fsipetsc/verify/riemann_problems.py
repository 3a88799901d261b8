"""Riemann problems of a gas and an elastic rod."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fsipetsc.verify.entry import Bound, Curve, Entry, Measured, reference

TEXT = """
A perfect gas (γ = 1.4, R = 1) left of x = 1, an elastic rod right of it, inviscid.

* rod: density 0.5, stress K ln F - 0.1, at rest under the pressure 0.1 at first (F = 1)
* gas on the rod: ρ = 0.125, p = 0.1 (speed of sound 1.0583)
* *ratio 10, 100*: at t = 0 the gas in 0 < x < 1 has ρ = 1, p = 1 or 10, u = 0; K = 4 or 40
* *Mach 3, 10*: a shock of this Mach number stands at x = 0.7 at t = 0, a piston follows the gas
  behind it from x = 0; it hits the rod at t = 0.3 over its speed; K = 4 or 40

The pressure p and the velocity u at the interface are then constant until a wave comes back. They
follow from the shock or fan in the gas and the shock in the rod. Errors: of u as the mean velocity
of the interface from its place at the end, and of p as the mean of the last fifth of the steps,
both relative. `h` is the spacing of both grids, the gas's at first.
"""
#: of each problem: its name, end time, options of the case
PROBLEMS = {
    "ratio 10": (0.3, {"shock_problem": "sod", "shock_ratio": 10.0, "solid_modulus": 4.0}),
    "ratio 100": (0.1, {"shock_problem": "sod", "shock_ratio": 100.0, "solid_modulus": 40.0}),
    "Mach 3": (0.25, {"shock_problem": "strong", "shock_mach": 3.0, "solid_modulus": 4.0}),
    "Mach 10": (0.06, {"shock_problem": "strong", "shock_mach": 10.0, "solid_modulus": 40.0}),
}


def measure(solve: Callable[..., Any], order: int, h: float) -> Measured:
    """Relative errors of velocity and pressure at the interface."""
    table, errors = reference("riemann_problems"), {}
    for k, (name, (end, options)) in enumerate(PROBLEMS.items()):
        hit, p, u = (float(table[column][k]) for column in ("hit", "p", "u"))
        with solve("shock", fsi_order=order, fsi_h=h, ts_max_time=end, **options) as run:
            t, x = run.series["t"], run.series["x_interface"][:, 0]
            pressure = -run.series["sigma_interface"][:, 0]
        late = t > t[-1] - 0.2 * (t[-1] - hit)
        errors[f"{name}, u"] = abs((x[-1] - 1.0) / (t[-1] - hit) / u - 1.0)
        errors[f"{name}, p"] = abs(float(pressure[late].mean()) / p - 1.0)
        if name == "Mach 3":
            ends, words = t[[0, -1]], ("t", "p at the interface, Mach 3")
            curve = Curve(words, t, pressure, ends, 0.0 * ends + p)
    return Measured(errors, curve)


ENTRY = Entry(
    name="riemann_problems",
    title="Riemann problems of gas and elastic rod",
    source="verify/riemann_problems.py (Rankine and Hugoniot, iteration)",
    text=TEXT,
    levels={
        "quick": {4: (0.01, 0.005)},
        "full": {order: (0.01, 0.005, 0.0025) for order in (2, 4, 6)},
    },
    measure=measure,
    bounds={
        (f"{name}, {what}", order): Bound(error=0.01)
        for name in PROBLEMS
        for what in "up"
        for order in (2, 4, 6)
    },
)
