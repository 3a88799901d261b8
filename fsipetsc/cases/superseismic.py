"""A shock in gas that runs along an elastic half space faster than its waves; its states are known.

The shock's foot runs along Y = 0 at the speed 1, with a P and an S wave behind it in the solid.
All is constant between fronts through the foot (J. W. Banks, W. D. Henshaw, D. W. Schwendeman, J.
Comput. Phys. 231 (2012) 3518, with the pressure force on the deformed face). The numbers below are
those of verify/superseismic.py, which derives them. The exact states are the data on all sides.
"""

import numpy as np

from fsipetsc import BlockProblem, Fluid
from fsipetsc.blocks.conditions import Given, Open
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases.common import SHOCKS, Opt, stack
from fsipetsc.checks import Array, Fields
from fsipetsc.materials.solid import ElasticSolid

OPTIONS = ()
DEFAULTS = {"fsi_h": 1 / 40, "ts_max_time": 0.5, "fsi_output_dt": 0.05, "fsi_norm": "L1", **SHOCKS}
#: gas ahead: density, temperature (p = rho T); Lame's constants; density of the solid is 1
RHO, T, LAMBDA, MU = 0.1114827, 0.09375, 0.1398307, 0.07203351
#: angle of the shock's normal, strengths of the P and the S wave; gas behind: rho, u, v, T
PHI, P_WAVE, S_WAVE = -0.0577610764136, -0.294687560053, 0.125425426543
BEHIND = 0.40332749096, 0.721181138995, -0.0417025872267, 0.225252990995
#: ends of the problem along the shock's way, height and depth [m]
ALONG, HEIGHT = (-0.5, 1.0), 0.75


def displacement(X: Array, Y: Array, t: float) -> tuple[Fields, Fields]:
    """(displacement, velocity) of the solid: each wave moves what it has passed."""
    moved, velocity = [0.0 * X, 0.0 * X], [0.0 * X, 0.0 * X]
    for strength, c, shear in (
        (P_WAVE, np.sqrt(LAMBDA + 2.0 * MU), False),
        (S_WAVE, np.sqrt(MU), True),
    ):
        n = c, -np.sqrt(1.0 - c * c)
        along = (-n[1], n[0]) if shear else n
        phase = n[0] * (X - t) + n[1] * Y
        for k in range(2):
            moved[k] = moved[k] + strength * along[k] * np.minimum(phase, 0.0)
            velocity[k] = velocity[k] - strength * along[k] * c * (phase < 0.0)
    return moved, velocity


def solid(X: Array, Y: Array, t: float = 0.0) -> Fields:
    """Return velocity, temperature, place."""
    moved, velocity = displacement(X, Y, t)
    return [*velocity, 1.0 + 0.0 * X, X + moved[0], Y + moved[1]]


def gas(X: Array, Y: Array, t: float = 0.0) -> Fields:
    """Density, velocity, temperature, on the grid that follows the solid below it."""
    x, y = (a + (1.0 - Y / HEIGHT) * b for a, b in zip((X, Y), displacement(X, 0.0 * Y, t)[0]))
    behind = np.cos(PHI) * (x - t) + np.sin(PHI) * y < 0.0
    return [np.where(behind, b, a) for a, b in zip((RHO, 0.0, 0.0, T), BEHIND)]


def build(opt: Opt) -> BlockProblem:
    """The solid below Y = 0, the gas above."""
    rho, u, v, hot = (lambda X, Y, t, k=k: gas(X, Y, t)[k] for k in range(4))
    outside = Open(rho, (u, v), hot)
    material = ElasticSolid(MU, LAMBDA, 0.0, 1.0, 1.0, RHO * T, law="linear", heat="elastic")
    return stack(
        opt,
        Layer("half space", material, (-HEIGHT, 0.0), solid, exact=solid, sides=Given(solid)),
        Layer("gas", Fluid(0.0, 0.0, 1.4, 1.0), (0.0, HEIGHT), gas, exact=gas, sides=outside),
        along=(ALONG,),
        lower=Given(solid),
        upper=outside,
    )
