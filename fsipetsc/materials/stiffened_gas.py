"""Stiffened gas, a liquid: p + p_inf, e - p_inf/rho and the entropy are those of a perfect gas."""

from typing import NamedTuple

import numpy as np

from fsipetsc.checks import NONNEGATIVE, POSITIVE, number


class StiffenedGas(NamedTuple):
    """gamma: ratio of the specific heats [-], cv: specific heat [J/(kg K)], p_inf: [Pa].

    Formulas have the names, arguments and units of those of PerfectGas.
    """

    gamma: float
    cv: float
    p_inf: float

    def pressure(self, rho, T):
        return (self.gamma - 1.0) * self.cv * rho * T - self.p_inf

    def internal_energy(self, rho, T):
        return self.cv * T + self.p_inf / rho

    def energy_density(self, rho, T):
        return self.cv * rho * T + self.p_inf

    def temperature(self, rho, e):
        return (e - self.p_inf / rho) / self.cv

    def density(self, p, T):
        return (p + self.p_inf) / ((self.gamma - 1.0) * self.cv * T)

    def temperature_of(self, rho, p):
        return (p + self.p_inf) / ((self.gamma - 1.0) * self.cv * rho)

    def heat_capacity(self, rho, T):
        return self.cv

    def sound_speed_squared(self, rho, T):
        return self.gamma * (self.gamma - 1.0) * self.cv * T

    def entropy(self, rho, T):
        return self.cv * (np.log(T) - (self.gamma - 1.0) * np.log(rho))

    def bulk_modulus(self, rho, T):
        return (self.gamma - 1.0) * self.cv * rho * T

    def pressure_by_temperature(self, rho, T):
        return (self.gamma - 1.0) * self.cv * rho


def stiffened_gas(gamma: float, cv: float, p_inf: float) -> StiffenedGas:
    """A liquid, for `Fluid(law=…)`: p = (gamma - 1) rho cv T - p_inf, e = cv T + p_inf/rho.

    Source: F. H. Harlow and A. A. Amsden, Fluid Dynamics, LA-4700 (1971).

    Args:
        gamma: ratio of the specific heats, above 1.
        cv: specific heat at constant volume [J/(kg K)].
        p_inf: stiffness [Pa].
    """
    return StiffenedGas(
        number(gamma, "stiffened_gas: gamma", "above 1"),
        number(cv, "stiffened_gas: cv", POSITIVE, "J/(kg K)"),
        number(p_inf, "stiffened_gas: p_inf", NONNEGATIVE, "Pa"),
    )
