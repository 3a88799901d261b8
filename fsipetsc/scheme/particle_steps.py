"""What particles do in a stage, with all that belongs to them in one box.

    begin_sums, exchange, end_sums, settle     complete the unknowns
    begin_rates, exchange, end_rates           complete their rates

Where particles have constraints, begin_normals, what blocks say of their faces, an exchange and
end_normals come before settle, for normals, and before begin_rates, for how they turn. Where
energies that members store matter to temperatures, begin_stored, what solids say of their members,
an exchange and end_stored come before settle. The formulas are those of fsipetsc.scheme.particles.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import njit

from fsipetsc.operators.boxed import Box
from fsipetsc.operators.loops import CALL
from fsipetsc.scheme.normals import sum_members
from fsipetsc.scheme.particles import (
    constrain,
    fill_rates,
    fill_state,
    give_places,
    give_rates,
    give_state,
    share,
    share_heat,
    slide,
    weigh_heat,
)
from fsipetsc.scheme.rows import Array


class Particles(NamedTuple):
    """The particles of a rank: see fsipetsc.scheme.particles.

    like: (0, …) of d dimensions. law: of the gas. stored: (rows, 1) energy per mass of members that
    is neither kinetic nor heat; stores: whether it changes. rows: (rows, columns) of the exchange.
    particle_rates: (p, 2d + 2). slips: whether any has constraints; normals, turning: (p, K, 2d).
    of_normals: (members of those, 2 K d) area vectors, at_normals: how many are here, of_particle,
    row_of: particle and row of each. moves: (p,) whether a wall there moves, place: (p, d) its
    displacement. behind: as many numbers at the end of a vector are what came in.
    """

    like: Any
    table: Any
    law: Any
    data: Any
    state: Any
    stored: Array
    rows: Array
    particle_rates: Array
    stores: int
    slips: int
    normals: Array
    turning: Array
    of_normals: Array
    at_normals: int
    of_particle: Array
    row_of: Array
    moves: Array
    place: Array
    behind: int


@njit(**CALL)
def begin_sums(p, s, gain):
    """Rows of the members of this rank."""
    gain[:] = 0.0
    fill_state(p.table, p.like, s, p.rows)


@njit(**CALL)
def end_sums(p, gain):
    """What particles share, from the rows of all members."""
    share(p.table, p.like, p.rows, p.data, p.state, gain)


@njit(**CALL)
def begin_normals(p):
    """Clear the rows of the members here."""
    for m in range(p.at_normals):
        for c in range(p.of_normals.shape[1]):
            p.of_normals[m, c] = 0.0


@njit(**CALL)
def end_normals(p, turning):
    """Normals of particles, or how they turn, from the rows of all members."""
    sum_members(p.of_particle, p.row_of, p.of_normals, p.turning if turning else p.normals)


@njit(**CALL)
def begin_stored(p, s):
    """Solid members get their displacement, for solids to say what they store."""
    give_places(p.table, p.like, s, p.state)


@njit(**CALL)
def end_stored(p):
    """What particles store, from what all members do."""
    weigh_heat(p.table, p.stored, p.state)


@njit(**CALL)
def settle(p, s, gain):
    """What constraints and heat make of it, for the members of this rank; s has what came in."""
    table, like, data, state, behind = p.table, p.like, p.data, p.state, p.behind
    if p.slips:
        slide(table, like, p.normals, data, state, gain)
    share_heat(table, p.law, like, data, state, gain)
    give_state(table, like, p.stored, s, state)
    for c in range(behind):
        s[s.size - behind + c] += gain[c]


@njit(**CALL)
def begin_rates(p, f):
    """Rows of the rates of the members of this rank."""
    fill_rates(p.table, p.like, f, p.rows)


@njit(**CALL)
def end_rates(p, s, f, gain):
    """Rates of the members under the constraints of their particles."""
    table, like, state, rates, behind = p.table, p.like, p.state, p.particle_rates, p.behind
    constrain(table, like, p.rows, p.normals, p.turning, p.data, state, rates, gain)
    give_rates(table, like, s, f, state, rates, gain)
    for c in range(behind):
        f[f.size - behind + c] = gain[c]


class Held(NamedTuple):
    """Particles and what they do, called by address: see fsipetsc.operators.boxed."""

    all: Any
    begin_sums: Any
    end_sums: Any
    begin_normals: Any
    end_normals: Any
    begin_stored: Any
    end_stored: Any
    settle: Any
    begin_rates: Any
    end_rates: Any


@njit(**CALL)
def hold(
    particles,
    begin_sums,
    end_sums,
    begin_normals,
    end_normals,
    begin_stored,
    end_stored,
    settle,
    begin_rates,
    end_rates,
):
    """A box of Held."""
    first = begin_sums, end_sums, begin_normals, end_normals, begin_stored, end_stored
    return Box(Held(particles, *first, settle, begin_rates, end_rates))
