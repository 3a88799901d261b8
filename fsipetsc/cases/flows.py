"""Shocks and supersonic flows on flat layers: gas alone, over a plate, a panel or a layer."""

import numpy as np

from fsipetsc import BlockProblem, ElasticSolid, Fluid, InputError, Layer, Option
from fsipetsc.blocks.conditions import Clamped, Free, Hinge, NoSlip, Open, Outflow, Roller, Slip
from fsipetsc.cases import common
from fsipetsc.cases.common import SHOCKS, Opt, case, materials
from fsipetsc.cases.riemann import GAMMA, GasState, behind_shock, sound
from fsipetsc.equations.elementary import exp, power
from fsipetsc.operators.sbp import OPERATORS


@case(
    {"fsi_h": 0.03125, "ts_max_time": 2.0, "fsi_output_dt": 0.05},
    *materials(fluid_mu=0.002, fluid_kappa=0.003, solid_density=5.0, solid_modulus=40.0),
    *materials(solid_law=("log", "neo-hookean", "svk")),
    Option("blast_height", float, 1.0, "Pa", "overpressure; else p is 1", check="nonnegative"),
)
def blast(opt: Opt) -> BlockProblem:
    """A pressure pulse under an elastic plate: gas | plate, a wall below, a pressure above.

    The plate is free of stress under the ambient pressure 1, and held at its sides against X alone.
    """
    gas = common.gas_of(opt)
    plate = common.elastic_of(opt, kappa_e=0.01, law=opt["solid_law"], heat="coupled")

    def start(X, Y):  # of the same entropy everywhere
        p = 1.0 + opt["blast_height"] * exp(-((X - 0.5) ** 2 + (Y - 0.5) ** 2) / 0.15**2)
        rho = power(p, 1.0 / gas.gamma)
        return rho, 0.0, 0.0, p / rho

    below = Layer("gas", gas, (0.0, 1.0), start, sides=Slip())
    above = Layer("plate", plate, (1.0, 1.25), common.at_rest(), sides=Roller())
    return common.stack(opt, below, above, lower=NoSlip(), upper=Free(1.0), along=((0.0, 1.0),))


@case(
    {"fsi_h": 1 / 32, "fsi_dissipation": 1.0, "ts_max_time": 40.0, "fsi_output_dt": 0.25},
    Option("panel_ends", str, "clamped", "", "how the panel is held", ("clamped", "hinged")),
    Option("panel_mach", float, 2.0, "", "Mach number of the flow", check="above 1"),
    Option("panel_lambda", float, 800.0, "", "2 q L^3/(D sqrt(M^2-1)), L = 1", check="positive"),
    Option("panel_mass", float, 10.0, "", "its mass / (rho L^2) of the gas", check="positive"),
    Option("panel_thickness", float, 0.04, "m", "its thickness; it is 1 m long", check="positive"),
    Option("panel_push", float, 5e-3, "", "velocity of the panel at first", check="nonnegative"),
    Option("panel_height", float, 0.5, "m", "height of the gas", check="positive"),
)
def panel(opt: Opt) -> BlockProblem:
    """Supersonic flow over an elastic panel that is set into a wall: panel flutter.

    Gas flows along y = 0 at the Mach number M; between x = 0 and 1 the wall is a panel, behind
    which a cavity has the pressure of the flow. In plane strain lambda = 2 q / (D sqrt(M^2 - 1)), q
    = M^2/2, has D = h^3/12 . 4 mu_e (lambda_e + mu_e) / (lambda_e + 2 mu_e) (docs/gallery.md). A
    hinge holds the middle of an end face. Units are those of the speed of sound and the density of
    the flow.
    """
    M, h, hinged = opt["panel_mach"], opt["panel_thickness"], opt["panel_ends"] == "hinged"
    height, beta = opt["panel_height"], float(np.sqrt(M * M - 1.0))
    # waves that a motion of the panel makes are beta times shorter across the flow than along it
    rows = int(np.ceil(height * max(beta, 1.0) / opt["fsi_h"] - 1e-9))
    p = 1.0 / GAMMA
    gas, flow = Fluid(0.0, 0.0, GAMMA, p), common.constant(1.0, M, 0.0, 1.0)
    stiffness = M * M / (opt["panel_lambda"] * beta)
    mu_e = 12.0 * stiffness / h**3 / 3.0  # for lambda_e = 2 mu_e
    across = max(8, OPERATORS[opt["fsi_order"]].min_points // 2 * 2)  # even: hinges
    panel = ElasticSolid(mu_e, 2.0 * mu_e, 0.0, opt["panel_mass"] / h, 1.0, p, heat="elastic")

    def push(X, Y):
        shape = np.sin(np.pi * X) ** 2 * (1.0 + np.cos(np.pi * X))
        return 0.0, opt["panel_push"] * shape, 1.0, X, Y

    outside = Open(1.0, (M, 0.0), 1.0)
    sides = {(0, 0): outside, (0, 1): Outflow(p)}
    ends = {"span": ((0.0, 1.0),), "sides": Free(p) if hinged else Clamped()}
    below = Layer("panel", panel, (-h, 0.0), push, cells=across, **ends)
    above = Layer("gas", gas, (0.0, height), flow, cells=rows, sides=sides, beside=Slip())
    points = [("panel", (x, -0.5 * h), Hinge()) for x in (0.0, 1.0) if hinged]
    where = {"lower": Free(p), "upper": outside, "along": ((-0.5, 1.5),)}
    return common.stack(opt, below, above, points=tuple(points), **where)


def turned_by(gas: Fluid, state: GasState, theta: float) -> GasState:
    """The gas behind the weak shock, at an angle beta to the flow, that turns a flow of velocity u,
    whatever its direction, by theta [rad]. InputError if no attached shock does.

    tan theta = 2 cot beta (M^2 sin^2 beta - 1) / (M^2 (gamma + cos 2 beta) + 2): J. D. Anderson,
    Modern Compressible Flow, 3rd ed., 2003, Sec. 4.3.
    """
    from scipy.optimize import brentq

    M = state.u / sound(gas, state)

    def turned(beta):
        below = M * M * (GAMMA + np.cos(2.0 * beta)) + 2.0
        return np.arctan(2.0 / np.tan(beta) * ((M * np.sin(beta)) ** 2 - 1.0) / below)

    angles = np.linspace(np.arcsin(1.0 / M), 0.5 * np.pi, 2001)
    most = angles[np.argmax(turned(angles))]
    if turned(most) <= theta:
        what = f"no attached shock turns a flow of M = {M:.4g} by {np.degrees(theta):.4g} degrees"
        raise InputError(f"{what}: expected less than {np.degrees(turned(most)):.4g}")
    beta = brentq(lambda b: turned(b) - theta, angles[0], most, xtol=1e-15, rtol=1e-14)
    normal, s = behind_shock(gas, state._replace(u=0.0), M * np.sin(beta))
    # what is along the shock stays
    return normal._replace(u=np.hypot(state.u * np.cos(beta), s - normal.u))


@case(
    {"fsi_h": 1 / 32, "ts_max_time": 4.0, "fsi_output_dt": 0.25, **SHOCKS},
    Option("oblique_mach", float, 2.9, "", "Mach number of the gas that comes in", check="above 1"),
    Option("oblique_angle", float, 10.0, "degrees", "theta, of the wedge", check="positive"),
    Option("oblique_wall", str, "elastic", "", "what is below", ("rigid", "elastic")),
    *materials(solid_modulus=40 / GAMMA, solid_density=10.0),
)
def oblique(opt: Opt) -> BlockProblem:
    """An oblique shock that is reflected from a wall: a rigid one, or an elastic layer upon it.

    Gas comes in from the left along the wall y = 0. A wedge above turns it by an angle theta
    towards the wall; its shock comes in at the upper left corner, and the wall turns the gas back
    by a second one (verify/oblique.py has both, over a rigid wall). An elastic layer is clamped
    below, held against x at its ends and free of stress under the gas's pressure. Units are those
    of the speed of sound and the density of the gas that comes in.
    """
    theta, gas = np.radians(opt["oblique_angle"]), Fluid(0.0, 0.0, GAMMA, 1.0 / GAMMA)
    first = GasState(1.0, opt["oblique_mach"], 1.0 / GAMMA)
    second = turned_by(gas, first, theta)
    flow = common.constant(1.0, first.u, 0.0, 1.0)
    u, v = second.u * np.cos(theta), -second.u * np.sin(theta)
    sides = {(0, 0): Open(first.rho, (first.u, 0.0), 1.0), (0, 1): Outflow()}
    members, lower = [Layer("gas", gas, (0.0, 1.0), flow, sides=sides)], Slip()
    if opt["oblique_wall"] == "elastic":
        solid, across = common.elastic_of(opt, first.p), (-0.25, 0.0)
        layer = Layer("layer", solid, across, common.at_rest(), cells=18, sides=Roller())
        members, lower = [layer, *members], Clamped()
    upper = Open(second.rho, (u, v), second.p / (gas.R * second.rho))
    return common.stack(opt, *members, along=((0.0, 3.0),), lower=lower, upper=upper)


@case(
    {"fsi_h": 1 / 40, "ts_max_time": 4.0, "fsi_output_dt": 0.1, **SHOCKS},
    Option("step_mach", float, 3.0, "", "Mach number of the gas that comes in", check="above 1"),
)
def step(opt: Opt) -> BlockProblem:
    """Supersonic flow over a step in a wind tunnel with rigid walls, in two dimensions.

    The problem is that of P. Woodward and P. Colella, J. Comput. Phys. 54 (1984) 115-173: density
    1.4 and pressure 1 come in, so the unit of velocity is their speed of sound. Front and top of
    the step are one wall, so that one condition, on the sum of both normals, holds at the edge.
    """
    M, rho, place, high = opt["step_mach"], 1.4, 0.6, 0.2  # X where the step begins, its height
    gas, flow = common.gas_of(opt, R=1.0 / rho), common.constant(rho, M, 0.0, 1.0)
    inflow, step = Open(rho, (M, 0.0), 1.0), Slip()
    floor, above = {(0, 0): inflow, (0, 1): step}, {(0, 0): inflow, (0, 1): Outflow()}
    members = (
        Layer("before", gas, (0.0, high), flow, span=((0.0, place),), sides=floor),
        Layer("above", gas, (high, 1.0), flow, sides=above, beside=step),
    )
    return common.stack(opt, *members, along=((0.0, 3.0),), lower=Slip(), upper=Slip())


@case(
    {"fsi_h": 1 / 100, "ts_max_time": 1.0, "fsi_output_dt": 0.1, **SHOCKS},
    Option("tube_reynolds", float, 200.0, "", "Reynolds number", check="positive"),
)
def viscous_tube(opt: Opt) -> BlockProblem:
    """A shock tube with viscosity: the shock comes back through the boundary layer it has left.

    Gas of density 120 and 1.2 at the same temperature, at rest on both sides of X = 1/2, in a unit
    box with adiabatic walls that the gas sticks to; the lower half, with a plane of symmetry above.
    p = rho/gamma; viscosity 1/Re, Prandtl number 0.73 (V. Daru, C. Tenaud, Comput. Fluids 30 (2001)
    89; 38 (2009) 664).
    """
    R, mu, rho, ratio = 1.0 / GAMMA, 1.0 / opt["tube_reynolds"], 1.2, 100.0
    gas = Fluid(mu, GAMMA / (GAMMA - 1.0) * R * mu / 0.73, GAMMA, R)

    def start(X, Y):  # a node in the middle has half of the jump
        right = 0.5 * (1.0 + np.sign(np.round(X - 0.5, 9)))
        return rho * (ratio * (1.0 - right) + right), 0.0, 0.0, 1.0

    half = Layer("gas", gas, (0.0, 0.5), start, sides=NoSlip())
    return common.stack(opt, half, along=((0.0, 1.0),), lower=NoSlip(), upper=Slip())
