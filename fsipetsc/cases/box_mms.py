"""A manufactured solution in one, two or three dimensions, whose errors can be measured.

Gas under a solid, with an interface that moves and bends (fsipetsc.cases.manufactured). The wall
below the gas has a given temperature, the uppermost points of the solid are given. The blocks are
periodic along the other axes; with -box_periodic false all unknowns are given at the sides. What
the equations lack is their forcing; what traction and heat flux lack at the interface is supplied.
"""

from fsipetsc import BlockProblem, Option
from fsipetsc.blocks.conditions import Given, NoSlip
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases.common import Opt, materials, stack
from fsipetsc.cases.manufactured import Solution

SUMMARY = "gas | solid in one, two or three dimensions, a manufactured solution"

OPTIONS = (
    Option("box_dimension", int, 2, "", "number of dimensions", (1, 2, 3)),
    Option("box_periodic", bool, True, "", "periodic along the layers; else sides are given"),
    *materials(fluid_mu=0.02, fluid_kappa=0.03, solid_kappa=0.05),
    *materials(solid_law=("neo-hookean", "log", "svk", "linear")),
)
DEFAULTS = {"fsi_h": 1 / 16, "fsi_order": 4, "ts_max_time": 0.25, "fsi_output_dt": 0.05}


def build(opt: Opt) -> BlockProblem:
    """The gas between eta = 0 and 1, the solid between 1 and 2."""
    d = opt["box_dimension"]
    exact = Solution(d, opt)

    def layer(name, material, low, of, forcing):
        sides = None if opt["box_periodic"] or d == 1 else Given(of)
        start = lambda *X: of(*X, 0.0)  # noqa: E731
        more = {"sides": sides, "forcing": forcing, "exact": of}
        return Layer(name, material, (low, low + 1.0), start, **more)

    return stack(
        opt,
        layer("gas", exact.fluid, 0.0, exact.exact_gas, exact.force_gas),
        layer("solid", exact.body, 1.0, exact.exact_solid, exact.force_solid),
        lower=NoSlip(T=lambda *where: exact.temperature(*where)[0]),
        upper=Given(exact.exact_solid),
        along=((0.0, 1.0),) * (d - 1),
        jumps=exact.supplied,
    )
