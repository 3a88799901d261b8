"""Forms of convection: what is taken as the flux of two nodes, and what a constant force does to
them (fsipetsc.scheme.gas_force).
"""

from typing import Any, NamedTuple

from numba.extending import register_jitable


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


@register_jitable
def state_like(like):
    """As many numbers as primitive variables."""
    return (*like, 0.0, 0.0, 0.0, 0.0, 0.0)
