"""Parts of blocks in one dimension as one record each: what a compiled step takes of them.

A step of a few hundred nodes takes less time than the calls of its loops from Python. So each part
is a record with its laws, its arrays and the faces at its two ends; the loops are those of all
dimensions.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from fsipetsc.operators.boxed import Box
from fsipetsc.operators.loops import CALL, INNER_LOOP, MERGED_CALL
from fsipetsc.operators.narrow import STIFFNESS_OF_WIDE
from fsipetsc.scheme.after_step import WORDS
from fsipetsc.scheme.block_look import BAD, CONVECTION, J_ERROR, LEAST_J, gas_look, look_at_end
from fsipetsc.scheme.faces import tangent
from fsipetsc.scheme.gas_rates import gas_rates
from fsipetsc.scheme.line_terms import LINE
from fsipetsc.scheme.rows import Array
from fsipetsc.scheme.solid_look import solid_look
from fsipetsc.scheme.solid_rates import solid_rates


class GasLine(NamedTuple):
    """A part of a gas block.

    begin: of its unknowns in the world vector. halo: (N, 4), its nodes with a halo, or (0, 4).
    S, weight: of three bands. masses: (M,) weights of its own nodes.
    follows: (n,) particles by which its ends move, here: (n, 2) their displacement and velocity;
    known: (m, 2) those of all ranks, of the columns ``ends`` of moved, moving: (1, ends of the
    block). low, high: (N,) weights of the ends. reference: (M,) J of the reference map. forcing:
    (3, M), or (3, 0). column: of its mass in ``gain``; columns: of its sums in the record.
    """

    gas: Any
    form: Any
    friction: Any
    dissipation: Any
    at_low: Any
    at_high: Any
    block: int
    begin: int
    column: int
    halo: Array
    metrics: Array
    inertia: Array
    S: Any
    weight: Any
    patch: Any
    work: Any
    per_h: Array
    row: Array
    masses: Array
    follows: Array
    here: Array
    known: Array
    ends: Array
    moved: Array
    moving: Array
    low: Array
    high: Array
    reference: Array
    forcing: Array
    came: Array
    seen: Array
    sums: Array
    columns: Array


class SolidLine(NamedTuple):
    """A part of a solid block; what has the same name as in GasLine is the same.

    inertia: (N,) J0 m0, masses: (M,) weights times J0 m0. F: (1, M), as the last look found it.
    forcing: (3, M), or (3, 0), of velocity, temperature and place. interfaces: (n, 5) number of an
    interface at this part, owned and ghosted row of its node, X, prestress. stored_at: (n,) ghosted
    rows of members that tell what they store, rows_of_stored: (n,) where; S, weight: of the band;
    none: (1, N) zeros.
    """

    solid: Any
    dissipation: Any
    at_low: Any
    at_high: Any
    block: int
    begin: int
    halo: Array
    metrics: Array
    inertia: Array
    prestress: Array
    patch: Any
    work: Any
    per_h: Array
    masses: Array
    F: Array
    forcing: Array
    came: Array
    seen: Array
    sums: Array
    columns: Array
    interfaces: Array
    stored_at: Array
    rows_of_stored: Array
    S: Array
    weight: Array
    none: Array


# what is done with a part; each is in a fsipetsc.operators.boxed.Box


@njit(**MERGED_CALL)
def owned(part, s, dof):
    """(M, dof), this part of a world vector s."""
    n = part.patch.own[0]
    return s[part.begin : part.begin + n * dof].reshape((n, dof))


@njit(**MERGED_CALL)
def ghosted(part, s, dof):
    """(N, dof), the same with its halo, if it has one."""
    n = part.patch.own[0]
    own = s[part.begin : part.begin + n * dof].reshape((n, dof))
    return part.halo if part.halo.shape[0] > 0 else own


@njit(**CALL)
def follow_gas(part, particles):
    """Tell a gas displacement and velocity of the particles here by which it moves."""
    follows, here, state, wall = part.follows, part.here, particles.state, particles.data.wall
    moves, place = particles.moves, particles.place
    for m in range(follows.size):
        n = follows[m]
        if moves[n] and state.solid_mass[n] == 0.0:
            here[m, 0], here[m, 1] = place[n], wall[n, 0]
        else:
            here[m, 0], here[m, 1] = state.D[n, 0], state.v[n, 0]


@njit(**CALL)
def move_gas(part):
    """Velocity of a gas's grid and J_t = D v."""
    ends, known, moved, moving = part.ends, part.known, part.moved, part.moving
    low, high, metrics = part.low, part.high, part.metrics
    for m in range(ends.size):
        moved[0, ends[m]], moving[0, ends[m]] = known[m, 0], known[m, 1]
    at_low, at_high = moving[0, 0], moving[0, -1]
    for i in range(low.size):
        metrics[1, i] = low[i] * at_low + high[i] * at_high
        metrics[2, i] = at_high - at_low


@njit(**CALL)
def rates_of_gas(part, s, f, gain):
    """Fill a gas's part of f, from that of a completed s; what comes in goes to ``gain``."""
    q, rates, came, patch = ghosted(part, s, 4), owned(part, f, 4), part.came, part.patch
    (S0, S1, S2), (w0, w1, w2), metrics = part.S, part.weight, part.metrics
    laws, form, friction = part.gas, part.form, part.friction
    gas_rates(
        laws, LINE, form, friction, q, metrics, S0, S1, S2, w0, w1, w2, patch, rates, part.work
    )
    part.dissipation.add(part, q, rates)
    came[0] = came[1] = came[2] = 0.0
    part.at_low.add(part, q, rates, came)
    part.at_high.add(part, q, rates, came)
    force, first, masses = laws.force[0], patch.first[0], part.masses
    if force != 0.0:
        for i in range(masses.size):
            came[1] += force * masses[i] * q[first + i, 1]
            came[2] += force * masses[i] * q[first + i, 2]
    forcing = part.forcing
    for c in range(3 * min(forcing.shape[1], 1)):
        for i in range(masses.size):
            supplied = q[first + i, 0] * forcing[c, i]
            rates[i, 1 + c] += supplied
            came[c] += masses[i] * supplied
    gain[part.column] += came[0]
    gain[gain.size - 2] += came[1]
    gain[gain.size - 1] += came[2]


@njit(**CALL)
def rates_of_solid(part, s, f, gain):
    """The same of a solid."""
    q, rates, came = ghosted(part, s, 3), owned(part, f, 3), part.came
    laws, first, masses = part.solid, part.patch.first[0], part.masses
    solid_rates(laws, LINE, q, part.metrics, part.prestress, rates, part.work)
    part.dissipation.add(part, q, rates)
    came[0] = came[1] = came[2] = 0.0
    part.at_low.add(part, q, rates, came)
    part.at_high.add(part, q, rates, came)
    force, forcing = laws.force[0], part.forcing
    forced = forcing.shape[1] > 0
    if force != 0.0 or forced:
        for i in range(masses.size):
            v, mass = q[first + i, 1], masses[i]
            came[1] += mass * force
            came[2] += mass * force * v
            if forced:
                push = forcing[0, i]
                heat = laws.alpha * forcing[1, i] + v * push
                rates[i, 0] += forcing[2, i]
                rates[i, 1] += push
                rates[i, 2] += heat
                came[1] += mass * push
                came[2] += mass * heat
    gain[gain.size - 2] += came[1]
    gain[gain.size - 1] += came[2]


@njit(**CALL)
def look_at_gas(part, s):
    """Fill seen and sums of a part."""
    q, seen, first, (w0, w1, w2) = ghosted(part, s, 4), part.seen, part.patch.first[0], part.weight
    laws, metrics, stiffness, moved = part.gas, part.metrics, STIFFNESS_OF_WIDE, part.moved
    patch, per_h, row, sums = part.patch, part.per_h, part.row, part.sums
    gas_look(laws, LINE, q, metrics, per_h, stiffness, w0, w1, w2, patch, row, seen, sums)
    if seen[BAD] != 0.0:  # no NaN may stay there for a step that is made again
        clear(part.work.w)
    longer, error, least, reference = moved[0, -1] - moved[0, 0], 0.0, np.inf, part.reference
    for i in range(reference.size):
        J, own = q[first + i, 0], reference[i] + longer
        error = max(error, abs(J - own) / abs(own))
        least = min(least, J / reference[i])
    seen[J_ERROR], seen[LEAST_J] = error, -least


@njit(**CALL)
def look_at_solid(part, s):
    """Fill seen, sums and F of a part."""
    q, laws, seen, sums = ghosted(part, s, 3), part.solid, part.seen, part.sums
    metrics, prestress, per_h = part.metrics, part.prestress, part.per_h
    masses, work, F, stiffness = part.masses, part.work, part.F, STIFFNESS_OF_WIDE
    solid_look(laws, LINE, q, metrics, prestress, per_h, stiffness, masses, work, F, seen, sums)


@njit(**MERGED_CALL)
def note_part(part, found):
    """Put the extremes and sums of a look where they belong."""
    begin, seen, sums, columns = 1 + WORDS * part.block, part.seen, part.sums, part.columns
    extremes, latest = found.extremes, found.latest
    for c in range(seen.size):
        extremes[begin + c] = seen[c]
    extremes[begin + CONVECTION] *= found.pace
    for c in range(sums.size):
        latest[columns[c]] += sums[c]


@njit(**CALL)
def go_along(part, particles):
    """Let the grid of a gas, all of whose block is here, follow the particles."""
    follow_gas(part, particles)
    move_gas(part)


@njit(**CALL)
def stay(part, particles):
    """Solids have no grid to move."""


@njit(**CALL)
def store(part, particles, s):
    """Tell particles what members of a solid with heat 'elastic' store: see
    fsipetsc.scheme.particle_steps.Particles.
    """
    q, at, rows, stored = ghosted(part, s, 3), part.stored_at, part.rows_of_stored, particles.stored
    solid, metrics, prestress = part.solid, part.metrics, part.prestress
    slopes = tangent(at, part.S, part.weight, 1, q.shape[0], part.none, q)
    for i in range(at.size):
        F = 1.0 + slopes[i, 0] * (metrics[0, at[i]] / metrics[1, at[i]])
        S = prestress[0, at[i]] if prestress.shape[1] > 0 else 0.0
        stored[rows[i]] = solid.law.energy((F,)) / solid.m0 + S * (F - 1.0) / solid.m0


@njit(**CALL)
def store_nothing(part, particles, s):
    """Of gases, of solids whose stresses heat them, and where nobody asks."""


@njit(**CALL)
def note_gas(part, found):
    """Put the extremes and sums of a look where they belong; found: a box of
    fsipetsc.scheme.line_steps.Found.
    """
    note_part(part, found)


@njit(**CALL)
def note_solid(part, found):
    """The same, and what is recorded of interfaces."""
    note_part(part, found)
    at_ends, interfaces, F = found.at_ends, part.interfaces, part.F
    q, laws = ghosted(part, found.y, 3), part.solid
    for m in range(interfaces.shape[0]):
        number, own, at, X, S = interfaces[m]
        of_end = at_ends[:, int(number)]
        look_at_end(laws, q, F, int(at), int(own), S, of_end)
        of_end[0] += X


class Held(NamedTuple):
    """A part and what is done with it in a step, called by address (fsipetsc.operators.boxed)."""

    part: Any
    store: Any
    follow: Any
    rates: Any
    look: Any
    note: Any


@njit(**CALL)
def hold(part, store, follow, rates, look, note):
    """A box of Held."""
    return Box(Held(part, store, follow, rates, look, note))


#: what is held of a gas, of a solid, and of one that stores
OF_GAS = store_nothing, go_along, rates_of_gas, look_at_gas, note_gas
OF_SOLID = store_nothing, stay, rates_of_solid, look_at_solid, note_solid
OF_STORING_SOLID = store, *OF_SOLID[1:]


@njit(**INNER_LOOP)
def clear(numbers):
    """Zeros."""
    for i in range(numbers.size):
        numbers[i] = 0.0
