"""A wave along the interface of a gas and an elastic layer, a normal mode of known rate s.

Gas above, between the interface and a rigid adiabatic wall, solid below, on a clamped end; both
at rest but for the mode of the linear equations (fsipetsc.cases.normal_mode), whose size is
small. What is exact to that size goes as exp(s t).
"""

import numpy as np

from fsipetsc import BlockProblem
from fsipetsc.blocks.conditions import Clamped, NoSlip, Slip
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases.common import Opt, elastic_of, gas_of, materials, stack
from fsipetsc.cases.normal_mode import slowest_wave

SUMMARY = "a normal mode of a gas over an elastic layer, whose frequency and decay are known"

OPTIONS = (
    *materials(fluid_mu=0.01, fluid_kappa=0.035 / 0.72, solid_density=1.0),
    *materials(solid_mu=1.0, solid_lambda=1.0),
)
DEFAULTS = {"fsi_h": 1 / 32, "fsi_order": 4, "ts_max_time": 1.0, "fsi_output_dt": 0.05}
#: wave number [1/m], displacement of the interface, height of the gas, depth of the solid [m]
K, SIZE, HEIGHT, DEPTH = 2.0 * np.pi, 1e-5, 1.0, 0.5


def build(opt: Opt) -> BlockProblem:
    """The solid below Y = 0, the gas above."""
    air, body = gas_of(opt), elastic_of(opt)
    mode = slowest_wave(air, body, K, HEIGHT, DEPTH)

    def swinging(amplitudes, X, Y, t):
        """Real parts of the amplitudes times exp(i k X + s t)."""
        phase = SIZE * np.exp(1j * K * X + mode.s * t)
        return [np.real(of_height(Y) * phase) for of_height in amplitudes]

    def gas(X, Y, t=0.0):
        rho, u, v, T = swinging(mode.gas, X, Y, t)
        return 1.0 + rho, u, v, 1.0 + T

    def solid(X, Y, t=0.0):
        x, y, u, v = swinging(mode.solid, X, Y, t)
        # without conduction and work of the stresses its temperature stays
        return u, v, 1.0, X + x, Y + y

    note = f"the mode goes as exp(s t), s = {mode.s.real:.9f} {mode.s.imag:+.9f} i"
    return stack(
        opt,
        Layer("layer", body, (-DEPTH, 0.0), solid, exact=solid),
        Layer("gas", air, (0.0, HEIGHT), gas, exact=gas),
        along=((0.0, 2.0 * np.pi / K),),
        lower=Clamped(),
        upper=NoSlip() if opt["fluid_mu"] > 0 else Slip(),
        notes=(note,),
    )
