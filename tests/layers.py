"""Gas | solid | gas | solid | gas between walls; the gases have pulses."""

import numpy as np

from fsipetsc.boundaries import Wall
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import Solid
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

OPTIONS = (
    Option("layers_gruneisen", "float", 0.0, "", "p = G rho epsilon in the solids"),
    Option("layers_moving", "bool", False, "", "the left wall is pushed in"),
)
DEFAULTS = {"fsi_h": 0.05, "fsi_order": 4, "ts_max_time": 1.0, "fsi_output_dt": 0.5}


def build(opt):
    """Layers of length 1; the gases have the pressure 1 but for a pulse."""
    gas = Fluid(0.01, 0.03, 1.4, 1.0)
    solid = Solid(20.0, 0.02, 2.0, 1.0, gruneisen=opt["layers_gruneisen"])

    def at_rest(X):
        return [0 * X, 0 * X + solid.pressure(1.0, 1.0) - 1.0, 1 + 0 * X, X]

    def layer(k):
        def pulse(X):
            return [1 + 0.2 * np.exp(-60 * (X - k - 0.4) ** 2), 0 * X, 1 + 0 * X]

        X = float(k), float(k + 1)
        if k % 2:
            return SolidLayer(f"bar {k}", solid, X, at_rest)
        return FluidLayer(f"gas {k}", gas, X, pulse)

    place = (lambda t: 0.05 * t * t) if opt["layers_moving"] else 0.0
    return Problem(tuple(map(layer, range(5))), Wall(place), Wall(5.0), units="none")
