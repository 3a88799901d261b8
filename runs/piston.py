"""A heavy piston flies into a closed cylinder of gas, bounces and comes back: gas | solid.

    mpiexec -n 2 python -m fsipetsc runs/piston.py

A case of one's own, as short as it gets. The gas lies between a wall at x = 0 and the piston; on
the piston's back the outer pressure acts. It shows a layer that loses 15 of its 41 grid points to
the moving boundary and gets them back, and an exact number to compare with: the compression is
adiabatic, so the energy balance gives the turning point, x = 0.6091 m, to four digits. 1,600 steps,
less than a second.
"""

from fsipetsc import Fluid, FluidLayer, Option, Problem, Solid, SolidLayer, Wall, free

OPTIONS = (
    Option("piston_speed", float, 25.0, "m/s", "initial speed of the piston"),
    Option("piston_density", float, 250.0, "kg/m3", "density of the piston", check="positive"),
    Option("piston_thickness", float, 0.2, "m", "thickness of the piston", check="positive"),
)
DEFAULTS = {
    "fsi_h": 0.025,
    "ts_max_time": 0.05,
    "fsi_output_dt": 0.001,
    "fsi_coupling": "energy",
    "fsi_mapping": "rigid",
}
P0, T0 = 1e5, 300.0


def build(opt):
    """Gas in 0 < X < 1, the piston right of it."""
    air = Fluid(mu=2e-5, kappa=0.026, gamma=1.4, R=287.0)
    steel = Solid(K=1e8, kappa_e=0.0, m0=opt["piston_density"], alpha=500.0)  # lets no heat in

    def gas(X):
        return P0 / (air.R * T0), -opt["piston_speed"] * X, T0  # no shock at the start

    def piston(X):
        return -opt["piston_speed"], -P0, T0, X

    layers = (
        FluidLayer("gas", air, (0.0, 1.0), gas),
        SolidLayer("piston", steel, (1.0, 1.0 + opt["piston_thickness"]), piston),
    )
    return Problem(layers, left=Wall(0.0), right=free(-P0))
