"""The materials of a case as NamedTuples of formulas.

Their laws are those of fsipetsc.materials: ``gas.law.pressure(rho, T)``.
"""

from typing import Any, NamedTuple

from fsipetsc.materials.fluid import Fluid, force_in
from fsipetsc.materials.solid import Elastic, Solid


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


def law_of(material: Fluid | Solid) -> Gas | Elastic:
    """What procedures take of the material of a layer. InputError for a gas's body force of
    more than one dimension."""
    if not isinstance(material, Fluid):
        return material.elastic
    mu, kappa, gamma = 4.0 / 3.0 * material.mu, material.kappa, material.gamma
    (force,) = force_in(material.force, 1, "Fluid")
    return Gas(material.gas_law, material.transport_law, mu, kappa, gamma, force)
