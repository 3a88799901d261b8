"""Regular reflection of an oblique shock from a rigid wall."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fsipetsc.verify.entry import Bound, Curve, Entry, Measured, reference

TEXT = """
Gas of γ = 1.4, inviscid, in 0 < x < 3, 0 < y < 1, comes in at x = 0 with ρ = 1, p = 1/1.4 (speed
of sound 1) and the velocity (2.9, 0), which all of it has at first. At y = 1 the gas beyond is that
behind a shock that turns the flow by 10 degrees to the wall y = 0:
ρ = 1.63279808878, (u, v) = (2.65017615175, -0.467297559183), p = 1.43877487422. The wall turns it
back: ρ = 2.50471545964, u = 2.45427666974, v = 0, p = 2.64302084805. The shock from (0, 1) falls at
0.490953906333 rad, the reflected one rises at 0.396962945688 rad. At x = 3 gas flows out faster
than sound.

Time 4, when the flow is steady, dissipation at shocks on (`-fsi_shock 1 -fsi_dissipation 1`).
Errors: of p, the mean over all nodes of |ours - exact| over p in front, whose order is 1 at most;
and of the mean of p on the wall in 2.4 < x < 2.8, relative.
"""


def measure(solve: Callable[..., Any], order: int, h: float) -> Measured:
    """Errors of the pressure."""
    table, given = reference("oblique"), {"oblique_wall": "rigid", "fsi_output_dt": 4.0}
    with solve("oblique", fsi_order=order, fsi_h=h, ts_max_time=4.0, **given) as run:
        frame = {name: np.asarray(run.layers[0].frame(-1)[name]) for name in ("x", "y", "p")}
    x, y, p = frame["x"], frame["y"], frame["p"]
    falls, rises = np.tan(table["angle"][1:])
    behind = y < (x - 1.0 / falls) * rises
    exact = np.where(behind, table["p"][2], np.where(y > 1.0 - x * falls, *table["p"][1::-1]))
    wall = np.abs(y) < 1e-9
    plateau = wall & (x > 2.4) & (x < 2.8)
    errors = {"p, mean of errors": float(np.abs(p - exact).mean() / table["p"][0])}
    errors["p on the wall"] = abs(float(p[plateau].mean() / table["p"][2]) - 1.0)
    words = "x", "p on the wall"
    return Measured(errors, Curve(words, x[wall], p[wall], x[wall], exact[wall]))


ENTRY = Entry(
    name="oblique",
    title="Oblique shock reflected from a rigid wall",
    source="verify/oblique.py (conservation laws across both shocks)",
    text=TEXT,
    levels={
        "quick": {4: (1 / 16, 1 / 32)},
        "full": {k: (1 / 16, 1 / 32, 1 / 64) for k in (2, 4, 6)},
    },
    measure=measure,
    # a shock has order 1 in the mean: measured 0.94; the wall 1.2e-4
    bounds={("p, mean of errors", 4): Bound(0.8), ("p on the wall", 4): Bound(error=1e-3)},
)
