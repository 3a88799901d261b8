"""Flutter of a clamped panel under a supersonic flow."""

from __future__ import annotations

from fsipetsc.verify.entry import Bound, Compared, Entry, Measured, Solve, reference

LAMBDAS = (600.0, 700.0)


def measure(solve: Solve, order: int, h: float) -> Measured:
    """Relative distance of the onset."""
    from fsipetsc.analysis.flutter import SMALL, one_run
    from fsipetsc.analysis.panel_modes import Flow, crossing
    from fsipetsc.cases import load_case
    from fsipetsc.options import defaults

    case = load_case("panel")
    opt = {**defaults(case), "fsi_order": order, "fsi_h": h, "fsi_cfl": 1.2, "panel_push": SMALL}
    flow = Flow(2.0, opt["panel_mass"])
    pairs = [one_run(case, opt, 2.0, dynamic).pair for dynamic in LAMBDAS]
    onset = crossing(LAMBDAS, [flow.unit(dynamic) for dynamic in LAMBDAS], pairs)[0]
    exact = float(reference("panel_flutter")["clamped lambda"][0])
    return Measured({"onset, thin limit": Compared(onset, exact)})


ENTRY = Entry(
    source="verify/beams.py (Dowell 1975 has 636.57; quasi-steady, thin, undamped)",
    levels={"quick": {4: (1 / 24,)}, "full": {4: (1 / 24, 1 / 32, 1 / 48)}},
    measure=measure,
    bounds={("onset, thin limit", 4): Bound(error=0.04)},
)
