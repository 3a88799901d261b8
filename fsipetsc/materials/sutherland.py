"""Viscosity and conductivity of gases: constants, and the law of Sutherland."""

from typing import NamedTuple

import numpy as np

from fsipetsc.checks import NONNEGATIVE, POSITIVE


class ConstantTransport(NamedTuple):
    """mu and kappa are those of the material."""

    def viscosity(self, T):
        """mu(T)/mu."""
        return 1.0

    conductivity = viscosity  # kappa(T)/kappa


class sutherland(NamedTuple):
    """For `Fluid(transport=…)`: mu(T)/mu = (T/T_ref)^(3/2) (T_ref + S)/(T + S), and so for kappa.

    Source: W. Sutherland, Philosophical Magazine 36 (1893) 507. S of gases: F. M. White, Viscous
    Fluid Flow (1974), Tables 1-2 and 1-3; air: T_ref = 273 K, S = 111 K and 194 K.

    Args:
        T_ref: temperature at which mu and kappa are those of the material [K].
        S: Sutherland's temperature of the viscosity [K].
        S_kappa: that of the conductivity [K]; None: S.
    """

    T_ref: float
    S: float
    S_kappa: float | None = None

    def ranges(self):
        return POSITIVE, NONNEGATIVE, *[NONNEGATIVE] * (self.S_kappa is not None)

    def viscosity(self, T):
        ratio = T / self.T_ref
        return ratio * np.sqrt(ratio) * ((self.T_ref + self.S) / (T + self.S))

    def conductivity(self, T):
        S = self.S if self.S_kappa is None else self.S_kappa
        return self._replace(S=S).viscosity(T)
