"""Hot gas against a cold block: the gas's transport follows Sutherland's law. gas | solid.

    mpiexec -n 2 python -m fsipetsc runs/sutherland.py

A gas of one's own, as short as it gets: mu and kappa grow with T as mu(T)/mu = (T/T_0)^(3/2) (T_0 +
S)/(T + S), T_0 = 273 K, S = 111 K for air (W. Sutherland, Philosophical Magazine 36 (1893) 507; F.
M. White, Viscous Fluid Flow, Table 1-2). The gas is as thick as glycerine, so that heat gets
somewhere within the time. -hot_law 0 leaves mu and kappa constant, -hot_law 2 takes the built-in
law, which is the same.
"""

import numpy as np

from fsipetsc import Fluid, FluidLayer, Option, Problem, Solid, SolidLayer, Wall, free
from fsipetsc.materials.own import transport_law
from fsipetsc.materials.sutherland import sutherland

OPTIONS = (
    Option("hot_T", float, 1200.0, "K", "temperature of the gas at the wall", check="positive"),
    Option("hot_law", int, 1, "", "1: Sutherland's, 2: the built-in one, 0: constant", (0, 1, 2)),
)
DEFAULTS = {"fsi_h": 0.02, "ts_max_time": 0.02, "fsi_output_dt": 0.002}
P0, COLD, T_0, S = 1e5, 300.0, 273.0, 111.0


def relative(T):
    """mu(T)/mu(T_0), and kappa(T)/kappa(T_0)."""
    return np.sqrt(T / T_0) * (T / T_0) * ((T_0 + S) / (T + S))


def build(opt):
    """Gas in 0 < X < 1, hot on the left and as cold as the block on its right."""
    transport = (None, transport_law(relative), sutherland(T_0, S))[opt["hot_law"]]
    air = Fluid(mu=1.0, kappa=1400.0, gamma=1.4, R=287.0, transport=transport)
    block = Solid(K=1e8, kappa_e=1000.0, m0=250.0, alpha=500.0)

    def gas(X):  # no heat through either end
        T = COLD + (opt["hot_T"] - COLD) * np.cos(0.5 * np.pi * X) ** 2
        return P0 / (air.R * T), 0.0, T

    def cold(X):
        return 0.0, -P0, COLD, X

    layers = FluidLayer("gas", air, (0.0, 1.0), gas), SolidLayer("block", block, (1.0, 1.2), cold)
    return Problem(layers, left=Wall(0.0), right=free(-P0))
