"""A gas flows through a plane channel: what stands at its ends, and its walls.

    mpiexec -n 2 python -m fsipetsc runs/channel.py
    python -m fsipetsc runs/channel.py -channel_inflow uniform -fsi_dissipation -1  # it oscillates

The unit of length is the height of the channel, that of velocity the speed of sound, density and
temperature are 1 at the end where the gas leaves. The walls have the temperature 1.

-channel_inflow profile: the gas comes in with the parabola of Poiseuille's flow. uniform: with the
same velocity everywhere, though the gas sticks to the walls. slip: so, too, but in 0 < X < 1 the
gas slips along the walls. fringe: it slips there with a slip length that falls from 10 to fsi_h.
given: the parabola, and all unknowns are prescribed, one more than the gas allows. periodic: a
force drives the gas through a channel without ends.

Numbers to compare with: u = 6 U Y (1 - Y), with the mean velocity U, and p + rho u^2, also its
mean, falls by 12 mu U per length. 3,460 steps: a second; three more the first time.
"""

from fsipetsc import Block, BlockProblem, Fluid, Option
from fsipetsc.blocks.conditions import Given, NoSlip, Open, Slip
from fsipetsc.blocks.maps import rectangle

INFLOWS = ("profile", "uniform", "slip", "fringe", "given", "periodic")
OPTIONS = (
    Option("channel_inflow", str, "profile", "", "how the gas comes in", INFLOWS),
    Option("channel_mach", float, 0.1, "", "Mach number of the mean velocity", check="positive"),
    Option("channel_reynolds", float, 20.0, "", "of mean velocity and height", check="positive"),
)
DEFAULTS = {"fsi_h": 1 / 16, "fsi_order": 4, "ts_max_time": 80.0, "fsi_output_dt": 4.0}
GAMMA, LENGTH, ENTRY = 1.4, 4.0, 1.0
R, PRANDTL = 1.0 / GAMMA, 0.72


def build(opt):
    """A block for the entry and one for the rest."""
    U, inflow = opt["channel_mach"], opt["channel_inflow"]
    mu, periodic = U / opt["channel_reynolds"], inflow == "periodic"
    kappa, falls = mu / (PRANDTL * (GAMMA - 1.0)), 12.0 * mu * U
    gas = Fluid(mu, kappa, GAMMA, R, force=(falls, 0.0) if periodic else (0.0, 0.0))

    def parabola(Y):
        return 6.0 * U * Y * (1.0 - Y)

    def start(X, Y):
        rho = 1.0 + (0.0 if periodic else falls / R * (LENGTH - X))
        return rho, parabola(Y), 0.0, 1.0

    def cells(length):
        return max(8, round(length / opt["fsi_h"])), max(8, round(1.0 / opt["fsi_h"]))

    if periodic:
        whole = rectangle((0.0, 0.0), (ENTRY, 1.0))
        block = Block("channel", gas, whole, cells(ENTRY), start, periodic=(True, False))
        walls = {("channel", 1, side): NoSlip(T=1.0) for side in (0, 1)}
        return BlockProblem((block,), walls, units="none")

    blocks = (
        Block("entry", gas, rectangle((0.0, 0.0), (ENTRY, 1.0)), cells(ENTRY), start),
        Block("channel", gas, rectangle((ENTRY, 0.0), (LENGTH, 1.0)), cells(LENGTH - ENTRY), start),
    )
    first = 1.0 + falls / R * LENGTH  # density at the inflow

    def profile(X, Y, t):
        return parabola(Y), 0.0

    comes, leaves = Open(first, profile, 1.0), Open(1.0, profile, 1.0)
    if inflow in ("uniform", "slip", "fringe"):
        comes = Open(first, (U, 0.0), 1.0)
    if inflow == "given":
        comes = Given(lambda X, Y, t: (first, *profile(X, Y, t), 1.0))
    faces = {("entry", 0, 0): comes, ("channel", 0, 1): leaves}
    entry = NoSlip(T=1.0)
    if inflow == "slip":
        entry = Slip()
    if inflow == "fringe":
        entry = NoSlip(T=1.0, slip_length=lambda X, Y, t: 10.0 * (opt["fsi_h"] / 10.0) ** X)
    for side in (0, 1):
        faces |= {("entry", 1, side): entry, ("channel", 1, side): NoSlip(T=1.0)}
    return BlockProblem(blocks, faces, units="none")
