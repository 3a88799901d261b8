"""A shock hits a clamped steel panel: an experiment."""

from __future__ import annotations

from fsipetsc.verify.entry import Bound, Compared, Curve, Entry, Measured, Solve, reference


def measure(solve: Solve, order: int, h: float) -> Measured:
    """Of the largest displacement [mm]."""
    with solve("fin", fsi_order=order, fsi_h=h, ts_max_time=3e-3) as run:
        t, x = run.series["t"], run.series["x_point"][:, 0]
    moved = 1e3 * (x - x[0])
    table = reference("shock_on_panel")
    largest = Compared(float(moved.max()), float(table["mm"][0]), size=1.0)
    errors = {"largest displacement of the tip, mm": largest}
    few = slice(None, None, max(1, len(t) // 300))
    words, ends = ("t [ms]", "tip [mm]"), 1e3 * t[[0, -1]]
    curve = Curve(words, 1e3 * t[few], moved[few], ends, table["mm"][[0, 0]])
    return Measured(errors, curve)


ENTRY = Entry(
    source="Giordano et al., Shock Waves 14 (2005) 103, quoted",
    levels={"quick": {}, "full": {4: (0.005,)}},
    measure=measure,
    bounds={("largest displacement of the tip, mm", 4): Bound(error=0.4)},
)
