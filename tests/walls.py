"""Manufactured solutions between walls that move, of given temperature or heat flux, and ends of
solids that are driven.

`gas`: a gas alone between a moving wall of given temperature T(t) and one with a heat flux(t).
`solid`: one alone between clamped(velocity(t), T(t)) and free(stress(t), flux(t)). `left` and
`right`: gas | solid and solid | gas with other pairs of these. Solids move as that of the case mms,
with sigma = K ln x_X, have Grüneisen's pressure, and the gas's temperature at X. X of a gas,
stretched between its ends, stands for x with x_X = J. The forcing is made as that of materials.py.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from materials import derivative

from fsipetsc.boundaries import Boundary, Wall, clamped, free
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "walls"
SUMMARY = "manufactured solutions between walls that move and driven ends"
OPTIONS = (
    Option(
        "walls_state", str, "gas", "", "which layers", choices=("gas", "solid", "left", "right")
    ),
)
DEFAULTS = {"fsi_h": 0.025, "ts_max_time": 0.45, "fsi_output_dt": 1.0, "fsi_cfl": 1.0}

AIR, ROCK = Fluid(0.015, 0.045, 1.4, 1.0), Solid(10.0, 0.03, 2.0, 1.0, gruneisen=0.3)


def solid(X, t):
    """u, sigma, T, x of a solid, and u_X, T_X, x_X."""
    g, g_X = 1 + X + 0.2 * np.sin(2 * np.pi * X), 1 + 0.4 * np.pi * np.cos(2 * np.pi * X)
    x_X = 1 + 0.5 * t * t * g_X
    T, T_X = 10 + 3 * np.sin(3 * t) * np.cos(2 * X), -6 * np.sin(3 * t) * np.sin(2 * X)
    return t * g, ROCK.K * np.log(x_X), T, X + 0.5 * t * t * g, t * g_X, T_X, x_X


# place and velocity of what stands at the ends of a gas


def left_wall(t):
    return 0.2 * np.sin(1.5 * t), 0.3 * np.cos(1.5 * t)


def right_wall(t):
    return 2 - 0.3 * t * t * np.cos(t), 0.3 * t * t * np.sin(t) - 0.6 * t * np.cos(t)


def interface(t):
    u, _, _, x, *_ = solid(1.0, t)
    return x, u


class Gas:
    """The exact solution of a gas between X and X + 1."""

    def __init__(self, X: float, *ends: Callable[[Any], tuple[Any, Any]]) -> None:
        self.X, self.ends = X, ends

    def grid(self, X, t):
        """(J, w, w_X)."""
        (x_0, v_0), (x_1, v_1) = (end(t) for end in self.ends)
        return x_1 - x_0, v_0 + (v_1 - v_0) * (X - self.X), v_1 - v_0

    def fields(self, X, t):
        """rho, u, T; at the ends u is the grid's."""
        u = self.grid(X, t)[1] + 0.5 * np.sin(t) * np.sin(np.pi * X)
        return 1 + 0.5 * np.cos(t) * np.sin(2 * X), u, 10 + 3 * np.sin(3 * t) * np.cos(2 * X)

    def stress_and_heat(self, X, t):
        """p - mu' u_x and kappa T_x."""
        (rho, _, T), (J, _, w_X) = self.fields(X, t), self.grid(X, t)
        u_X, T_X = (
            w_X + 0.5 * np.pi * np.sin(t) * np.cos(np.pi * X),
            -6 * np.sin(3 * t) * np.sin(2 * X),
        )
        return AIR.R * rho * T - 4 / 3 * AIR.mu * u_X / J, AIR.kappa * T_X / J

    def conserved(self, X, t):
        rho, u, T = self.fields(X, t)
        return np.array([rho, rho * u, rho * (AIR.cv * T + u * u / 2)])

    def flux(self, X, t):
        (_, w, _), (stress, heat), q = (
            self.grid(X, t),
            self.stress_and_heat(X, t),
            self.conserved(X, t),
        )
        u = q[1] / q[0]
        return q * (u - w) + np.array([0 * u, stress, u * stress - heat])

    def forcing(self, X, t):
        """What the equations leave over."""
        rates = derivative(lambda t: self.grid(X, t)[0] * self.conserved(X, t), t) + derivative(
            lambda X: self.flux(X, t), X
        )
        return rates / self.grid(X, t)[0]

    def layer(self) -> FluidLayer:
        return FluidLayer(
            *("gas", AIR, (self.X, self.X + 1), lambda X: self.fields(X, 0.0)),
            forcing=self.forcing,
            exact=self.fields,
        )

    def temperature(self, X: float) -> Callable[[float], float]:
        return lambda t: self.fields(X, t)[2]

    def heat_flux(self, X: float) -> Callable[[float], float]:
        """Into the gas, at its left end self.X or the right one."""
        return lambda t: (1 if X > self.X else -1) * self.stress_and_heat(X, t)[1]


class Rock:
    """The exact solution of a solid, that of materials.py, between X and X + 1."""

    def __init__(self, X: float) -> None:
        self.X = X

    def net_and_heat(self, X, t):
        """sigma - p and the heat flux."""
        _, sigma, T, _, _, T_X, x_X = solid(X, t)
        return sigma - ROCK.gruneisen * ROCK.m0 / x_X * ROCK.alpha * T, ROCK.kappa_e / x_X * T_X

    def forcing(self, X, t):
        """What the equations leave over."""
        u_t, sigma_t, T_t, x_t = derivative(lambda t: np.array(solid(X, t)[:4]), t)
        net_X, heat_X = derivative(lambda X: np.array(self.net_and_heat(X, t)), X)
        u, _, _, _, u_X, _, x_X = solid(X, t)
        heating = (self.net_and_heat(X, t)[0] * u_X + heat_X) / (ROCK.alpha * ROCK.m0)
        return u_t - net_X / ROCK.m0, sigma_t - ROCK.K / x_X * u_X, T_t - heating, x_t - u

    def layer(self) -> SolidLayer:
        return SolidLayer(
            *("solid", ROCK, (self.X, self.X + 1), lambda X: solid(X, 0.0)[:4]),
            forcing=self.forcing,
            exact=lambda X, t: solid(X, t)[:4],
        )

    def velocity(self, X: float) -> Callable[[float], float]:
        return lambda t: solid(X, t)[0]

    def stress(self, X: float) -> Callable[[float], float]:
        return lambda t: self.net_and_heat(X, t)[0]

    def temperature(self, X: float) -> Callable[[float], float]:
        return lambda t: solid(X, t)[2]

    def heat_flux(self, X: float) -> Callable[[float], float]:
        """Into the solid, at its left end self.X or the right one."""
        return lambda t: (1 if X > self.X else -1) * self.net_and_heat(X, t)[1]


def wall(motion: Callable[[Any], tuple[Any, Any]], **heat: Any) -> Wall:
    return Wall(lambda t: motion(t)[0], velocity=lambda t: motion(t)[1], **heat)


def jumps(gas: Gas, rock: Rock) -> Callable[[int, float], tuple[float, ...]]:
    """Velocity and temperature have none."""

    def at(k: int, t: float) -> tuple[float, ...]:
        (stress, heat), (net, heat_s) = gas.stress_and_heat(1.0, t), rock.net_and_heat(1.0, t)
        return 0.0, net + stress, 0.0, heat_s - heat

    return at


def alone(layer: FluidLayer | SolidLayer, left: Boundary, right: Boundary) -> Problem:
    return Problem((layer,), left, right, units="none")


def build(opt: Mapping[str, Any]) -> Problem:
    state = opt["walls_state"]
    if state == "gas":
        gas = Gas(0.0, left_wall, right_wall)
        return alone(
            gas.layer(),
            wall(left_wall, T=gas.temperature(0.0)),
            wall(right_wall, heat_flux=gas.heat_flux(1.0)),
        )
    if state == "solid":
        rock = Rock(0.0)
        held = clamped(rock.velocity(0.0), T=rock.temperature(0.0))
        return alone(rock.layer(), held, free(rock.stress(1.0), heat_flux=rock.heat_flux(1.0)))
    if state == "left":
        gas, rock = Gas(0.0, left_wall, interface), Rock(1.0)
        layers, left = (gas.layer(), rock.layer()), wall(left_wall, heat_flux=gas.heat_flux(0.0))
        right = free(rock.stress(2.0), T=rock.temperature(2.0))
    else:
        gas, rock = Gas(1.0, interface, right_wall), Rock(0.0)
        layers, right = (rock.layer(), gas.layer()), wall(right_wall, T=gas.temperature(2.0))
        left = clamped(rock.velocity(0.0), heat_flux=rock.heat_flux(0.0))
    return Problem(layers, left, right, jumps(gas, rock), units="none")
