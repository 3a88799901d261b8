"""Perfect gas: p = rho R T, e = cv T, with cv = R/(gamma - 1).

Entropy s = cv ln T - R ln rho, up to a constant.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fsipetsc.materials.formulas import GAS_LAW  # noqa: F401  (registers the names)


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
        return e * ((self.gamma - 1.0) / self.R)

    def density(self, p, T):
        """rho [kg/m3]."""
        return p / (self.R * T)

    def heat_capacity(self, rho, T):
        """cv [J/(kg K)]."""
        return self.R / (self.gamma - 1.0) + 0.0 * T

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
