"""The pressure of a solid p = G rho epsilon with epsilon = alpha T, rho = m0 / x_X; G = 0 is the purely elastic solid.

A law of pressure is formulas of numbers or of vectors of points; c is what ``constants`` has read of a layer or an
interface. T: temperature [K], x_X: strain, stretch: 1/x_X, K: elastic modulus [Pa], heat: alpha m0 [J/(m3 K)].
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA


@njit(**FORMULA)
def constants(record):
    """(G m0 alpha, G) of a layer or an interface."""
    return record.gruneisen * record.m0 * record.alpha, record.gruneisen


@njit(**FORMULA)
def pressure(c, T, x_X):
    """p [Pa]."""
    return c[0] * T / x_X


@njit(**FORMULA)
def pressure_in_loops(c, T, stretch):
    """The same but for round-off, without a division."""
    return c[0] * T * stretch


@njit(**FORMULA)
def pressure_by_temperature(c, T, x_X):
    """dp/dT at constant x_X."""
    return c[0] / x_X


@njit(**FORMULA)
def stiffness(c, T, x_X):
    """-x_X dp/dx_X at constant T."""
    return c[0] * T / x_X


@njit(**FORMULA)
def wave_modulus(c, K, heat, T, p, sigma, x_X):
    """m0 times the squared speed of elastic waves in Lagrangian coordinates [Pa]; p is that of T and x_X.

    It is what (3.1b-d) make of (sigma - p)_t over u_X: (K - x_X p_x + x_X p_T (p - sigma) / heat) / x_X, with p_x and p_T the
    derivatives by x_X and T; in the letters after (3.9), where x_X = 1, K + (p - sigma) p_eps / rho + rho p_rho.
    """
    return (K + p + c[1] * (p - sigma)) / x_X


gruneisen = Formulas(
    constants=constants,
    pressure=pressure,
    pressure_in_loops=pressure_in_loops,
    pressure_by_temperature=pressure_by_temperature,
    stiffness=stiffness,
    wave_modulus=wave_modulus,
)
