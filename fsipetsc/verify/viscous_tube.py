"""Viscous shock tube: a shock comes back through the boundary layer that it has left."""

from __future__ import annotations

import numpy as np

from fsipetsc.verify.entry import Array, Bound, Compared, Curve, Entry, Measured, Solve, reference


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


def measure(solve: Solve, order: int, h: float) -> Measured:
    """Distance of the triple point from that quoted."""
    given = {"ts_max_time": 1.0, "fsi_output_dt": 1.0, "fsi_shock": 1.0, "fsi_dissipation": 1.0}
    with solve("viscous_tube", fsi_order=order, fsi_h=h, **given) as run:
        frame = {name: np.asarray(run.layers[0].frame(-1)[name]) for name in ("x", "y", "p")}
    x, y = frame["x"][0], frame["y"][:, 0]
    place, height, places = triple_point(x, y, frame["p"])
    table = reference("viscous_tube")
    found = {"x": place, "y": height}
    errors = {
        f"{axis} of the triple point": Compared(v, float(table[axis][0]), size=1.0)
        for axis, v in found.items()
    }
    curve = Curve(("front of the shock, x", "y"), np.array(places), y, table["x"], table["y"])
    return Measured(errors, curve)


ENTRY = Entry(
    source="Daru and Tenaud, Comput. Fluids 30 (2001) 89, quoted",
    levels={"quick": {}, "full": {4: (1 / 100, 1 / 200, 1 / 400), 6: (1 / 100, 1 / 200)}},
    measure=measure,
    bounds={
        (f"{x} of the triple point", order): Bound(error=0.01) for x in "xy" for order in (4, 6)
    },
)
