"""Gas under a solid, and gas beside it, in one to three dimensions: a case for stub_scheme.py."""

from __future__ import annotations

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import Clamped, NoSlip, Roller, Slip
from fsipetsc.blocks.maps import rectangle
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.options import Option

NAME = "block_case"
OPTIONS = (
    Option("case_dimension", int, 2, "", "dimensions", (1, 2, 3)),
    Option("case_mu", float, 0.1, "Pa s", "viscosity"),
    Option("case_fails", bool, False, "", "temperatures fall below 0"),
    Option("case_fault", bool, False, "", "a wrong initial"),
    Option("case_timed", bool, False, "", "a wall whose temperature depends on time"),
)
DEFAULTS = {"fsi_h": 0.1, "fsi_order": 2, "ts_max_time": 0.1, "fsi_output_dt": 0.02}


def build(opt):
    d = opt["case_dimension"]
    gas = Fluid(opt["case_mu"], 0.0, 1.4, 1.0)
    plate = ElasticSolid(1.0, 1.0, 0.1, 2.0, 1.0)
    n = {1: (12,), 2: (12, 9), 3: (8, 7, 6)}[d]

    def swirl(*X):
        if opt["case_fault"]:
            return [1.0]
        u = [np.sin(3.0 * X[0] + k) for k in range(d)]
        return [1.0 + 0.2 * np.cos(5.0 * X[-1]), *u, 1.0 + 0.1 * np.sin(4.0 * sum(X))]

    def rest(*X):
        v = [0.1 * np.cos(2.0 * X[0] + k) for k in range(d)]
        return [*v, 1.0 + 0.05 * np.sin(3.0 * X[0]), *(1.01 * x for x in X)]

    def place(first, last, axis):
        low, high = [0.0] * d, [1.0] * d
        low[axis], high[axis] = first, last
        return rectangle(low, high) if d > 1 else rectangle(low[0], high[0])

    blocks = [
        Block("gas", gas, place(0.0, 1.0, d - 1), n, swirl, exact=lambda *X: swirl(*X[:-1])),
        Block("plate", plate, place(1.0, 1.5, d - 1), n, rest, exact=lambda *X: rest(*X[:-1])),
    ]
    if d > 1:
        blocks.append(
            Block("more gas", gas, place(1.0, 2.0, 0), n, swirl, exact=lambda *X: swirl(*X[:-1]))
        )
    hot = (lambda *X: 1.0 + 0.1 * X[-1]) if opt["case_timed"] else None
    faces = {}
    for k, block in enumerate(blocks):
        for axis in range(d):
            for side in (0, 1):
                met = (k, axis, side) in ((0, d - 1, 1), (1, d - 1, 0)) or (
                    d > 1 and (k, axis, side) in ((0, 0, 1), (2, 0, 0))
                )
                if not met:
                    wall = NoSlip(T=hot) if axis == d - 1 else Slip()
                    held = Clamped() if axis == d - 1 else Roller()
                    faces[block.name, axis, side] = held if block.kind == "solid" else wall
    return BlockProblem(tuple(blocks), faces, notes=("fails",) if opt["case_fails"] else ())
