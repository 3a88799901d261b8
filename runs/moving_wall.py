"""A piston whose way is a table drives gas in a long tube.

    mpiexec -n 2 python -m fsipetsc runs/moving_wall.py

The table has samples of x = A sin^4(pi t/P), which stand for a measured motion. A spline of
SciPy goes through them; velocity and acceleration of the wall are its derivatives. -wall_way exact
takes the function itself, -wall_way lines joins the samples by straight lines.

A number to compare with: the gas has no viscosity and its far end is open, so the piston makes a
simple wave. The pressure on it is p0 (1 + (gamma - 1)/2 v/c0)^(2 gamma/(gamma - 1)) at the velocity
v of the piston, at any time. A second.
"""

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from fsipetsc import Fluid, FluidLayer, Open, Option, Piecewise, Problem, Wall

OPTIONS = (
    Option("wall_way", str, "spline", "", "interpolant", ("spline", "pchip", "lines", "exact")),
    Option("wall_samples", int, 25, "", "samples of the table", check="positive"),
)
DEFAULTS = {"fsi_h": 0.01, "fsi_order": 4, "ts_max_time": 0.01, "fsi_output_dt": 1e-4}

A, P, P0, T0 = 0.1, 0.01, 1e5, 300.0


def way(t):
    """The exact motion [m]."""
    return A * (np.sin(np.pi * t / P) ** 2) ** 2


def build(opt):
    """Gas in 0 < X < 2; the piston starts at X = 0."""
    air = Fluid(mu=0.0, kappa=0.0, gamma=1.4, R=287.0)
    t = np.linspace(0.0, P, opt["wall_samples"])
    x = way(t)
    piston = {
        "spline": Piecewise(CubicSpline(t, x, bc_type="clamped")),  # at rest at both ends
        "pchip": Piecewise(PchipInterpolator(t, x)),
        "lines": lambda now: np.interp(now, t, x),
        "exact": way,
    }[opt["wall_way"]]

    def still(X):
        return P0 / (air.R * T0), 0.0, T0

    gas = FluidLayer("gas", air, (0.0, 2.0), still)
    return Problem((gas,), left=Wall(piston), right=Open(2.0, P0, T0))
