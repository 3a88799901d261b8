"""The two forms of convection: which flux two nodes exchange."""

from typing import Any, NamedTuple

from fsipetsc.materials.stiffened_gas import PerfectGas, StiffenedGas

#: laws whose entropy the two-point flux of fsipetsc.equations.gas conserves
CONSERVED = PerfectGas, StiffenedGas


class EntropyForm(NamedTuple):
    """The flux of two nodes conserves entropy. raises: whether a constant force acts on the gas,
    which comes from its potential then, pair by pair (fsipetsc.scheme.gas_force).
    """

    raises: bool

    def distance(self, gas, l, r):
        """Return how far apart two states are: `near` is for near ones, `any` for all."""
        return gas.pair_distance(l, r)

    def near(self, gas, l, r, a_l, a_r, g):
        """Return the flux of two nodes with similar states."""
        return gas.pair_flux(l, r, a_l, a_r, g, near=True)

    def any(self, gas, l, r, a_l, a_r, g):
        """Return the flux of two nodes with any states."""
        return gas.pair_flux(l, r, a_l, a_r, g, near=False)


class DivergenceForm(NamedTuple):
    """The flux of two nodes is the mean of their fluxes. It exists for any gas law; nothing is
    known of the entropy. A constant force acts node by node.
    """

    raises: bool = False

    def distance(self, gas, l, r):
        return 0.0

    def near(self, gas, l, r, a_l, a_r, g):
        return gas.mean_flux(l, r, a_l, a_r, g)

    def any(self, gas, l, r, a_l, a_r, g):
        return gas.mean_flux(l, r, a_l, a_r, g)


def convection_of(option: str, gas: Any) -> DivergenceForm | EntropyForm:
    """Return the form that -fsi_convection asks for. auto: the entropy form where its flux
    conserves the entropy of the gas's law.
    """
    divergence = option == "divergence" or not isinstance(gas.law, CONSERVED)
    return DivergenceForm() if divergence else EntropyForm(any(gas.force))
