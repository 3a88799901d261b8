"""Viscosity and conductivity that are constants, or powers of the temperature."""

from typing import NamedTuple

from fsipetsc.checks import ANY, POSITIVE, number


class ConstantTransport(NamedTuple):
    """mu and kappa are those of the material, times a factor; T [K]."""

    factor: float = 1.0

    def viscosity(self, T):
        """mu(T)/mu."""
        return self.factor

    def conductivity(self, T):
        """kappa(T)/kappa."""
        return self.factor


class PowerLaw(NamedTuple):
    """T_ref: where mu and kappa are those of the material [K]; n, n_kappa: powers."""

    T_ref: float
    n: float
    n_kappa: float

    def viscosity(self, T):
        return (T / self.T_ref) ** self.n

    def conductivity(self, T):
        return (T / self.T_ref) ** self.n_kappa


def power_law(T_ref: float, n: float, n_kappa: float | None = None) -> PowerLaw:
    """Powers of T, for `Fluid(transport=…)`: mu(T)/mu = (T/T_ref)^n, and so for kappa.

    n = 1/2: hard spheres, n = 1: Maxwell's molecules (S. Chapman and T. G. Cowling, The
    Mathematical Theory of Non-Uniform Gases). Source of n of gases: F. M. White, Viscous Fluid Flow
    (1974), Tables 1-2 and 1-3; air: 0.67 and 0.81.

    Args:
        T_ref: temperature at which mu and kappa are those of the material [K].
        n: power of the viscosity.
        n_kappa: power of the conductivity; None: n.
    """
    return PowerLaw(
        number(T_ref, "power_law: T_ref", POSITIVE, "K"),
        number(n, "power_law: n", ANY),
        number(n if n_kappa is None else n_kappa, "power_law: n_kappa", ANY),
    )
