"""A wall that moves drives gas against an elastic layer, behind which more gas lies.

The wall on the left moves in by 0.3 m and comes to rest, x = 0.3 sin^2(pi t / (2 time)), so
smoothly that the gas is compressed nearly without a loss. The layer is pushed over and swings. The
mass of each gas stays what it is to round-off, and the energy of all grows by the work of the wall.
"""

from math import pi

import numpy as np

from fsipetsc import FluidLayer, Option, Problem, SolidLayer, Wall
from fsipetsc.cases.common import Opt, constant, gas_of, line_at_rest, materials, solid_of

OPTIONS = (
    *materials(fluid_mu=1.8e-5, fluid_kappa=0.026, solid_modulus=1e7, solid_kappa=0.2),
    *materials(solid_density=100.0, solid_alpha=1000.0),
    Option("piston_time", float, 0.02, "s", "time that the wall takes", check="positive"),
)
DEFAULTS = {"fsi_h": 0.0125, "ts_max_time": 0.04, "fsi_output_dt": 5e-4}

STROKE, P0, T0 = 0.3, 1e5, 300.0


def build(opt: Opt) -> Problem:
    """The layer between X = 1 and X = 1.2, everything at rest under P0."""
    gas, solid, time = gas_of(opt, R=287.0), solid_of(opt), opt["piston_time"]
    still = constant(P0 / (gas.R * T0), 0.0, T0)

    def phase(t):
        return 0.5 * pi * np.minimum(t, time) / time

    def place(t):
        return STROKE * np.sin(phase(t)) ** 2

    def velocity(t):
        return STROKE * pi / time * np.sin(phase(t)) * np.cos(phase(t))

    layers = (
        FluidLayer("driven", gas, (0.0, 1.0), still),
        SolidLayer("layer", solid, (1.0, 1.2), line_at_rest(-P0, T0)),
        FluidLayer("behind", gas, (1.2, 2.2), still),
    )
    return Problem(layers, left=Wall(place, velocity=velocity), right=Wall(2.2))
