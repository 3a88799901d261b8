"""Flows over walls, panels and bodies: what shocks run over, a nozzle, disks and shells."""

from collections.abc import Sequence
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from fsipetsc import Block, BlockProblem, ElasticSolid, Fluid, Layer, Option
from fsipetsc.blocks.conditions import Centre, Clamped, Free, Hinge, NoSlip, Open, Outflow, Slip
from fsipetsc.blocks.maps import Map, Places, annulus, off_axis, rectangle
from fsipetsc.cases import common
from fsipetsc.cases.common import SHOCKS, Opt, case, materials
from fsipetsc.cases.ring import CORE, INNER, OUTER, VESSEL
from fsipetsc.cases.shocks import GAMMA, GasState, shock_in_plane
from fsipetsc.checks import Array
from fsipetsc.equations.elementary import tanh
from fsipetsc.operators.sbp import OPERATORS

#: gas before a shock: the unit of velocity is its speed of sound
AHEAD = GasState(1.4, 0.0, 1.0)


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
    hinge holds the middle of an end face. Units: speed of sound and density of the flow.
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
    before = Layer("before", gas, (0.0, high), flow, span=((0.0, place),), sides=floor)
    over = Layer("above", gas, (high, 1.0), flow, sides=above, beside=step)
    return common.stack(opt, before, over, along=((0.0, 3.0),), lower=Slip(), upper=Slip())


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


@case(
    {"fsi_h": 0.0125, "ts_max_time": 2.0, "fsi_output_dt": 0.02, "fsi_shock": 1.0},
    Option("shell_kappa", int, 2, "", "1: around an axis, 2: around a centre", (1, 2)),
    Option("shell_gas", str, "centre", "", "gas inside", ("none", "around", "centre")),
    Option("shell_charge", float, 50.0, "", "T of the charge / T at rest - 1", check="nonnegative"),
    *materials(fluid_mu=0.0, fluid_kappa=0.0, solid_density=2.0),
    *materials(solid_mu=1.0, solid_lambda=1.5, solid_law=("neo-hookean", "log", "svk")),
)
def shell(opt: Opt) -> BlockProblem:
    """A charge in the middle of an elastic shell, in one dimension: gas | shell | gas in a vessel.

    All depends on the distance r from a centre (kappa = 2), or from the axis of a tube (kappa = 1).
    Hot gas in the middle, of the density of the rest, sends a shock to the shell, which is free of
    stress under the pressure of the gas at rest.
    """
    gas, core, width = common.gas_of(opt), CORE if opt["shell_gas"] == "around" else 0.0, 0.2
    pressure = 0.0 if opt["shell_gas"] == "none" else 1.0
    solid = common.elastic_of(opt, pressure, law=opt["solid_law"])

    def block(name, material, low, high, initial):
        (n,), shape = common.cells_of(opt, high - low), rectangle(low, high)
        return Block(name, material, off_axis(shape, n) if low == 0.0 else shape, (n,), initial)

    def charge(r):  # its edge is a fifth of it wide
        hot = 0.5 * (1.0 - tanh((r - core - width) / (0.1 * width)))
        return 1.0 + 0.0 * r, 0.0 * r, 1.0 + opt["shell_charge"] * hot

    blocks = (block("shell", solid, INNER, OUTER, common.at_rest()),)
    faces = {("shell", 0, 0): Free(), ("shell", 0, 1): Free()}
    if opt["shell_gas"] != "none":
        around = block("around", gas, OUTER, VESSEL, common.constant(1.0, 0.0, 1.0))
        blocks = (block("inside", gas, core, INNER, charge), *blocks, around)
        faces = {("inside", 0, 0): Slip() if core else Centre(), ("around", 0, 1): Slip()}
    return BlockProblem(blocks, faces, units="none", symmetry=opt["shell_kappa"])


def centre(half: float, xi: Places) -> Places:
    """Map to the block in the middle of a disk: a square, whose sides, twice ``half``, bulge."""
    s, t = (2.0 * x - 1.0 for x in xi)
    wider = [1.0 + 0.25 * (1.0 - across**2 / 2.0) for across in (t, s)]
    return half * s * wider[0], half * t * wider[1]


def quarter(q: int, radius: float, half: float, xi: Places) -> Places:
    """Map to a block between the middle and the edge; axes: outwards, around; q: right, top …"""
    c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[q]
    inner, angle = centre(half, (1.0 + 0.0 * xi[0], xi[1])), np.pi / 4.0 * (2.0 * xi[1] - 1.0)
    x, y = between(xi[0], inner, (radius * np.cos(angle), radius * np.sin(angle)))
    return c * x - s * y, s * x + c * y


def between(s: Array, inner: Places, outer: Places) -> Places:
    """Return places straight from one curve to the other."""
    return tuple((1.0 - s) * a + s * b for a, b in zip(inner, outer))


def disk_in_gas(
    radius: float, half: float, cells: Sequence[int], solid: Any, gas: Any, beyond: Any, sides: Any
) -> BlockProblem:
    """A disk of five blocks in gas of four. Axis 0 of all but the one in the middle goes outwards.

    cells: around a quarter, in the disk, in the gas. solid, gas: material, initial data, and more
    that a block may have. beyond: of q and xi, places of the gas. sides: conditions of its edge.
    """
    around, within, outside = cells

    def block(name: str, map: Map, across: int, of: Any) -> Block:
        material, start, *more = of
        return Block(name, material, map, (across, around), start, *more)

    blocks, faces = [block("middle", partial(centre, half), around, solid)], {}
    for q, (name, side) in enumerate(zip(("right", "top", "left", "bottom"), sides)):
        blocks.append(block(f"disk {name}", partial(quarter, q, radius, half), within, solid))
        blocks.append(block(f"gas {name}", partial(beyond, q), outside, gas))
        faces[f"gas {name}", 0, 1] = side
    return BlockProblem(tuple(blocks), faces, units="none")


@case(
    {"fsi_h": 0.05, "ts_max_time": 1.25, "fsi_output_dt": 0.025},
    Option("disk_spin", float, 0.8, "1/s", "angular velocity of the disk at the start"),
    Option("disk_power", int, 0, "", "p of the factor (1 - R^2)^p of spin", check="nonnegative"),
    *materials(fluid_mu=0.0, fluid_kappa=0.0, solid_density=2.0, solid_mu=1.0, solid_lambda=1.5),
)
def disk(opt: Opt) -> BlockProblem:
    """A disk of St. Venant and Kirchhoff's solid that spins in gas, in two dimensions.

    At the start the disk spins as a rigid body and is free of stress under the pressure of the gas,
    so it widens and swings. With -disk_power the edge is at rest at first, and the motion is
    smooth: verify/disk.py solves it in the radius alone. The grid of the gas is wound up with the
    disk: a run must end well before half a turn.
    """
    gas, solid = common.gas_of(opt), common.elastic_of(opt, law="svk")
    radius, vessel, half = 1.0, 2.2, 0.45

    def spinning(X, Y):
        # 1 - R^2 is round-off at the edge, and below 0 there
        spin = opt["disk_spin"] * np.abs(1.0 - X * X - Y * Y) ** opt["disk_power"]
        return -spin * Y, spin * X, 1.0 + 0.0 * X, X, Y

    def ring(q, xi):
        ends = np.pi / 4 * (2.0 * q - 1.0), np.pi / 4 * (2.0 * q + 1.0)
        return annulus(radius, vessel, ends)(xi)

    cells = common.cells_of(opt, 2.0 * half, radius - half, vessel - radius)
    content = (solid, spinning), (gas, common.constant(1.0, 0.0, 0.0, 1.0))
    wall = NoSlip() if gas.mu > 0.0 else Slip()
    return disk_in_gas(radius, half, cells, *content, ring, [wall] * 4)


@case(
    {"fsi_h": 1 / 32, "ts_max_time": 2.0, "fsi_output_dt": 0.05, **SHOCKS},
    Option("cylinder_mach", float, 2.0, "", "Mach number of the shock", check="above 1"),
    *materials(solid_modulus=40.0, solid_density=14.0),
)
def cylinder(opt: Opt) -> BlockProblem:
    """A shock runs over an elastic cylinder at the origin, which flies away along a channel."""
    gas, radius, core = common.gas_of(opt, R=AHEAD.p / AHEAD.rho), 0.5, 0.22
    solid = common.elastic_of(opt, AHEAD.p, law="neo-hookean")
    flow, inflow = shock_in_plane(gas, AHEAD, opt["cylinder_mach"], -1.0)
    # corners of the channel, that of quarter q and the next: right, upper, left, lower side
    corners = np.array([(2.5, -1.5), (2.5, 1.5), (-1.5, 1.5), (-1.5, -1.5)])

    def in_gas(q, xi):
        """From the circle to a side of the channel."""
        angle = np.pi / 4 * (2.0 * xi[1] - 1.0 + 2.0 * q)
        circle = radius * np.cos(angle), radius * np.sin(angle)
        return between(xi[0], circle, between(xi[1], corners[q], corners[(q + 1) % 4]))

    cells = common.cells_of(opt, np.pi / 2 * radius, radius - core, 1.25)
    sides = Outflow(AHEAD.p), Slip(), inflow, Slip()
    return disk_in_gas(radius, core, cells, (solid, common.at_rest()), (gas, flow), in_gas, sides)


@case(
    {"fsi_h": 1 / 24, "ts_max_time": 2.5, "fsi_output_dt": 0.05, **SHOCKS},
    Option("nozzle_mach", float, 1.5, "", "Mach number of the shock", check="above 1"),
    *materials(solid_modulus=60.0, solid_density=14.0),
)
def nozzle(opt: Opt) -> BlockProblem:
    """A shock runs through an elastic nozzle, around an axis: gas inside, the wall, gas around it.

    X, along axis 0 of the blocks, is the place along the axis, Y the distance from it. The wall is
    clamped at both ends and wide at these.
    """
    gas = common.gas_of(opt, R=AHEAD.p / AHEAD.rho)
    wall = common.elastic_of(opt, AHEAD.p, law="neo-hookean")
    flow, inflow = shock_in_plane(gas, AHEAD, opt["nozzle_mach"], 0.2)
    length, wide, throat, thickness, vessel = 3.0, 0.5, 0.3, 0.12, 1.2
    widths = length, wide, thickness, vessel - wide - thickness
    along, inside, across, around = common.cells_of(opt, *widths)

    def radius(z):
        narrower = np.sin(np.pi * z / length) ** 2
        return wide - (wide - throat) * narrower * narrower

    def from_wall(low, high, xi):
        """From so far beyond the inner side of the wall to so far; high = 0: to the vessel."""
        z = length * xi[0]
        outer = radius(z) + high if high else vessel
        return z, (1.0 - xi[1]) * (radius(z) + low) + xi[1] * outer

    core = off_axis(lambda xi: (length * xi[0], xi[1] * radius(length * xi[0])), inside)
    still, rest = common.constant(AHEAD.rho, 0.0, 0.0, 1.0), common.at_rest()
    inner = Block("inside", gas, core, (along, inside), flow)
    lining = Block("wall", wall, partial(from_wall, 0.0, thickness), (along, across), rest)
    outer = Block("around", gas, partial(from_wall, thickness, 0.0), (along, around), still)
    faces = {("inside", 1, 0): Centre(), ("around", 1, 1): Slip()}
    faces |= {("inside", 0, 0): inflow, ("inside", 0, 1): Outflow(AHEAD.p)}
    for side in (0, 1):
        faces |= {("wall", 0, side): Clamped(), ("around", 0, side): Slip()}
    return BlockProblem((inner, lining, outer), faces, units="none", symmetry=1)


@case(
    {"fsi_h": 0.005, "fsi_cfl": 1.2, "ts_max_time": 2e-3, "fsi_output_dt": 1e-4, **SHOCKS}
    | {"fsi_probes": "0.051,0.05"},
    Option("fin_mach", float, 1.21, "", "Mach number of the shock", check="above 1"),
    Option("fin_length", float, 0.05, "m", "length of the panel, below 0.065", check="positive"),
    Option("fin_thickness", float, 1e-3, "m", "thickness of the panel", check="positive"),
)
def fin(opt: Opt) -> BlockProblem:
    """A shock hits a steel panel that stands on the floor of a shock tube, its foot clamped.

    Data are those of J. Giordano et al., Shock Waves 14 (2005) 103-110: air at 101 kPa and 1.2
    kg/m3, a panel of 1 x 50 mm in a channel of 65 x 300 mm, its end 250 mm behind the panel.
    """
    length, height = opt["fin_length"], 0.065
    air, ahead = Fluid(0.0, 0.0, 1.4, 287.0), GasState(1.2, 0.0, 101e3)
    flow, inflow = shock_in_plane(air, ahead, opt["fin_mach"], 0.025)
    young, poisson, density, alpha = 220e9, 0.3, 7600.0, 470.0  # of steel [SI]
    mu_e = young / (2.0 * (1.0 + poisson))
    lambda_e = 2.0 * mu_e * poisson / (1.0 - 2.0 * poisson)
    laws = {"law": "neo-hookean", "heat": "elastic"}
    steel = ElasticSolid(mu_e, lambda_e, 0.0, density, alpha, ahead.p, **laws)
    rest = common.at_rest(ahead.p / (air.R * ahead.rho))
    x, y = np.cumsum([0.0, 0.05, opt["fin_thickness"], 0.25]), (0.0, length, height)
    columns, rows = (common.cells_of(opt, *np.diff(at)) for at in (x, y))
    blocks, faces = [], {}
    for j, i in product(range(2), range(3)):
        panel = (i, j) == (1, 0)
        name = ("before", "panel", "behind")[i] + " above" * j
        map = rectangle((x[i], y[j]), (x[i + 1], y[j + 1]))
        material, start = (steel, rest) if panel else (air, flow)
        blocks.append(Block(name, material, map, (columns[i], rows[j]), start))
        faces[name, 1, j] = Clamped() if panel else Slip()
        if i != 1:
            faces[name, 0, i // 2] = Slip() if i else inflow
    return BlockProblem(tuple(blocks), faces)
