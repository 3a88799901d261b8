"""Viscosity and conductivity that do not depend on the temperature."""

from typing import NamedTuple


class ConstantTransport(NamedTuple):
    """mu and kappa are those of the material, times a factor; T [K]."""

    factor: float = 1.0

    def viscosity(self, T):
        """mu(T)/mu."""
        return self.factor

    def conductivity(self, T):
        """kappa(T)/kappa."""
        return self.factor
