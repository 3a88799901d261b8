"""A manufactured solution for materials that are not the built-in pair, and a column of them at rest under gravity.

gas | solid | gas: a gas with Sutherland's viscosity and conductivity, a solid with pressure, a gas with powers of T for
viscosity and conductivity; a body force acts on all. The solution is that of the case mms with more heat in the gas. The
forcing is the equations (3.1), (3.2) themselves, with laws written as the literature has them: p of rho and epsilon.
Derivatives of what no formula is wanted for are imaginary parts at a point beside the real axis: exact but for round-off.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from fsipetsc.boundaries import Dirichlet, Wall
from fsipetsc.options import Option
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.mie_gruneisen import mie_gruneisen
from fsipetsc.physics.power_law import power_law
from fsipetsc.physics.solid import Solid
from fsipetsc.physics.stiffened_gas import stiffened_gas
from fsipetsc.physics.sutherland import sutherland
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "materials"
SUMMARY = "manufactured solution with other materials"
OPTIONS = (
    Option("materials_solid", str, "mie", "", "pressure of the solid", choices=("mie", "stiffened")),
    Option("materials_state", str, "mms", "", "manufactured, or a column at rest", choices=("mms", "column")),
)
DEFAULTS = {"fsi_h": 0.025, "ts_max_time": 0.45, "fsi_output_dt": 1.0}

EPS, OMEGA, PHI, FORCE = 0.2, 2.0, 0.47, -1.5
MU, KAPPA, GAMMA, R = 0.015, 0.045, 1.4, 1.0
K, KAPPA_E, M0, ALPHA, T_0 = 10.0, 0.03, 2.0, 1.0, 3.0
#: temperature of the column
REST = 5.0
LEFT, RIGHT, FACES = 0.25, 4.0, (1.0, 2.0)

# the laws as the literature has them


def by_sutherland(T):
    """(mu, kappa)."""
    return MU * (T / 10) ** 1.5 * (10 + 4) / (T + 4), KAPPA * (T / 10) ** 1.5 * (10 + 7) / (T + 7)


def by_power(T):
    """(mu, kappa)."""
    return MU * (T / 10) ** 0.7, KAPPA * (T / 10) ** 0.9


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


SOLIDS = {
    "mie": (of_mie, mie_gruneisen(2.0, 1.3, 1.5, T_0)),
    "stiffened": (of_stiffened, stiffened_gas(1.5, 4.0, T_0, 1.0)),
}
GASES = (by_sutherland, sutherland(10.0, 4.0, 7.0)), (by_power, power_law(10.0, 0.7, 0.9))

# the exact solution, of complex X and t, too


def derivative(f: Callable[[Any], np.ndarray], x: Any) -> np.ndarray:
    """f'(x) of a function that is real on the real axis."""
    return np.imag(f(x + 1e-30j)) / 1e-30


def gas(X, t):
    """rho, u, T, and u_X, T_X."""
    rho, u = 1 + 0.5 * np.cos(t) * np.sin(OMEGA * X), np.sin(t) * np.cos(OMEGA * X + PHI)
    T = 10 + 3 * np.sin(3 * t) * np.cos(2 * X)
    return rho, u, T, -OMEGA * np.sin(t) * np.sin(OMEGA * X + PHI), -6 * np.sin(3 * t) * np.sin(2 * X)


def solid(X, t):
    """u, sigma, T, x, and u_X, T_X, x_X."""
    g, g_X = 1 + X + EPS * np.sin(2 * np.pi * X), 1 + 2 * np.pi * EPS * np.cos(2 * np.pi * X)
    sigma, T = np.sin(t * t) * np.sin(OMEGA * X), 5 + np.cos(t) * np.sin(3 * X)
    return t * g, sigma, T, X + 0.5 * t * t * g, t * g_X, 3 * np.cos(t) * np.cos(3 * X), 1 + 0.5 * t * t * g_X


def stress_and_heat(X, t, transport):
    """p - mu' u_X and kappa T_X of the gas."""
    rho, _, T, u_X, T_X = gas(X, t)
    mu, kappa = transport(T)
    return R * rho * T - 4 / 3 * mu * u_X, kappa * T_X


def net_and_heat(X, t, p):
    """sigma - p and the heat flux of the solid."""
    _, sigma, T, _, _, T_X, x_X = solid(X, t)
    return sigma - p(M0 / x_X, ALPHA * T), KAPPA_E / x_X * T_X


def gas_forcing(X, t, s, transport):
    """What (3.2) leaves over in a frame of velocity s."""

    def conserved(t):
        rho, u, T, *_ = gas(X, t)
        return np.array([rho, rho * u, rho * (R / (GAMMA - 1) * T + u * u / 2)])

    def flux(X):
        rho, u, T, *_ = gas(X, t)
        stress, heat = stress_and_heat(X, t, transport)
        e = rho * (R / (GAMMA - 1) * T + u * u / 2)
        return np.array([rho * (u - s), rho * u * (u - s) + stress, e * (u - s) + u * stress - heat])

    rho, u, *_ = gas(X, t)
    return derivative(conserved, t) + derivative(flux, X) - FORCE * np.array([0 * rho, rho, rho * u])


def solid_forcing(X, t, p):
    """What (3.1) leaves over."""
    u_t, sigma_t, T_t, x_t = derivative(lambda t: np.array(solid(X, t)[:4]), t)
    net_X, heat_X = derivative(lambda X: np.array(net_and_heat(X, t, p)), X)
    u, _, _, _, u_X, _, x_X = solid(X, t)
    heating = (net_and_heat(X, t, p)[0] * u_X + heat_X) / (ALPHA * M0)
    return u_t - net_X / M0 - FORCE, sigma_t - K / x_X * u_X, T_t - heating, x_t - u


def manufactured(pressure: str) -> Problem:
    """The layers where those of mms are."""
    p, pressing = SOLIDS[pressure]

    def jumps(k: int, t: float) -> tuple[float, ...]:
        X = FACES[k]
        (_, uf, Tf, *_), (us, _, Ts, *_) = gas(X, t), solid(X, t)
        (stress, heat), (net, heat_s) = stress_and_heat(X, t, GASES[k][0]), net_and_heat(X, t, p)
        return us - uf, net + stress, Ts - Tf, heat_s - heat

    def of_gas(k: int, name: str, X: tuple[float, float]) -> FluidLayer:
        transport, law = GASES[k]
        return FluidLayer(
            name,
            Fluid(MU, KAPPA, GAMMA, R, transport=law, force=FORCE),
            X,
            initial=lambda X: gas(X, 0.0)[:3],
            forcing=lambda X, t: gas_forcing(X, t, gas(FACES[k], t)[1], transport),
            exact=lambda X, t: gas(X, t)[:3],
        )

    def end(x: float, X: float) -> Dirichlet:
        return Dirichlet(x, lambda t: gas(X + x - solid(X, t)[3], t)[:3])

    middle = SolidLayer(
        "solid",
        Solid(K, KAPPA_E, M0, ALPHA, FORCE, pressing=pressing),
        FACES,
        initial=lambda X: solid(X, 0.0)[:4],
        forcing=lambda X, t: solid_forcing(X, t, p),
        exact=lambda X, t: solid(X, t)[:4],
    )
    layers = of_gas(0, "left", (LEFT, FACES[0])), middle, of_gas(1, "right", (FACES[1], RIGHT))
    return Problem(layers, end(LEFT, FACES[0]), end(RIGHT, FACES[1]), jumps, units="none")


def column(pressure: str) -> Problem:
    """The same materials at rest between two walls at one temperature: the gas below carries the solid and the gas above."""
    p_below, scale = 12.0, FORCE / (R * REST)  # p at the lower face; gas: p_X / p
    p_above = p_below + M0 * FORCE * (FACES[1] - FACES[0])
    solid_p = SOLIDS[pressure][0](M0, ALPHA * REST)

    def at_rest(k: int, name: str, X: tuple[float, float]) -> FluidLayer:
        material, p = Fluid(MU, KAPPA, GAMMA, R, transport=GASES[k][1], force=FORCE), (p_below, p_above)[k]

        def exact(X: np.ndarray, t: float) -> tuple[Any, ...]:
            return p / (R * REST) * np.exp(scale * (X - FACES[k])), 0.0 * X, REST + 0.0 * X

        return FluidLayer(name, material, X, initial=lambda X: exact(X, 0.0), exact=exact)

    def under_its_weight(X: np.ndarray, t: float) -> tuple[Any, ...]:
        return 0.0 * X, solid_p - p_below - M0 * FORCE * (X - FACES[0]), REST + 0.0 * X, X

    material = Solid(K, KAPPA_E, M0, ALPHA, FORCE, pressing=SOLIDS[pressure][1])
    block = SolidLayer("solid", material, FACES, initial=lambda X: under_its_weight(X, 0.0), exact=under_its_weight)
    layers = at_rest(0, "left", (0.0, FACES[0])), block, at_rest(1, "right", (FACES[1], 3.0))
    return Problem(layers, Wall(0.0), Wall(3.0), units="none")


def build(opt: Mapping[str, Any]) -> Problem:
    return (manufactured if opt["materials_state"] == "mms" else column)(opt["materials_solid"])
