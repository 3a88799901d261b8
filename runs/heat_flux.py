"""Heat goes from a warm wall to a cold one: through air, a board of foam, and air again.

    mpiexec -n 2 python -m fsipetsc runs/heat_flux.py

Gas | solid | gas, each 2 cm thick, at 280 K at first. Then the inner wall becomes warm, and a
steady flux of heat comes about, which is that of resistances in series. The layers are plane, or
with -flux_symmetry 1 and 2 around an axis (a pipe) or a centre, the inner wall at r = 2 cm.

Heat is slow and sound is fast: a real minute would take a hundred million steps. So kappa of all
layers and mu are -flux_faster times those of air and foam: all that conduction does takes that part
of the time, and fluxes are that much larger, as long as sound remains much faster (docs/heat.md).
"""

import numpy as np

from fsipetsc import Block, BlockProblem, ElasticSolid, Fluid, Option
from fsipetsc.blocks.conditions import NoSlip
from fsipetsc.blocks.maps import rectangle

OPTIONS = (
    Option("flux_symmetry", int, 0, "", "0: plane, 1: around an axis, 2: a centre", (0, 1, 2)),
    Option("flux_warm", float, 300.0, "K", "temperature of the inner wall", check="positive"),
    Option("flux_faster", float, 1e4, "", "conductivities over the real ones", check="positive"),
    Option("flux_foam", float, 0.035, "W/(m K)", "conductivity of the foam", check="positive"),
)
DEFAULTS = {"fsi_h": 0.002, "ts_max_time": 0.7, "fsi_output_dt": 0.007}

P0, COLD = 1e5, 280.0
#: [m] of the layers; [s] in which the real inner wall would become warm
X, RAMP = (0.02, 0.04, 0.06, 0.08), 20.0


def build(opt):
    """The layers between two walls that keep their temperatures."""
    faster, warm = opt["flux_faster"], opt["flux_warm"]
    air = Fluid(mu=1.8e-5 * faster, kappa=0.026 * faster, gamma=1.4, R=287.0)
    foam = ElasticSolid(2e6, 4e6, opt["flux_foam"] * faster, m0=30.0, alpha=1300.0, p_ref=P0)

    def gas(x):
        return P0 / (air.R * COLD), 0.0, COLD

    def heated(x, t):
        return warm + (COLD - warm) * np.exp(-t * faster / RAMP)

    def solid(x):
        return 0.0, COLD, x

    layers = ("inner", air, gas), ("foam", foam, solid), ("outer", air, gas)
    cells = (max(2 * opt["fsi_order"], round(0.02 / opt["fsi_h"])),)
    blocks = [
        Block(name, material, rectangle(low, high), cells, initial)
        for (name, material, initial), low, high in zip(layers, X, X[1:])
    ]
    faces = {("inner", 0, 0): NoSlip(T=heated), ("outer", 0, 1): NoSlip(T=COLD)}
    return BlockProblem(tuple(blocks), faces, symmetry=opt["flux_symmetry"])
