"""Flutter of a clamped panel under a supersonic flow."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fsipetsc.verify.entry import Bound, Entry, Measured, reference

TEXT = """
Gas flows at M = 2 along a wall; from X = 0 to 1 the wall is an elastic panel, clamped at both ends.

* gas: perfect, γ = 1.4, ρ = 1, speed of sound 1, inviscid, -0.5 < X < 1.5, 0 < Y < 0.5
* panel: thickness 0.04, mass 10 per length, λₑ = 2 μₑ, 12 D/d³ = 3 μₑ, clamped end faces; behind it
  the pressure of the flow
* push: velocity 1e-5 sin²(πX) (1 + cos πX) at first

Runs at λ = 2 q L³/(D √(M²-1)) = 600 and 700 are taken apart into modes; the λ at which the growth
becomes positive is compared with

* *thin, quasi-steady*: 636.5691312597, where w'''' + λ w' = q w has a double q
* simply supported panels flutter from 343.3564262798 on; the case has clamps only, so that is not
  run

The panel of the runs is no thin one: shear lowers its onset by 4.5 %, the damping by the flow
raises it by less than 1 %, and clamps that hold the panel in Y, too, raise it by 1 to 2 %. So the
error says how far the onset is from the thin limit, and need not fall with h.
"""
LAMBDAS = (600.0, 700.0)


def measure(solve: Callable[..., Any], order: int, h: float) -> Measured:
    """Relative distance of the onset."""
    from fsipetsc.analysis.flutter import SMALL, one_run
    from fsipetsc.analysis.flutter_motion import crossing
    from fsipetsc.analysis.flutter_theory import Flow
    from fsipetsc.cases import load_case
    from fsipetsc.options import defaults

    case = load_case("panel")
    opt = {**defaults(case), "fsi_order": order, "fsi_h": h, "fsi_cfl": 1.2, "panel_push": SMALL}
    flow = Flow(2.0, opt["panel_mass"])
    pairs = [one_run(case, opt, 2.0, dynamic).pair for dynamic in LAMBDAS]
    onset = crossing(LAMBDAS, [flow.unit(dynamic) for dynamic in LAMBDAS], pairs)[0]
    exact = float(reference("panel_flutter")["clamped lambda"][0])
    return Measured({"onset, thin limit": abs(onset / exact - 1.0)})


ENTRY = Entry(
    name="panel_flutter",
    title="Flutter of a clamped panel",
    source="verify/beams.py (Dowell 1975 has 636.57; quasi-steady, thin, undamped)",
    text=TEXT,
    levels={"quick": {4: (1 / 24,)}, "full": {4: (1 / 24, 1 / 32, 1 / 48)}},
    measure=measure,
    bounds={("onset, thin limit", 4): Bound(error=0.04)},
)
