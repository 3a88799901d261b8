"""Perfect gas: p = rho R T, e = cv T, cv = R/(gamma - 1), entropy s = cv ln T - R ln rho."""

from typing import NamedTuple

import numpy as np


class PerfectGas(NamedTuple):
    """gamma: ratio of the specific heats [-], R: gas constant over molar mass [J/(kg K)].

    Arguments of the formulas: rho [kg/m3], T [K], p [Pa], e [J/kg].
    """

    gamma: float
    R: float

    def pressure(self, rho, T):
        """p [Pa]."""
        return rho * (self.R * T)

    def internal_energy(self, rho, T):
        """e [J/kg]."""
        return self.R / (self.gamma - 1.0) * T

    def energy_density(self, rho, T):
        """rho e [J/m3]."""
        return rho * (self.R / (self.gamma - 1.0) * T)

    def temperature(self, rho, e):
        """T [K]."""
        return (self.gamma - 1.0) / self.R * e

    def density(self, p, T):
        """rho [kg/m3]."""
        return p / (self.R * T)

    def temperature_of(self, rho, p):
        """T [K] of a pressure."""
        return p / (self.R * rho)

    def heat_capacity(self, rho, T):
        """cv [J/(kg K)]."""
        return self.R / (self.gamma - 1.0)

    def sound_speed_squared(self, rho, T):
        """c^2 [m2/s2]."""
        return self.gamma * self.R * T

    def entropy(self, rho, T):
        """s [J/(kg K)]."""
        return self.R / (self.gamma - 1.0) * np.log(T) - self.R * np.log(rho)

    def bulk_modulus(self, rho, T):
        """rho dp/drho at constant T [Pa]."""
        return rho * (self.R * T)

    def pressure_by_temperature(self, rho, T):
        """dp/dT at constant rho [Pa/K]."""
        return self.R * rho
