"""The problem that ``bench`` measures: a gas beneath a solid in one, two or three dimensions, unit
cubes, periodic along the interface, with a wall below and clamped above. The gas begins with waves.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc import BlockProblem, Fluid, Option
from fsipetsc.blocks.conditions import Clamped, NoSlip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.cases.common import at_rest
from fsipetsc.materials.solid import ElasticSolid

NAME = "square"
SUMMARY = "gas | solid, two squares, for measuring what a step costs"
OPTIONS = (
    Option("square_dimension", int, 2, "", "number of dimensions", (1, 2, 3)),
    Option("square_viscous", bool, False, "", "viscosity and conduction in both"),
)
DEFAULTS = {"fsi_h": 1 / 64, "fsi_order": 4, "ts_max_time": 1.0}


def gas(*X: np.ndarray) -> tuple[Any, ...]:
    """(rho, u_1 … u_d, T)."""
    *beside, Y = X
    phase = 2.0 * np.pi * sum(beside, 0.0 * Y)
    rho, T = 1.0 + 0.1 * np.sin(phase + Y), 1.0 + 0.1 * np.cos(phase) * np.sin(Y)
    return rho, *(0.0 * x for x in X), T


def build(opt: Mapping[str, Any]) -> BlockProblem:
    """n = 1/h nodes along each axis of a block."""
    d, n, viscous = opt["square_dimension"], round(1.0 / opt["fsi_h"]), opt["square_viscous"]
    plate = ElasticSolid(1.5, 2.0, 0.02 * viscous, 2.0, 1.0, heat="elastic")
    air = Fluid(0.02 * viscous, 0.03 * viscous, 1.4, 1.0)
    below = Layer("gas", air, (0.0, 1.0), gas, cells=n - 1)
    above = Layer("solid", plate, (1.0, 2.0), at_rest(), cells=n - 1)
    beside = {"along": ((0.0, 1.0),) * (d - 1), "cells": (n,) * (d - 1)}
    return layers(below, above, lower=NoSlip(), upper=Clamped(), units="none", **beside)
