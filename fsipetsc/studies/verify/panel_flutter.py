"""Flutter of clamped and hinged panels under a supersonic flow."""

import numpy as np

from fsipetsc.options import defaults
from fsipetsc.studies.flutter import CASE, crossing, modes_at
from fsipetsc.studies.verdicts import Compared, Expected, Measured, Solve
from fsipetsc.studies.verify.data import reference

#: ends -> lambdas around the onset; without that in the middle it is 0.1 to 0.2 % too low
RUNS = {"clamped": (600.0, 650.0, 700.0), "hinged": (320.0, 350.0, 380.0)}
THICKNESS = 0.04


def measure(solve: Solve, order: int, h: float) -> Measured:
    table, errors = reference("panel_flutter"), {}
    thick = np.argmin(np.abs(table["d"] - THICKNESS))
    opt = {**defaults(CASE), "fsi_order": order, "fsi_h": h}
    for ends, lambdas in RUNS.items():
        opt |= {"panel_ends": ends, "panel_thickness": THICKNESS}
        pairs = [modes_at(opt, 2.0, dynamic) for dynamic in lambdas]
        onset = crossing(2.0, opt["panel_mass"], lambdas, pairs)[0]
        errors[f"{ends}, theory"] = Compared(onset, table[f"{ends} theory"][thick])
        errors[f"{ends}, thin limit"] = Compared(onset, table[f"{ends} lambda"][0])
    return Measured(errors)


SOURCE = "verify/beams.py (plane strain, linear flow; Dowell 1975 has 636.57 in the thin limit)"
QUICK = {4: (1 / 24,)}
FULL = {4: (1 / 24, 1 / 32, 1 / 48)}
WHY = (
    "stress in a clamped corner goes as r^(0.69 - 1), so the order is 1.38; errors: what the"
    " thickness takes off the thin limit in theory"
)


def expected(quantity: str, order: int, h: float) -> Expected:
    """The effect of the thickness is to be seen."""
    thin, thick = reference("panel_flutter")[f"{quantity.split(',')[0]} lambda"][:2]
    return Expected(1.38 if quantity == "clamped, theory" else None, 1.0 - thick / thin)
