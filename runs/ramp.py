"""A supersonic flow meets an elastic ramp: an oblique shock at its foot, a fan at its crest.

    mpiexec -n 2 python -m fsipetsc runs/ramp.py

Two dimensions. Gas without viscosity flows along a floor, which rises by an angle from x = 0 to 1
and is level behind. Floor and ramp are the face of a solid, clamped below, or rigid. Behind the
shock and behind the fan the state of the gas is known (J. D. Anderson, Modern Compressible Flow,
3rd ed., 2003, Sec. 4.3 and 4.14); notes of the result say it. docs/shocks.md has what the run makes
of it. Velocities are over the speed of sound of the gas that comes in, densities over its density.
"""

import numpy as np
from scipy.optimize import brentq

from fsipetsc import Block, BlockProblem, ElasticSolid, Fluid, Option
from fsipetsc.blocks.conditions import Clamped, Open, Outflow, Roller, Slip
from fsipetsc.blocks.maps import corners
from fsipetsc.cases import common
from fsipetsc.cases.shocks import GasState, sound, turned_by

OPTIONS = (
    Option("ramp_mach", float, 2.0, "", "Mach number of the gas that comes in", check="above 1"),
    Option("ramp_angle", float, 10.0, "degrees", "angle of the ramp", check="positive"),
    Option("ramp_wall", str, "elastic", "", "what the floor is", ("rigid", "elastic")),
    Option("ramp_modulus", float, 200.0, "", "2 mu_e + lambda_e over p_1", check="positive"),
)
DEFAULTS = {"fsi_h": 1 / 32, "ts_max_time": 4.0, "fsi_output_dt": 0.2, **common.SHOCKS}

GAMMA, HEIGHT, DEPTH = 1.4, 1.75, 0.25
#: X of the inflow, the foot, the crest, the outflow
X = (-0.5, 0.0, 1.0, 2.0)


def through_fan(gas: Fluid, state: GasState, theta: float) -> GasState:
    """The gas that a fan has turned by theta [rad] away from itself (Prandtl and Meyer)."""

    def angle(M):
        k, m = np.sqrt((GAMMA + 1) / (GAMMA - 1)), np.sqrt(M * M - 1)
        return k * np.arctan(m / k) - np.arctan(m)

    def total(M):
        return 1 + 0.5 * (GAMMA - 1) * M * M

    M = state.u / sound(gas, state)
    after = brentq(lambda m: angle(m) - angle(M) - theta, M, 50.0)
    cold = total(M) / total(after)
    p, rho = state.p * cold ** (GAMMA / (GAMMA - 1)), state.rho * cold ** (1 / (GAMMA - 1))
    return GasState(rho, after * np.sqrt(GAMMA * p / rho), p)


def build(opt):
    """Three blocks of gas: before, on and behind the ramp; below them three of the solid."""
    M, theta, gas = opt["ramp_mach"], np.radians(opt["ramp_angle"]), Fluid(0, 0, GAMMA, 1 / GAMMA)
    first = GasState(1.0, M, 1 / GAMMA)
    second = turned_by(gas, first, theta)
    third = through_fan(gas, second, theta)
    K = opt["ramp_modulus"] * first.p
    solid = ElasticSolid(K / 4, K / 2, 0.0, 10.0, 1.0, p_ref=first.p, heat="elastic")
    rise, elastic = np.tan(theta), opt["ramp_wall"] == "elastic"
    floor, top, bottom = (0.0, 0.0, rise, rise), (HEIGHT,) * 4, (-DEPTH,) * 4

    def cells(length, least=8):
        return max(least, round(length / opt["fsi_h"]))

    def blocks(what, material, low, high, n, initial):
        """Three blocks between two lines, each given by its places at X."""
        return [
            Block(
                f"{what} {k}",
                material,
                corners(*((X[m], line[m]) for line in (low, high) for m in (k, k + 1))),
                (cells(X[k + 1] - X[k]), n),
                initial,
            )
            for k in range(3)
        ]

    flow, rest = common.constant(1.0, M, 0.0, 1.0), common.at_rest()
    beyond = Open(1.0, (M, 0.0), 1.0)
    faces = {(f"gas {k}", 1, 1): beyond for k in range(3)}
    faces |= {("gas 0", 0, 0): beyond, ("gas 2", 0, 1): Outflow()}
    parts = blocks("gas", gas, floor, top, cells(HEIGHT), flow)
    if elastic:
        parts += blocks("solid", solid, bottom, floor, cells(DEPTH, 12), rest)
        faces |= {(f"solid {k}", 1, 0): Clamped() for k in range(3)}
        faces |= {("solid 0", 0, 0): Roller(), ("solid 2", 0, 1): Roller()}
    else:
        faces |= {(f"gas {k}", 1, 0): Slip() for k in range(3)}
    on, behind = (
        f"p/p_1 = {q.p / first.p:.8g}, T/T_1 = {q.p / first.p / q.rho:.8g}, "
        f"M = {q.u / sound(gas, q):.6g}"
        for q in (second, third)
    )
    notes = f"behind the shock {on}", f"behind the fan {behind}"
    return BlockProblem(tuple(parts), faces, notes=notes, units="none")
