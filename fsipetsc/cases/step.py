"""Supersonic flow over a step in a wind tunnel with rigid walls, in two dimensions.

Gas fills the tunnel, 3 long and 1 high, from the start. A shock stands off the step, is reflected
from the ceiling and from the step; a fan spreads from the edge. The problem is that of P. Woodward
and P. Colella, J. Comput. Phys. 54 (1984) 115-173: density 1.4 and pressure 1 come in, so the unit
of velocity is their speed of sound. Three blocks are joined: below and above the edge's height
before the step, and above it.

Front and top of the step are one wall: at the edge the gas may go around, which one condition on
the sum of both normals allows. Nothing else is done there.
"""

from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Open, Outflow, Slip
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases.common import SHOCKS, Opt, constant, gas_of, stack
from fsipetsc.options import Option, above_one

OPTIONS = (
    Option("step_mach", float, 3.0, "", "Mach number of the gas that comes in", check=above_one),
)
DEFAULTS = {"fsi_h": 1 / 40, "ts_max_time": 4.0, "fsi_output_dt": 0.1, **SHOCKS}

RHO, P, LENGTH, HEIGHT = 1.4, 1.0, 3.0, 1.0
#: X where the step begins, its height [m]
PLACE, STEP = 0.6, 0.2


def build(opt: Opt) -> BlockProblem:
    """The floor before the step is at Y = 0."""
    M = opt["step_mach"]
    gas, flow = gas_of(opt, R=P / RHO), constant(RHO, M, 0.0, 1.0)
    inflow, step = Open(RHO, (M, 0.0), 1.0), Slip(name="step")
    floor, above = {(0, 0): inflow, (0, 1): step}, {(0, 0): inflow, (0, 1): Outflow()}
    return stack(
        opt,
        Layer("before", gas, (0.0, STEP), flow, span=((0.0, PLACE),), sides=floor),
        Layer("above", gas, (STEP, HEIGHT), flow, sides=above, beside=step),
        along=((0.0, LENGTH),),
        lower=Slip(name="floor"),
        upper=Slip(name="ceiling"),
    )
