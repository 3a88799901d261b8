"""A row of nodes of gas: where its numbers stand, and the fluxes of its pairs of nodes.

Of each node a row has w, a^1 … a^d, velocity of the grid, A around an axis, what the form keeps,
viscous fluxes. A form is what convection takes as the flux of two nodes; Viscous and Inviscid
say whether there are viscous fluxes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable

from fsipetsc.equations.tensors import outer
from fsipetsc.operators.loops import EXACT_LOOP, along, mean, sub
from fsipetsc.scheme.rows import ROW, U64, at, put


class Place(NamedTuple):
    """Where a row of nodes has its numbers, of one axis where this matters."""

    state: np.uint64
    grid: np.uint64
    area: np.uint64
    densities: np.uint64
    flux: np.uint64
    viscous: np.uint64


class EntropyForm(NamedTuple):
    """Two-point fluxes that conserve entropy."""

    kind: int = 0

    def kept(self, like):
        """As many numbers as a node keeps for its pairs."""
        return ()

    def near(self, gas, like, w, place, i, j):
        """The flux of the nodes i and j of a row, which are near one another."""
        l, r = pair_of(like, w, place, i, j)
        return gas.near_pair_flux(l, r, *grid_of(gas, like, w, place, i, j))

    def any(self, gas, like, w, place, i, j):
        """The flux of any two nodes."""
        l, r = pair_of(like, w, place, i, j)
        return gas.pair_flux(l, r, *grid_of(gas, like, w, place, i, j))

    def distance(self, gas, like, w, place, i, j):
        """How far they are apart."""
        like_w = state_like(like)
        return gas.pair_distance(
            at(like_w, w, place.state, ROW, i), at(like_w, w, place.state, ROW, j)
        )

    def keep(self, gas, like, w, row, n):
        """Nothing is kept."""
        return None

    def two(self, gas, l, r, a_l, v_l, a_r, v_r):
        """The flux of two states."""
        return gas.pair_flux(l, r, a_l, v_l, a_r, v_r)

    def flux_through(self, gas, l, r, a, g):
        """The same through the area a whose volume flux is g."""
        return gas.flux_through(l, r, a, g)


class DivergenceForm(NamedTuple):
    """Means of the fluxes of two nodes: for any gas law, without a statement on entropy."""

    kind: int = 0

    def kept(self, like):
        return (*outer(like, like), *like, *like, *like, 0.0, 0.0)

    def near(self, gas, like, w, place, i, j):
        like_f = (*like, 0.0, 0.0)
        U = mean(at(like_f, w, place.densities, ROW, i), at(like_f, w, place.densities, ROW, j))
        f = mean(at(like_f, w, place.flux, ROW, i), at(like_f, w, place.flux, ROW, j))
        a_l, v_l, a_r, v_r = grid_of(gas, like, w, place, i, j)
        return along(f, -gas.volume_flux(a_l, v_l, a_r, v_r), U)

    def any(self, gas, like, w, place, i, j):
        return self.near(gas, like, w, place, i, j)

    def distance(self, gas, like, w, place, i, j):
        return 0.0

    def keep(self, gas, like, w, row, n):
        keep_fluxes(gas, like, w, place_of(like, self, row, 0), n)

    def two(self, gas, l, r, a_l, v_l, a_r, v_r):
        return gas.mean_flux(l, r, a_l, v_l, a_r, v_r)

    def flux_through(self, gas, l, r, a, g):
        return gas.mean_flux_through(l, r, a, g)


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
def place_of(like, form, row, k):
    """Where the row that begins at `row` has what pairs along axis k take."""
    d = len(like)
    grid = d + 5 + d * d
    densities, viscous = grid + d + 1, grid + d + 1 + len(form.kept(like))
    return Place(
        row,
        row + U64(grid) * ROW,
        row + U64(d + 5 + k * d) * ROW,
        row + U64(densities) * ROW,
        row + U64(densities + (d + 2) * (k + 1)) * ROW,
        row + U64(viscous + k * (d + 1)) * ROW,
    )


@register_jitable
def pair_of(like, w, place, i, j):
    """States of two nodes."""
    like_w = state_like(like)
    return at(like_w, w, place.state, ROW, i), at(like_w, w, place.state, ROW, j)


@register_jitable
def grid_of(gas, like, w, place, i, j):
    """Areas and velocities of the grid of two nodes, in turn."""
    like_v = gas.of_grid(like)
    a_l, v_l = at(like, w, place.area, ROW, i), at(like_v, w, place.grid, ROW, i)
    return a_l, v_l, at(like, w, place.area, ROW, j), at(like_v, w, place.grid, ROW, j)


@njit(**EXACT_LOOP)
def keep_fluxes(gas, like, w, place, n):
    """Conserved variables and the inviscid fluxes through all areas."""
    d = U64(len(like))
    for i in range(n):
        state = at(state_like(like), w, place.state, ROW, i)
        put(w, place.densities, ROW, i, gas.densities(state))
        for k in range(d):
            a = at(like, w, place.area + k * d * ROW, ROW, i)
            put(w, place.flux + k * (d + U64(2)) * ROW, ROW, i, gas.flux(state, a))
