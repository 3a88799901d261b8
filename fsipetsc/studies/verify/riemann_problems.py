"""Riemann problems of a gas and an elastic rod."""

from fsipetsc.studies.verdicts import Compared, Curve, Expected, Measured, Solve
from fsipetsc.studies.verify.data import reference

#: of each problem: its name, end time, options of the case
PROBLEMS = {
    "ratio 10": (0.3, {"shock_problem": "sod", "shock_ratio": 10.0, "solid_modulus": 4.0}),
    "ratio 100": (0.1, {"shock_problem": "sod", "shock_ratio": 100.0, "solid_modulus": 40.0}),
    "Mach 3": (0.25, {"shock_problem": "strong", "shock_mach": 3.0, "solid_modulus": 4.0}),
    "Mach 10": (0.06, {"shock_problem": "strong", "shock_mach": 10.0, "solid_modulus": 40.0}),
}


def measure(solve: Solve, order: int, h: float) -> Measured:
    table, errors = reference("riemann_problems"), {}
    for k, (name, (end, options)) in enumerate(PROBLEMS.items()):
        hit, p, u = (table[column][k] for column in ("hit", "p", "u"))
        series = solve("shock", order, h, ts_max_time=end, **options).series
        t, x = series["t"], series["x_interface"][:, 0]
        pressure = -series["sigma_interface"][:, 0]
        late = t > t[-1] - 0.2 * (t[-1] - hit)
        errors[f"{name}, u"] = Compared((x[-1] - 1.0) / (t[-1] - hit), u)
        errors[f"{name}, p"] = Compared(pressure[late].mean(), p)
        if name == "Mach 3":
            ends, labels = t[[0, -1]], ("t", "p at the interface, Mach 3")
            curve = Curve(labels, t, pressure, ends, 0.0 * ends + p)
    return Measured(errors, curve)


SOURCE = "verify/riemann_problems.py (Rankine and Hugoniot, iteration)"
QUICK = {4: (0.01, 0.005)}
FULL = {order: (0.01, 0.005, 0.0025) for order in (2, 4, 6)}
WHY = "shocks are captured to first order, within a cell: h of the length 1 of the gas"


def expected(quantity: str, order: int, h: float) -> Expected:
    return Expected(1.0, h if quantity.endswith("p") else None)
