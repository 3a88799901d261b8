"""The perfect gas, and the stiffened gas: p + p_inf, e - p_inf/rho and the entropy of this liquid
are those of a perfect gas.
"""

from typing import NamedTuple

import numpy as np

from fsipetsc.checks import NONNEGATIVE, POSITIVE


class PerfectGas(NamedTuple):
    """p = rho R T, e = cv T, cv = R/(gamma - 1), entropy s = cv ln T - R ln rho.

    gamma: ratio of the specific heats [-], R: gas constant over molar mass [J/(kg K)]. Arguments of
    the formulas: rho [kg/m3], T [K], p [Pa], e [J/kg].
    """

    gamma: float
    R: float

    def pressure(self, rho, T):
        return rho * (self.R * T)

    bulk_modulus = pressure  # rho dp/drho at constant T [Pa]

    def pressure_by_temperature(self, rho, T):
        """dp/dT at constant rho [Pa/K]."""
        return self.R * rho

    def internal_energy(self, rho, T):
        return self.heat_capacity(rho, T) * T

    def energy_density(self, rho, T):
        """rho e [J/m3]."""
        return rho * self.internal_energy(rho, T)

    def heat_capacity(self, rho, T):
        """cv [J/(kg K)]."""
        return self.R / (self.gamma - 1.0)

    def temperature(self, rho, e):
        return (self.gamma - 1.0) / self.R * e

    def density(self, p, T):
        return p / (self.R * T)

    def temperature_of(self, rho, p):
        return p / (self.R * rho)

    def sound_speed_squared(self, rho, T):
        return self.gamma * self.R * T

    def entropy(self, rho, T):
        return self.heat_capacity(rho, T) * np.log(T) - self.R * np.log(rho)


class stiffened_gas(NamedTuple):
    """A liquid, for `Fluid(law=…)`: p = (gamma - 1) rho cv T - p_inf, e = cv T + p_inf/rho.

    Source: F. H. Harlow and A. A. Amsden, Fluid Dynamics, LA-4700 (1971).

    Args:
        gamma: ratio of the specific heats, above 1.
        cv: specific heat at constant volume [J/(kg K)].
        p_inf: stiffness [Pa].
    """

    gamma: float
    cv: float
    p_inf: float

    def ranges(self):
        return "above 1", POSITIVE, NONNEGATIVE

    def pressure(self, rho, T):
        return self.bulk_modulus(rho, T) - self.p_inf

    def bulk_modulus(self, rho, T):
        return (self.gamma - 1.0) * self.cv * rho * T

    def pressure_by_temperature(self, rho, T):
        return (self.gamma - 1.0) * self.cv * rho

    def internal_energy(self, rho, T):
        return self.cv * T + self.p_inf / rho

    def energy_density(self, rho, T):
        return self.cv * rho * T + self.p_inf

    def heat_capacity(self, rho, T):
        return self.cv

    def temperature(self, rho, e):
        return (e - self.p_inf / rho) / self.cv

    def density(self, p, T):
        return (p + self.p_inf) / ((self.gamma - 1.0) * self.cv * T)

    def temperature_of(self, rho, p):
        return self.density(p, rho)  # density and T are alike in p

    def sound_speed_squared(self, rho, T):
        return self.gamma * (self.gamma - 1.0) * self.cv * T

    def entropy(self, rho, T):
        return self.cv * (np.log(T) - (self.gamma - 1.0) * np.log(rho))
