"""Supersonic flow over an elastic panel that is set into a wall: panel flutter.

Gas flows along y = 0 at the Mach number M; between x = 0 and 1 the wall is a panel of thickness
panel_thickness, behind which a cavity has the pressure of the flow. The panel is pushed a little
at the beginning. Above a critical dynamic pressure its oscillation grows to a limit cycle, below
it decays. With D the bending stiffness, L = 1 and q the dynamic pressure, the parameter is

    lambda = 2 q L^3 / (D sqrt(M^2 - 1)),
    D = h^3/12 . 4 mu_e (lambda_e + mu_e) / (lambda_e + 2 mu_e)       (plane strain)

and in theory without damping by the flow a thin panel flutters from lambda = 636.57 on if its ends
are clamped, from 343.36 on if they are hinged (E. H. Dowell, Aeroelasticity of Plates and Shells,
1975). A hinge holds the middle of an end face. panel_lambda sets the stiffness; unit of velocity is
the speed of sound of the flow, of density its density.
"""

from dataclasses import replace

import numpy as np

from fsipetsc import BlockProblem, Fluid, InputError, Option
from fsipetsc.blocks.conditions import Clamped, Free, Given, Hinge, Open, Outflow
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases.common import Opt, materials, stack, wall_for
from fsipetsc.equations.elementary import tanh
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.operators.sbp import operator
from fsipetsc.options import above_one

OPTIONS = (
    Option("panel_ends", str, "clamped", "", "how the panel is held", ("clamped", "hinged")),
    Option("panel_mach", float, 2.0, "", "Mach number of the flow", check=above_one),
    Option("panel_lambda", float, 800.0, "", "2 q L^3/(D sqrt(M^2-1)), L = 1", check="positive"),
    Option("panel_mass", float, 10.0, "", "its mass / (rho L^2) of the gas", check="positive"),
    Option("panel_thickness", float, 0.04, "m", "its thickness; it is 1 m long", check="positive"),
    Option("panel_push", float, 5e-3, "", "velocity of the panel at first", check="nonnegative"),
    Option("panel_height", float, 0.5, "m", "height of the gas", check="positive"),
    *materials(fluid_mu=0.0),
    Option("panel_layer", float, 0.2, "m", "boundary layer's depth, if viscous", check="positive"),
)
DEFAULTS = {"fsi_h": 1 / 32, "fsi_dissipation": 1.0, "ts_max_time": 40.0, "fsi_output_dt": 0.25}

GAMMA, PRANDTL = 1.4, 0.72
#: edges of the gas in X; cells across the panel, more where the operators want them
EDGES, CELLS = (-0.5, 1.5), 8


def build(opt: Opt) -> BlockProblem:
    """The panel between Y = -thickness and 0, the gas above."""
    M, h, mu = opt["panel_mach"], opt["panel_thickness"], opt["fluid_mu"]
    height, beta = opt["panel_height"], float(np.sqrt(M * M - 1.0))
    # waves that a motion of the panel makes are beta times shorter across the flow than along it
    rows = int(np.ceil(height * max(beta, 1.0) / opt["fsi_h"] - 1e-9))
    p, rho = 1.0 / GAMMA, 1.0
    gas = Fluid(mu, mu * GAMMA / (GAMMA - 1.0) * p / PRANDTL, GAMMA, p)
    q = 0.5 * rho * M * M
    stiffness = 2.0 * q / (opt["panel_lambda"] * beta)
    # 12 D/h^3 = 4 mu (lambda + mu) / (lambda + 2 mu), which is 3 mu for lambda = 2 mu
    mu_e = 12.0 * stiffness / h**3 / 3.0
    density = opt["panel_mass"] / h
    across = max(CELLS, operator(opt["fsi_order"]).min_points // 2 * 2)  # even: hinges
    panel = ElasticSolid(mu_e, 2.0 * mu_e, 0.0, density, 1.0, p_ref=p, heat="elastic")

    def flow(X, Y, t=0.0):
        """With viscosity a boundary layer, hot at the wall as Crocco and Busemann have it."""
        along = M * tanh(2.0 * Y / opt["panel_layer"]) if mu > 0 else M + 0.0 * X
        T = 1.0 + 0.5 * (GAMMA - 1.0) * PRANDTL**0.5 * (M * M - along * along)
        return [1.0 / T, along, 0.0 * X, T]

    def push(X, Y):
        shape = np.sin(np.pi * X) ** 2 * (1.0 + np.cos(np.pi * X))
        return [0.0 * X, opt["panel_push"] * shape, np.ones_like(X), X, Y]

    hinged = opt["panel_ends"] == "hinged"
    if hinged and mu > 0.0:
        raise InputError("-panel_ends hinged: expected -fluid_mu 0: gas that sticks holds edges")
    outside = Open(rho, (M, 0.0), 1.0)
    echo = f"waves that the panel makes come back to it from Y = {height:g}: see -panel_height"
    beside = wall_for(gas)
    sides = {(0, 0): Given(flow) if mu > 0 else outside, (0, 1): Outflow(p)}
    ends = {"span": ((0.0, 1.0),), "sides": Free(p) if hinged else Clamped()}
    problem = stack(
        opt,
        Layer("panel", panel, (-h, 0.0), push, cells=across, **ends),
        Layer("gas", gas, (0.0, height), flow, cells=rows, sides=sides, beside=beside),
        along=(EDGES,),
        lower=Free(p),
        upper=outside,
        notes=(echo,) if 2.0 * height * beta < 1.0 else (),
    )
    points = tuple(("panel", (x, -0.5 * h), Hinge()) for x in (0.0, 1.0))
    return replace(problem, points=points) if hinged else problem
