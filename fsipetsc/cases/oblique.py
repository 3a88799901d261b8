"""An oblique shock that is reflected from a wall: a rigid one, or an elastic layer upon it.

Gas comes in from the left at the Mach number M along the wall y = 0. A wedge above turns it by
an angle theta towards the wall; its shock comes in at the upper left corner, at the angle beta
to the flow, with

    tan theta = 2 cot beta (M^2 sin^2 beta - 1) / (M^2 (gamma + cos 2 beta) + 2),

and the wall turns the gas back by a second one (J. D. Anderson, Modern Compressible Flow, 3rd
ed., 2003, Sec. 4.3, 4.6). What is behind each of them over a rigid wall is known; notes of the
result say it. Over an elastic layer, which is clamped below and held against x at its ends, the
shock hits what it bends. Velocities are over the speed of sound of the gas that comes in,
densities over its density.
"""

import numpy as np

from fsipetsc import BlockProblem, Fluid, InputError, Option
from fsipetsc.blocks.conditions import Clamped, Open, Outflow, Roller, Slip
from fsipetsc.blocks.layers import Layer
from fsipetsc.cases.common import SHOCKS, Opt, at_rest, beside_gas, constant, elastic_of, stack
from fsipetsc.cases.riemann import GasState, behind_shock, sound
from fsipetsc.options import above_one

OPTIONS = (
    Option("oblique_mach", float, 2.9, "", "Mach number of the gas that comes in", check=above_one),
    Option("oblique_angle", float, 10.0, "degrees", "theta, of the wedge", check="positive"),
    Option("oblique_wall", str, "elastic", "", "what is below", ("rigid", "elastic")),
    *beside_gas(40.0),
)
DEFAULTS = {"fsi_h": 1 / 32, "ts_max_time": 4.0, "fsi_output_dt": 0.25, **SHOCKS}

#: the gas is 1 high, the layer, if there is one, so thick and so many cells [m]
GAMMA, LENGTH, THICKNESS, CELLS = 1.4, 3.0, 0.25, 18


def shock_angle(M: float, theta: float) -> float:
    """beta [rad] of the weak shock that turns a flow by theta [rad]. InputError if none does."""
    from scipy.optimize import brentq

    def turned(beta):
        normal = (M * np.sin(beta)) ** 2
        below = M * M * (GAMMA + np.cos(2.0 * beta)) + 2.0
        return np.arctan(2.0 / np.tan(beta) * (normal - 1.0) / below)

    angles = np.linspace(np.arcsin(1.0 / M), 0.5 * np.pi, 2001)
    most = angles[np.argmax([turned(beta) for beta in angles])]
    if turned(most) <= theta:
        raise InputError(
            f"no attached shock turns a flow of M = {M:.4g} by {np.degrees(theta):.4g} degrees: "
            f"expected less than {np.degrees(turned(most)):.4g}"
        )
    return brentq(lambda beta: turned(beta) - theta, angles[0], most, xtol=1e-15, rtol=1e-14)


def turned_by(gas: Fluid, state: GasState, theta: float) -> tuple[GasState, float]:
    """(The gas behind the weak shock that turns a flow of velocity u, whatever its direction, by
    theta, the angle beta of the shock to the flow) [rad]."""
    M = state.u / sound(gas, state)
    beta = shock_angle(M, theta)
    normal, s = behind_shock(gas, state._replace(u=0.0), M * np.sin(beta))
    # what is along the shock stays
    return normal._replace(u=np.hypot(state.u * np.cos(beta), s - normal.u)), beta


def build(opt: Opt) -> BlockProblem:
    """The gas between Y = 0 and 1, the layer below it, free of stress under the gas's pressure."""
    theta, gas = np.radians(opt["oblique_angle"]), Fluid(0.0, 0.0, GAMMA, 1.0 / GAMMA)
    first = GasState(1.0, opt["oblique_mach"], 1.0 / GAMMA)
    second, beta = turned_by(gas, first, theta)
    third, back = turned_by(gas, second, theta)
    flow = constant(1.0, first.u, 0.0, 1.0)
    u, v = second.u * np.cos(theta), -second.u * np.sin(theta)
    sides = {(0, 0): Open(first.rho, (first.u, 0.0), 1.0), (0, 1): Outflow()}
    members, lower = [Layer("gas", gas, (0.0, 1.0), flow, sides=sides)], Slip()
    if opt["oblique_wall"] == "elastic":
        solid, across = elastic_of(opt, first.p), (-THICKNESS, 0.0)
        layer = Layer("layer", solid, across, at_rest(), cells=CELLS, sides=Roller())
        members, lower = [layer, *members], Clamped()
    between, both = (
        f"p/p_1 = {q.p / first.p:.8g}, M = {q.u / sound(gas, q):.6g}" for q in (second, third)
    )
    return stack(
        opt,
        *members,
        along=((0.0, LENGTH),),
        lower=lower,
        upper=Open(second.rho, (u, v), second.p / (gas.R * second.rho)),
        notes=(
            f"the shock comes in at {np.degrees(beta):.6g} degrees and leaves a rigid wall at "
            f"x = {1.0 / np.tan(beta):.6g} at {np.degrees(back - theta):.6g} degrees",
            f"{between} between, {both} behind both",
        ),
    )
