"""An elastic ring around a gas that is compressed on one side: curved blocks.

    python -m fsipetsc FILE.py                                 # ten seconds; more the first time
    mpiexec -n 2 python -m fsipetsc FILE.py -ring_density 500  # on two ranks, with an option
    python -m fsipetsc FILE.py -help                           # all options
    python -m fsipetsc plot NAME.h5 -o pictures                # draw the result
    python -m fsipetsc plot NAME.h5 -animate                   # a film of it; ParaView: NAME.xdmf

This file is a case: data, and functions of X and Y. Change what you like and run it again. If
something is wrong, one message names the block, the face and the place. docs/cases.md lists all
that a case can say.

What to expect here: gas and ring act as springs; the radius of the ring, E = 3/4 ring_modulus,
oscillates with
    omega^2 = (E h/r^2 + 2 gamma P0 r/(r^2 - r_pipe^2)) / (density h),    h = 0.1 m, r = 0.4 m.
This is for thin rings: it gives the period 0.018 s, the computed one is 0.019 s. With the pulse as
it is the ring widens by 5.6 mm. It also bends into an ellipse.
"""

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.block_problem import BlockProblem

# Conditions of faces. Of a gas: NoSlip, Slip, Open, Outflow; of a solid: Clamped, Free,
# Roller; of both: Given and Periodic.
from fsipetsc.blocks.conditions import Free, Slip

# Maps of the unit square to a block: rectangle, corners, annulus, transfinite, nodes, or any
# function of (xi_0, xi_1), arrays of numbers from 0 to 1, that returns X and Y and is smooth.
from fsipetsc.blocks.maps import annulus

# Functions whose bits are the same on all machines, which numpy's are not.
from fsipetsc.equations.elementary import exp, power
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.options import Option

# One line for -help. The result is named after this file; NAME = "..." would name it otherwise.
SUMMARY = "an elastic ring around a gas that is compressed on one side"

# Options of this case: name, type, default, unit, meaning, and perhaps what is allowed.
OPTIONS = (
    Option("ring_modulus", float, 1e6, "Pa", "2 mu + lambda of the ring", check="positive"),
    Option("ring_density", float, 100.0, "kg/m3", "density of the ring", check="positive"),
    Option("pulse", float, 2.0, "", "overpressure of the pulse / pressure of the air"),
)

# Defaults of the program's own options for this case. Blocks have numbers of cells; build computes
# them from fsi_h below.
DEFAULTS = {
    "fsi_h": 0.02,  # grid spacing [m]
    "fsi_order": 4,  # order of the differences: 2, 4, 6 or 8
    "ts_max_time": 0.02,  # the run begins at t = 0 and ends here [s]
    "fsi_output_dt": 0.0004,  # interval at which fields are saved [s]
}

P0, T0 = 1e5, 300.0  # of the air at the start: pressure [Pa], temperature [K]
PIPE, INNER, OUTER = 0.1, 0.4, 0.5  # radii: of the pipe in the middle, of the ring [m]


def build(opt):
    """The problem, for the options in force: opt["ring_density"], opt["fsi_h"] and so on."""
    # Materials. A gas: viscosity [Pa s] (0: it slips along walls and solids), heat conductivity
    # [W/(m K)], gamma, gas constant R/M [J/(kg K)]. A solid: mu and lambda [Pa], heat conductivity,
    # density [kg/m3], specific heat [J/(kg K)], the pressure under which it is free of stress;
    # law="log", "svk" or "linear" would be another material.
    air = Fluid(mu=0.0, kappa=0.0, gamma=1.4, R=287.0)
    K, density = opt["ring_modulus"], opt["ring_density"]
    rubber = ElasticSolid(
        K / 4, K / 2, 0.0, m0=density, alpha=1500.0, p_ref=P0, law="neo-hookean", heat="elastic"
    )

    # Initial data: functions of arrays X and Y of coordinates [m] of the map. They return, for each
    # unknown, an array of their shape or one number. The grid of a gas follows the solids.
    def pulse(X, Y):
        p = P0 * (1.0 + opt["pulse"] * exp(-((X - 0.25) ** 2 + Y**2) / 0.05**2))
        T = T0 * power(p / P0, 1.0 - 1.0 / air.gamma)
        return p / (air.R * T), 0.0, 0.0, T  # density, velocity in x and y, temperature

    def at_rest(X, Y):
        return 0.0, 0.0, T0, X, Y  # velocity, temperature, where X, Y is

    # Blocks: name, material, map, cells along its axes, initial data. Axes of an annulus: along the
    # radius, and around, where it is periodic. Faces with the same nodes are connected. With
    # exact=function(X, Y, t) errors are printed; forcing=function(X, Y, t) adds right-hand sides.
    def cells(thickness):
        return max(8, round(thickness / opt["fsi_h"]))

    around, loop = 8 * round(np.pi * INNER / 8 / opt["fsi_h"]), (False, True)
    inside, outside = (cells(INNER - PIPE), around), (cells(OUTER - INNER), around)
    blocks = (
        Block("gas", air, annulus(PIPE, INNER), inside, pulse, periodic=loop),
        Block("ring", rubber, annulus(INNER, OUTER), outside, at_rest, periodic=loop),
    )
    # Each other face has a condition: (block, axis, side), side 0 at xi = 0. In the middle is a
    # pipe, along which the gas slips; outside, a pressure follows the ring.
    faces = {("gas", 0, 0): Slip(), ("ring", 0, 1): Free(P0)}
    return BlockProblem(blocks, faces)
