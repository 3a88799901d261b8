"""The manufactured solution of the case box_mms in two dimensions, periodic along X."""

from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.cases import box_mms
from fsipetsc.cases.common import Opt, materials

SUMMARY = "gas | solid in two dimensions, a manufactured solution whose errors can be measured"

OPTIONS = (
    *materials(fluid_mu=0.02, fluid_kappa=0.03, solid_kappa=0.05),
    *materials(solid_law=("log", "neo-hookean", "svk")),
)
DEFAULTS = {"fsi_h": 1 / 32, "fsi_order": 4, "ts_max_time": 0.25, "fsi_output_dt": 0.05}


def build(opt: Opt) -> BlockProblem:
    """The gas between Y = 0 and 1, the solid between 1 and 2."""
    return box_mms.build({**opt, "box_dimension": 2, "box_periodic": True})
