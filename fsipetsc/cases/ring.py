"""An elastic ring with gas inside and outside: curved blocks.

    mpiexec -n 2 python -m fsipetsc FILE.py -ring_pulse 1      # a second; more the first time
    python -m fsipetsc plot NAME.h5 -o pictures                # draw the result
    python -m fsipetsc plot NAME.h5 -animate                   # a film of it; ParaView: NAME.xdmf

The gas reaches from a rigid core to a rigid vessel. All begins at rest but for a pulse of pressure
in the gas inside, which bends the ring. What to expect: small motions into an ellipse go as
exp(i omega t), omega = 0.118, 1.720, 2.089 … (python -m fsipetsc modes ring). docs/cases.md lists
conditions of faces, maps and laws.
"""

import numpy as np

from fsipetsc import Block, BlockProblem, ElasticSolid, Fluid, Option
from fsipetsc.blocks.conditions import Free, Slip
from fsipetsc.blocks.maps import annulus

# exp, power: of the same bits on all machines, which numpy's are not
from fsipetsc.equations.elementary import exp, power

OPTIONS = (
    Option("ring_gas", bool, True, "", "gas inside and outside; else the ring is in a vacuum"),
    Option("ring_pulse", float, 0.5, "Pa", "overpressure; else p is 1", check="nonnegative"),
    Option("ring_around", int, None, "", "cells around; default: by -fsi_h", check="positive"),
    Option("solid_law", str, "neo-hookean", "", "law of the ring", ("neo-hookean", "log", "svk")),
)
DEFAULTS = {"fsi_h": 0.025, "fsi_order": 6, "ts_max_time": 3.0, "fsi_output_dt": 0.05}
CORE, INNER, OUTER, VESSEL = 0.4, 1.0, 1.3, 2.0  # radii [m]


def build(opt):
    """The problem, for the options in force."""
    p0, h = 1.0 if opt["ring_gas"] else 0.0, opt["fsi_h"]
    gas = Fluid(mu=0.0, kappa=0.0, gamma=1.4, R=1.0)  # without viscosity it slips along walls
    # mu, lambda, heat conductivity, density, specific heat, pressure at which it is unstrained
    solid = ElasticSolid(1.0, 1.5, 0.0, 2.0, 1.0, p0, opt["solid_law"], heat="elastic")

    # Initial data: functions of arrays X and Y of coordinates of the map, which return, for each
    # unknown, an array of their shape or one number. The grid of a gas follows the solids.
    def pulse(X, Y):
        p = 1.0 + opt["ring_pulse"] * exp(-((X - 0.7) ** 2 + Y**2) / 0.2**2)
        rho = power(p, 1.0 / gas.gamma)
        return rho, 0.0, 0.0, p / rho  # density, velocity in x and y, temperature

    def at_rest(X, Y):
        return 0.0, 0.0, 1.0, X, Y  # velocity, temperature, where X, Y is

    # Blocks: name, material, map, cells along its axes, initial data. Axes of an annulus: along the
    # radius, and around, where it is periodic. Faces with the same nodes are connected.
    def block(name, material, inner, outer, initial):
        around = opt["ring_around"] or max(24, 8 * round(2.0 * np.pi * INNER / (32.0 * h)))
        cells = max(2 * opt["fsi_order"], round((outer - inner) / h)), around
        return Block(name, material, annulus(inner, outer), cells, initial, periodic=(False, True))

    ring = block("ring", solid, INNER, OUTER, at_rest)
    # Each other face (block, axis, side) has a condition; side 0 is at the beginning of the axis.
    if not opt["ring_gas"]:
        free = {("ring", 0, 0): Free(), ("ring", 0, 1): Free()}
        return BlockProblem((ring,), free, units="none")
    inside = block("inside", gas, CORE, INNER, pulse)
    outside = block("outside", gas, OUTER, VESSEL, lambda X, Y: (1.0, 0.0, 0.0, 1.0))
    faces = {("inside", 0, 0): Slip(), ("outside", 0, 1): Slip()}
    return BlockProblem((inside, ring, outside), faces, units="none")
