"""The pressure of Mie and Grüneisen about the Hugoniot u_s = c_0 + s u_p of shocks of speed u_s into the solid at rest.

With the compression eta = 1 - m0/rho = 1 - x_X, the pressure and the energy behind a shock into the solid at T_0, p = 0 are

    p_H = m0 c_0^2 eta / (1 - s eta)^2,        epsilon_H = alpha T_0 + p_H eta / (2 m0),

and with G rho = G_0 m0 (G_0: that of the reference configuration)

    p = p_H + G rho (epsilon - epsilon_H) = p_H (1 - G_0 eta / 2) + G_0 m0 alpha (T - T_0),        epsilon = alpha T.

M. A. Meyers, Dynamic Behavior of Materials (1994), chapters 4 and 5, where c_0, s and G_0 of many solids are. It is meant for
-1/s < eta < 1/s: a shock cannot compress further, and pulled further apart the solid would have no speed of sound. At
rest, x_X = 1, without K, sound has the speed c_0. The letters are those of fsipetsc.physics.gruneisen.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.checks import NONNEGATIVE, POSITIVE, number
from fsipetsc.errors import InputError
from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.physics.material_law import Law


@njit(**FORMULA)
def constants(record):
    """(G_0 m0 alpha, T_0, m0 c_0^2, s, G_0)."""
    numbers = record.pressing_numbers
    c_0, s, G_0, T_0 = numbers[0], numbers[1], numbers[2], numbers[3]
    return G_0 * record.m0 * record.alpha, T_0, record.m0 * c_0 * c_0, s, G_0


@njit(**FORMULA)
def pressure(c, T, x_X):
    """p [Pa]."""
    eta = 1.0 - x_X
    room = 1.0 - c[3] * eta
    return c[2] * eta / (room * room) * (1.0 - 0.5 * c[4] * eta) + c[0] * (T - c[1])


@njit(**FORMULA)
def pressure_in_loops(c, T, stretch):
    """The same but for round-off, with one division."""
    squeezed = stretch - 1.0
    room = stretch - c[3] * squeezed
    return c[2] * squeezed * (stretch - 0.5 * c[4] * squeezed) / (room * room) + c[0] * (T - c[1])


@njit(**FORMULA)
def pressure_by_temperature(c, T, x_X):
    """dp/dT at constant x_X."""
    return c[0]


@njit(**FORMULA)
def stiffness(c, T, x_X):
    """-x_X dp/dx_X at constant T: x_X (p_H' (1 - G_0 eta/2) - p_H G_0/2), p_H' = m0 c_0^2 (1 + s eta)/(1 - s eta)^3."""
    eta = 1.0 - x_X
    room = 1.0 - c[3] * eta
    slope = (1.0 + c[3] * eta) / room * (1.0 - 0.5 * c[4] * eta) - 0.5 * c[4] * eta
    return x_X * c[2] * slope / (room * room)


@njit(**FORMULA)
def wave_modulus(c, K, heat, T, p, sigma, x_X):
    """m0 times the squared speed of elastic waves in Lagrangian coordinates [Pa]; p is that of T and x_X."""
    return (K + stiffness(c, T, x_X)) / x_X + c[4] * (p - sigma)


_formulas = Formulas(
    constants=constants,
    pressure=pressure,
    pressure_in_loops=pressure_in_loops,
    pressure_by_temperature=pressure_by_temperature,
    stiffness=stiffness,
    wave_modulus=wave_modulus,
)


def mie_gruneisen(c_0: float, s: float, G_0: float, T_0: float) -> Law:
    """The law for the pressing of a Solid: c_0 [m/s], s and G_0 [-] not below 0, T_0 [K].

    G_0 is at most 4 s, so that sound in the compressed solid is faster. InputError for what is no number or out of range.
    """
    ranges = {"c_0": (c_0, POSITIVE), "s": (s, NONNEGATIVE), "G_0": (G_0, NONNEGATIVE), "T_0": (T_0, POSITIVE)}
    numbers = tuple(number(value, f"mie_gruneisen: {name}", at) for name, (value, at) in ranges.items())
    if numbers[2] > 4 * numbers[1]:
        raise InputError(f"mie_gruneisen: G_0 is {numbers[2]:g}, s is {numbers[1]:g}: expected G_0 of at most 4 s")
    return Law(_formulas, numbers)
