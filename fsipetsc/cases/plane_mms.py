"""A manufactured solution in two dimensions: gas | solid, periodic along X, on a grid that moves.

The plane of fsipetsc.cases.manufactured. Both fields are smooth and not linear, mu, kappa and
kappa_e are above 0, the heat of the solid is coupled. The gas has a wall of given temperature
below, the topmost row of the solid is given. Velocity and temperature are continuous at the
interface; what traction and heat flux lack is supplied there, what the equations lack
everywhere.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.cases import box_mms
from fsipetsc.options import Option

NAME = "plane_mms"
SUMMARY = "gas | solid in two dimensions, a manufactured solution whose errors can be measured"

OPTIONS = (
    Option("fluid_mu", float, 0.02, "Pa s", "viscosity of the gas", check="nonnegative"),
    Option("fluid_kappa", float, 0.03, "W/(m K)", "conductivity of the gas", check="nonnegative"),
    Option("solid_law", str, "log", "", "law of the solid", ("log", "neo-hookean", "svk")),
    Option("solid_kappa", float, 0.05, "W/(m K)", "conductivity of the solid", check="nonnegative"),
)
DEFAULTS = {"fsi_h": 1 / 32, "fsi_order": 4, "ts_max_time": 0.25, "fsi_output_dt": 0.05}


def build(opt: Mapping[str, Any]) -> BlockProblem:
    """The gas between Y = 0 and 1, the solid between 1 and 2."""
    return box_mms.build({**opt, "box_dimension": 2, "box_periodic": True})
