"""The pressure of a stiffened gas, p = (gamma-1) rho (epsilon - q) - gamma p_inf, epsilon = alpha T, rho = m0 / x_X.

A liquid, or a solid far beyond its strength (F. H. Harlow and A. A. Amsden, Fluid Dynamics, LA-4700, 1971). The energy q is
told by the state T_0, p_0 of the reference configuration, x_X = 1:

    p = ((gamma-1) m0 alpha (T - T_0) + p_0 + gamma p_inf) / x_X - gamma p_inf,
    q = alpha T_0 - (p_0 + gamma p_inf)/((gamma-1) m0)

Without K and sigma sound has the speed c^2 = gamma (p + p_inf)/rho. The letters are those of fsipetsc.physics.gruneisen.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.checks import ANY, NONNEGATIVE, POSITIVE, number
from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.physics.material_law import Law


@njit(**FORMULA)
def constants(record):
    """((gamma-1) m0 alpha, gamma p_inf, T_0, p_0, gamma-1)."""
    numbers = record.pressing_numbers
    gamma, p_inf, T_0, p_0 = numbers[0], numbers[1], numbers[2], numbers[3]
    return (gamma - 1.0) * record.m0 * record.alpha, gamma * p_inf, T_0, p_0, gamma - 1.0


@njit(**FORMULA)
def pressure(c, T, x_X):
    """p [Pa]."""
    return (c[0] * (T - c[2]) + c[3] + c[1] * (1.0 - x_X)) / x_X


@njit(**FORMULA)
def pressure_in_loops(c, T, stretch):
    """The same but for round-off, without a division."""
    return (c[0] * (T - c[2]) + c[3]) * stretch + c[1] * (stretch - 1.0)


@njit(**FORMULA)
def pressure_by_temperature(c, T, x_X):
    """dp/dT at constant x_X."""
    return c[0] / x_X


@njit(**FORMULA)
def stiffness(c, T, x_X):
    """-x_X dp/dx_X at constant T."""
    return (c[0] * (T - c[2]) + c[3] + c[1]) / x_X


@njit(**FORMULA)
def wave_modulus(c, K, heat, T, p, sigma, x_X):
    """m0 times the squared speed of elastic waves in Lagrangian coordinates [Pa]; p is that of T and x_X."""
    return (K + p + c[1] + c[4] * (p - sigma)) / x_X


_formulas = Formulas(
    constants=constants,
    pressure=pressure,
    pressure_in_loops=pressure_in_loops,
    pressure_by_temperature=pressure_by_temperature,
    stiffness=stiffness,
    wave_modulus=wave_modulus,
)


def stiffened_gas(gamma: float, p_inf: float, T_0: float, p_0: float = 0.0) -> Law:
    """The law for the pressing of a Solid: gamma above 1; p_inf [Pa] not below 0; p = p_0 [Pa] at T_0 [K] where x_X = 1.

    InputError for what is no number or out of range.
    """
    ranges = {"gamma": (gamma, "above 1"), "p_inf": (p_inf, NONNEGATIVE), "T_0": (T_0, POSITIVE), "p_0": (p_0, ANY)}
    return Law(_formulas, tuple(number(value, f"stiffened_gas: {name}", at) for name, (value, at) in ranges.items()))
