"""Particles: sums over members, constraints by Gauss's principle, and what each member gets back.

Compiled. Gas members of a particle share U = (rho, rho u, E), solid members share displacement and
velocity, and have one temperature or each its own. With the sums

    gas    V = sum H J,  M = sum H J rho,  P = sum H J rho u,  E = sum H J e
    solid  M_s = sum H J0 m0,  and those of M_s times displacement, velocity, energy per mass e_s

`end_sums` gives all members what follows from the sums; sums are linear in the unknowns, so that a
Runge-Kutta method keeps them. `end_rates` does the same for rates. With a_g = (R_m - u R_rho)/M and
a_s = F/M_s the accelerations without constraints, it minimises

    1/2 M |a_g' - a_g|^2 + 1/2 M_s |a_s' - a_s|^2     where     G_c . a_g' + S_c . a_s' = b_c:

forces pi_c G_c on the gas and pi_c S_c on the solid, with pi from the symmetric system

    sum_e (G_c . G_e / M + S_c . S_e / M_s) pi_e  =  b_c - G_c . a_g - S_c . a_s.

G_c is the sum of the area vectors of gas faces, S_c minus that of those at a solid, so that G_c +
S_c is the sum over walls: what they push comes in from outside. Sticking gas and solid are one body
of mass M + M_s. A body whose motion is given counts as infinitely heavy.

What comes in is added to ``gain``, see fsipetsc.scheme.part.Gain. Constraints tell it by their
forces, data that replace unknowns by the change.

    begin_sums, exchange, end_sums, settle     complete the unknowns
    begin_rates, exchange, end_rates           complete their rates

begin_normals, what blocks say of their faces, an exchange and end_normals come before settle and
begin_rates where particles have constraints; begin_stored, what solids say of their members, an
exchange and end_stored before settle where energies that members store matter to temperatures.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fsipetsc.blocks.particles import SLIPS
from fsipetsc.operators.loops import (
    CALL,
    INLINED_CALL,
    add,
    along,
    dot,
    node,
    part_of,
    per,
    put_part,
    scale,
    sub,
)
from fsipetsc.operators.loops import _by_length as by_length
from fsipetsc.scheme.normals import sum_members

Array = NDArray[Any]

GAS, SOLID = 0, 1
#: a pivot below this part of its size before elimination belongs to a constraint that others imply
REDUNDANT = 1e-9
#: the vector G or S, from ``first`` on, of constraint k of particle p
normal = by_length(
    "normal",
    "like, array, p, k, first",
    lambda d: f" return ({''.join(f'array[p, k, first + {c}],' for c in range(d))})",
)


class Table(NamedTuple):
    """Particles on a rank. Rows are members; those of this rank come first, in any order.

    begin: (p + 1,), rows of particle p are row[begin[p]:begin[p + 1]], in the order that all ranks
    have. kind: (rows,) GAS or SOLID. at: (own,) where the unknowns of a member begin in the world's
    vector. weight: (rows,) H of a gas member, M_s of a solid one; alpha: (rows,) specific heat of
    solids. inertia: (own,) M_s of members whose work is booked, else 0. count: (p,) number of
    constraints; constraint: (p, K) their kinds. column: (p,) where the mass of the gas is in
    ``gain``. faces: (p, 4), through which face what moves gas and solid does work, and what gives
    temperatures to gas and solid heats. flags: (p, FLAGS) 1 or 0 for each of MINE …, see
    fsipetsc.blocks.particles.
    """

    begin: Array
    row: Array
    kind: Array
    at: Array
    weight: Array
    alpha: Array
    inertia: Array
    count: Array
    constraint: Array
    column: Array
    faces: Array
    flags: Array


#: this rank adds what comes in; forces move the gas, the solid; a clamp gives the place; gas and
#: solid stick; motion of the gas, of the solid is given, all of the gas, of the solid; temperature
#: of the gas, of the solid; they have one; so have members of the solid
MINE, FREE_GAS, FREE_SOLID, PLACED, STICKS, HELD_GAS, HELD_SOLID, GIVEN_GAS, GIVEN_SOLID = range(9)
WARM_GAS, WARM_SOLID, SHARES_HEAT, ONE_T = range(9, 13)
FLAGS = 13
#: columns of ``faces``
MOVES_GAS, MOVES_SOLID, HEATS_GAS, HEATS_SOLID = range(4)


class Data(NamedTuple):
    """What conditions prescribe at an instant, for each particle: velocity and acceleration of
    walls (p, d), displacement, velocity and acceleration of clamps (p, d), temperatures (p,) of gas
    and solid, all unknowns: (p, d + 2) of a gas, (rho, rho u, E), and (p, 2d) of a solid, place
    less X and velocity.
    """

    wall: Array
    wall_rate: Array
    clamp: Array
    clamp_velocity: Array
    clamp_rate: Array
    T: Array
    T_solid: Array
    gas: Array
    solid: Array


class State(NamedTuple):
    """What `end_sums` found, for each particle: mass of gas and solid (p,), V (p,), U of the gas
    (p, d + 2), displacement D and velocity v (p, d) and energy per mass e (p,) of the solid.
    mean_energy: (p,) that of its members before a change. capacity, potential: (p,) mean specific
    heat and mean energy per mass that is neither kinetic nor heat, of the solid.
    """

    mass: Array
    solid_mass: Array
    V: Array
    U: Array
    D: Array
    v: Array
    e: Array
    mean_energy: Array
    capacity: Array
    potential: Array


class Particles(NamedTuple):
    """The particles of a rank, which all functions here get in a box.

    like: (0, …) of d dimensions. law: of the gas. stored: (rows, 1) energy per mass of members that
    is neither kinetic nor heat; stores: whether it changes. rows: (rows, columns) of the exchange.
    slips: whether any has constraints; normals, turning: (p, K, 2d), G and S and how they turn.
    of_normals: (members of those, 2 K d) area vectors, at_normals: how many are here, of_particle,
    row_of: particle and row of each. moves: (p,) whether a wall there moves, place: (p, d) its
    displacement. behind: as many numbers at the end of a vector are what came in.
    """

    like: Any
    table: Table
    law: Any
    data: Data
    state: State
    stored: Array
    rows: Array
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


# Functions name arrays before their loops: where a record is asked within a loop, numba counts
# references to its arrays, which takes as long as all else.


@njit(**CALL)
def begin_sums(all, s, gain):
    """Rows of this rank's members: H q of a gas, (M_s D, M_s v, M_s e, M_s) of a solid."""
    gain.numbers[:] = 0.0
    weigh(all, s)
    d, rows, kind, weight = len(all.like), all.rows, all.table.kind, all.table.weight
    for r in range(all.table.at.size):
        if kind[r] == SOLID:
            rows[r, 2 * d + 1] = weight[r]


@njit(**CALL)
def begin_rates(all, f):
    """The same of rates."""
    weigh(all, f)


@njit(**INLINED_CALL)
def weigh(all, y):
    """Rows of this rank's members: what they have in y times their weights."""
    d, rows, kind, at, weight = (
        len(all.like),
        all.rows,
        all.table.kind,
        all.table.at,
        all.table.weight,
    )
    for r in range(at.size):
        for c in range(d + 3 if kind[r] == GAS else 2 * d + 1):
            rows[r, c] = weight[r] * y[at[r] + c]


@njit(**INLINED_CALL)
def summed(table, like, p, rows):
    """(V, M, P, E) of the gas and (M_s, M_s D, M_s v, M_s e) of the solid of particle p."""
    d, begin, row, kind = len(like), table.begin, table.row, table.kind
    V, M, P, E, M_s, D, P_s, E_s = 0.0, 0.0, like, 0.0, 0.0, like, like, 0.0
    for m in range(begin[p], begin[p + 1]):
        r = row[m]
        if kind[r] == GAS:
            V, M, E = V + rows[r, 0], M + rows[r, 1], E + rows[r, d + 2]
            P = add(P, part_of(like, rows, r, 2))
        else:
            M_s, E_s = M_s + rows[r, 2 * d + 1], E_s + rows[r, 2 * d]
            D, P_s = add(D, node(like, rows, r)), add(P_s, part_of(like, rows, r, d))
    return (V, M, P, E), (M_s, D, P_s, E_s)


@njit(**INLINED_CALL)
def kinetic(P, M):
    """Energy of a body with this momentum."""
    return 0.5 * dot(P, P) / M if M > 0.0 else 0.0


@njit(**CALL)
def end_sums(all, gain):
    """From the sums of all members: one U, one displacement and velocity; what sticks has one
    velocity, and the kinetic energy that the solid loses by that goes to the gas.
    """
    table, like, rows, data, state = all.table, all.like, all.rows, all.data, all.state
    flags, column, faces, d = table.flags, table.column, table.faces, len(like)
    masses, impulse, energies = gain.mass, gain.impulse, gain.energy
    mass, solid_mass, V_of, U, e = state.mass, state.solid_mass, state.V, state.U, state.e
    D_of, v, mean_energy, clamp, wall = state.D, state.v, state.mean_energy, data.clamp, data.wall
    of_gas, of_solid, clamp_velocity = data.gas, data.solid, data.clamp_velocity
    for p in range(column.size):
        (V, M, P, E), (M_s, D, P_s, E_s) = summed(table, like, p, rows)
        before, before_s, energy, energy_s, M_0 = P, P_s, E, E_s, M
        solid_mass[p] = M_s
        if M_s > 0.0:
            mean_energy[p], D = E_s / M_s, per(D, M_s)
        held, held_s = flags[p, HELD_GAS] == 1, flags[p, HELD_SOLID] == 1
        if held_s:
            P_s = scale(M_s, node(like, clamp_velocity, p))
        if held:
            P = scale(M, node(like, wall, p))
        if flags[p, STICKS]:
            both = per(add(P, P_s), M + M_s)
            if held_s:
                both = per(P_s, M_s)
            elif held:
                both = node(like, wall, p)
            first, P, P_s = kinetic(P_s, M_s), scale(M, both), scale(M_s, both)
            if not held_s:
                change = kinetic(P_s, M_s) - first
                E, E_s = E - change, E_s + change
        if flags[p, PLACED]:
            D = node(like, clamp, p)
        if flags[p, GIVEN_GAS]:
            M, P, E = V * of_gas[p, 0], scale(V, part_of(like, of_gas, p, 1)), V * of_gas[p, d + 1]
        if flags[p, GIVEN_SOLID]:
            D, P_s = node(like, of_solid, p), scale(M_s, part_of(like, of_solid, p, d))
        mass[p], V_of[p] = M, V
        if V > 0.0:
            U[p, 0], U[p, d + 1] = M / V, E / V
            put_part(U, p, 1, per(P, V))
        if M_s > 0.0:
            e[p] = E_s / M_s
            put_part(v, p, 0, per(P_s, M_s))
            put_part(D_of, p, 0, D)
        given = flags[p, GIVEN_GAS] or flags[p, GIVEN_SOLID]
        if flags[p, MINE] and (held or held_s or given):
            if V > 0.0:
                masses[column[p]] += M - M_0
            push = add(sub(P, before), sub(P_s, before_s))
            for c in range(d):
                impulse[c] += push[c]
            energies[faces[p, MOVES_GAS]] += (E - energy) + (E_s - energy_s)


# normals, and what members store


@njit(**CALL)
def begin_normals(all):
    """Clear the rows of the members here."""
    table = all.of_normals
    for m in range(all.at_normals):
        for c in range(table.shape[1]):
            table[m, c] = 0.0


@njit(**CALL)
def end_normals(all, turning):
    """Normals of particles, or how they turn, from the rows of all members."""
    total = all.turning if turning else all.normals
    sum_members(all.of_particle, all.row_of, all.of_normals, total)


@njit(**CALL)
def begin_stored(all, s):
    """Solid members of this rank get the displacement of their particle, for solids to say what
    they store.
    """
    table, D, d = all.table, all.state.D, len(all.like)
    begin, row, kind, at = table.begin, table.row, table.kind, table.at
    for p in range(begin.size - 1):
        for m in range(begin[p], begin[p + 1]):
            r = row[m]
            if r < at.size and kind[r] == SOLID:
                for c in range(d):
                    s[at[r] + c] = D[p, c]


@njit(**CALL)
def end_stored(all):
    """Mean specific heat of the solid members of each particle and mean of what they store."""
    weigh_heat(all.table, all.stored, all.state)


@njit(**CALL)
def weigh_heat(table, stored, state):
    """The same; stored: (rows, 1) energy per mass."""
    begin, row, kind, weight = table.begin, table.row, table.kind, table.weight
    alpha, capacity, potential = table.alpha, state.capacity, state.potential
    for p in range(begin.size - 1):
        mass, heat, energy = 0.0, 0.0, 0.0
        for m in range(begin[p], begin[p + 1]):
            r = row[m]
            if kind[r] == SOLID:
                mass += weight[r]
                heat += weight[r] * alpha[r]
                energy += weight[r] * stored[r, 0]
        if mass > 0.0:
            capacity[p], potential[p] = heat / mass, energy / mass


# constraints


@njit(**INLINED_CALL)
def solve(table, like, p, normals, wanted, M, M_s, a, b, room):
    """The vectors a of the gas and b of the solid, changed least in their masses so that G_c . a +
    S_c . b = wanted_c, for count[p] constraints. room: A, sizes of pivots; wanted becomes pi.
    """
    K, d, flags, (A, size) = table.count[p], len(like), table.flags, room
    per_gas = 1.0 / M if M > 0.0 and flags[p, FREE_GAS] else 0.0
    per_solid = 1.0 / M_s if M_s > 0.0 and flags[p, FREE_SOLID] else 0.0
    sticks = flags[p, STICKS] == 1
    if sticks:
        per_gas, per_solid = 1.0 / (M + M_s) if flags[p, FREE_GAS] else 0.0, 0.0
    for k in range(K):
        G, S = normal(like, normals, p, k, 0), normal(like, normals, p, k, d)
        G = add(G, S) if sticks else G
        wanted[k] -= dot(G, a) if sticks else dot(G, a) + dot(S, b)
        for i in range(K):
            G_i, S_i = normal(like, normals, p, i, 0), normal(like, normals, p, i, d)
            G_i = add(G_i, S_i) if sticks else G_i
            A[k, i] = dot(G, G_i) * per_gas + dot(S, S_i) * per_solid
    eliminate(K, A, wanted, size)
    for k in range(K):
        G, S = normal(like, normals, p, k, 0), normal(like, normals, p, k, d)
        a = along(a, wanted[k] * per_gas, add(G, S) if sticks else G)
        b = along(b, wanted[k] * per_solid, S)
    return a, a if sticks else b


@njit(**CALL)
def eliminate(K, A, x, size):
    """Solve A pi = x in place of x for K constraints and a symmetric semidefinite A; those that
    others imply get no force.
    """
    for k in range(K):
        size[k] = A[k, k]
    for k in range(K):
        if not A[k, k] > REDUNDANT * size[k]:
            size[k] = -1.0
            continue
        for e in range(k + 1, K):
            factor = A[e, k] / A[k, k]
            x[e] -= factor * x[k]
            for c in range(k, K):
                A[e, c] -= factor * A[k, c]
    for k in range(K - 1, -1, -1):
        if size[k] < 0.0:
            x[k] = 0.0
            continue
        for e in range(k + 1, K):
            x[k] -= A[k, e] * x[e]
        x[k] /= A[k, k]


@njit(**CALL)
def settle(all, s, gain):
    """What constraints and heat make of the sums, for the members of this rank; what came in is
    added behind the unknowns.
    """
    if all.slips:
        slide(all, gain)
    share_heat(all.table, all.law, all.like, all.data, all.state, gain)
    give_state(all.table, all.like, all.stored, s, all.state)
    came = sum_up(gain)
    for c in range(all.behind):
        s[s.size - all.behind + c] += came[c]


@njit(**INLINED_CALL)
def sum_up(gain):
    """The numbers of what came in, with the sum of energies."""
    numbers, energy, total = gain.numbers, gain.energy, gain.total
    total[0] = 0.0
    for c in range(energy.size):
        total[0] += energy[c]
    return numbers


@njit(**INLINED_CALL)
def slide(all, gain):
    """Project velocities on what the constraints allow; the kinetic energy that the solid loses
    goes to the gas.
    """
    table, like, normals, state = all.table, all.like, all.normals, all.state
    flags, count, constraint, wall = table.flags, table.count, table.constraint, all.data.wall
    mass, solid_mass, V, U, vs, e = state.mass, state.solid_mass, state.V, state.U, state.v, state.e
    d, K, impulse = len(like), normals.shape[1], gain.impulse
    pi, room = np.zeros(K), (np.zeros((K, K)), np.zeros(K))
    for p in range(count.size):
        if count[p] == 0:
            continue
        M, M_s, v = mass[p], solid_mass[p], node(like, vs, p)
        u = per(part_of(like, U, p, 1), U[p, 0]) if M > 0.0 else like
        for k in range(count[p]):
            pi[k] = 0.0
            if constraint[p, k] == SLIPS:
                G, S = normal(like, normals, p, k, 0), normal(like, normals, p, k, d)
                pi[k] = dot(add(G, S), node(like, wall, p))
        before = 0.5 * M_s * dot(v, v)
        u, v = solve(table, like, p, normals, pi, M, M_s, u, v, room)
        change = 0.5 * M_s * dot(v, v) - before
        for k in range(count[p] if flags[p, MINE] else 0):  # what forces do to bodies they move
            G, S = normal(like, normals, p, k, 0), normal(like, normals, p, k, d)
            for c in range(d):
                both = flags[p, FREE_GAS] * G[c] + flags[p, FREE_SOLID] * S[c]
                impulse[c] += pi[k] * both
        put_part(vs, p, 0, v)
        if M > 0.0:
            put_part(U, p, 1, scale(U[p, 0], u))
        if M_s > 0.0 and M > 0.0:
            e[p] += change / M_s
            U[p, d + 1] -= change / V[p]


@njit(**INLINED_CALL)
def share_heat(table, law, like, data, state, gain):
    """One temperature of gas and solid where both conduct, or that which is given."""
    d, flags, T_gas, T_solid = len(like), table.flags, data.T, data.T_solid
    mass, solid_mass, V, U, v, e = state.mass, state.solid_mass, state.V, state.U, state.v, state.e
    capacity, potential, faces = state.capacity, state.potential, table.faces
    energies, heats = gain.energy, gain.heat
    for p in range(mass.size):
        warm_gas, warm_solid = flags[p, WARM_GAS] == 1, flags[p, WARM_SOLID] == 1
        both = flags[p, SHARES_HEAT] == 1 and not warm_gas and not warm_solid
        if not (both or warm_gas or warm_solid):
            continue
        rho, M, M_s, mine = U[p, 0], mass[p], solid_mass[p], flags[p, MINE]
        u = per(part_of(like, U, p, 1), rho) if M > 0.0 else like
        of_gas = 0.5 * dot(u, u)
        of_solid = potential[p] + 0.5 * dot(node(like, v, p), node(like, v, p))
        if both:
            energy = U[p, d + 1] / rho
            heat = M * (energy - of_gas) + M_s * (e[p] - of_solid)
            T = (e[p] - of_solid) / capacity[p]
            T = common_temperature(law, rho, M, M_s * capacity[p], heat, T)
            sum_of_both = M * U[p, d + 1] / rho + M_s * e[p]  # it stays
            e[p] = of_solid + capacity[p] * T
            U[p, d + 1] = rho * (sum_of_both - M_s * e[p]) / M
        if warm_gas and M > 0.0:
            E = rho * (law.internal_energy(rho, T_gas[p]) + of_gas)
            came, at = mine * V[p] * (E - U[p, d + 1]), faces[p, HEATS_GAS]
            energies[at], heats[at] = energies[at] + came, heats[at] + came
            U[p, d + 1] = E
        if warm_solid and M_s > 0.0:
            found = of_solid + capacity[p] * T_solid[p]
            came, at = mine * M_s * (found - e[p]), faces[p, HEATS_SOLID]
            energies[at] += came
            heats[at] += came if flags[p, GIVEN_SOLID] == 0 else 0.0
            e[p] = found


@njit(**INLINED_CALL)
def common_temperature(law, rho, M, capacity, heat, T):
    """T at which a gas of mass M and a solid have this heat, by Newton's method from a first T."""
    for _ in range(20):
        missing = heat - M * law.internal_energy(rho, T) - capacity * T
        change = missing / (M * law.heat_capacity(rho, T) + capacity)
        T += change
        if not abs(change) > 1e-15 * abs(T):
            break
    return T


@njit(**INLINED_CALL)
def give_state(table, like, stored, y, state):
    """Members of this rank get what their particle has; each keeps its own J."""
    d, flags, begin, row, kind = len(like), table.flags, table.begin, table.row, table.kind
    starts, alpha, U, D, v, e = table.at, table.alpha, state.U, state.D, state.v, state.e
    potential, mean_energy, capacity = state.potential, state.mean_energy, state.capacity
    for p in range(begin.size - 1):
        kinetic = 0.5 * dot(node(like, v, p), node(like, v, p))
        heat = e[p] - kinetic - potential[p]
        for m in range(begin[p], begin[p + 1]):
            r = row[m]
            if r >= starts.size:
                continue
            at = starts[r]
            if kind[r] == GAS:
                for c in range(d + 2):
                    y[at + 1 + c] = y[at] * U[p, c]
                continue
            for c in range(d):
                y[at + c], y[at + d + c] = D[p, c], v[p, c]
            if flags[p, ONE_T]:
                y[at + 2 * d] = kinetic + stored[r, 0] + heat * alpha[r] / capacity[p]
            else:
                y[at + 2 * d] += e[p] - mean_energy[p]


@njit(**CALL)
def end_rates(all, y, f, gain):
    """Rates of members from the sums of their rates, under the constraints of their particles:
    (J U)_t = J U_t + U J_t of gas members; accelerations of solid ones, and their power.
    """
    table, like, rows, data, state = all.table, all.like, all.rows, all.data, all.state
    normals, turning, wall, wall_rate = all.normals, all.turning, data.wall, data.wall_rate
    flags, count, constraint, clamp_rate = (
        table.flags,
        table.count,
        table.constraint,
        data.clamp_rate,
    )
    mass, solid_mass, V, U, vs = state.mass, state.solid_mass, state.V, state.U, state.v
    begin, row, kind, starts, inertia = table.begin, table.row, table.kind, table.at, table.inertia
    d, K, lost, impulse = len(like), normals.shape[1], gain.lost, gain.impulse
    energies, faces = gain.energy, table.faces
    pi, room = np.zeros(K), (np.zeros((K, K)), np.zeros(K))
    for p in range(count.size):
        (J_t, R, R_m, R_E), (_, _, F, _) = summed(table, like, p, rows)
        M, M_s, v, w = mass[p], solid_mass[p], node(like, vs, p), node(like, wall, p)
        u = per(part_of(like, U, p, 1), U[p, 0]) if M > 0.0 else like
        a = per(sub(R_m, scale(R, u)), M) if M > 0.0 else like
        b = per(F, M_s) if M_s > 0.0 else like
        force, force_s = scale(-M, a), scale(-M_s, b)
        held, held_s, sticks = flags[p, HELD_GAS], flags[p, HELD_SOLID], flags[p, STICKS] == 1
        if held_s:
            b = node(like, clamp_rate, p)
        if held:
            a = node(like, wall_rate, p)
        if sticks:
            both = b if held_s else a
            if not (held_s or held):
                both = per(add(scale(M, a), scale(M_s, b)), M + M_s)
            a, b = both, both
        for k in range(count[p]):  # walls accelerate, area vectors turn under relative velocities
            pi[k] = 0.0
            if constraint[p, k] == SLIPS:
                at_solid = normal(like, turning, p, k, d)
                of_walls = add(normal(like, turning, p, k, 0), at_solid)
                N = add(normal(like, normals, p, k, 0), normal(like, normals, p, k, d))
                pi[k] = dot(at_solid, sub(u, v)) - dot(of_walls, sub(u, w))
                pi[k] += dot(N, node(like, wall_rate, p))
        if count[p] > 0:
            a, b = solve(table, like, p, normals, pi, M, M_s, a, b, room)
        force, force_s = along(force, M, a), along(force_s, M_s, b)
        power, of_solid = dot(force, u), 0.0
        if count[p] > 0 and flags[p, FREE_GAS] and not sticks:  # faces move as solid or wall there
            power = 0.0
            for k in range(count[p]):
                if constraint[p, k] == SLIPS:
                    S = normal(like, normals, p, k, d)
                    power += pi[k] * dot(add(normal(like, normals, p, k, 0), S), w)
                    of_solid -= pi[k] * dot(S, v)
        alone = not (flags[p, FREE_GAS] and flags[p, FREE_SOLID])
        if flags[p, MINE] and alone:  # what walls and clamps do
            for c in range(d):
                impulse[c] += force[c] + force_s[c]
            energies[faces[p, MOVES_GAS]] += power
            energies[faces[p, MOVES_SOLID]] += of_solid + dot(force_s, v)
        power += of_solid
        # else walls' own forces alone count: those between gas and solid must cancel
        for k in range(count[p] if flags[p, MINE] and not alone else 0):
            N = add(normal(like, normals, p, k, 0), normal(like, normals, p, k, d))
            for c in range(d):
                impulse[c] += pi[k] * N[c]
            slips = constraint[p, k] == SLIPS
            at = faces[p, MOVES_GAS if slips else MOVES_SOLID]
            energies[at] += pi[k] * dot(N, w if slips else v)
        momentum = add(R_m, force)
        rho_t, U_t, E_t = 0.0, like, 0.0
        if M > 0.0:
            rho_t, E_t = (R - U[p, 0] * J_t) / V[p], (R_E + power - U[p, d + 1] * J_t) / V[p]
            U_t = per(sub(momentum, scale(J_t, part_of(like, U, p, 1))), V[p])
        for m in range(begin[p], begin[p + 1]):
            r = row[m]
            if r >= starts.size:
                continue
            at = starts[r]
            if kind[r] == GAS:
                J, J_t = y[at], f[at]
                f[at + 1], f[at + d + 2] = J * rho_t + U[p, 0] * J_t, J * E_t + U[p, d + 1] * J_t
                for c in range(d):
                    f[at + 2 + c] = J * U_t[c] + U[p, 1 + c] * J_t
                continue
            for c in range(d):
                push = b[c] - f[at + d + c]
                f[at + d + c] += push
                f[at + 2 * d] += push * v[c]
                if inertia[r] > 0.0:
                    lost[0] += inertia[r] * push * v[c]
    came = sum_up(gain)
    for c in range(all.behind):
        f[f.size - all.behind + c] = came[c]


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
