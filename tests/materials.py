"""A manufactured solution for materials that are not the built-in pair; a column of them under gravity, held and in free fall.

gas | solid | gas | solid | gas: Sutherland's law, the pressure of Mie and Grüneisen, Sutherland's law with other numbers, that
of a stiffened gas, powers of T, written by hand as a user would; a body force acts on all. The solids move as that
of the case mms. The outer gases have rigid grids, the inner one is stretched: X stands for x with x_X = J, x_t = w. The forcing
is the equations (3.1), (3.2) themselves, with laws written as the literature has them: p of rho and epsilon. Derivatives of
what no formula is wanted for are imaginary parts at a point beside the real axis: exact but for round-off.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from fsipetsc.boundaries import Dirichlet, Wall
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.own import transport_law
from fsipetsc.materials.power_law import power_law
from fsipetsc.materials.solid_pressure import mie_gruneisen, stiffened_pressure
from fsipetsc.materials.sutherland import sutherland
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "materials"
SUMMARY = "manufactured solution with other materials"
OPTIONS = (
    Option("materials_state", str, "mms", "", "manufactured; a column, held or falling", choices=("mms", "column", "fall")),
)
DEFAULTS = {"fsi_h": 0.025, "ts_max_time": 0.45, "fsi_output_dt": 1.0}

EPS, OMEGA, FORCE = 0.2, 2.0, -1.5
MU, KAPPA, GAMMA, R = 0.015, 0.045, 1.4, 1.0
K, KAPPA_E, M0, ALPHA, T_0 = 10.0, 0.03, 2.0, 1.0, 3.0
#: temperature of the column
REST = 5.0
LEFT, RIGHT, FACES = 0.25, 6.25, (1.0, 2.0, 3.0, 4.0)

# the laws as the literature has them


def by_sutherland(T):
    """(mu, kappa)."""
    return MU * (T / 10) ** 1.5 * (10 + 4) / (T + 4), KAPPA * (T / 10) ** 1.5 * (10 + 7) / (T + 7)


def by_other_numbers(T):
    """(mu, kappa)."""
    return MU * (T / 8) ** 1.5 * (8 + 2) / (T + 2), KAPPA * (T / 8) ** 1.5 * (8 + 2) / (T + 2)


def by_power(T):
    """(mu, kappa)."""
    return MU * (T / 10) ** 0.7, KAPPA * (T / 10) ** 0.9


def mu_by_hand(T):
    """The same as a law of a case file."""
    return (T / 10) ** 0.7


def kappa_by_hand(T):
    """The same as a law of a case file."""
    return (T / 10) ** 0.9


def of_mie(rho, epsilon, c_0=2.0, s=1.3, G=1.5):
    """p about the Hugoniot."""
    eta = 1 - M0 / rho
    p_H = M0 * c_0**2 * eta / (1 - s * eta) ** 2
    epsilon_H = ALPHA * T_0 + p_H * eta / (2 * M0)
    return p_H + G * M0 * (epsilon - epsilon_H)


def of_stiffened(rho, epsilon, gamma=1.5, p_inf=4.0, p_0=1.0):
    """p of a stiffened gas that has p_0 at T_0."""
    q = ALPHA * T_0 - (p_0 + gamma * p_inf) / ((gamma - 1) * M0)
    return (gamma - 1) * rho * (epsilon - q) - gamma * p_inf


#: of the layers from left to right: the law above and the built-in one
LAWS = (
    (by_sutherland, sutherland(10.0, 4.0, 7.0)),
    (of_mie, mie_gruneisen(2.0, 1.3, 1.5, T_0)),
    (by_other_numbers, sutherland(8.0, 2.0)),
    (of_stiffened, stiffened_pressure(1.5, 4.0, T_0, 1.0)),
    (by_power, power_law(10.0, 0.7, 0.9)),
)
OWN = transport_law(mu_by_hand, kappa_by_hand)

# the exact solution, of complex X and t, too


def derivative(f: Callable[[Any], np.ndarray], x: Any) -> np.ndarray:
    """f'(x) of a function that is real on the real axis."""
    return np.imag(f(x + 1e-30j)) / 1e-30


def grid(k, X, t):
    """(J, w, w_X) of the grid of gas k: rigid, stretched, rigid; the ends move as the solids do, with t (1 + X)."""
    if k == 2:
        return 1 + 0.5 * t * t, t * (1 + X), t
    return 1.0, t * (1 + FACES[0 if k == 0 else 3]), 0.0


def gas(k, X, t):
    """rho, u, T of gas k, and u_X, T_X; at the interfaces u is that of the solids."""
    _, w, w_X = grid(k, X, t)
    rho, u = 1 + 0.5 * np.cos(t) * np.sin(OMEGA * X), w + 0.5 * np.sin(t) * np.sin(np.pi * X)
    T = 10 + 3 * np.sin(3 * t) * np.cos(2 * X)
    return rho, u, T, w_X + 0.5 * np.pi * np.sin(t) * np.cos(np.pi * X), -6 * np.sin(3 * t) * np.sin(2 * X)


def solid(X, t):
    """u, sigma, T, x of either solid, and u_X, T_X, x_X."""
    g, g_X = 1 + X + EPS * np.sin(2 * np.pi * X), 1 + 2 * np.pi * EPS * np.cos(2 * np.pi * X)
    sigma, T = np.sin(t * t) * np.sin(OMEGA * X), 5 + np.cos(t) * np.sin(3 * X)
    return t * g, sigma, T, X + 0.5 * t * t * g, t * g_X, 3 * np.cos(t) * np.cos(3 * X), 1 + 0.5 * t * t * g_X


def stress_and_heat(k, X, t):
    """p - mu' u_x and kappa T_x of gas k."""
    rho, _, T, u_X, T_X = gas(k, X, t)
    (mu, kappa), (J, _, _) = LAWS[k][0](T), grid(k, X, t)
    return R * rho * T - 4 / 3 * mu * u_X / J, kappa * T_X / J


def net_and_heat(k, X, t):
    """sigma - p and the heat flux of solid k."""
    _, sigma, T, _, _, T_X, x_X = solid(X, t)
    return sigma - LAWS[k][0](M0 / x_X, ALPHA * T), KAPPA_E / x_X * T_X


def gas_forcing(k, X, t):
    """What (3.2) leaves over on the grid of gas k."""

    def conserved(t):
        rho, u, T, *_ = gas(k, X, t)
        return grid(k, X, t)[0] * np.array([rho, rho * u, rho * (R / (GAMMA - 1) * T + u * u / 2)])

    def flux(X):
        rho, u, T, *_ = gas(k, X, t)
        (stress, heat), (_, w, _) = stress_and_heat(k, X, t), grid(k, X, t)
        e = rho * (R / (GAMMA - 1) * T + u * u / 2)
        return np.array([rho * (u - w), rho * u * (u - w) + stress, e * (u - w) + u * stress - heat])

    rho, u, *_ = gas(k, X, t)
    rates = derivative(conserved, t) + derivative(flux, X)
    return rates / grid(k, X, t)[0] - FORCE * np.array([0 * rho, rho, rho * u])


def solid_forcing(k, X, t):
    """What (3.1) leaves over."""
    u_t, sigma_t, T_t, x_t = derivative(lambda t: np.array(solid(X, t)[:4]), t)
    net_X, heat_X = derivative(lambda X: np.array(net_and_heat(k, X, t)), X)
    u, _, _, _, u_X, _, x_X = solid(X, t)
    heating = (net_and_heat(k, X, t)[0] * u_X + heat_X) / (ALPHA * M0)
    return u_t - net_X / M0 - FORCE, sigma_t - K / x_X * u_X, T_t - heating, x_t - u


def layer(k: int, X: tuple[float, float], exact: Callable[..., Any], **more: Any) -> FluidLayer | SolidLayer:
    """Layer k with its material and an exact solution, with which it starts; the last gas has the law written by hand."""
    if k % 2:
        kind, material = SolidLayer, Solid(K, KAPPA_E, M0, ALPHA, FORCE, pressing=LAWS[k][1])
    else:
        transport = OWN if k == 4 else LAWS[k][1]
        kind, material = FluidLayer, Fluid(MU, KAPPA, GAMMA, R, transport=transport, force=FORCE)
    return kind(f"layer {k}", material, X, initial=lambda X: exact(X, 0.0), exact=exact, **more)


def manufactured() -> Problem:
    """Five layers."""

    def jumps(k: int, t: float) -> tuple[float, ...]:
        at_gas, at_solid, X = k + k % 2, k + 1 - k % 2, FACES[k]
        (_, uf, Tf, *_), (us, _, Ts, *_) = gas(at_gas, X, t), solid(X, t)
        (stress, heat), (net, heat_s) = stress_and_heat(at_gas, X, t), net_and_heat(at_solid, X, t)
        return us - uf, net + stress, Ts - Tf, heat_s - heat

    def end(k: int, x: float, X: float) -> Dirichlet:
        return Dirichlet(x, lambda t: gas(k, X + x - solid(X, t)[3], t)[:3])

    places = list(zip((LEFT, *FACES), (*FACES, RIGHT)))
    layers = [
        layer(k, X, lambda X, t: solid(X, t)[:4], forcing=lambda X, t, k=k: solid_forcing(k, X, t))
        if k % 2
        else layer(k, X, lambda X, t, k=k: gas(k, X, t)[:3], forcing=lambda X, t, k=k: gas_forcing(k, X, t))
        for k, X in enumerate(places)
    ]
    return Problem(tuple(layers), end(0, LEFT, FACES[0]), end(4, RIGHT, FACES[3]), jumps, units="none")


def column() -> Problem:
    """The same materials at rest between two walls at one temperature: each layer carries those above it."""
    layers, p = [], 16.0
    for k in range(5):
        X0, X1 = float(k), float(k + 1)
        if k % 2:

            def exact(X: np.ndarray, t: float, k: int = k, p: float = p, X0: float = X0) -> tuple[Any, ...]:
                stress = LAWS[k][0](M0, ALPHA * REST) - p - M0 * FORCE * (X - X0)
                return 0.0 * X, stress, REST + 0.0 * X, X

            p += M0 * FORCE
        else:

            def exact(X: np.ndarray, t: float, p: float = p, X0: float = X0) -> tuple[Any, ...]:
                return p / (R * REST) * np.exp(FORCE / (R * REST) * (X - X0)), 0.0 * X, REST + 0.0 * X

            p *= np.exp(FORCE / (R * REST))
        layers.append(layer(k, (X0, X1), exact))
    return Problem(tuple(layers), Wall(0.0), Wall(5.0), units="none")


def fall() -> Problem:
    """The same materials under one pressure between two walls: all fall alike, and nothing else changes."""

    def gas_falls(X: np.ndarray, t: float) -> tuple[Any, ...]:
        return 10.0 / (R * REST) + 0.0 * X, FORCE * t + 0.0 * X, REST + 0.0 * X

    def solid_falls(k: int) -> Callable[..., Any]:
        stress = LAWS[k][0](M0, ALPHA * REST) - 10.0
        return lambda X, t: (FORCE * t + 0.0 * X, stress + 0.0 * X, REST + 0.0 * X, X + 0.5 * FORCE * t * t)

    layers = [layer(k, (float(k), float(k + 1)), solid_falls(k) if k % 2 else gas_falls) for k in range(5)]
    walls = [Wall(lambda t, x=x: x + 0.5 * FORCE * t * t, velocity=lambda t: FORCE * t) for x in (0.0, 5.0)]
    return Problem(tuple(layers), *walls, units="none")


def build(opt: Mapping[str, Any]) -> Problem:
    return {"mms": manufactured, "column": column, "fall": fall}[opt["materials_state"]]()
