"""A row of nodes of gas: where its numbers stand, and the fluxes of its pairs of nodes.

Of each node a row has w, a^1 … a^d, velocity of the grid, A around an axis, viscous fluxes, the
potential of a constant force. A form is what convection takes as the flux of two nodes, and has
what a constant force does to them (fsipetsc.scheme.gas_force); Viscous and Inviscid say whether
there are viscous fluxes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable

from fsipetsc.operators.loops import mean, sub
from fsipetsc.scheme.rows import ROW, U64, at


class Place(NamedTuple):
    """Where a row of nodes has its numbers, of one axis where this matters."""

    state: np.uint64
    grid: np.uint64
    area: np.uint64
    viscous: np.uint64
    potential: np.uint64


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


class Inviscid(NamedTuple):
    """No viscous fluxes; reach: how many times farther nodes are read."""

    reach: int = 0

    def less(self, like, F, w, place, i, j):
        """F less the viscous flux."""
        return F


class Viscous(NamedTuple):
    """Viscosity and conduction."""

    reach: int = 1

    def less(self, like, F, w, place, i, j):
        like_s = (*like, 0.0)
        s = mean(at(like_s, w, place.viscous, ROW, i), at(like_s, w, place.viscous, ROW, j))
        return (F[0], *sub(F[1:], s))


@register_jitable
def state_like(like):
    """As many numbers as primitive variables."""
    return (*like, 0.0, 0.0, 0.0, 0.0, 0.0)


@register_jitable
def place_of(gas, like, row, k):
    """Where the row that begins at `row` has what pairs along axis k take."""
    d, grid = len(like), len(like) + 5 + len(like) ** 2
    viscous = grid + len(gas.of_grid(like))
    return Place(
        row,
        row + U64(grid) * ROW,
        row + U64(d + 5 + k * d) * ROW,
        row + U64(viscous + k * (d + 1)) * ROW,
        row + U64(viscous + d * (d + 1)) * ROW,
    )


@register_jitable
def pair_of(like, w, place, i, j):
    """States of two nodes."""
    like_w = state_like(like)
    return at(like_w, w, place.state, ROW, i), at(like_w, w, place.state, ROW, j)


@register_jitable
def grid_of(gas, like, w, place, i, j):
    """Areas of two nodes, and their volume flux."""
    like_v, a_l = gas.of_grid(like), at(like, w, place.area, ROW, i)
    a_r, v_r = at(like, w, place.area, ROW, j), at(like_v, w, place.grid, ROW, j)
    return a_l, a_r, gas.volume_flux(a_l, at(like_v, w, place.grid, ROW, i), a_r, v_r)
