"""A plate that is clamped into the floor of a box of air rings: two space dimensions, a solid under a gas.

    python -m fsipetsc FILE.py                                # run it: three seconds; a minute when it is the first run
    mpiexec -n 2 python -m fsipetsc FILE.py -plate_lift 1e-3  # on two ranks, with an option of this file
    python -m fsipetsc FILE.py -help                          # all options, those of this file on top
    python -m fsipetsc plot NAME.h5 -o pictures               # draw the result; `info NAME.h5` says it in words
    python -m fsipetsc plot NAME.h5 -animate                  # a film of it; ParaView opens NAME.xdmf

This file is a case: data, and functions of X and Y. Change what you like and run it again: what is wrong is answered by one
message that names the line, or the layer, and what is expected there. All that a case may say: docs/cases.md.

What to expect here: a beam between two clamps would swing with omega = 22.37 sqrt(D / m) / length^2, that is a period of
0.00281 s; this plate is not that slender, and moves air: its period is 0.00292 s.
"""

import numpy as np

from fsipetsc import Fluid, Option, PlaneFluidLayer, PlaneProblem, PlaneSolid, PlaneSolidLayer

# What may stand at an edge. Of a gas: NoSlip, Slip, Open, Outflow; of a solid: Clamped, Roller, Free; of both: Given,
# and Periodic at the left and the right of all layers.
from fsipetsc.boundaries.plane import Clamped, Free, NoSlip

# One line for -help. The result is named after this file; NAME = "..." here would name it otherwise.
SUMMARY = "a plate clamped into the floor of a box of air rings"

# Options of this case: name, type, default, unit, meaning, and perhaps what is allowed. `-plate_lift 1e-3` sets one.
OPTIONS = (
    Option("plate_lift", float, 5e-4, "m", "how far the middle of the plate is lifted at the start"),
    Option("plate_density", float, 1000.0, "kg/m3", "density of the plate", check="positive"),
)

# Defaults of the program's own options for this case. Columns are h apart or nearly so: where a solid ends, one must be.
DEFAULTS = {
    "fsi_h": 0.00625,  # grid spacing [m]
    "fsi_order": 4,  # order of the differences: 2, 4, 6 or 8
    "ts_max_time": 0.004,  # the run begins at t = 0 and ends here [s]
    "fsi_output_dt": 0.0001,  # fields are saved that often [s]
    "fsi_points": (0.1,),  # X of points of interfaces whose motion, traction and heat flux are recorded in each step
}

P0, T0 = 1e5, 300.0  # of the air at the start: pressure [Pa], temperature [K]
BEGIN, END, THICK = 0.05, 0.15, 0.01  # the plate, which lies below Y = 0 [m]
WIDTH, HEIGHT = 0.2, 0.1  # of the box [m]


def build(opt):
    """The problem, for the options in force: opt["plate_lift"], opt["fsi_h"] and so on."""
    # Materials. A gas: viscosity [Pa s] (0: it slips along walls and solids), heat conductivity [W/(m K)], gamma, gas
    # constant R/M [J/(kg K)]. A solid: mu and lambda [Pa], heat conductivity, density [kg/m3], specific heat [J/(kg K)],
    # the pressure under which it is free of stress; law="neo-hookean" or "svk" would be another material.
    air = Fluid(mu=2e-5, kappa=0.026, gamma=1.4, R=287.0)
    plate = PlaneSolid(
        mu_e=4e7, lambda_e=8e7, kappa_e=0.2, m0=opt["plate_density"], alpha=1000.0, p_ref=P0, heat="elastic"
    )

    # Initial data: from arrays X and Y of coordinates [m], of one shape, for each unknown an array of that shape or one
    # number. The grid of the gas follows the plate; X and Y are those of the flat one.
    def still(X, Y):
        return P0 / (air.R * T0), 0.0, 0.0, T0  # density, velocity in x and y, temperature

    def lifted(X, Y):
        shape = np.sin(np.pi * (X - BEGIN) / (END - BEGIN)) ** 2
        return 0.0, 0.0, T0, X, Y + opt["plate_lift"] * shape  # velocity, temperature, where X, Y is

    # Layers from below: name, material, begin and end in Y [m], initial data, what stands left and right. A solid may cover a
    # part of X: `beside` of the gas says what the floor is there. cells: across the layer, else as many as fsi_h gives.
    # exact=function(X, Y, t) would let the errors be computed, forcing=function(X, Y, t) would add right-hand sides.
    layers = (
        PlaneSolidLayer("plate", plate, (-THICK, 0.0), lifted, X=(BEGIN, END), left=Clamped(), right=Clamped(), cells=8),
        PlaneFluidLayer("air", air, (0.0, HEIGHT), still, left=NoSlip(), right=NoSlip(), beside=NoSlip()),
    )
    # Below the plate a pressure that follows it, above the gas a wall.
    return PlaneProblem(layers, X=(0.0, WIDTH), lower=Free(P0), upper=NoSlip())
