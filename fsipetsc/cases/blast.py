"""A pressure pulse under an elastic plate: gas | plate, symmetric sides, a wall below, the ambient pressure above.

The pulse spreads, bends the plate upwards, and comes back from the wall. With blast_kind shock it is a disc of one pressure,
which sends a shock out from the start: that needs -fsi_shock and -fsi_dissipation. The plate is free of stress under the
ambient pressure, held at its sides against X alone, so the sides are planes of symmetry: a row of plates and pulses without
end.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.boundaries.plane import Free, NoSlip, Roller, Slip
from fsipetsc.options import Option
from fsipetsc.physics.fluid import Fluid
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem, PlaneSolid, PlaneSolidLayer

NAME = "blast"
SUMMARY = "a pressure pulse under an elastic plate, in two dimensions"

OPTIONS = (
    Option("fluid_mu", float, 0.002, "Pa s", "viscosity of the gas", check="nonnegative"),
    Option("fluid_kappa", float, 0.003, "W/(m K)", "heat conductivity of the gas", check="nonnegative"),
    Option("solid_density", float, 5.0, "kg/m3", "density of the plate", check="positive"),
    Option("solid_modulus", float, 40.0, "Pa", "2 mu_e + lambda_e of the plate, mu_e a quarter of it", check="positive"),
    Option("solid_law", str, "log", "", "law of the plate", ("log", "neo-hookean", "svk")),
    Option("blast_kind", str, "pulse", "", "pulse: smooth, of one entropy; shock: a disc of high pressure", ("pulse", "shock")),
    Option("blast_height", float, 1.0, "Pa", "overpressure in its middle, over the ambient 1", check="nonnegative"),
    Option("blast_width", float, 0.15, "m", "of the pulse", check="positive"),
)
DEFAULTS = {"fsi_h": 0.03125, "fsi_order": 4, "ts_max_time": 2.0, "fsi_output_dt": 0.05}


def build(opt: Mapping[str, Any]) -> PlaneProblem:
    """The gas between Y = 0 and 1, the plate above it."""
    gas = Fluid(opt["fluid_mu"], opt["fluid_kappa"], 1.4, 1.0)
    K = opt["solid_modulus"]
    plate = PlaneSolid(K / 4, K / 2, 0.01, opt["solid_density"], 1.0, p_ref=1.0, law=opt["solid_law"])

    def pulse(X: np.ndarray, Y: np.ndarray) -> list[np.ndarray]:
        """Of pressure; the entropy is the same everywhere."""
        p = 1.0 + opt["blast_height"] * np.exp(-((X - 0.5) ** 2 + (Y - 0.5) ** 2) / opt["blast_width"] ** 2)
        rho = p ** (1.0 / gas.gamma)
        return [rho, 0.0 * X, 0.0 * X, p / rho]

    def disc(X: np.ndarray, Y: np.ndarray) -> list[np.ndarray]:
        """Twice as hot as what is around it."""
        inside = (X - 0.5) ** 2 + (Y - 0.5) ** 2 < opt["blast_width"] ** 2
        p, T = np.where(inside, 1.0 + opt["blast_height"], 1.0), np.where(inside, 2.0, 1.0)
        return [p / T, 0.0 * X, 0.0 * X, T]

    def rest(X: np.ndarray, Y: np.ndarray) -> list[np.ndarray]:
        return [0.0 * X, 0.0 * X, np.ones_like(X), X, Y]

    return PlaneProblem(
        layers=(
            PlaneFluidLayer("gas", gas, (0.0, 1.0), disc if opt["blast_kind"] == "shock" else pulse, left=Slip(), right=Slip()),
            PlaneSolidLayer("plate", plate, (1.0, 1.25), rest, left=Roller(), right=Roller()),
        ),
        X=(0.0, 1.0),
        lower=NoSlip(),
        upper=Free(1.0),
        units="none",
    )
