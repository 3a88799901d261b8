"""Taylor and Green's vortex at Re = 1600, on its way to turbulence."""

import numpy as np

from fsipetsc.studies.verdicts import Compared, Curve, Measured, Solve, of_order
from fsipetsc.studies.verify.data import reference
from fsipetsc.studies.verify.taylor_green import PERIOD, cube

#: quantity -> steps of 0.5 in time
SPANS = {"energy lost, 0 < t < 5": slice(10), "energy lost, 4.5 < t < 5.5": slice(9, 11)}


def measure(solve: Solve, order: int, h: float) -> Measured:
    n, table = round(PERIOD / h), reference("taylor_green_1600")
    given = {"fsi_convection": "entropy", "fsi_dissipation": -1.0, "fsi_output_dt": 0.5}
    run = solve(cube(n, 100 / 1.4, 1 / 1600), order, h, 5.5, **given)
    frames = map(run.layers[0].frame, range(run.nframes))
    E = [0.5 * (f["rho"] * sum(f[v] ** 2 for v in "uvw")).mean() for f in frames]
    ours, exact = -np.diff(E), -np.diff(table["E"])
    errors = {name: Compared(ours[at].sum(), exact[at].sum()) for name, at in SPANS.items()}
    t = table["t"][1:] - 0.25
    return Measured(errors, Curve(("t", "dissipation"), t, 2.0 * ours, t, 2.0 * exact))


SOURCE = "spectral_Re1600_512.gdiag (workshop on high-order CFD methods, case C3.5)"
QUICK = {}
FULL = {4: (PERIOD / 16, PERIOD / 32)}
WHY = "order p; these grids are far from what turbulence needs"
expected = of_order(float)
