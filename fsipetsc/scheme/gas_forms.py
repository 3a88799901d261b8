"""Forms of convection: what is taken as the flux of two nodes, and what a constant force does to
them (fsipetsc.scheme.gas_force).
"""

from typing import Any, NamedTuple

from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.stiffened_gas import StiffenedGas
from fsipetsc.scheme.gas_force import force_of

#: laws whose entropy the two-point flux of fsipetsc.equations.gas conserves
CONSERVED = PerfectGas, StiffenedGas


class EntropyForm(NamedTuple):
    """Two-point fluxes that conserve entropy."""

    force: Any

    def distance(self, gas, l, r):
        """How far two states are apart."""
        return gas.pair_distance(l, r)

    def near(self, gas, l, r, a_l, a_r, g):
        """The flux of two nodes which are near one another."""
        return gas.near_pair_flux(l, r, a_l, a_r, g)

    def any(self, gas, l, r, a_l, a_r, g):
        """The flux of any two nodes."""
        return gas.pair_flux(l, r, a_l, a_r, g)


class DivergenceForm(NamedTuple):
    """Means of the fluxes of two nodes: for any gas law, without a statement on entropy."""

    force: Any

    def distance(self, gas, l, r):
        return 0.0

    def near(self, gas, l, r, a_l, a_r, g):
        return gas.mean_flux(l, r, a_l, a_r, g)

    def any(self, gas, l, r, a_l, a_r, g):
        return gas.mean_flux(l, r, a_l, a_r, g)


def convection_of(option: str, gas: Any) -> DivergenceForm | EntropyForm:
    """The form of -fsi_convection for a gas, with its constant force; auto: entropy where the flux
    conserves it.
    """
    divergence = option == "divergence" or not isinstance(gas.law, CONSERVED)
    force = force_of(gas.force, divergence)
    return DivergenceForm(force) if divergence else EntropyForm(force)


def state_like(like):
    """A tuple of as many numbers as there are primitive variables."""
    return (*like, 0.0, 0.0, 0.0, 0.0, 0.0)
