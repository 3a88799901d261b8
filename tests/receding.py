"""A piston that recedes from a gas, x_I = -t^4/4, without viscosity and conduction: solid | gas.

The piston is a rod that moves as one; what the interface lacks in stress is prescribed as a jump. The gas is a simple wave
(Riemann): along x = x_I(tau) + (u + c)(t - tau) it has the piston's velocity u = -tau^3 and the speed of sound
c = 1 + (gamma-1)/2 u. After the elastic piston of J. W. Banks, W. D. Henshaw, D. W. Schwendeman, J. Comput. Phys. 231 (2012)
3518-3547, whose gas is this one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.boundaries import Open, free
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "receding"
SUMMARY = "a piston recedes from a gas without conduction"
OPTIONS = ()
DEFAULTS = {"fsi_h": 0.025, "ts_max_time": 0.9, "fsi_output_dt": 1.0}

GAMMA, RHO = 1.4, 0.1
T = 1 / GAMMA  # the speed of sound at rest is 1


def piston(t):
    """Its position."""
    return -(t**4) / 4


def gas(X, t):
    """(rho, u, T); the piston is at X = 0."""
    x = np.maximum(X, 0.0) + piston(t)  # a ghost point beyond the piston has the piston's values
    low, high = np.zeros_like(x), np.full_like(x, t)  # of tau, by bisection; beyond x = t the gas is at rest
    for _ in range(60):
        middle = (low + high) / 2
        outside = piston(middle) + (1 - (GAMMA + 1) / 2 * middle**3) * (t - middle) < x
        low, high = np.where(outside, low, middle), np.where(outside, middle, high)
    u = np.where(x < t, -(low**3), 0.0)
    c = 1 + (GAMMA - 1) / 2 * u
    return RHO * c ** (2 / (GAMMA - 1)), u, T * c**2


def solid(X, t):
    """(u, sigma, T, x)."""
    return np.full_like(X, -(t**3)), np.zeros_like(X), np.ones_like(X), X + piston(t)


def push(X, t):
    """What moves the rod."""
    nothing = np.zeros_like(X)
    return np.full_like(X, -3 * t**2), nothing, nothing, nothing


def jumps(interface, t):
    """The rod has no stress, so all of the gas's pressure is one."""
    rho, _, temperature = gas(np.zeros(1), t)
    return 0.0, float(rho[0] * temperature[0]), 0.0, 0.0


def build(opt: Mapping[str, Any]) -> Problem:
    return Problem(
        layers=(
            SolidLayer("rod", Solid(1.0, 0.0, 1.0, 1.0), (-1.0, 0.0), lambda X: solid(X, 0.0), push, solid),
            FluidLayer("gas", Fluid(0.0, 0.0, GAMMA, 1.0), (0.0, 1.5), lambda X: gas(X, 0.0), exact=gas),
        ),
        left=free(),
        right=Open(1.5, RHO * T, T),
        jumps=jumps,
        units="none",
    )
