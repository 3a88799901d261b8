"""Becker's shock: a viscous shock at rest, with a piston behind it that moves with the gas: gas | solid.

R. Becker, Stosswelle und Detonation, Z. Phys. 8 (1922) 321-362: for the Prandtl number 3/4, mu' c_p = kappa, the total
enthalpy is constant and the Navier-Stokes equations become, with the mass flux m,

    mu' u u_x = m (gamma+1)/(2 gamma) (u - u_1) (u - u_2),

which gives x as a function of u. The gas comes in at x = 0 faster than sound. The piston is so far behind the shock that
nothing but the uniform state reaches it; it moves to the right, so that the layer grows, and its grid is stretched.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.boundaries import Dirichlet, clamped
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "becker"
SUMMARY = "a viscous shock with supersonic inflow"
OPTIONS = (
    Option("becker_mach", float, 1.5, "", "Mach number of the shock", check="positive"),
    Option("becker_mu", float, 0.02, "Pa s", "4/3 of the viscosity", check="positive"),
    Option("becker_centre", float, 0.3, "m", "where the velocity is the mean of the two"),
)
DEFAULTS = {"fsi_h": 0.0125, "ts_max_time": 0.15, "fsi_output_dt": 1.0}

GAMMA, R = 1.4, 1.0


def velocity(x: np.ndarray, u1: float, u2: float, rate: float) -> np.ndarray:
    """u(x) between u1 and u2, the mean at 0, by bisection for z = ln((u1 - u)/(u - u2)); rate: m (gamma+1)/(2 gamma mu')."""
    wanted = np.atleast_1d(rate * (u1 - u2) * x)

    def place(z: np.ndarray) -> np.ndarray:
        """rate (u1 - u2) x: u1 ln(u1 - u) - u2 ln(u - u2) less its value at the mean."""
        log_left = -np.logaddexp(0.0, -z)  # ln of the share (u1 - u)/(u1 - u2)
        log_right = -np.logaddexp(0.0, z)
        return u1 * (log_left + np.log(2)) - u2 * (log_right + np.log(2))

    low, high = np.full(wanted.shape, -800.0), np.full(wanted.shape, 800.0)
    for _ in range(70):
        z = 0.5 * (low + high)
        left = place(z) < wanted
        low, high = np.where(left, z, low), np.where(left, high, z)
    z = 0.5 * (low + high)
    share = np.exp(-np.logaddexp(0.0, -z))
    return (u1 - (u1 - u2) * share).reshape(np.shape(x))


def build(opt: Mapping[str, Any]) -> Problem:
    """Gas in 0 < X < 1 at the start, the piston right of it."""
    M, mu = opt["becker_mach"], opt["becker_mu"]
    cp = R * GAMMA / (GAMMA - 1)
    gas = Fluid(0.75 * mu, mu * cp, GAMMA, R)
    u1 = M * float(gas.sound_speed(1.0))
    u2 = u1 * ((GAMMA - 1) * M * M + 2) / ((GAMMA + 1) * M * M)
    total = cp + 0.5 * u1 * u1

    def state(x: np.ndarray) -> tuple[np.ndarray, ...]:
        u = velocity(x - opt["becker_centre"], u1, u2, u1 * (GAMMA + 1) / (2 * GAMMA * mu))
        return u1 / u, u, (total - 0.5 * u * u) / cp

    T2 = (total - 0.5 * u2 * u2) / cp
    pressure = R * u1 / u2 * T2
    piston = Solid(K=20 * pressure, kappa_e=gas.kappa, m0=5.0, alpha=2.0)

    def rest(X: np.ndarray, t: float) -> list[np.ndarray]:
        return [np.full(X.shape, u2), np.full(X.shape, -pressure), np.full(X.shape, T2), X + u2 * t]

    inflow = tuple(float(v) for v in state(np.array(0.0)))
    return Problem(
        layers=(
            FluidLayer(
                *("gas", gas, (0.0, 1.0), lambda X: state(X)),
                exact=lambda X, t: state(X * (1 + u2 * t)),
            ),
            SolidLayer("piston", piston, (1.0, 1.4), lambda X: rest(X, 0.0), exact=rest),
        ),
        left=Dirichlet(0.0, lambda t: inflow),
        right=clamped(u2),
        units="none",
    )
