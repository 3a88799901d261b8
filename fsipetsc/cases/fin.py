"""A shock hits a steel panel that stands on the floor of a shock tube, its foot clamped.

The panel is hit from the left, bends to the right, and swings back; the shock goes on over its tip
and comes back from the end wall. Data are those of J. Giordano et al., Shock Waves 14 (2005)
103-110: air at 101 kPa and 1.2 kg/m3, a shock of Mach 1.21 that leaves 155.7 kPa, 1.63 kg/m3 and
109.6 m/s behind, a panel of 1 x 50 mm in a channel of 65 x 300 mm, its end 250 mm behind the
panel. The gas slips; it is left, right and above, so the tip has two corners, and goes around them.

X and x of the panel's tip are in the series of the result: points at (0.051, 0.05).
"""

from itertools import product

import numpy as np

from fsipetsc import Block, BlockProblem, Fluid, InputError, Option
from fsipetsc.blocks.conditions import Clamped, Slip
from fsipetsc.blocks.maps import rectangle
from fsipetsc.cases.common import SHOCKS, Opt, at_rest
from fsipetsc.cases.riemann import GasState, shock_in_plane
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.operators.sbp import operator
from fsipetsc.options import above_one

OPTIONS = (
    Option("fin_mach", float, 1.21, "", "Mach number of the shock", check=above_one),
    Option("fin_length", float, 0.05, "m", "length of the panel, below 0.065", check="positive"),
    Option("fin_thickness", float, 1e-3, "m", "thickness of the panel", check="positive"),
)
DEFAULTS = {"fsi_h": 0.005, "fsi_cfl": 1.2, "ts_max_time": 2e-3, "fsi_output_dt": 1e-4, **SHOCKS}
DEFAULTS |= {"fsi_probes": "0.051,0.05"}

AHEAD = GasState(1.2, 0.0, 101e3)
#: steel: Young's modulus [Pa], Poisson's ratio, density [kg/m3], specific heat [J/(kg K)]
YOUNG, POISSON, DENSITY, HEAT = 220e9, 0.3, 7600.0, 470.0
#: of the gas before the panel, behind it, and of the channel; X of the shock at first [m]
BEFORE, BEHIND, HEIGHT, START = 0.05, 0.25, 0.065, 0.025


def build(opt: Opt) -> BlockProblem:
    """Three blocks beside each other up to the panel's tip, three above it."""
    length = opt["fin_length"]
    if length >= HEIGHT:
        raise InputError(f"-fin_length {length:g}: expected less than {HEIGHT:g}")
    air = Fluid(0.0, 0.0, 1.4, 287.0)
    flow, inflow, note = shock_in_plane(air, AHEAD, opt["fin_mach"], START)
    mu_e = YOUNG / (2.0 * (1.0 + POISSON))
    lambda_e = 2.0 * mu_e * POISSON / (1.0 - 2.0 * POISSON)
    laws = {"law": "neo-hookean", "heat": "elastic"}
    steel = ElasticSolid(mu_e, lambda_e, 0.0, DENSITY, HEAT, AHEAD.p, **laws)
    rest = at_rest(AHEAD.p / (air.R * AHEAD.rho))
    x, y = np.cumsum([0.0, BEFORE, opt["fin_thickness"], BEHIND]), (0.0, length, HEIGHT)
    least = operator(opt["fsi_order"]).min_points - 1
    columns, rows = ([max(round(d / opt["fsi_h"]), least) for d in np.diff(at)] for at in (x, y))
    columns[1] = least
    blocks, faces = [], {}
    for j, i in product(range(2), range(3)):
        panel = (i, j) == (1, 0)
        name = ("before", "panel", "behind")[i] + " above" * j
        map = rectangle((x[i], y[j]), (x[i + 1], y[j + 1]))
        material, start = (steel, rest) if panel else (air, flow)
        blocks.append(Block(name, material, map, (columns[i], rows[j]), start))
        floor = Clamped() if panel else Slip(name="floor")
        faces[name, 1, j] = Slip(name="ceiling") if j else floor
        if i != 1:
            faces[name, 0, i // 2] = Slip(name="end") if i else inflow
    return BlockProblem(tuple(blocks), faces, notes=(note,))
