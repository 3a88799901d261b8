"""Sutherland's law of viscosity and conductivity, for molecules that attract each other.

    mu(T)/mu = (T/T_ref)^(3/2) (T_ref + S)/(T + S),    kappa(T)/kappa likewise with its own S

W. Sutherland, Philosophical Magazine 36 (1893) 507. S of gases: F. M. White, Viscous Fluid Flow
(1974), Tables 1-2 (mu) and 1-3 (kappa); air: T_ref = 273 K, S = 111 K and 194 K.
"""

from typing import NamedTuple

import numpy as np

from fsipetsc.checks import NONNEGATIVE, POSITIVE, number


class Sutherland(NamedTuple):
    """mu and kappa are those of the material at T_ref; all [K]."""

    T_ref: float
    S: float
    S_kappa: float

    def viscosity(self, T):
        """mu(T)/mu."""
        ratio = T / self.T_ref
        return ratio * np.sqrt(ratio) * ((self.T_ref + self.S) / (T + self.S))

    def conductivity(self, T):
        """kappa(T)/kappa."""
        ratio = T / self.T_ref
        return ratio * np.sqrt(ratio) * ((self.T_ref + self.S_kappa) / (T + self.S_kappa))


def sutherland(T_ref: float, S: float, S_kappa: float | None = None) -> Sutherland:
    """The law with checked numbers [K]; S_kappa: S if it is not given. InputError."""
    return Sutherland(
        number(T_ref, "sutherland: T_ref", POSITIVE, "K"),
        number(S, "sutherland: S", NONNEGATIVE, "K"),
        number(S if S_kappa is None else S_kappa, "sutherland: S_kappa", NONNEGATIVE, "K"),
    )
