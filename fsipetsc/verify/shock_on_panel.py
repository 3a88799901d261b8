"""A shock hits a clamped steel panel: an experiment."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fsipetsc.verify.entry import Bound, Curve, Entry, Measured, reference

TEXT = """
A channel 65 mm high. A steel panel, 1 mm thick and 50 mm high, is clamped into its floor 50 mm
behind the inflow; its end wall is 250 mm behind the panel. Air (γ = 1.4, R = 287 J/(kg K),
inviscid) of 1.2 kg/m³ and 101 kPa, and behind a shock of Mach 1.21, 25 mm before the panel at
first, 1.63 kg/m³, 109.6 m/s, 155.7 kPa; the gas slips along all walls and the panel.

Steel: neo-Hookean with E = 220 GPa, ν = 0.3 at small strain, plane strain, 7600 kg/m³, no damping,
free of stress under 101 kPa. Time 3 ms.

The quantity is the largest displacement of the tip's right corner along the channel. The
experiment has 6.2 ± 0.4 mm, other codes 5.8 to 6.6 mm (quoted: J. Giordano et al., Shock Waves 14
(2005) 103). `h` is the spacing in the gas [m]; the panel has the least number of cells across that
the order allows. The error is in mm; it need not fall with `h`, as an experiment is not exact. A
run has about a hundred thousand steps: this entry is of the full level only.
"""


def measure(solve: Callable[..., Any], order: int, h: float) -> Measured:
    """Of the largest displacement [mm]."""
    with solve("fin", fsi_order=order, fsi_h=h, ts_max_time=3e-3) as run:
        t, x = run.series["t"], run.series["x_point"][:, 0]
    moved = 1e3 * (x - x[0])
    table = reference("shock_on_panel")
    errors = {"largest displacement of the tip, mm": abs(float(moved.max() - table["mm"][0]))}
    few = slice(None, None, max(1, len(t) // 300))
    words, ends = ("t [ms]", "tip [mm]"), 1e3 * t[[0, -1]]
    curve = Curve(words, 1e3 * t[few], moved[few], ends, table["mm"][[0, 0]])
    return Measured(errors, curve)


ENTRY = Entry(
    name="shock_on_panel",
    title="Shock on a flexible panel (experiment of Giordano et al.)",
    source="Giordano et al., Shock Waves 14 (2005) 103, quoted",
    text=TEXT,
    levels={"quick": {}, "full": {4: (0.005,)}},
    measure=measure,
    bounds={("largest displacement of the tip, mm", 4): Bound(error=0.4)},
)
