"""Viscosity and conductivity that do not depend on the temperature."""

from __future__ import annotations

from typing import NamedTuple

from fsipetsc.materials.formulas import TRANSPORT_LAW  # noqa: F401  (registers the names)


class ConstantTransport(NamedTuple):
    """mu and kappa are those of the material; T [K]."""

    def viscosity(self, T):
        """mu(T)/mu."""
        return 1.0

    def conductivity(self, T):
        """kappa(T)/kappa."""
        return 1.0
