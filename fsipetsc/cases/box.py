"""Gas | solid | gas in a closed box with adiabatic walls, which conserves mass and energy.

The gas on the left is hotter and under a higher pressure than that on the right; within the solid
stress and temperature go smoothly from one to the other. So the solid is pushed to the right,
swings between two cushions of gas and conducts heat. At the walls and interfaces the initial state
is flat to the sixth derivative, so that it satisfies all conditions there, as time goes on, too.
"""

import numpy as np

from fsipetsc import FluidLayer, Problem, SolidLayer, Wall
from fsipetsc.cases.common import Opt, constant, gas_of, materials, solid_of
from fsipetsc.checks import Array

OPTIONS = (
    *materials(fluid_mu=0.01, fluid_kappa=0.03, fluid_gamma=1.4, solid_modulus=20.0),
    *materials(solid_kappa=0.02, solid_density=2.0, solid_alpha=1.0, solid_gruneisen=0.0),
)
DEFAULTS = {"fsi_h": 0.0125, "ts_max_time": 2.0, "fsi_output_dt": 0.05}

#: walls and interfaces; pressure and temperature on the left and on the right
X, P, T = (0.0, 1.0, 2.0, 3.0), (2.2, 2.0), (5.0, 4.0)


def smooth_step(z: Array) -> Array:
    """Polynomial that goes from 0 at z = 0 to 1 at z = 1, flat to the sixth derivative at both."""
    return z**7 * np.polyval([924, -6006, 16380, -24024, 20020, -9009, 1716], z)


def build(opt: Opt) -> Problem:
    """The solid between X = 1 and X = 2, the walls at 0 and 3."""
    gas, solid = gas_of(opt), solid_of(opt)
    left, right = (constant(p / (gas.R * t), 0.0, t) for p, t in zip(P, T))

    def between(X_s):
        done = smooth_step(X_s - X[1])
        p, t = P[0] + (P[1] - P[0]) * done, T[0] + (T[1] - T[0]) * done
        return [np.zeros_like(X_s), solid.pressure(t, 1.0) - p, t, X_s]

    layers = (
        FluidLayer("left", gas, X[0:2], left),
        SolidLayer("solid", solid, X[1:3], between),
        FluidLayer("right", gas, X[2:4], right),
    )
    return Problem(layers, Wall(X[0]), Wall(X[3]), units="none")
