"""A square steel plate, clamped along its edges, swings under a sudden pressure: three dimensions.

    mpiexec -n 2 python -m fsipetsc runs/square_plate.py

It swings between 0 and nearly twice its static deflection, 5.5 um, with its first frequency,
4.37 kHz (Mindlin's theory for L/d = 20, docs/plates.md). 1,728 steps, 3 s of one core.
"""

from fsipetsc import Block, BlockProblem, ElasticSolid, Option
from fsipetsc.blocks.conditions import Clamped, Free
from fsipetsc.blocks.maps import rectangle

OPTIONS = (
    Option("plate_thickness", float, 0.005, "m", "thickness d of the plate", check="positive"),
    Option("plate_cells", int, 7, "", "cells through the thickness; order 4 needs 7, 6 needs 11"),
    Option("plate_load", float, 1e5, "Pa", "pressure below"),
)
DEFAULTS = {
    **{"fsi_h": 0.005, "fsi_cfl": 1.2, "ts_max_time": 2.4e-4, "fsi_output_dt": 2e-5},
    "fsi_probes": "0.05,0.05,0",
}
LENGTH, YOUNG, POISSON, DENSITY = 0.1, 210e9, 0.3, 7800.0  # of steel: E [Pa], nu, density [kg/m3]


def build(opt):
    """One block; axis 2 is through the thickness."""
    mu = 0.5 * YOUNG / (1.0 + POISSON)
    lam = 2.0 * mu * POISSON / (1.0 - 2.0 * POISSON)
    steel = ElasticSolid(mu, lam, 0.0, DENSITY, 470.0, law="svk", heat="elastic")
    n = round(LENGTH / opt["fsi_h"])

    def rest(X, Y, Z):
        return 0.0, 0.0, 0.0, 300.0, X, Y, Z  # velocity, temperature, place

    box = rectangle((0.0, 0.0, 0.0), (LENGTH, LENGTH, opt["plate_thickness"]))
    plate = Block("plate", steel, box, (n, n, opt["plate_cells"]), rest)
    faces = {("plate", axis, side): Clamped() for axis in (0, 1) for side in (0, 1)}
    faces |= {("plate", 2, 0): Free(opt["plate_load"]), ("plate", 2, 1): Free()}
    return BlockProblem((plate,), faces)
