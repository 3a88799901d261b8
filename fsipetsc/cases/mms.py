"""Manufactured solution (Sec. 5.1): fluid | solid | fluid with forcing in the layers and at the interfaces.

The fields (5.1), (5.2) are given in the coordinate X of each layer's own grid; x is given in the solid alone. So the
forcing of a fluid contains the exact velocity s of its frame, the fluid's at its interface point, and the embedded
boundaries lie at X = X_I + x_boundary - x(X_I, t). Density, velocity and temperature at the boundaries are exact
data; the four interface conditions get the jumps of the exact solution.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, wraps
from math import cos, sin
from typing import Any

import numpy as np

from fsipetsc.boundaries import Dirichlet
from fsipetsc.options import Option
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.solid import Solid
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "mms"
SUMMARY = "manufactured solution: errors against the exact solution (Sec. 5.1)"

#: degree of the embedded-boundary formulas that lets each order show its rate
DEGREE = {2: 2, 4: 3, 6: 4, 8: 5}

OPTIONS = (
    Option("fluid_mu", "float", 0.01, "Pa s", "viscosity", check="nonnegative"),
    Option("fluid_kappa", "float", 0.03, "W/(m K)", "heat conductivity of the fluid", check="nonnegative"),
    Option(
        *("fluid_gamma", "float", 1.4, "", "ratio of the specific heats"),
        check=lambda value: None if value > 1 else "a number above 1",
    ),
    Option("fluid_R", "float", 1.0, "J/(kg K)", "gas constant over molar mass", check="positive"),
    Option("solid_modulus", "float", 10.0, "Pa", "2 mu_e + lambda_e", check="positive"),
    Option("solid_kappa", "float", 0.02, "W/(m K)", "heat conductivity of the solid", check="nonnegative"),
    Option("solid_density", "float", 2.0, "kg/m3", "density m0 of the solid in its reference state", check="positive"),
    Option("solid_alpha", "float", 1.0, "J/(kg K)", "specific heat of the solid", check="positive"),
    Option("mms_epsilon", "float", 0.2, "", "epsilon of (5.2d)"),
    Option("mms_omega", "float", 2.0, "1/m", "wave number omega of (5.1), (5.2)"),
    Option("mms_phi", "float", 0.47, "", "phase phi of (5.1b)"),
    Option("mms_degree", "int", None, "", "degree of the embedded-boundary formulas: 2 to 5", (2, 3, 4, 5)),
)
DEFAULTS = {"fsi_h": 0.0125, "fsi_order": 4, "ts_max_time": 0.45, "fsi_output_dt": 0.05}

LEFT, RIGHT = 0.25, 4.0


def _once_per_grid(function: Callable[..., tuple[np.ndarray, ...]]) -> Callable[..., tuple[np.ndarray, ...]]:
    """Keep what a method finds from X alone: every stage asks for it at the same points."""

    @lru_cache(maxsize=64)
    def kept(exact: Exact, points: bytes, shape: tuple[int, ...]) -> tuple[np.ndarray, ...]:
        return function(exact, np.frombuffer(points).reshape(shape))

    @wraps(function)
    def method(exact: Exact, X: np.ndarray) -> tuple[np.ndarray, ...]:
        X = np.asarray(X, dtype=float)
        return kept(exact, X.tobytes(), X.shape)

    return method


@dataclass(frozen=True)
class Exact:
    """The exact solution and its derivatives; eps, omega, phi as in (5.1), (5.2).

    All fields are a constant plus a factor in t times a *mode* in X.
    """

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
        """Modes of u and x-X, of sigma, of T, then their X-derivatives, then the second ones of x, T."""
        w, a = self.omega, 2 * np.pi
        modes = 1 + X + self.eps * np.sin(a * X), np.sin(w * X), np.sin(3 * X)
        slopes = 1 + self.eps * a * np.cos(a * X), w * np.cos(w * X), 3 * np.cos(3 * X)
        return *modes, *slopes, -self.eps * a * a * np.sin(a * X), -9 * modes[2]

    def fluid(self, X: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(rho, u, T) of (5.1)."""
        rho, u, T, *_ = self.fluid_modes(X)
        return 1 + cos(t) * rho, sin(t) * u, 10 + sin(3 * t) * T

    def fluid_slopes(self, X: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        """rho_X, u_X, T_X, u_XX, T_XX."""
        *_, rho1, u1, T1, u2, T2 = self.fluid_modes(X)
        return cos(t) * rho1, sin(t) * u1, sin(3 * t) * T1, sin(t) * u2, sin(3 * t) * T2

    def fluid_rates(self, X: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        """rho_t, u_t, T_t at fixed X."""
        rho, u, T, *_ = self.fluid_modes(X)
        return -sin(t) * rho, cos(t) * u, 3 * cos(3 * t) * T

    def solid(self, X: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        """(u, sigma, T, x) of (5.2)."""
        g, sigma, T, *_ = self.solid_modes(X)
        return t * g, sin(t * t) * sigma, 5 + cos(t) * T, X + 0.5 * t * t * g

    def solid_slopes(self, X: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        """u_X, sigma_X, T_X, x_X, T_XX, x_XX."""
        *_, g1, sigma1, T1, g2, T2 = self.solid_modes(X)
        return t * g1, sin(t * t) * sigma1, cos(t) * T1, 1 + 0.5 * t * t * g1, cos(t) * T2, 0.5 * t * t * g2

    def solid_rates(self, X: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        """u_t, sigma_t, T_t."""
        g, sigma, T, *_ = self.solid_modes(X)
        return g, 2 * t * cos(t * t) * sigma, -sin(t) * T


def fluid_forcing(exact: Exact, gas: Fluid, X: np.ndarray, t: float, X_I: float) -> tuple[np.ndarray, ...]:
    """What the exact solution leaves over in (4.20), in a frame that moves with the fluid at X_I."""
    mu, R, cv = 4 / 3 * gas.mu, gas.R, gas.cv
    s = float(exact.fluid(X_I, t)[1])
    rho, u, T = exact.fluid(X, t)
    r1, u1, T1, u2, T2 = exact.fluid_slopes(X, t)
    r_t, u_t, T_t = exact.fluid_rates(X, t)
    # along the frame's path: D rho, rho D u and rho D E with E = cv T + u^2/2
    v, p, p1 = u - s, R * rho * T, R * (r1 * T + rho * T1)
    mass = r_t + r1 * v + rho * u1
    force = rho * (u_t + v * u1) + p1 - mu * u2
    heat = rho * cv * (T_t + v * T1) + p * u1 - mu * u1 * u1 - gas.kappa * T2
    return mass, mass * u + force, mass * (cv * T + 0.5 * u * u) + u * force + heat


def solid_forcing(exact: Exact, solid: Solid, X: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
    """What the exact solution leaves over in (4.19), with p = 0."""
    sigma = exact.solid(X, t)[1]
    u1, sigma1, T1, x1, T2, x2 = exact.solid_slopes(X, t)
    u_t, sigma_t, T_t = exact.solid_rates(X, t)
    conduction = solid.kappa_e * (T2 / x1 - T1 * x2 / x1**2)
    return (
        u_t - sigma1 / solid.m0,
        sigma_t - solid.K / x1 * u1,
        T_t - (sigma * u1 + conduction) / (solid.alpha * solid.m0),
        np.zeros_like(X),
    )


def jumps(exact: Exact, gas: Fluid, solid: Solid, X_I: float, t: float) -> tuple[float, float, float, float]:
    """Left over in u_s = u_f, the stress condition, T_s = T_f and the heat-flux condition at X_I."""
    rho, uf, Tf = exact.fluid(X_I, t)
    _, uf1, Tf1, _, _ = exact.fluid_slopes(X_I, t)
    us, sigma, Ts, _ = exact.solid(X_I, t)
    _, _, Ts1, x1, _, _ = exact.solid_slopes(X_I, t)
    stress = sigma + gas.R * rho * Tf - 4 / 3 * gas.mu * uf1
    return us - uf, stress, Ts - Tf, solid.kappa_e / x1 * Ts1 - gas.kappa * Tf1


def build(opt: Mapping[str, Any]) -> Problem:
    """Solid in 1 < X < 2, fluid beside it in 1/4 < x < 4."""
    exact = Exact(opt["mms_epsilon"], opt["mms_omega"], opt["mms_phi"])
    gas = Fluid(opt["fluid_mu"], opt["fluid_kappa"], opt["fluid_gamma"], opt["fluid_R"])
    solid = Solid(opt["solid_modulus"], opt["solid_kappa"], opt["solid_density"], opt["solid_alpha"])
    degree = opt["mms_degree"] or DEGREE[opt["fsi_order"]]

    def boundary(x_boundary: float, X_I: float) -> Dirichlet:
        def data(t: float) -> tuple[float, float, float]:
            return exact.fluid(X_I + x_boundary - exact.solid(X_I, t)[3], t)

        return Dirichlet(x_boundary, data, degree)

    def fluid(name: str, X: tuple[float, float], X_I: float) -> FluidLayer:
        return FluidLayer(
            name,
            gas,
            X,
            initial=lambda X: exact.fluid(X, 0.0),
            forcing=lambda X, t: fluid_forcing(exact, gas, X, t, X_I),
            exact=exact.fluid,
        )

    middle = SolidLayer(
        "solid",
        solid,
        (1.0, 2.0),
        initial=lambda X: exact.solid(X, 0.0),
        forcing=lambda X, t: solid_forcing(exact, solid, X, t),
        exact=exact.solid,
    )
    return Problem(
        layers=(fluid("left", (LEFT, 1.0), 1.0), middle, fluid("right", (2.0, RIGHT), 2.0)),
        left=boundary(LEFT, 1.0),
        right=boundary(RIGHT, 2.0),
        jumps=lambda k, t: jumps(exact, gas, solid, (1.0, 2.0)[k], t),
    )
