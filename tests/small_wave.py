"""A wave of 1e-5 in the closed box, on its way through the gas into the solid, for -fsi_check.

wave_lost: this part of the rate of momentum is left out of the right-hand side at the first
interface. So the momentum of the wave is not kept, and nothing else is changed.
"""

import numpy as np

from fsipetsc import FluidLayer, Option, Problem, SolidLayer, Wall
from fsipetsc.blockrun.block_state import BlockState
from fsipetsc.cases import box
from fsipetsc.cases.common import constant, gas_of, solid_of

NAME = "small_wave"
SUMMARY = "a small wave in the closed box"
OPTIONS = (*box.OPTIONS, Option("wave_lost", "float", 0.0, "", "part of the momentum that is lost"))
DEFAULTS = {**box.DEFAULTS, "fsi_h": 0.05, "ts_max_time": 0.5}
SIZE, P, T = 1e-5, 2.0, 4.0


def build(opt):
    gas, solid = gas_of(opt), solid_of(opt)
    rho, c = P / (gas.R * T), np.sqrt(gas.gamma * gas.R * T)

    def wave(X):
        s = SIZE * np.exp(-(((X - 0.7) / 0.1) ** 2))
        return [rho * (1.0 + s), c * s, T * (1.0 + (gas.gamma - 1.0) * s)]

    def still(X):
        return [0.0 * X, solid.pressure(T, 1.0) - P + 0.0 * X, T + 0.0 * X, X]

    if opt["wave_lost"]:
        BlockState.right_hand_side = losing(opt["wave_lost"])
    layers = (
        FluidLayer("left", gas, (0.0, 1.0), wave),
        SolidLayer("solid", solid, (1.0, 2.0), still),
        FluidLayer("right", gas, (2.0, 3.0), constant(rho, 0.0, T)),
    )
    return Problem(layers, Wall(0.0), Wall(3.0), units="none")


def losing(part, right=BlockState.right_hand_side):
    """The right-hand side of one rank, without a part of the force at the first interface."""

    def right_hand_side(state, y, f):
        right(state, y, f)
        state.layout.owned(0, f)[-1, 2] *= 1.0 - part
        state.layout.owned(1, f)[0, 1] *= 1.0 - part

    return right_hand_side
