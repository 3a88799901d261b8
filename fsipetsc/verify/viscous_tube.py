"""Viscous shock tube: a shock comes back through the boundary layer that it has left."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fsipetsc.verify.entry import Array, Bound, Curve, Entry, Measured, reference

TEXT = """
A box 0 < x < 1, 0 < y < 1/2, whose walls at x = 0, x = 1 and y = 0 are adiabatic and hold the gas;
y = 1/2 is a plane of symmetry. γ = 1.4, p = ρ T/γ (R = 1/γ, speed of sound 1 at T = 1), viscosity
1/200 (Re = 200), Prandtl number 0.73, no bulk viscosity. At t = 0 the gas is at rest, T = 1, and
ρ = 120 for x < 1/2, 1.2 for x > 1/2, the mean at the node x = 1/2. Time 1, dissipation at shocks on
(`-fsi_shock 1 -fsi_dissipation 1`).

The shock comes back from x = 1, and at the wall it is a λ. The point where its three branches meet
is measured so: in each row x_f(y) is where p, coming from x = 0.2, first has a fifth of the
pressure jump of the row y = 0.4; lines through x_f in 0.2 < y < 0.4 and in 0.04 < y < 0.1 meet
there. The reference is (0.58, 0.137), quoted for Re = 200. It was not computed here by another
program, and it is known to about 0.01.
"""


def front(x: Array, p: Array, level: float) -> float:
    """Where p first reaches a level, from the left."""
    k = int(np.argmax(p > level))
    return float(x[k - 1] + (level - p[k - 1]) / (p[k] - p[k - 1]) * (x[k] - x[k - 1]))


def triple_point(x: Array, y: Array, p: Array) -> tuple[float, float, list[float]]:
    """(x, y), and x_f of each row; x of columns, y of rows, p of both."""
    right = x > 0.2
    high = p[int(np.argmin(abs(y - 0.4)))][right]
    level = high[0] + 0.2 * (high.max() - high[0])
    places = [front(x[right], row[right], level) for row in p]
    lines = []
    for low, top in ((0.2, 0.4), (0.04, 0.1)):
        rows = (y > low) & (y < top)
        lines.append(np.polyfit(y[rows], np.array(places)[rows], 1))
    (a, b), (c, d) = lines
    height = (d - b) / (a - c)
    return a * height + b, height, places


def measure(solve: Callable[..., Any], order: int, h: float) -> Measured:
    """Distance of the triple point from that quoted."""
    given = {"ts_max_time": 1.0, "fsi_output_dt": 1.0, "fsi_shock": 1.0, "fsi_dissipation": 1.0}
    with solve("viscous_tube", fsi_order=order, fsi_h=h, **given) as run:
        frame = {name: np.asarray(run.layers[0].frame(-1)[name]) for name in ("x", "y", "p")}
    x, y = frame["x"][0], frame["y"][:, 0]
    place, height, places = triple_point(x, y, frame["p"])
    table = reference("viscous_tube")
    errors = {"x of the triple point": abs(place - float(table["x"][0]))}
    errors["y of the triple point"] = abs(height - float(table["y"][0]))
    curve = Curve(("front of the shock, x", "y"), np.array(places), y, table["x"], table["y"])
    return Measured(errors, curve)


ENTRY = Entry(
    name="viscous_tube",
    title="Viscous shock tube at Re = 200",
    source="Daru and Tenaud, Comput. Fluids 30 (2001) 89, quoted",
    text=TEXT,
    levels={"quick": {}, "full": {4: (1 / 100, 1 / 200, 1 / 400), 6: (1 / 100, 1 / 200)}},
    measure=measure,
    bounds={
        (f"{x} of the triple point", order): Bound(error=0.01) for x in "xy" for order in (4, 6)
    },
)
