"""Gas flows through a plane channel: it comes in on the left and leaves on the right.

    mpiexec -n 2 python -m fsipetsc FILE.py -gas_speed 35    # a second; more the first time
    python -m fsipetsc plot NAME.h5 -o pictures              # draw the result

What to expect: Poiseuille's flow, u = 6 U (Y/H) (1 - Y/H) with the mean velocity U = gas_speed and
the height H. The pressure falls by 12 mu U/H^2 = 84 kPa/m, here by 86.5 in the middle half, as the
gas expands. docs/channels.md says which end has which condition, and why the inflow has a profile.
"""

from fsipetsc import Block, BlockProblem, Fluid, Option
from fsipetsc.blocks.conditions import NoSlip, Open
from fsipetsc.blocks.maps import rectangle

OPTIONS = (Option("gas_speed", float, 35.0, "m/s", "mean velocity", check="positive"),)
# With dissipation what the grid does not resolve at corners decays. At the end the flow is steady.
DEFAULTS = {"fsi_h": 0.01 / 16, "fsi_dissipation": 1.0, "ts_max_time": 0.003}
DEFAULTS |= {"fsi_output_dt": 1.5e-4}
HEIGHT, LENGTH, P0, T0 = 0.01, 0.04, 1e5, 300.0  # P0: where the gas leaves; m, Pa, K


def build(opt):
    """One block, two ends that are open, and two walls of the temperature T0."""
    U = opt["gas_speed"]
    gas = Fluid(mu=0.02, kappa=28.0, gamma=1.4, R=287.0)  # a thousand times as viscous as air
    fall = 12.0 * gas.mu * U / HEIGHT**2

    def density(X):
        return (P0 + fall * (LENGTH - X)) / (gas.R * T0)

    def velocity(X, Y, t=0.0):  # 0 at the walls, as there: if it jumped, it would oscillate
        return 6.0 * U * (Y / HEIGHT) * (1.0 - Y / HEIGHT), 0.0

    def start(X, Y):  # density, velocity in x and y, temperature
        return density(X), *velocity(X, Y), T0

    cells = round(LENGTH / opt["fsi_h"]), round(HEIGHT / opt["fsi_h"])
    block = Block("gas", gas, rectangle((0.0, 0.0), (LENGTH, HEIGHT)), cells, start)
    # Faces (block, axis, side): what is beyond the ends, and the walls.
    ends = {("gas", 0, s): Open(density(s * LENGTH), velocity, T0) for s in (0, 1)}
    walls = {("gas", 1, s): NoSlip(T=T0) for s in (0, 1)}
    return BlockProblem((block,), {**ends, **walls})
