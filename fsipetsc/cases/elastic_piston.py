"""An elastic rod that recedes from a gas, or advances into it, with an exact solution: solid | gas.

The interface moves as F(t) = -t^4/4 or t^4/4. The gas (gamma = 1.4, speed of sound 1 at rest) is a
simple wave: u = F'(s) along x = F(s) + (1 + 1.2 F'(s)) (t - s). The rod is linear elastic, of
density 1 and wave speed c = 2,

    displacement f(t - X/c) + g(t + X/c),    f' = (F' + q/c)/2,    g' = (F' - q/c)/2,

q = p - p0 at the interface. Nothing is viscous or conducts heat. After the elastic piston of J. W.
Banks, W. D. Henshaw, D. W. Schwendeman, J. Comput. Phys. 231 (2012) 3518-3547.
"""

import numpy as np
from numpy.polynomial import Polynomial

from fsipetsc import BlockProblem, Fluid, Option
from fsipetsc.blocks.conditions import Free, Slip
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases.common import Opt, stack
from fsipetsc.materials.solid import ElasticSolid

OPTIONS = (
    Option("piston_way", str, "receding", "", "what the rod does", ("receding", "advancing")),
)
DEFAULTS = {"fsi_h": 1 / 40, "ts_max_time": 0.7, "fsi_output_dt": 0.1}

GAMMA, RHO, T = 1.4, 0.1, 1 / 1.4
P = RHO * T
#: the rod is -0.5 < X < 0, the gas goes to a wall that no wave reaches before t = 1.5
LENGTH, WIDTH = 0.5, 1.5
#: speed of waves in the rod
C = 2.0


def build(opt: Opt) -> BlockProblem:
    """The rod left of X = 0, the gas right of it."""
    F = Polynomial([0.0, 0.0, 0.0, 0.0, -0.25 if opt["piston_way"] == "receding" else 0.25])
    speed = F.deriv()
    q = P * ((1.0 + 0.2 * speed) ** 7 - 1.0) / C
    f, g = 0.5 * (F + q.integ()), 0.5 * (F - q.integ())

    def rod(X, t=0.0):
        to, fro = t - X / C, np.maximum(t + X / C, 0.0)  # no wave goes left before t = 0
        return f.deriv()(to) + g.deriv()(fro), 1.0, X + f(to) + g(fro)

    def pressure(X, t):
        """Return the pressure of the rod [Pa]."""
        return P - C * (g.deriv()(np.maximum(t + X / C, 0.0)) - f.deriv()(t - X / C))

    def gas(X, t=0.0):
        """Return (rho, u, T) on the grid between the rod and the wall."""
        x = X + (1.0 - X / WIDTH) * F(t)
        low, high = np.zeros_like(x), np.full_like(x, t)  # of s; beyond x = t the gas is at rest
        for _ in range(60):
            s = 0.5 * (low + high)
            outside = F(s) + (1.0 + 1.2 * speed(s)) * (t - s) < x
            low, high = np.where(outside, low, s), np.where(outside, s, high)
        u = np.where(x < t, speed(low), 0.0)
        c = 1.0 + 0.2 * u
        return RHO * c**5, u, T * c**2

    solid = ElasticSolid(C**2 / 3, C**2 / 3, 0.0, 1.0, 1.0, P, law="linear", heat="elastic")
    return stack(
        opt,
        Layer("rod", solid, (-LENGTH, 0.0), rod, exact=rod),
        Layer("gas", Fluid(0.0, 0.0, GAMMA, 1.0), (0.0, WIDTH), gas, exact=gas),
        lower=Free(pressure),
        upper=Slip(),
        units="",
    )
