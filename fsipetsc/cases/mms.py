"""Manufactured solution (Sec. 5.1): fluid | solid | fluid with forcing in the layers and at the
interfaces.

The fields (5.1), (5.2) are given in the coordinate X of each layer's own grid; x is given in the
solid alone. So the forcing of a fluid contains the exact velocity s of its frame, the fluid's at
its interface point, and the embedded boundaries lie at X = X_I + x_boundary - x(X_I, t). Density,
velocity and temperature at the boundaries are exact data; the four interface conditions get the
jumps of the exact solution.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, wraps
from math import cos, sin
from typing import Any

import numpy as np
from numba import njit

from fsipetsc.boundaries import DEGREES, Dirichlet
from fsipetsc.cases.materials import gas_of, material_options, solid_of
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.operators.loops import CALL as COMPILED
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "mms"
SUMMARY = "manufactured solution: errors against the exact solution (Sec. 5.1)"

OPTIONS = (
    *material_options(
        fluid_mu=0.01,
        fluid_kappa=0.03,
        fluid_gamma=1.4,
        fluid_R=1.0,
        solid_modulus=10.0,
        solid_kappa=0.02,
        solid_density=2.0,
        solid_alpha=1.0,
    ),
    Option("mms_epsilon", "float", 0.2, "", "epsilon of (5.2d)"),
    Option("mms_omega", "float", 2.0, "1/m", "wave number omega of (5.1), (5.2)"),
    Option("mms_phi", "float", 0.47, "", "phase phi of (5.1b)"),
    Option("mms_degree", "int", None, "", "degree of the ends' formulas, if not by order", DEGREES),
)
#: interfaces and grids are the paper's
DEFAULTS = {
    **{"fsi_h": 0.0125, "fsi_order": 4, "ts_max_time": 0.45, "fsi_output_dt": 0.05},
    "fsi_coupling": "projection",
}

LEFT, RIGHT = 0.25, 4.0


def _once_per_grid(modes: Callable[..., Sequence[np.ndarray]]) -> Callable[..., Any]:
    """Keep what a method finds from X alone, because every stage asks for it at the same points:
    (modes, n), or floats."""

    @lru_cache(maxsize=64)
    def kept(exact: Exact, points: bytes, shape: tuple[int, ...]) -> np.ndarray | list[float]:
        found = np.array(modes(exact, np.frombuffer(points).reshape(shape)))
        return found if shape else found.tolist()

    @wraps(modes)
    def method(exact: Exact, X: np.ndarray | float) -> np.ndarray | list[float]:
        X = np.asarray(X, dtype=float)
        return kept(exact, X.tobytes(), X.shape)

    return method


@dataclass(frozen=True)
class Exact:
    """The exact solution; eps, omega, phi as in (5.1), (5.2). A field is a function of t times a
    *mode* in X, plus 1, 10, …"""

    eps: float
    omega: float
    phi: float

    @_once_per_grid
    def fluid_modes(self, X: np.ndarray) -> tuple[np.ndarray, ...]:
        """Modes of rho, u, T, then their X-derivatives, then the second ones of u, T."""
        w = self.omega
        rho, u, T = 0.5 * np.sin(w * X), np.cos(w * X + self.phi), np.cos(2 * X)
        slopes = 0.5 * w * np.cos(w * X), -w * np.sin(w * X + self.phi), -2 * np.sin(2 * X)
        return rho, u, T, *slopes, -w * w * u, -4 * T

    @_once_per_grid
    def solid_modes(self, X: np.ndarray) -> tuple[np.ndarray, ...]:
        """Modes of u and x-X, of sigma, of T, then their X-derivatives, then the second ones of x,
        T."""
        w, a = self.omega, 2 * np.pi
        modes = 1 + X + self.eps * np.sin(a * X), np.sin(w * X), np.sin(3 * X)
        slopes = 1 + self.eps * a * np.cos(a * X), w * np.cos(w * X), 3 * np.cos(3 * X)
        return *modes, *slopes, -self.eps * a * a * np.sin(a * X), -9 * modes[2]

    def fluid(self, X: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(rho, u, T) of (5.1)."""
        rho, u, T, *_ = self.fluid_modes(X)
        return 1 + cos(t) * rho, sin(t) * u, 10 + sin(3 * t) * T

    def solid(self, X: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        """(u, sigma, T, x) of (5.2)."""
        g, sigma, T, *_ = self.solid_modes(X)
        return t * g, sin(t * t) * sigma, 5 + cos(t) * T, X + 0.5 * t * t * g


@njit(**COMPILED)
def fluid_forcing(modes, t, s, mu, kappa, R, cv):
    """What the exact solution leaves over in (4.20), shape (3, n), in a frame of velocity s; mu is
    4/3 of the viscosity."""
    out = np.empty((3, modes.shape[1]))
    a, b, c, a_t, b_t, c_t = cos(t), sin(t), sin(3 * t), -sin(t), cos(t), 3 * cos(3 * t)
    for i in range(modes.shape[1]):
        rho, u, T = 1 + a * modes[0, i], b * modes[1, i], 10 + c * modes[2, i]
        rho_t, u_t, T_t = a_t * modes[0, i], b_t * modes[1, i], c_t * modes[2, i]
        rho1, u1, T1 = a * modes[3, i], b * modes[4, i], c * modes[5, i]
        u2, T2 = b * modes[6, i], c * modes[7, i]
        p, p1 = R * rho * T, R * (rho1 * T + rho * T1)
        mass = rho_t + rho1 * (u - s) + rho * u1
        force = rho * (u_t + (u - s) * u1) + p1 - mu * u2
        heat = rho * cv * (T_t + (u - s) * T1) + p * u1 - mu * u1 * u1 - kappa * T2
        out[0, i], out[1, i] = mass, mass * u + force
        out[2, i] = mass * (cv * T + 0.5 * u * u) + u * force + heat
    return out


@njit(**COMPILED)
def solid_forcing(modes, t, K, kappa_e, m0, alpha):
    """What the exact solution leaves over in (4.19), shape (4, n), with p = 0."""
    out = np.zeros((4, modes.shape[1]))
    b, b_t, c, c_t, half = sin(t * t), 2 * t * cos(t * t), cos(t), -sin(t), 0.5 * t * t
    for i in range(modes.shape[1]):
        u1, sigma1, T1 = t * modes[3, i], b * modes[4, i], c * modes[5, i]
        x1 = 1 + half * modes[3, i]
        x2, T2 = half * modes[6, i], c * modes[7, i]
        conduction = kappa_e * (T2 / x1 - T1 * x2 / (x1 * x1))
        out[0, i] = modes[0, i] - sigma1 / m0
        out[1, i] = b_t * modes[1, i] - K / x1 * u1
        out[2, i] = c_t * modes[2, i] - (b * modes[1, i] * u1 + conduction) / (alpha * m0)
    return out


def jumps(
    exact: Exact, gas: Fluid, solid: Solid, X_I: float, t: float
) -> tuple[float, float, float, float]:
    """Left over in u_s = u_f, the stress condition, T_s = T_f and the heat-flux condition at
    X_I."""
    rho, uf, Tf = exact.fluid(X_I, t)
    us, sigma, Ts, _ = exact.solid(X_I, t)
    uf1, Tf1 = exact.fluid_modes(X_I)[4:6]
    g1, _, Ts1 = exact.solid_modes(X_I)[3:6]
    stress = sigma + gas.R * rho * Tf - 4 / 3 * gas.mu * sin(t) * uf1
    flux = solid.kappa_e / (1 + 0.5 * t * t * g1) * cos(t) * Ts1 - gas.kappa * sin(3 * t) * Tf1
    return us - uf, stress, Ts - Tf, flux


def build(opt: Mapping[str, Any]) -> Problem:
    """Solid in 1 < X < 2, fluid beside it in 1/4 < x < 4."""
    if opt["fsi_coupling"] == "conservative":
        problem = "the solution of mms is a function of X in a rigid frame"
        raise InputError(
            f"-fsi_coupling conservative: {problem}: take projection, energy or traditional"
        )
    exact = Exact(opt["mms_epsilon"], opt["mms_omega"], opt["mms_phi"])
    gas = gas_of(opt)
    solid = solid_of(opt)
    gas_numbers = 4 / 3 * gas.mu, gas.kappa, gas.R, gas.cv

    def boundary(x_boundary: float, X_I: float) -> Dirichlet:
        def data(t: float) -> tuple[float, float, float]:
            return exact.fluid(X_I + x_boundary - exact.solid(X_I, t)[3], t)

        return Dirichlet(x_boundary, data, opt["mms_degree"])

    def fluid(name: str, X: tuple[float, float], X_I: float) -> FluidLayer:
        return FluidLayer(
            name,
            gas,
            X,
            initial=lambda X: exact.fluid(X, 0.0),
            forcing=lambda X, t: fluid_forcing(
                exact.fluid_modes(X), t, exact.fluid(X_I, t)[1], *gas_numbers
            ),
            exact=exact.fluid,
        )

    middle = SolidLayer(
        "solid",
        solid,
        (1.0, 2.0),
        initial=lambda X: exact.solid(X, 0.0),
        forcing=lambda X, t: solid_forcing(
            exact.solid_modes(X), t, solid.K, solid.kappa_e, solid.m0, solid.alpha
        ),
        exact=exact.solid,
    )
    return Problem(
        layers=(fluid("left", (LEFT, 1.0), 1.0), middle, fluid("right", (2.0, RIGHT), 2.0)),
        left=boundary(LEFT, 1.0),
        right=boundary(RIGHT, 2.0),
        jumps=lambda k, t: jumps(exact, gas, solid, (1.0, 2.0)[k], t),
        units="none",
    )
