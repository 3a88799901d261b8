"""Shocks and fans, most with exact solutions, as of Riemann's problem of gas and solid.

There the gas stands on the left, the solid on the right; nothing is viscous or conducts heat. Both
sides have one velocity u and one pressure p at the interface, their temperatures differ. The solid
is at rest under a lower pressure, so that a shock goes into it; a shock or a fan goes into the gas.
Gas: E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics, 3rd ed., Springer 2009,
Sec. 4.2 to 4.5. Solid, with F = x_X, E = alpha m0 T and sigma - K ln F = const.: across a shock,
whose speed over X is s, into the state 0

    u - u0 = -s (F - F0),    m0 s^2 (F - F0) = sigma - sigma0,
    E - E0 = (sigma + sigma0)/2 (F - F0).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from fsipetsc import BlockProblem, Fluid, FluidLayer, Layer, Option, Problem, Solid, SolidLayer
from fsipetsc.blocks.conditions import Clamped, Free, Given, NoSlip, Open, Outflow, Roller, Slip
from fsipetsc.boundaries import Wall, clamped, free
from fsipetsc.cases import common
from fsipetsc.cases.common import SHOCKS, Opt, case, gas_of, materials, solid_of, stack
from fsipetsc.checks import Array, Fields
from fsipetsc.equations.elementary import exp, power
from fsipetsc.errors import InputError
from fsipetsc.materials.solid import ElasticSolid

GAMMA = 1.4


class GasState(NamedTuple):
    """Density [kg/m3], velocity [m/s], pressure [Pa]."""

    rho: Any
    u: Any
    p: Any


def sound(gas: Fluid, state: GasState) -> Any:
    """Return the speed of sound [m/s]."""
    return np.sqrt(gas.gamma * state.p / state.rho)


def behind_shock(gas: Fluid, ahead: GasState, mach: float) -> tuple[GasState, float]:
    """(the gas behind a shock that goes to the right at a Mach number above 1, its speed [m/s])."""
    g = gas.gamma
    s = ahead.u + mach * sound(gas, ahead)
    rho = ahead.rho * (g + 1) * mach**2 / ((g - 1) * mach**2 + 2)
    p = ahead.p * (1 + 2 * g / (g + 1) * (mach**2 - 1))
    return GasState(rho, s - (s - ahead.u) * ahead.rho / rho, p), s


def shock_in_plane(gas: Fluid, ahead: GasState, mach: float, start: float) -> tuple[Any, Open]:
    """Of a shock that is at X = start at first: initial data of a block, the inflow."""
    behind, _ = behind_shock(gas, ahead, mach)
    hot, warm = (state.p / (gas.R * state.rho) for state in (behind, ahead))

    def flow(X: Array, Y: Array) -> Fields:
        values = (behind.rho, ahead.rho), (behind.u, ahead.u), (0.0, 0.0), (hot, warm)
        return [np.where(X < start, hit, still) for hit, still in values]

    return flow, Open(behind.rho, (behind.u, 0.0), hot)


#: the gas of high pressure in Sod's shock tube; that of low pressure, whose pressure is on the rod
HIGH, LOW = GasState(1.0, 0.0, 1.0), GasState(0.125, 0.0, 0.1)


def behind_wave(gas: Fluid, before: GasState, p: float) -> GasState:
    """The gas behind a wave that goes to the left, where the pressure is p [Pa]."""
    (rho0, u0, p0), c0, g = before, sound(gas, before), gas.gamma
    if p > p0:
        dense = ((g + 1) * p / p0 + g - 1) / ((g - 1) * p / p0 + g + 1)
        change = (p - p0) * np.sqrt(2 / rho0 / ((g + 1) * p + (g - 1) * p0))
    else:
        dense = (p / p0) ** (1 / g)
        change = 2 * c0 / (g - 1) * ((p / p0) ** ((g - 1) / (2 * g)) - 1)
    return GasState(rho0 * dense, u0 - change, p)


def shocked(solid: Solid, p: float) -> tuple[float, float, float, float]:
    """(u, T, F) of a solid behind a shock of pressure p [Pa] that goes to the right, and the speed
    of the shock over X. Before it the solid is at rest under LOW.p, with T = 1.
    """
    sigma, m0 = LOW.p - p, solid.m0  # beyond that before the shock
    change = np.expm1(sigma / solid.K)
    s, heat = np.sqrt(sigma / change / m0), (0.5 * sigma - LOW.p) * change
    return -s * change, 1.0 + heat / (solid.alpha * m0), 1.0 + change, s


def contact(gas: Fluid, solid: Solid, state: GasState) -> tuple[Any, Any, tuple[str, str]]:
    """Exact solution of a gas in 0 < X < 1, in a state of a pressure above LOW.p, and a solid in 1
    < X < 2, at rest under LOW.p, which meet at t = 0. The wall on the left moves with the gas.

    Returns (rho, u, T) of the gas as a function of (X, t), where X is on the grid from the wall to
    the solid; (u, sigma, T, x) of the solid; notes. InputError if no shock goes into the solid.
    """
    from scipy.optimize import brentq

    (rho0, u0, p0), c0, g, high = state, sound(gas, state), gas.gamma, 1.0
    apart = lambda p: float(behind_wave(gas, state, p).u - shocked(solid, p)[0])  # noqa: E731
    if apart(LOW.p * (1.0 + 1e-9)) < 0.0:
        raise InputError(f"no shock goes into the solid: the gas has {state}")
    while apart(high) > 0.0:
        high *= 2.0
    p = float(brentq(apart, 1e-12 * high, high, xtol=1e-300, rtol=1e-15))
    (u, T_s, F, s), near = shocked(solid, p), behind_wave(gas, state, p)
    front, back = u0 - c0, near.u - sound(gas, near)  # of a fan; a shock has one speed
    if p > p0:
        front = back = (near.rho * near.u - rho0 * u0) / (near.rho - rho0)

    def in_gas(X: Array, t: float = 0.0) -> Fields:
        if t <= 0:
            return [value + 0.0 * X for value in (rho0, u0, p0 / (gas.R * rho0))]
        wall = u0 * t
        speed = (wall + X * (1.0 + near.u * t - wall) - 1.0) / t
        c = np.clip((2 * c0 + (g - 1) * (u0 - speed)) / (g + 1), 0.0, None)
        fan = rho0 * (c / c0) ** (2 / (g - 1)), speed + c, p0 * (c / c0) ** (2 * g / (g - 1))
        states = zip(state, fan, near, strict=True)
        rho, v, q = (np.select([speed < front, speed < back], [a, b], d) for a, b, d in states)
        return [rho, v, q / (gas.R * rho)]

    def in_solid(X: Array, t: float = 0.0) -> Fields:
        passed = X - 1.0 < s * t
        moved = np.where(passed, u * t + F * (X - 1.0), X - 1.0)  # all depends on X/t
        pairs = (u, 0.0), (-p, -LOW.p), (T_s, 1.0)
        return [*(np.where(passed, a, b) for a, b in pairs), 1.0 + moved]

    end = min(1.0 / s, 1.0 / (u0 - front))  # a wave comes to an end
    exact = f"the exact solution has no viscosity and conduction, and holds until t = {end:.6g}"
    return in_gas, in_solid, (f"interface: p = {p:.10g}, u = {u:.10g}, x_X = {F:.10g}", exact)


@case(
    {"fsi_h": 0.005, "ts_max_time": 0.3, "fsi_output_dt": 0.01, "fsi_norm": "L1"}
    | {"fsi_shock": 1.4, "fsi_dissipation": 2.0},
    Option("shock_problem", str, "sod", "", "which problem", ("sod", "strong")),
    Option("shock_mach", float, 3.0, "", "strong: Mach number of the shock", check="above 1"),
    Option("shock_ratio", float, 10.0, "", "sod: ratio of the pressures", check="above 1"),
    *materials(fluid_mu=0.0, fluid_kappa=0.0),
    *materials(solid_modulus=4.0, solid_density=0.5, solid_alpha=1.0),
)
def shock(opt: Opt) -> Problem:
    """Shocks in a gas and in the elastic rod before it, with exact solutions.

    sod: the left half of Sod's shock tube, with a rod under the low pressure in the place of the
    right half, whose right end is clamped. A fan goes into the gas, a shock into the rod.

    strong: a piston drives a shock through the gas of low pressure. At t = 0 it hits the light rod:
    a shock goes back into the gas and one on into the rod, whose right end is free.
    """
    gas, solid = gas_of(opt), solid_of(opt)
    if opt["shock_problem"] == "strong":
        state, _ = behind_shock(gas, LOW, opt["shock_mach"])
        left = Wall(lambda t: state.u * t, velocity=lambda t: state.u)
        right = free(-LOW.p)
    else:
        state, left, right = HIGH._replace(p=opt["shock_ratio"] * LOW.p), Wall(0.0), clamped()
    in_gas, in_solid, notes = contact(gas, solid, state)
    first = FluidLayer("gas", gas, (0.0, 1.0), in_gas, exact=in_gas)
    layers = first, SolidLayer("rod", solid, (1.0, 2.0), in_solid, exact=in_solid)
    return Problem(layers, left, right, notes=notes, units="none")


@case(
    {"fsi_h": 0.01, "ts_max_time": 0.15, "fsi_output_dt": 0.05, "fsi_norm": "L1", **SHOCKS},
    *materials(solid_modulus=4.0, solid_density=0.5),
)
def tube(opt: Opt) -> BlockProblem:
    """The shock tube of the case `shock` in a plane: across Y into an elastic layer.

    Where nothing varies along X the law `log` is that of the rod.
    """
    gas, rod = gas_of(opt), Solid(opt["solid_modulus"], 0.0, opt["solid_density"], 1.0)
    across_gas, across_solid, notes = contact(gas, rod, HIGH)
    layer = ElasticSolid(rod.K / 4, rod.K / 2, 0.0, rod.m0, 1.0, p_ref=LOW.p)

    def in_gas(X, Y, t=0.0):
        rho, v, T = across_gas(Y, t)
        return rho, 0.0 * v, v, T

    def in_solid(X, Y, t=0.0):
        v, _, T, y = across_solid(Y, t)
        return 0.0 * v, v, T, X, y

    below = Layer("gas", gas, (0.0, 1.0), in_gas, exact=in_gas)
    above = Layer("layer", layer, (1.0, 2.0), in_solid, exact=in_solid)
    ends = {"lower": Slip(), "upper": Clamped(), "along": ((0.0, 0.25),)}
    return stack(opt, below, above, notes=notes, **ends)


@case(
    {"fsi_h": 1 / 40, "ts_max_time": 0.7, "fsi_output_dt": 0.1},
    Option("piston_way", str, "receding", "", "what the rod does", ("receding", "advancing")),
)
def elastic_piston(opt: Opt) -> BlockProblem:
    """An elastic rod that recedes from a gas, or advances into it, with an exact solution.

    The rod is on the left. The interface moves as F(t) = -t^4/4 or t^4/4. The gas (gamma = 1.4,
    speed of sound 1 at rest) is a simple wave: u = F'(s) along x = F(s) + (1 + 1.2 F'(s)) (t - s).
    The rod is linear elastic, of density 1 and wave speed c = 2,

        displacement f(t - X/c) + g(t + X/c),    f' = (F' + q/c)/2,    g' = (F' - q/c)/2,

    q = p - p0 at the interface. Nothing is viscous or conducts heat. After the elastic piston of J.
    W. Banks, W. D. Henshaw, D. W. Schwendeman, J. Comput. Phys. 231 (2012) 3518-3547.
    """
    # of the gas at rest; no wave reaches the wall at its end before t = 1.5
    rho, T, C, width = 0.1, 1 / 1.4, 2.0, 1.5
    P = rho * T
    F = Polynomial([0.0, 0.0, 0.0, 0.0, -0.25 if opt["piston_way"] == "receding" else 0.25])
    speed = F.deriv()
    q = P * ((1.0 + 0.2 * speed) ** 7 - 1.0) / C
    f, g = 0.5 * (F + q.integ()), 0.5 * (F - q.integ())

    def rod(X, t=0.0):
        to, fro = t - X / C, np.maximum(t + X / C, 0.0)  # no wave goes left before t = 0
        return f.deriv()(to) + g.deriv()(fro), 1.0, X + f(to) + g(fro)

    def pressure(X, t):
        return P - C * (g.deriv()(np.maximum(t + X / C, 0.0)) - f.deriv()(t - X / C))

    def gas(X, t=0.0):
        """Return (rho, u, T) on the grid between the rod and the wall."""
        x = X + (1.0 - X / width) * F(t)
        low, high = np.zeros_like(x), np.full_like(x, t)  # of s; beyond x = t the gas is at rest
        for _ in range(60):
            s = 0.5 * (low + high)
            outside = F(s) + (1.0 + 1.2 * speed(s)) * (t - s) < x
            low, high = np.where(outside, low, s), np.where(outside, s, high)
        u = np.where(x < t, speed(low), 0.0)
        c = 1.0 + 0.2 * u
        return rho * c**5, u, T * c**2

    solid = ElasticSolid(C**2 / 3, C**2 / 3, 0.0, 1.0, 1.0, P, law="linear", heat="elastic")
    left = Layer("rod", solid, (-0.5, 0.0), rod, exact=rod)
    right = Layer("gas", Fluid(0.0, 0.0, GAMMA, 1.0), (0.0, width), gas, exact=gas)
    return stack(opt, left, right, lower=Free(pressure), upper=Slip(), units="")


@case({"fsi_h": 1 / 40, "ts_max_time": 0.5, "fsi_output_dt": 0.05, "fsi_norm": "L1", **SHOCKS})
def superseismic(opt: Opt) -> BlockProblem:
    """A shock in gas that runs along an elastic half space faster than its waves, with its states.

    The shock's foot runs along Y = 0 at the speed 1, with a P and an S wave behind it in the solid.
    All is constant between fronts through the foot; verify/superseismic.py derives the numbers.
    """
    # gas ahead (p = rho T) and behind: rho, u, v, T; Lame's constants; density of the solid is 1
    ahead = 0.1114827, 0.0, 0.0, 0.09375
    behind = 0.40332749096, 0.721181138995, -0.0417025872267, 0.225252990995
    lame, mu, height = 0.1398307, 0.07203351, 0.75
    phi = -0.0577610764136  # angle of the shock's normal
    # speeds of the P and the S wave, and their strengths
    waves = (np.sqrt(lame + 2.0 * mu), -0.294687560053), (np.sqrt(mu), 0.125425426543)

    def displacement(X, Y, t):
        """(displacement, velocity) of the solid: each wave moves what it has passed."""
        moved, velocity = [0.0 * X, 0.0 * X], [0.0 * X, 0.0 * X]
        for shear, (c, strength) in enumerate(waves):
            n = c, -np.sqrt(1.0 - c * c)
            phase = n[0] * (X - t) + n[1] * Y
            for k, along in enumerate((-n[1], n[0]) if shear else n):
                moved[k] = moved[k] + strength * along * np.minimum(phase, 0.0)
                velocity[k] = velocity[k] - strength * along * c * (phase < 0.0)
        return moved, velocity

    def solid(X, Y, t=0.0):
        moved, velocity = displacement(X, Y, t)
        return [*velocity, 1.0, X + moved[0], Y + moved[1]]

    def gas(X, Y, t=0.0):  # on the grid that follows the solid below it
        moved = displacement(X, 0.0 * Y, t)[0]
        x, y = (a + (1.0 - Y / height) * b for a, b in zip((X, Y), moved))
        passed = np.cos(phi) * (x - t) + np.sin(phi) * y < 0.0
        return [np.where(passed, b, a) for a, b in zip(ahead, behind)]

    rho, u, T = (lambda X, Y, t, at=at: gas(X, Y, t)[at] for at in (0, slice(1, 3), 3))
    outside, p = Open(rho, u, T), ahead[0] * ahead[3]
    material = ElasticSolid(mu, lame, 0.0, 1.0, 1.0, p, law="linear", heat="elastic")
    below = Layer("half space", material, (-height, 0.0), solid, exact=solid, sides=Given(solid))
    above = Layer("gas", Fluid(0.0, 0.0, GAMMA, 1.0), (0.0, height), gas, exact=gas, sides=outside)
    return stack(opt, below, above, lower=Given(solid), upper=outside, along=((-0.5, 1.0),))


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
    gas = gas_of(opt)
    plate = common.elastic_of(opt, kappa_e=0.01, law=opt["solid_law"], heat="coupled")

    def start(X, Y):  # of the same entropy everywhere
        p = 1.0 + opt["blast_height"] * exp(-((X - 0.5) ** 2 + (Y - 0.5) ** 2) / 0.15**2)
        rho = power(p, 1.0 / gas.gamma)
        return rho, 0.0, 0.0, p / rho

    below = Layer("gas", gas, (0.0, 1.0), start, sides=Slip())
    above = Layer("plate", plate, (1.0, 1.25), common.at_rest(), sides=Roller())
    return stack(opt, below, above, lower=NoSlip(), upper=Free(1.0), along=((0.0, 1.0),))


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
    return stack(opt, *members, along=((0.0, 3.0),), lower=lower, upper=upper)
