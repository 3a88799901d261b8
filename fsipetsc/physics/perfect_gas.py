"""The perfect gas: p = rho R T, internal energy cv T per mass, cv = R/(gamma-1).

A gas law is formulas of numbers or of vectors of points; c is what ``constants`` has read of a layer or an interface.
rho: density [kg/m3], T: temperature [K], p: pressure [Pa], e: internal energy per mass [J/kg].
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA


@njit(**FORMULA)
def constants(record):
    """(R, gamma, cv, 1/cv) of a layer or an interface."""
    return record.R, record.gamma, record.cv, 1.0 / record.cv


@njit(**FORMULA)
def temperature(c, rho, e):
    """T(rho, e)."""
    return e / c[2]


@njit(**FORMULA)
def temperature_in_loops(c, rho, e):
    """The same but for round-off, without a division."""
    return e * c[3]


@njit(**FORMULA)
def energy(c, rho, T):
    """e(rho, T)."""
    return c[2] * T


@njit(**FORMULA)
def pressure(c, rho, T):
    """p(rho, T)."""
    return c[0] * rho * T


@njit(**FORMULA)
def pressure_of_energy(c, rho, E):
    """p of rho and the internal energy per volume E = rho e."""
    return (c[1] - 1.0) * E


@njit(**FORMULA)
def density(c, p, T):
    """rho(p, T)."""
    return p / (c[0] * T)


@njit(**FORMULA)
def temperature_of_pressure(c, rho, p):
    """T(rho, p)."""
    return p / (c[0] * rho)


@njit(**FORMULA)
def heat_capacity(c, rho, T):
    """de/dT at constant rho."""
    return c[2]


@njit(**FORMULA)
def pressure_by_temperature(c, rho, T):
    """dp/dT at constant rho."""
    return c[0] * rho


@njit(**FORMULA)
def bulk_modulus(c, rho, T):
    """rho dp/drho at constant T."""
    return c[0] * rho * T


@njit(**FORMULA)
def bulk_modulus_of_energy(c, rho, E):
    """The same of rho and the internal energy per volume."""
    return (c[1] - 1.0) * E


@njit(**FORMULA)
def sound_speed_squared(c, rho, T):
    """c^2(rho, T)."""
    return c[1] * c[0] * T


@njit(**FORMULA)
def sound_speed_squared_of_energy(c, rho, e):
    """c^2(rho, e)."""
    return c[1] * (c[1] - 1.0) * e


@njit(**FORMULA)
def entropy(c, rho, T):
    """Entropy per mass, cv ln T - R ln rho."""
    return c[2] * np.log(T) - c[0] * np.log(rho)


perfect_gas = Formulas(
    constants=constants,
    temperature=temperature,
    temperature_in_loops=temperature_in_loops,
    energy=energy,
    pressure=pressure,
    pressure_of_energy=pressure_of_energy,
    density=density,
    temperature_of_pressure=temperature_of_pressure,
    heat_capacity=heat_capacity,
    pressure_by_temperature=pressure_by_temperature,
    bulk_modulus=bulk_modulus,
    bulk_modulus_of_energy=bulk_modulus_of_energy,
    sound_speed_squared=sound_speed_squared,
    sound_speed_squared_of_energy=sound_speed_squared_of_energy,
    entropy=entropy,
)
