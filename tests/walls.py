"""Manufactured solutions between walls that move and give off heat, and driven ends of solids.

`left`: a gas between a moving wall with a heat flux(t) and a solid that ends free under a
stress(t) and T(t). `right`: a solid clamped at an end that moves and has a heat flux(t), and a gas
up to a moving wall of T(t). Solids move as that of the case mms, with sigma = K ln x_X, have
Grüneisen's pressure, and the gas's temperature at X. X of a gas, stretched between its ends, stands
for x with x_X = J. The forcing is made of derivatives by a step along the imaginary
axis.
"""

import numpy as np

from fsipetsc.boundaries import Wall, clamped, free
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import Solid
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

OPTIONS = (Option("walls_state", str, "left", "", "side of the gas", ("left", "right")),)
DEFAULTS = {"fsi_h": 0.025, "ts_max_time": 0.45, "fsi_output_dt": 1.0, "fsi_cfl": 1.0}

AIR, ROCK = Fluid(0.015, 0.045, 1.4, 1.0), Solid(10.0, 0.03, 2.0, 1.0, gruneisen=0.3)


def derivative(f, x):
    """f'(x) of a function that is real on the real axis."""
    return np.imag(f(x + 1e-30j)) / 1e-30


# of the solid


def solid(X, t):
    """u, sigma, T, x of a solid, and u_X, T_X, x_X."""
    g, g_X = 1 + X + 0.2 * np.sin(2 * np.pi * X), 1 + 0.4 * np.pi * np.cos(2 * np.pi * X)
    x_X = 1 + 0.5 * t * t * g_X
    T, T_X = 10 + 3 * np.sin(3 * t) * np.cos(2 * X), -6 * np.sin(3 * t) * np.sin(2 * X)
    return t * g, ROCK.K * np.log(x_X), T, X + 0.5 * t * t * g, t * g_X, T_X, x_X


def net_and_heat(X, t):
    """sigma - p and the heat flux."""
    _, sigma, T, _, _, T_X, x_X = solid(X, t)
    return sigma - ROCK.gruneisen * ROCK.m0 / x_X * ROCK.alpha * T, ROCK.kappa_e / x_X * T_X


def force_solid(X, t):
    """What the equations leave over."""
    u_t, sigma_t, T_t, x_t = derivative(lambda t: np.array(solid(X, t)[:4]), t)
    net_X, heat_X = derivative(lambda X: np.array(net_and_heat(X, t)), X)
    u, _, _, _, u_X, _, x_X = solid(X, t)
    heating = (net_and_heat(X, t)[0] * u_X + heat_X) / (ROCK.alpha * ROCK.m0)
    return u_t - net_X / ROCK.m0, sigma_t - ROCK.K / x_X * u_X, T_t - heating, x_t - u


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

    def __init__(self, X, *ends):
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
        u_X = w_X + 0.5 * np.pi * np.sin(t) * np.cos(np.pi * X)
        T_X = -6 * np.sin(3 * t) * np.sin(2 * X)
        return AIR.R * rho * T - 4 / 3 * AIR.mu * u_X / J, AIR.kappa * T_X / J

    def conserved(self, X, t):
        rho, u, T = self.fields(X, t)
        return np.array([rho, rho * u, rho * (AIR.cv * T + u * u / 2)])

    def flux(self, X, t):
        (_, w, _), q = self.grid(X, t), self.conserved(X, t)
        (stress, heat), u = self.stress_and_heat(X, t), q[1] / q[0]
        return q * (u - w) + np.array([0 * u, stress, u * stress - heat])

    def forcing(self, X, t):
        """What the equations leave over."""
        rates = derivative(lambda t: self.grid(X, t)[0] * self.conserved(X, t), t)
        return (rates + derivative(lambda X: self.flux(X, t), X)) / self.grid(X, t)[0]


def build(opt):
    left = opt["walls_state"] == "left"
    gas = Gas(0.0, left_wall, interface) if left else Gas(1.0, interface, right_wall)
    X, motion = (1.0, left_wall) if left else (0.0, right_wall)  # of the solid; of the wall
    ends = gas.X, gas.X + 1
    of_gas = FluidLayer("gas", AIR, ends, lambda X: gas.fields(X, 0.0), gas.forcing, gas.fields)
    of_solid = SolidLayer(
        *("solid", ROCK, (X, X + 1), lambda X: solid(X, 0.0)[:4]),
        forcing=force_solid,
        exact=lambda X, t: solid(X, t)[:4],
    )
    heat = {"T": lambda t: gas.fields(2.0, t)[2]}
    if left:
        heat = {"heat_flux": lambda t: -gas.stress_and_heat(0.0, t)[1]}
    wall = Wall(lambda t: motion(t)[0], velocity=lambda t: motion(t)[1], **heat)
    loaded = free(lambda t: net_and_heat(2.0, t)[0], T=lambda t: solid(2.0, t)[2])
    driven = clamped(lambda t: solid(0.0, t)[0], heat_flux=lambda t: -net_and_heat(0.0, t)[1])

    def jumps(k, t):
        """Velocity and temperature have none."""
        (stress, heat), (net, heat_s) = gas.stress_and_heat(1.0, t), net_and_heat(1.0, t)
        return 0.0, net + stress, 0.0, heat_s - heat

    if left:
        return Problem((of_gas, of_solid), wall, loaded, jumps, units="none")
    return Problem((of_solid, of_gas), driven, wall, jumps, units="none")
