"""The materials of a case as NamedTuples, whose scalar methods compiled loops call.

Their laws are those of fsipetsc.materials: ``gas.law.pressure(rho, T)``.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba.extending import register_jitable

from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid, force_in
from fsipetsc.materials.line_solid import Solid, wave_modulus
from fsipetsc.materials.own import no_entropy

wave_modulus = register_jitable(wave_modulus)


class Gas(NamedTuple):
    """mu: 4/3 of the shear viscosity [Pa s]; kappa [W/(m K)]; force: body force per mass [m/s2].

    law: the equation of state, of rho, T, and the internal energy per mass e; transport: what mu
    and kappa are multiplied with.
    """

    law: Any
    transport: Any
    mu: float
    kappa: float
    gamma: float
    force: float

    def viscosity(self, T):
        """mu' = 4/3 mu(T)."""
        return self.mu * self.transport.viscosity(T)

    def conductivity(self, T):
        """kappa(T)."""
        return self.kappa * self.transport.conductivity(T)

    def velocity_and_temperature(self, rho, m, E):
        """(u, T) from (rho, rho u, e), the last one per volume."""
        u = m / rho
        return u, self.law.temperature(rho, E / rho - 0.5 * u * u)

    def total_energy(self, rho, u, T):
        """e, per volume."""
        return rho * (self.law.internal_energy(rho, T) + 0.5 * u * u)


class Elastic(NamedTuple):
    """K = 2 mu_e + lambda_e [Pa]; kappa_e [W/(m K)]; m0 [kg/m3]; alpha [J/(kg K)]; force: body
    force per mass [m/s2].

    law: the pressure p of J = x_X, T, m0 and alpha.
    """

    law: Any
    K: float
    kappa_e: float
    m0: float
    alpha: float
    force: float

    def pressure(self, T, x_X):
        """p [Pa]."""
        return self.law.pressure(x_X, T, self.m0, self.alpha)

    def pressure_by_temperature(self, T, x_X):
        """dp/dT [Pa/K]."""
        return self.law.pressure_by_temperature(x_X, T, self.m0, self.alpha)

    def stiffness(self, T, x_X):
        """-x_X dp/dx_X [Pa]."""
        return self.law.stiffness(x_X, T, self.m0, self.alpha)

    def wave_modulus(self, T, p, sigma, x_X):
        """m0 c^2 of elastic waves [Pa]."""
        p_T, stiff = self.pressure_by_temperature(T, x_X), self.stiffness(T, x_X)
        return wave_modulus(self.K, self.alpha * self.m0, p_T, stiff, p, sigma, x_X)


def gas_of(material: Fluid) -> Gas:
    """The gas of a layer. InputError for a body force of more than one dimension."""
    mu, kappa, gamma = 4.0 / 3.0 * material.mu, material.kappa, material.gamma
    (force,) = force_in(material.force, 1, "Fluid")
    return Gas(material.gas_law, material.transport_law, mu, kappa, gamma, force)


def elastic_of(material: Solid) -> Elastic:
    """The solid of a layer."""
    numbers = material.K, material.kappa_e, material.m0, material.alpha, material.force
    return Elastic(material.pressure_law, *numbers)


def check_entropy(layers: Any) -> None:
    """InputError for a gas law of the user's without a formula for the entropy."""
    for layer in layers:
        material = layer.material
        if isinstance(material, Fluid) and type(material.gas_law).entropy is no_entropy:
            what = "no formula entropy(rho, T), which -fsi_entropy and -fsi_check need"
            raise InputError(f"the gas law of layer '{layer.name}' has {what}")
