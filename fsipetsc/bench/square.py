"""The problem that is measured in two dimensions: a gas above a wall, beneath a solid that is clamped above, periodic in X.

Both are one high and one long, and begin with smooth disturbances of a tenth: what moves and bends costs as much as it ever
will, and nothing else is there.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.boundaries.plane import Clamped, NoSlip
from fsipetsc.options import Option
from fsipetsc.physics.fluid import Fluid
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem, PlaneSolid, PlaneSolidLayer

NAME = "square"
SUMMARY = "gas | solid, both squares, for measuring what a step costs in two dimensions"
OPTIONS = (Option("square_friction", bool, False, "", "friction and conduction in both"),)
DEFAULTS = {"fsi_h": 1 / 64, "fsi_order": 4, "ts_max_time": 1.0}

#: name -> options of the run, and words for the other program
FORMS: dict[str, tuple[dict[str, Any], tuple[str, ...]]] = {
    "entropy": ({}, ()),
    "divergence": ({"fsi_convection": "divergence"}, ("-form", "div")),
    "viscous": ({"square_friction": True}, ("-visc", "1")),
    "divergence-viscous": ({"fsi_convection": "divergence", "square_friction": True}, ("-form", "div", "-visc", "1")),
}
_K, _SIZE = 2.0 * np.pi, 0.1


def gas(X: np.ndarray, Y: np.ndarray) -> tuple[np.ndarray, ...]:
    """(rho, u, v, T)."""
    between = 4.0 * Y * (1.0 - Y)
    u, v = _SIZE * between * np.sin(_K * X), _SIZE * between * np.cos(_K * X)
    return 1.0 + _SIZE * np.sin(_K * X + Y), u, v, 1.0 + _SIZE * np.cos(_K * X) * np.sin(Y)


def solid(X: np.ndarray, Y: np.ndarray) -> tuple[np.ndarray, ...]:
    """(u, v, T, x, y)."""
    u, v = 0.5 * _SIZE * (2.0 - Y) * np.sin(_K * X + Y), 0.4 * _SIZE * (2.0 - Y) * np.cos(_K * X) * np.sin(Y)
    x, y = 0.1 * _SIZE * np.sin(_K * X) * np.cos(3.0 * Y), 0.2 * _SIZE * np.cos(_K * X) * np.sin(2.0 * Y)
    return u, v, np.ones_like(X), X + x, Y + y


def build(opt: Mapping[str, Any]) -> PlaneProblem:
    """As many rows in either layer as columns."""
    friction, cells = opt["square_friction"], round(1.0 / opt["fsi_h"]) - 1
    mu, kappa, kappa_e = (0.02, 0.03, 0.02) if friction else (0.0, 0.0, 0.0)
    plate = PlaneSolid(1.5, 2.0, kappa_e, 2.0, 1.0, heat="elastic")
    layers = (
        PlaneFluidLayer("gas", Fluid(mu, kappa, 1.4, 1.0), (0.0, 1.0), gas, cells=cells),
        PlaneSolidLayer("solid", plate, (1.0, 2.0), solid, cells=cells),
    )
    return PlaneProblem(layers, (0.0, 1.0), NoSlip(), Clamped(), units="none")
