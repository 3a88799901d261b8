"""Receding and advancing elastic piston."""

from fsipetsc.studies.verdicts import Curve, Expected, Measured, Solve, kinked
from fsipetsc.studies.verify.data import largest, reference, root_mean_square, smooth

PLACE = 0.7**4 / 4
#: largest errors by cgmp, the paper's second-order scheme, at h = 1/40 and 1/320, quoted
QUOTED = {
    "rho": (3.16e-5, 5.98e-7),
    "u": (3.17e-4, 5.98e-6),
    "T": (9.04e-5, 1.71e-6),
    "stress": (3.00e-5, 3.90e-7),
}
#: way -> the sign of the motion, the norm of its errors
WAYS = {"receding": (-1.0, largest), "advancing": (1.0, root_mean_square)}
P = 0.1 / 1.4


def measure(solve: Solve, order: int, h: float) -> Measured:
    table, errors = reference("elastic_piston"), {}
    for way, (sign, norm) in WAYS.items():
        run = solve("elastic_piston", order, h, piston_way=way, fsi_cfl=0.4)
        rod, gas = (layer.frame(-1) for layer in run.layers)
        X = run.layers[0].X
        s = (gas["x"] - sign * PLACE) / (1.5 - sign * PLACE)
        for name in ("rho", "u", "T"):
            exact = smooth(table["s"], table[f"{way}_{name}"])(s)
            errors[f"{way}, {name}"] = norm(gas[name] - exact)
        ours = rod["sigma"] + P
        errors[f"{way}, stress"] = norm(ours - smooth(table["X"], table[f"{way}_stress"])(X))
    labels = "X, label in the rod", "stress - stress at rest"
    return Measured(errors, Curve(labels, X, ours, table["X"], table["advancing_stress"]))


SOURCE = "verify/elastic_piston.py, after Banks, Henshaw, Schwendeman (2012)"
QUICK = {4: (1 / 20, 1 / 40)}
FULL = {order: (1 / 40, 1 / 80, 1 / 160, 1 / 320) for order in (2, 4, 6, 8)}
WHY = "3.5 p/(p + 1) in the mean square, as third derivatives jump at fronts; errors of cgmp"


def expected(quantity: str, order: int, h: float) -> Expected:
    """Orders; of the receding piston published errors, which are those of a scheme of order 2."""
    way, name = quantity.split(", ")
    if way == "advancing":
        return Expected(kinked(order, 3.5))
    if order == 2:  # in the solid F = D x has an error of first order at the ends
        return Expected(1.0 if name == "stress" else 2.0)
    return Expected(error=QUOTED[name][h < 1 / 100])
