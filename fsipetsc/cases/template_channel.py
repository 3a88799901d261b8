"""Gas flows through a plane channel: it comes in on the left and leaves on the right.

    python -m fsipetsc FILE.py                               # four seconds; more the first time
    mpiexec -n 2 python -m fsipetsc FILE.py -gas_speed 20    # on two ranks, with an option
    python -m fsipetsc plot NAME.h5 -o pictures              # draw the result

This file is a case: data, and functions of X and Y. docs/channels.md says which condition is for
which end, and why the inflow has a profile; docs/cases.md lists all that a case can say.

What to expect here: Poiseuille's flow, u = 6 U (Y/H) (1 - Y/H) with the mean velocity U = gas_speed
and the height H. The pressure falls by 12 mu U/H^2 = 84 kPa/m. In the middle half of the channel
the run has 86.4 kPa/m, with half the spacing 85.7: the gas expands, and so gets faster.
"""

from fsipetsc import Block, BlockProblem, Fluid, Option

# Conditions of faces of a gas: NoSlip, Slip, Open, Outflow, Given, Periodic.
from fsipetsc.blocks.conditions import NoSlip, Open
from fsipetsc.blocks.maps import rectangle

SUMMARY = "gas flows through a plane channel"
OPTIONS = (
    Option("gas_speed", float, 35.0, "m/s", "mean velocity", check="positive"),
    Option("gas_viscosity", float, 0.02, "Pa s", "a thousand times that of air", check="positive"),
)
DEFAULTS = {
    "fsi_h": 0.01 / 16,  # grid spacing [m]
    "fsi_order": 4,  # order of the differences: 2, 4, 6 or 8
    "fsi_dissipation": 1.0,  # corners make waves that the grid does not resolve: they decay
    "ts_max_time": 0.003,  # time enough to become steady [s]
    "fsi_output_dt": 1.5e-4,  # interval at which fields are saved [s]
}
HEIGHT, LENGTH, P0, T0 = 0.01, 0.04, 1e5, 300.0  # [m], pressure where the gas leaves [Pa], T [K]


def build(opt):
    """One block, four faces."""
    U, mu = opt["gas_speed"], opt["gas_viscosity"]
    gas = Fluid(mu=mu, kappa=1400.0 * mu, gamma=1.4, R=287.0)
    fall = 12.0 * mu * U / HEIGHT**2  # of the pressure, per length

    def density(X):
        return (P0 + fall * (LENGTH - X)) / (gas.R * T0)

    def velocity(X, Y, t=0.0):  # 0 at the walls, as the gas there: a jump would oscillate
        return 6.0 * U * (Y / HEIGHT) * (1.0 - Y / HEIGHT), 0.0

    def start(X, Y):  # density, velocity in x and y, temperature
        return density(X), *velocity(X, Y), T0

    cells = round(LENGTH / opt["fsi_h"]), round(HEIGHT / opt["fsi_h"])
    block = Block("gas", gas, rectangle((0.0, 0.0), (LENGTH, HEIGHT)), cells, start)
    faces = {  # (block, axis, side): what is beyond the ends, and walls of the temperature T0
        ("gas", 0, 0): Open(density(0.0), velocity, T0),
        ("gas", 0, 1): Open(density(LENGTH), velocity, T0),
        ("gas", 1, 0): NoSlip(T=T0),
        ("gas", 1, 1): NoSlip(T=T0),
    }
    return BlockProblem((block,), faces)
