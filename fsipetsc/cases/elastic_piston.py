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
from fsipetsc.checks import Array, Fields
from fsipetsc.materials.solid import ElasticSolid

SUMMARY = "an elastic rod recedes from a gas or advances into it, with an exact solution"
OPTIONS = (
    Option("piston_way", str, "receding", "", "what the rod does", ("receding", "advancing")),
)
DEFAULTS = {"fsi_h": 1 / 40, "fsi_order": 4, "ts_max_time": 0.7, "fsi_output_dt": 0.1}

GAMMA, RHO, T = 1.4, 0.1, 1 / 1.4
P = RHO * T
#: the rod is -0.5 < X < 0, the gas goes to a wall that no wave reaches before t = 1.5
LENGTH, WIDTH = 0.5, 1.5
#: speed of waves in the rod
C = 2.0


class Solution:
    """Exact. way: -1 where the rod recedes, 1 where it advances."""

    def __init__(self, way: float) -> None:
        self.F = Polynomial([0.0, 0.0, 0.0, 0.0, 0.25 * way])
        self.speed = self.F.deriv()
        q = P * ((1.0 + 0.2 * self.speed) ** 7 - 1.0) / C
        self.f, self.g = 0.5 * (self.F + q.integ()), 0.5 * (self.F - q.integ())

    def rod(self, X: Array, t: float = 0.0) -> Fields:
        """Velocity, temperature, place."""
        to, fro = t - X / C, np.maximum(t + X / C, 0.0)  # no wave goes left before t = 0
        velocity = self.f.deriv()(to) + self.g.deriv()(fro)
        return [velocity, 1.0 + 0.0 * X, X + self.f(to) + self.g(fro)]

    def pressure(self, X: Array, t: float) -> Array:
        """Of the rod."""
        to, fro = t - X / C, np.maximum(t + X / C, 0.0)
        return P - C * (self.g.deriv()(fro) - self.f.deriv()(to))

    def gas(self, X: Array, t: float = 0.0) -> Fields:
        """Density, velocity, temperature on the grid between the rod and the wall."""
        x = X + (1.0 - X / WIDTH) * self.F(t)
        low, high = np.zeros_like(x), np.full_like(x, t)  # of s; beyond x = t the gas is at rest
        for _ in range(60):
            s = 0.5 * (low + high)
            outside = self.F(s) + (1.0 + 1.2 * self.speed(s)) * (t - s) < x
            low, high = np.where(outside, low, s), np.where(outside, s, high)
        u = np.where(x < t, self.speed(low), 0.0)
        c = 1.0 + 0.2 * u
        return [RHO * c**5, u, T * c**2]


def build(opt: Opt) -> BlockProblem:
    """The rod left of X = 0, the gas right of it."""
    exact = Solution(-1.0 if opt["piston_way"] == "receding" else 1.0)
    rod = ElasticSolid(C**2 / 3, C**2 / 3, 0.0, 1.0, 1.0, P, law="linear", heat="elastic")
    return stack(
        opt,
        Layer("rod", rod, (-LENGTH, 0.0), exact.rod, exact=exact.rod),
        Layer("gas", Fluid(0.0, 0.0, GAMMA, 1.0), (0.0, WIDTH), exact.gas, exact=exact.gas),
        lower=Free(exact.pressure),
        upper=Slip(),
        units="",
    )
