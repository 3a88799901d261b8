"""A St. Venant-Kirchhoff disk that spins in gas."""

import numpy as np

from fsipetsc.studies.verdicts import Curve, Measured, Solve, of_order
from fsipetsc.studies.verify.data import joined, largest, reference, smooth

DENSITIES = (0.5, 2.0, 20.0)


def measure(solve: Solve, order: int, h: float) -> Measured:
    table, errors = reference("spinning_disk"), {}
    for density in DENSITIES:
        given = {"disk_spin": 2.0, "disk_power": 4, "solid_density": density}
        layers = solve("disk", order, h, 0.5, **given).layers
        solids = [layer for layer in layers if layer.kind == "solid"]
        first, last = (joined(layer.frame(k) for layer in solids) for k in (0, -1))

        def exact(name, R, density=density):
            return smooth(table["R"], table[f"{name} {density:g}"])(R)

        X, v = first["x"] + 1j * first["y"], last["u"] + 1j * last["v"]
        z = X * (exact("real", abs(X)) + 1j * exact("imag", abs(X)))
        v_exact = X * (exact("v_real", abs(X)) + 1j * exact("v_imag", abs(X)))
        errors[f"place, density {density:g}"] = largest(last["x"] + 1j * last["y"] - z)
        errors[f"velocity, density {density:g}"] = largest(v - v_exact)
    R, labels = table["R"], ("R", f"speed in the disk of density {density:g}")
    exact_speed = R * np.hypot(exact("v_real", R), exact("v_imag", R))
    return Measured(errors, Curve(labels, abs(X), abs(v), R, exact_speed))


SOURCE = "verify/disk.py (reduced to the radius; spectral Galerkin method)"
QUICK = {4: (0.05, 0.025)}
FULL = {4: (0.1, 0.05, 0.025), 6: (0.05, 0.025)}
WHY = "order s in the maximum, the degree to which closures are exact where blocks are joined"
expected = of_order(lambda order: order // 2)
