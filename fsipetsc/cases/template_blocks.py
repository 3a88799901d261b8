"""An elastic ring around a gas that is compressed on one side: curved blocks.

    mpiexec -n 2 python -m fsipetsc FILE.py -ring_density 500  # on two ranks, with an option
    python -m fsipetsc plot NAME.h5 -o pictures                # draw the result
    python -m fsipetsc plot NAME.h5 -animate                   # a film of it; ParaView: NAME.xdmf

What to expect: gas and ring act as springs. A thin ring, E = 3/4 ring_modulus, oscillates with
    omega^2 = (E h/r^2 + 2 gamma P0 r/(r^2 - r_pipe^2)) / (density h),    h = 0.1 m, r = 0.4 m,
the period 0.018 s; the computed one is 0.019 s. docs/cases.md lists conditions, maps and laws.
"""

import numpy as np

from fsipetsc import Block, BlockProblem, Fluid, Option
from fsipetsc.blocks.conditions import Free, Slip
from fsipetsc.blocks.maps import annulus

# Functions whose bits are the same on all machines, which numpy's are not.
from fsipetsc.equations.elementary import exp, power
from fsipetsc.materials.solid import ElasticSolid

SUMMARY = "an elastic ring around a gas that is compressed on one side"
OPTIONS = (
    Option("ring_modulus", float, 1e6, "Pa", "2 mu + lambda of the ring", check="positive"),
    Option("ring_density", float, 100.0, "kg/m3", "density of the ring", check="positive"),
    Option("pulse", float, 2.0, "", "overpressure of the pulse / pressure of the air"),
)
DEFAULTS = {"fsi_h": 0.02, "ts_max_time": 0.02, "fsi_output_dt": 0.0004}
P0, T0 = 1e5, 300.0  # of the air at the start: pressure [Pa], temperature [K]
PIPE, INNER, OUTER = 0.1, 0.4, 0.5  # radii: of the pipe in the middle, of the ring [m]


def build(opt):
    """The problem, for the options in force."""
    # A solid: mu and lambda [Pa], heat conductivity, density [kg/m3], specific heat [J/(kg K)], the
    # pressure under which it is free of stress.
    air = Fluid(mu=0.0, kappa=0.0, gamma=1.4, R=287.0)
    K, density = opt["ring_modulus"], opt["ring_density"]
    rubber = ElasticSolid(K / 4, K / 2, 0.0, density, 1500.0, P0, "neo-hookean", heat="elastic")

    # Initial data: functions of arrays X and Y of coordinates [m] of the map.
    def pulse(X, Y):
        p = P0 * (1.0 + opt["pulse"] * exp(-((X - 0.25) ** 2 + Y**2) / 0.05**2))
        T = T0 * power(p / P0, 1.0 - 1.0 / air.gamma)
        return p / (air.R * T), 0.0, 0.0, T  # density, velocity in x and y, temperature

    def at_rest(X, Y):
        return 0.0, 0.0, T0, X, Y  # velocity, temperature, where X, Y is

    # Blocks: name, material, map, cells along its axes, initial data. Axes of an annulus: along the
    # radius, and around, where it is periodic. Faces with the same nodes are connected.
    def ring(name, material, inner, outer, initial):
        around = 8 * round(np.pi * INNER / 8 / opt["fsi_h"])
        cells = max(8, round((outer - inner) / opt["fsi_h"])), around
        return Block(name, material, annulus(inner, outer), cells, initial, periodic=(False, True))

    blocks = (
        ring("gas", air, PIPE, INNER, pulse),
        ring("ring", rubber, INNER, OUTER, at_rest),
    )
    # Each other face (block, axis, side) has a condition: the gas slips along a pipe in the middle,
    # outside a pressure follows the ring.
    return BlockProblem(blocks, {("gas", 0, 0): Slip(), ("ring", 0, 1): Free(P0)})
