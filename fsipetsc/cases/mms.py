"""Manufactured solution (Sec. 5.1): fluid | solid | fluid with forcing in the layers and at the interfaces.

The fields (5.1), (5.2) are given in the coordinate X of each layer's own grid; x is given in the solid alone. So the
forcing of a fluid contains the exact velocity s of its frame, the fluid's at its interface point, and the embedded
boundaries lie at X = X_I + x_boundary - x(X_I, t). Density, velocity and temperature at the boundaries are exact
data; the four interface conditions get the jumps of the exact solution.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
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


@dataclass(frozen=True)
class Exact:
    """The exact solution and its derivatives; eps, omega, phi as in (5.1), (5.2)."""

    eps: float
    omega: float
    phi: float

    def shape(self, X: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """1 + X + eps sin(2 pi X) and its first two derivatives: displacement and velocity are multiples of it."""
        a = 2 * np.pi
        return (
            1 + X + self.eps * np.sin(a * X),
            1 + self.eps * a * np.cos(a * X),
            -self.eps * a * a * np.sin(a * X),
        )

    def fluid(self, X: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(rho, u, T) of (5.1)."""
        w = self.omega
        return (
            1 + 0.5 * np.sin(w * X) * np.cos(t),
            np.sin(t) * np.cos(w * X + self.phi),
            10 + np.sin(3 * t) * np.cos(2 * X),
        )

    def fluid_slopes(self, X: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        """rho_X, u_X, T_X, u_XX, T_XX."""
        w = self.omega
        u = np.sin(t) * np.cos(w * X + self.phi)
        T1 = np.sin(3 * t) * np.cos(2 * X)
        return (
            0.5 * w * np.cos(w * X) * np.cos(t),
            -w * np.sin(t) * np.sin(w * X + self.phi),
            -2 * np.sin(3 * t) * np.sin(2 * X),
            -w * w * u,
            -4 * T1,
        )

    def fluid_rates(self, X: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        """rho_t, u_t, T_t at fixed X."""
        w = self.omega
        return (
            -0.5 * np.sin(w * X) * np.sin(t),
            np.cos(t) * np.cos(w * X + self.phi),
            3 * np.cos(3 * t) * np.cos(2 * X),
        )

    def solid(self, X: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        """(u, sigma, T, x) of (5.2)."""
        g = self.shape(X)[0]
        return t * g, np.sin(t * t) * np.sin(self.omega * X), 5 + np.cos(t) * np.sin(3 * X), X + 0.5 * t * t * g

    def solid_slopes(self, X: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        """u_X, sigma_X, T_X, x_X, T_XX, x_XX."""
        _, g1, g2 = self.shape(X)
        w = self.omega
        return (
            t * g1,
            w * np.sin(t * t) * np.cos(w * X),
            3 * np.cos(t) * np.cos(3 * X),
            1 + 0.5 * t * t * g1,
            -9 * np.cos(t) * np.sin(3 * X),
            0.5 * t * t * g2,
        )

    def solid_rates(self, X: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        """u_t, sigma_t, T_t."""
        return (
            self.shape(X)[0],
            2 * t * np.cos(t * t) * np.sin(self.omega * X),
            -np.sin(t) * np.sin(3 * X),
        )


def fluid_forcing(exact: Exact, gas: Fluid, X: np.ndarray, t: float, X_I: float) -> tuple[np.ndarray, ...]:
    """What the exact solution leaves over in (4.20), in a frame that moves with the fluid at X_I."""
    mu, cv = 4 / 3 * gas.mu, gas.cv
    s = exact.fluid(X_I, t)[1]
    rho, u, T = exact.fluid(X, t)
    r1, u1, T1, u2, T2 = exact.fluid_slopes(X, t)
    r_t, u_t, T_t = exact.fluid_rates(X, t)
    p, p1 = gas.R * rho * T, gas.R * (r1 * T + rho * T1)
    E = cv * T + 0.5 * u * u
    E1, E_t = cv * T1 + u * u1, cv * T_t + u * u_t
    m1, e1 = r1 * u + rho * u1, r1 * E + rho * E1
    return (
        r_t + r1 * (u - s) + rho * u1,
        r_t * u + rho * u_t + m1 * (u - s) + rho * u * u1 + p1 - mu * u2,
        r_t * E + rho * E_t + e1 * (u - s) + rho * E * u1 + u1 * p + u * p1 - mu * (u1 * u1 + u * u2) - gas.kappa * T2,
    )


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
