"""Particles: sums over members, constraints by Gauss's principle, and what each member gets back.

Compiled. Gas members of a particle share U = (rho, rho u, E), solid members share displacement and
velocity, and have one temperature or each its own. With the sums

    gas    V = sum H J,  M = sum H J rho,  P = sum H J rho u,  E = sum H J e
    solid  M_s = sum H J0 m0,  and those of M_s times displacement, velocity, energy per mass e_s

`share` gives all members what follows from the sums; sums are linear in the unknowns, so that a
Runge-Kutta method keeps them. `constrain` does the same for rates. With a_g = (R_m - u R_rho)/M and
a_s = F/M_s the accelerations without constraints, it minimises

    1/2 M |a_g' - a_g|^2 + 1/2 M_s |a_s' - a_s|^2     where     G_c . a_g' + S_c . a_s' = b_c:

forces pi_c G_c on the gas and pi_c S_c on the solid, with pi from the symmetric system

    sum_e (G_c . G_e / M + S_c . S_e / M_s) pi_e  =  b_c - G_c . a_g - S_c . a_s.

G_c is the sum of the area vectors of gas faces, S_c minus that of those at a solid, so that G_c +
S_c is the sum over walls: what they push comes in from outside. Sticking gas and solid are one body
of mass M + M_s. A body whose motion is given counts as infinitely heavy.

What comes in is added to ``gain``: masses of the gas blocks, work on solids if it is booked,
impulse (d), energy. Constraints tell it by their forces, data that replace unknowns by the change.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fsipetsc.blocks.particles import SLIPS
from fsipetsc.operators.loops import CALL, MERGED_CALL

Array = NDArray[Any]

GAS, SOLID = 0, 1
#: a pivot below this part of its size before elimination belongs to a constraint that others imply
REDUNDANT = 1e-9


class Table(NamedTuple):
    """Particles on a rank. Rows are members; those of this rank come first, in any order.

    begin: (p + 1,), rows of particle p are row[begin[p]:begin[p + 1]], in the order that all ranks
    have. kind: (rows,) GAS or SOLID. at: (own,) where the unknowns of a member begin in the world's
    vector. weight: (rows,) H of a gas member, M_s of a solid one; alpha: (rows,) specific heat of
    solids. inertia: (own,) M_s of members whose work is booked, else 0. count: (p,) number of
    constraints; constraint: (p, K) their kinds. column: (p,) where the mass of the gas is in
    ``gain``. flags: (p, FLAGS) 1 or 0 for each of MINE …, see fsipetsc.blocks.particles.

    Functions name arrays before their loops: where a record is asked within a loop, numba counts
    references to its arrays, which takes as long as all else.
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
    flags: Array


#: this rank adds what comes in; forces move the gas, the solid; a clamp gives the place; gas and
#: solid stick; motion of the gas, of the solid is given, all of the gas, of the solid; temperature
#: of the gas, of the solid; they have one; so have members of the solid
MINE, FREE_GAS, FREE_SOLID, PLACED, STICKS, HELD_GAS, HELD_SOLID, GIVEN_GAS, GIVEN_SOLID = range(9)
WARM_GAS, WARM_SOLID, SHARES_HEAT, ONE_T = range(9, 13)
FLAGS = 13


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
    """What `share` found, for each particle: mass of gas and solid (p,), V (p,), U of the gas (p, d
    + 2), displacement D and velocity v (p, d) and energy per mass e (p,) of the solid. mean_energy:
    (p,) that of its members before a change. capacity, potential: (p,) mean specific heat and mean
    energy per mass that is neither kinetic nor heat, of the solid.
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


@njit(**MERGED_CALL)
def fill_state(table, like, y, out):
    """Rows of this rank's members: H q of a gas, (M_s D, M_s v, M_s e, M_s) of a solid."""
    d, kind, at, weight = len(like), table.kind, table.at, table.weight
    for r in range(at.size):
        gas = kind[r] == GAS
        for c in range(d + 3 if gas else 2 * d + 1):
            out[r, c] = weight[r] * y[at[r] + c]
        if not gas:
            out[r, 2 * d + 1] = weight[r]


@njit(**MERGED_CALL)
def fill_rates(table, like, f, out):
    """The same of rates."""
    d, kind, at, weight = len(like), table.kind, table.at, table.weight
    for r in range(at.size):
        for c in range(d + 3 if kind[r] == GAS else 2 * d + 1):
            out[r, c] = weight[r] * f[at[r] + c]


@njit(**MERGED_CALL)
def _add(members, like, p, rows, gas, solid):
    """Sums over the members of particle p; gas: (d + 3,), solid: (2d + 2,). Loops over numbers of a
    node know how many there are: else they would take five times as long.
    """
    d, (begin, row, kind) = len(like), members
    for c in range(d + 3):
        gas[c] = 0.0
    for c in range(2 * d + 2):
        solid[c] = 0.0
    for m in range(begin[p], begin[p + 1]):
        r = row[m]
        if kind[r] == GAS:
            for c in range(d + 3):
                gas[c] += rows[r, c]
        else:
            for c in range(2 * d + 2):
                solid[c] += rows[r, c]


@njit(**MERGED_CALL)
def _kinetic(like, P, first, M):
    total = 0.0
    for c in range(len(like)):
        total += P[first + c] * P[first + c]
    return 0.5 * total / M if M > 0.0 else 0.0


@njit(**MERGED_CALL)
def share(table, like, rows, data, state, gain):
    """From the sums in ``rows``: one U, one displacement and velocity; what sticks has one
    velocity, and the kinetic energy that the solid loses by that goes to the gas.
    """
    d, flags, column = len(like), table.flags, table.column
    members, begin = (table.begin, table.row, table.kind), table.begin
    solid_mass, mean_energy, D = state.solid_mass, state.mean_energy, state.D
    gas, solid = np.zeros(d + 3), np.zeros(2 * d + 2)
    before, before_s = np.zeros(d + 3), np.zeros(2 * d + 2)
    for p in range(begin.size - 1):
        _add(members, like, p, rows, gas, solid)
        _add(members, like, p, rows, before, before_s)
        M_s = solid[2 * d + 1]
        solid_mass[p] = M_s
        if M_s > 0.0:
            mean_energy[p] = solid[2 * d] / M_s
            for c in range(d):
                D[p, c] = solid[c] / M_s
        _hold_velocities(flags, like, p, data, gas, solid)
        if flags[p, PLACED]:
            for c in range(d):
                D[p, c] = data.clamp[p, c]
        if flags[p, GIVEN_GAS]:
            for c in range(d + 2):
                gas[1 + c] = gas[0] * data.gas[p, c]
        if flags[p, GIVEN_SOLID]:
            for c in range(d):
                D[p, c], solid[d + c] = data.solid[p, c], M_s * data.solid[p, d + c]
        _put(state, like, p, gas, solid)
        given = flags[p, GIVEN_GAS] or flags[p, GIVEN_SOLID]
        if flags[p, MINE] and (flags[p, HELD_GAS] or flags[p, HELD_SOLID] or given):
            gain[column[p]] += gas[1] - before[1]
            for c in range(d):
                change = (gas[2 + c] - before[2 + c]) + (solid[d + c] - before_s[d + c])
                gain[gain.size - 1 - d + c] += change
            change = (gas[d + 2] - before[d + 2]) + (solid[2 * d] - before_s[2 * d])
            gain[gain.size - 1] += change


@njit(**MERGED_CALL)
def _hold_velocities(flags, like, p, data, gas, solid):
    """Momenta of bodies whose motion is given, and of what sticks together."""
    d = len(like)
    M, M_s = gas[1], solid[2 * d + 1]
    if flags[p, HELD_SOLID]:
        for c in range(d):
            solid[d + c] = M_s * data.clamp_velocity[p, c]
    if flags[p, HELD_GAS]:
        for c in range(d):
            gas[2 + c] = M * data.wall[p, c]
    if flags[p, STICKS]:
        before = _kinetic(like, solid, d, M_s)
        for c in range(d):
            P, P_s = gas[2 + c], solid[d + c]
            both = P_s / M_s if flags[p, HELD_SOLID] else (P + P_s) / (M + M_s)
            if flags[p, HELD_GAS] and not flags[p, HELD_SOLID]:
                both = data.wall[p, c]
            gas[2 + c], solid[d + c] = M * both, M_s * both
        if not flags[p, HELD_SOLID]:
            change = _kinetic(like, solid, d, M_s) - before
            solid[2 * d] += change
            gas[2 + d] -= change


@njit(**MERGED_CALL)
def _put(state, like, p, gas, solid):
    d = len(like)
    state.V[p], state.mass[p] = gas[0], gas[1]
    if gas[0] > 0.0:
        for c in range(d + 2):
            state.U[p, c] = gas[1 + c] / gas[0]
    M_s = solid[2 * d + 1]
    if M_s > 0.0:
        state.e[p] = solid[2 * d] / M_s
        for c in range(d):
            state.v[p, c] = solid[d + c] / M_s


@njit(**MERGED_CALL)
def slide(table, like, normals, data, state, gain):
    """Project velocities on what the constraints allow; the kinetic energy that the solid loses
    goes to the gas. normals: (p, K, 2d), G and S.
    """
    d, flags, count = len(like), table.flags, table.count
    K = normals.shape[1]
    u, v, wanted, room = np.zeros(d), np.zeros(d), np.zeros(K), room_for(K, d)
    for p in range(count.size):
        if count[p] == 0:
            continue
        M, M_s = state.mass[p], state.solid_mass[p]
        before = 0.0
        for c in range(d):
            u[c] = state.U[p, 1 + c] / state.U[p, 0] if M > 0.0 else 0.0
            v[c] = state.v[p, c]
            before += 0.5 * M_s * v[c] * v[c]
        for k in range(table.count[p]):
            wanted[k] = 0.0
            if table.constraint[p, k] == SLIPS:
                for c in range(d):
                    wanted[k] += (normals[p, k, c] + normals[p, k, d + c]) * data.wall[p, c]
        solve(table, like, p, normals, wanted, M, M_s, u, v, room)
        after = 0.0
        for c in range(d):
            after += 0.5 * M_s * v[c] * v[c]
            if flags[p, MINE]:
                gain[gain.size - 1 - d + c] += _pushed(table, p, normals, room[1], c, d)
            state.v[p, c] = v[c]
            if M > 0.0:
                state.U[p, 1 + c] = state.U[p, 0] * u[c]
        if M_s > 0.0 and M > 0.0:
            state.e[p] += (after - before) / M_s
            state.U[p, d + 1] -= (after - before) / state.V[p]


@njit(**MERGED_CALL)
def _pushed(table, p, normals, pi, c, d):
    """Component c of what the constraints' forces pi do to bodies that they move."""
    total, flags = 0.0, table.flags
    for k in range(table.count[p]):
        on_gas, on_solid = normals[p, k, c], normals[p, k, d + c]
        both = flags[p, FREE_GAS] * on_gas + flags[p, FREE_SOLID] * on_solid
        total += pi[k] * both
    return total


@njit(**MERGED_CALL)
def room_for(K, d):
    """Room for `solve` with at most K constraints: A, multipliers pi, sizes of pivots, G and S."""
    return np.zeros((K, K)), np.zeros(K), np.zeros(K), np.zeros((K, 2 * d))


@njit(**MERGED_CALL)
def solve(table, like, p, normals, wanted, M, M_s, a, b, room):
    """Change the vectors a of the gas and b of the solid, least in their masses, so that
    G_c . a + S_c . b = wanted_c; the multipliers are room[1].
    """
    K, d, flags = table.count[p], len(like), table.flags
    per_gas = 1.0 / M if M > 0.0 and flags[p, FREE_GAS] else 0.0
    per_solid = 1.0 / M_s if M_s > 0.0 and flags[p, FREE_SOLID] else 0.0
    A, pi, N = room[0], room[1], room[3]
    sticks = flags[p, STICKS] == 1
    if sticks:
        per_gas = 1.0 / (M + M_s) if flags[p, FREE_GAS] else 0.0
    for k in range(K):
        pi[k] = wanted[k]
        for c in range(d):
            on_gas, on_solid = normals[p, k, c], normals[p, k, d + c]
            N[k, c] = on_gas + on_solid if sticks else on_gas
            N[k, d + c] = 0.0 if sticks else on_solid
            pi[k] -= N[k, c] * a[c] + N[k, d + c] * b[c]
    for k in range(K):
        for e in range(K):
            A[k, e] = 0.0
            for c in range(d):
                A[k, e] += N[k, c] * N[e, c] * per_gas + N[k, d + c] * N[e, d + c] * per_solid
    eliminate(K, A, pi, room[2])
    for c in range(d):
        for k in range(K):
            a[c] += pi[k] * N[k, c] * per_gas
            b[c] += pi[k] * N[k, d + c] * per_solid
        if sticks:
            b[c] = a[c]


@njit(**MERGED_CALL)
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
def weigh_heat(table, stored, state):
    """Mean specific heat of the solid members of each particle and mean of what they store: (rows,
    1) energy per mass.
    """
    for p in range(table.begin.size - 1):
        mass, capacity, potential = 0.0, 0.0, 0.0
        for m in range(table.begin[p], table.begin[p + 1]):
            r = table.row[m]
            if table.kind[r] == SOLID:
                mass += table.weight[r]
                capacity += table.weight[r] * table.alpha[r]
                potential += table.weight[r] * stored[r, 0]
        if mass > 0.0:
            state.capacity[p], state.potential[p] = capacity / mass, potential / mass


@njit(**MERGED_CALL)
def share_heat(table, law, like, data, state, gain):
    """One temperature of gas and solid where both conduct, or that which is given. law: of the gas.
    """
    d, flags = len(like), table.flags
    for p in range(table.begin.size - 1):
        warm_gas, warm_solid = flags[p, WARM_GAS] == 1, flags[p, WARM_SOLID] == 1
        both = flags[p, SHARES_HEAT] == 1 and not warm_gas and not warm_solid
        if not (both or warm_gas or warm_solid):
            continue
        rho, M, M_s = state.U[p, 0], state.mass[p], state.solid_mass[p]
        of_gas, of_solid = 0.0, state.potential[p]
        for c in range(d):
            if M > 0.0:
                of_gas += 0.5 * (state.U[p, 1 + c] / rho) ** 2
            of_solid += 0.5 * state.v[p, c] ** 2
        if both:
            T = _common_temperature(law, p, of_gas, of_solid, state)
            sum_of_both = M * state.U[p, d + 1] / rho + M_s * state.e[p]  # it stays
            state.e[p] = of_solid + state.capacity[p] * T
            state.U[p, d + 1] = rho * (sum_of_both - M_s * state.e[p]) / M
        came = 0.0
        if warm_gas and M > 0.0:
            E = rho * (law.internal_energy(rho, data.T[p]) + of_gas)
            came += state.V[p] * (E - state.U[p, d + 1])
            state.U[p, d + 1] = E
        if warm_solid and M_s > 0.0:
            e = of_solid + state.capacity[p] * data.T_solid[p]
            came += M_s * (e - state.e[p])
            state.e[p] = e
        if flags[p, MINE]:
            gain[gain.size - 1] += came


@njit(**MERGED_CALL)
def _common_temperature(law, p, of_gas, of_solid, state):
    """T at which gas and solid have the heat that they have together, by Newton's method."""
    rho, M, M_s = state.U[p, 0], state.mass[p], state.solid_mass[p]
    energy = state.U[p, state.U.shape[1] - 1] / rho
    heat = M * (energy - of_gas) + M_s * (state.e[p] - of_solid)
    capacity = M_s * state.capacity[p]
    T = (state.e[p] - of_solid) / state.capacity[p]
    for _ in range(20):
        missing = heat - M * law.internal_energy(rho, T) - capacity * T
        change = missing / (M * law.heat_capacity(rho, T) + capacity)
        T += change
        if not abs(change) > 1e-15 * abs(T):
            break
    return T


@njit(**CALL)
def give_places(table, like, y, state):
    """Solid members of this rank get the displacement of their particle."""
    d = len(like)
    for p in range(table.begin.size - 1):
        for m in range(table.begin[p], table.begin[p + 1]):
            r = table.row[m]
            if r < table.at.size and table.kind[r] == SOLID:
                for c in range(d):
                    y[table.at[r] + c] = state.D[p, c]


@njit(**MERGED_CALL)
def give_state(table, like, stored, y, state):
    """Members of this rank get what their particle has; each keeps its own J. stored: (rows, 1)."""
    d, flags, begin, row, kind = len(like), table.flags, table.begin, table.row, table.kind
    starts, alpha, U, D, v, e = table.at, table.alpha, state.U, state.D, state.v, state.e
    potential, mean_energy, capacity = state.potential, state.mean_energy, state.capacity
    for p in range(begin.size - 1):
        kinetic = 0.0
        for c in range(d):
            kinetic += 0.5 * v[p, c] ** 2
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


@njit(**MERGED_CALL)
def constrain(table, like, rows, normals, turning, data, state, rates, gain):
    """Rates of particles from sums of members' rates in ``rows``, under their constraints.

    normals, turning: (p, K, 2d), G and S and how they turn. rates: (p, 2d + 2): of (rho, rho u, E)
    of the gas, then accelerations of the solid.
    """
    d, flags, count = len(like), table.flags, table.count
    members, K = (table.begin, table.row, table.kind), normals.shape[1]
    masses, solid_masses, volumes, U, vs = state.mass, state.solid_mass, state.V, state.U, state.v
    gas, solid = np.zeros(d + 3), np.zeros(2 * d + 2)
    u, v, a, b, wanted = np.zeros(d), np.zeros(d), np.zeros(d), np.zeros(d), np.zeros(K)
    force, force_s, room = np.zeros(d), np.zeros(d), room_for(K, d)
    for p in range(count.size):
        _add(members, like, p, rows, gas, solid)
        M, M_s, V = masses[p], solid_masses[p], volumes[p]
        for c in range(d):
            u[c] = U[p, 1 + c] / U[p, 0] if M > 0.0 else 0.0
            v[c] = vs[p, c]
            a[c] = (gas[2 + c] - u[c] * gas[1]) / M if M > 0.0 else 0.0
            b[c] = solid[d + c] / M_s if M_s > 0.0 else 0.0
            force[c], force_s[c] = -M * a[c], -M_s * b[c]
        _hold(flags, like, p, data, M, M_s, a, b)
        if count[p] > 0:
            _want(table, like, p, normals, turning, data, u, v, wanted)
            solve(table, like, p, normals, wanted, M, M_s, a, b, room)
        of_rows = count[p] > 0 and flags[p, FREE_GAS] and not flags[p, STICKS]
        power, power_s = 0.0, 0.0
        if of_rows:
            power = _power(table, like, p, normals, room[1], data, v)
        for c in range(d):
            force[c] += M * a[c]
            force_s[c] += M_s * b[c]
            power_s += force_s[c] * v[c]
            gas[2 + c] += force[c]
            if not of_rows:
                power += force[c] * u[c]
        if flags[p, MINE]:
            pushes = force, force_s, power + power_s
            _note_forces(table, like, p, normals, room[1], data, v, pushes, gain)
        if M > 0.0:
            gas[2 + d] += power
            for c in range(d + 2):
                rates[p, c] = (gas[1 + c] - U[p, c] * gas[0]) / V
        for c in range(d):
            rates[p, d + 2 + c] = b[c]


@njit(**MERGED_CALL)
def _hold(flags, like, p, data, M, M_s, a, b):
    """Accelerations of bodies whose motion is given, and of what sticks together."""
    for c in range(len(like)):
        if flags[p, HELD_SOLID]:
            b[c] = data.clamp_rate[p, c]
        if flags[p, HELD_GAS]:
            a[c] = data.wall_rate[p, c]
        if flags[p, STICKS]:
            if flags[p, HELD_SOLID]:
                a[c] = b[c]
            elif flags[p, HELD_GAS]:
                b[c] = a[c]
            else:
                a[c] = b[c] = (M * a[c] + M_s * b[c]) / (M + M_s)


@njit(**MERGED_CALL)
def _want(table, like, p, normals, turning, data, u, v, wanted):
    """b_c: walls accelerate, and area vectors turn under the relative velocity."""
    d = len(like)
    for k in range(table.count[p]):
        wanted[k] = 0.0
        if table.constraint[p, k] == SLIPS:
            for c in range(d):
                at_solid, of_walls = -turning[p, k, d + c], turning[p, k, c] + turning[p, k, d + c]
                wanted[k] -= at_solid * (u[c] - v[c]) + of_walls * (u[c] - data.wall[p, c])
                N = normals[p, k, c] + normals[p, k, d + c]
                wanted[k] += N * data.wall_rate[p, c]


@njit(**MERGED_CALL)
def _power(table, like, p, normals, pi, data, v):
    """Of the forces on gas that slips: each face's moves as the solid or the wall there."""
    d, power = len(like), 0.0
    for k in range(table.count[p]):
        if table.constraint[p, k] == SLIPS:
            for c in range(d):
                at_solid, of_walls = -normals[p, k, d + c], normals[p, k, c] + normals[p, k, d + c]
                power += pi[k] * (at_solid * v[c] + of_walls * data.wall[p, c])
    return power


@njit(**MERGED_CALL)
def _note_forces(table, like, p, normals, pi, data, v, pushes, gain):
    """What walls and clamps do to a particle. Where all is free to move, only walls' own forces
    count: those between gas and solid must cancel.
    """
    d, (force, force_s, power) = len(like), pushes
    flags, begin, end = table.flags, gain.size - 1 - d, gain.size - 1
    if not (flags[p, FREE_GAS] and flags[p, FREE_SOLID]):
        for c in range(d):
            gain[begin + c] += force[c] + force_s[c]
        gain[end] += power
        return
    for k in range(table.count[p]):
        slips = table.constraint[p, k] == SLIPS
        for c in range(d):
            push = pi[k] * (normals[p, k, c] + normals[p, k, d + c])
            gain[begin + c] += push
            gain[end] += push * (data.wall[p, c] if slips else v[c])


@njit(**MERGED_CALL)
def give_rates(table, like, y, f, state, rates, gain):
    """(J U)_t = J U_t + U J_t of gas members; accelerations of solid ones, and their power."""
    d, begin, row, kind, starts = len(like), table.begin, table.row, table.kind, table.at
    inertia, work = table.inertia, gain.size - 2 - d
    U, v = state.U, state.v
    for p in range(begin.size - 1):
        for m in range(begin[p], begin[p + 1]):
            r = row[m]
            if r >= starts.size:
                continue
            at = starts[r]
            if kind[r] == GAS:
                for c in range(d + 2):
                    f[at + 1 + c] = y[at] * rates[p, c] + U[p, c] * f[at]
            else:
                for c in range(d):
                    force = rates[p, d + 2 + c] - f[at + d + c]
                    f[at + d + c] += force
                    f[at + 2 * d] += force * v[p, c]
                    if inertia[r] > 0.0:
                        gain[work] += inertia[r] * force * v[p, c]
