"""Receding and advancing elastic piston."""

from fsipetsc.studies.verdicts import Bound, Curve, Measured, Solve, expect
from fsipetsc.studies.verify.data import largest, reference, smooth

PLACE = 0.7**4 / 4
#: errors of NAMES by the paper's second-order scheme at h = 1/40 and 1/320, quoted
QUOTED = (3.16e-5, 5.98e-7), (3.17e-4, 5.98e-6), (9.04e-5, 1.71e-6), (3.00e-5, 3.90e-7)
#: three times our errors at the same spacings, 4/2
ADVANCING = (1.1e-5, 1e-7), (1.1e-4, 5e-7), (2.7e-5, 3e-7), (1.4e-4, 6e-7)
NAMES = "rho", "u", "T", "stress"
WAYS = {"receding": -1.0, "advancing": 1.0}
P = 0.1 / 1.4


def measure(solve: Solve, order: int, h: float) -> Measured:
    """Largest errors of both ways."""
    table, errors = reference("elastic_piston"), {}
    for way, sign in WAYS.items():
        run = solve("elastic_piston", order, h, piston_way=way, fsi_cfl=0.4)
        rod, gas = (layer.frame(-1) for layer in run.layers)
        X = run.layers[0].X
        s = (gas["x"] - sign * PLACE) / (1.5 - sign * PLACE)
        for name in NAMES[:3]:
            exact = smooth(table["s"], table[f"{way}_{name}"])(s)
            errors[f"{way}, {name}"] = largest(gas[name] - exact)
        ours = rod["sigma"] + P
        errors[f"{way}, stress"] = largest(ours - smooth(table["X"], table[f"{way}_stress"])(X))
    labels = "X, label in the rod", "stress - stress at rest"
    return Measured(errors, Curve(labels, X, ours, table["X"], table["advancing_stress"]))


SOURCE = "verify/elastic_piston.py, after Banks, Henshaw, Schwendeman (2012)"
QUICK = {4: (1 / 20, 1 / 40)}
FULL = {order: (1 / 40, 1 / 80, 1 / 160, 1 / 320) for order in (2, 4, 6, 8)}
BOUNDS = {
    **expect((f"{way}, {name}" for way in WAYS for name in NAMES[:3]), (2,), 1.8),
    # third derivatives jump at the front, so the order varies: measured 8.3e-6 and 9.3e-6
    **expect((f"{way}, stress" for way in WAYS), (2,), error=3e-5),
    **{
        (f"{way}, {name}", order): Bound(at={1 / 40: coarse, 1 / 320: fine})
        for way, known in zip(WAYS, (QUOTED, ADVANCING))
        for name, (coarse, fine) in zip(NAMES, known)
        for order in (4, 6, 8)
    },
}
