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

    weigh, exchange, end_sums, impose_conditions     complete the unknowns
    weigh, exchange, end_rates                       complete their rates

What blocks say of their faces, an exchange and end_normals come before impose_conditions and the
rates where particles have constraints; begin_stored, what solids say of their members, an exchange
and weigh_heat before impose_conditions where stored energies matter.
"""

import numpy as np

from fsipetsc.operators.loops import njit
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
from fsipetsc.scheme.constraints import book, powers, right_sides, slide, solve
from fsipetsc.scheme.part import clear
from fsipetsc.scheme.particle_heat import for_each_law, share_heat
from fsipetsc.scheme.particle_records import GAS, SOLID

# Functions name arrays before their loops: where a record is asked within a loop, numba counts
# references to its arrays, which takes as long as all else.


@njit(**CALL)
def weigh(all, y):
    """Rows of this rank's members: H q of a gas, (M_s D, M_s v, M_s e) of a solid; or of rates."""
    table, rows, d = all.table, all.rows, len(all.like)
    kind, at, weight = table.kind, table.at, table.weight
    for r in range(at.size):
        for c in range(d + 3 if kind[r] == GAS else 2 * d + 1):
            rows[r, c] = weight[r] * y[at[r] + c]


@njit(**INLINED_CALL)
def summed(table, like, p, rows):
    """(V, M, P, E) of the gas and (M_s, M_s D, M_s v, M_s e) of the solid of particle p."""
    begin, row, kind, weight, d = table.begin, table.row, table.kind, table.weight, len(like)
    V, M, P, E, M_s, D, P_s, E_s = 0.0, 0.0, like, 0.0, 0.0, like, like, 0.0
    for m in range(begin[p], begin[p + 1]):
        r = row[m]
        if kind[r] == GAS:
            V, M, E = V + rows[r, 0], M + rows[r, 1], E + rows[r, d + 2]
            P = add(P, part_of(like, rows, r, 2))
        else:
            M_s, E_s = M_s + weight[r], E_s + rows[r, 2 * d]
            D, P_s = add(D, node(like, rows, r)), add(P_s, part_of(like, rows, r, d))
    return (V, M, P, E), (M_s, D, P_s, E_s)


@njit(**INLINED_CALL)
def kinetic(P, M):
    """Energy of a body with this momentum."""
    return 0.5 * dot(P, P) / M if M > 0.0 else 0.0


@njit(**CALL)
def end_sums(all, gain):
    """From the sums of all members: one U, one displacement and velocity; what sticks has one
    velocity, and the kinetic energy that the solid loses by that goes to the gas. What comes in
    begins here.
    """
    clear(gain.numbers)
    table, like, rows, data, state = all.table, all.like, all.rows, all.data, all.state
    facts, d = table.facts, len(like)
    masses, impulse, energies = gain.mass, gain.impulse, gain.energy
    mass, solid_mass, V_of, U, e = state.mass, state.solid_mass, state.V, state.U, state.e
    D_of, v, mean_energy = state.D, state.v, state.mean_energy
    for p in range(facts.size):
        one = facts[p]
        of_gas, of_solid = summed(table, like, p, rows)
        (V, M, P, E), (M_s, D, P_s, E_s) = obeyed(one, like, p, data, of_gas, of_solid)
        mass[p], V_of[p], solid_mass[p] = M, V, M_s
        if V > 0.0:
            U[p, 0], U[p, d + 1] = M / V, E / V
            put_part(U, p, 1, per(P, V))
        if M_s > 0.0:
            mean_energy[p], e[p] = of_solid[3] / M_s, E_s / M_s
            put_part(v, p, 0, per(P_s, M_s))
            put_part(D_of, p, 0, D)
        given = one.given_gas or one.given_solid
        if one.mine and (one.at_wall or one.clamped or given):
            if V > 0.0:
                masses[one.column] += M - of_gas[1]
            push = add(sub(P, of_gas[2]), sub(P_s, of_solid[2]))
            for c in range(d):
                impulse[c] += push[c]
            energies[one.moves_gas] += (E - of_gas[3]) + (E_s - of_solid[3])


@njit(**INLINED_CALL)
def obeyed(one, like, p, data, of_gas, of_solid):
    """The sums of particle p with the mean displacement in place of its sum, as walls, clamps and
    data have them.
    """
    (V, M, P, E), (M_s, D, P_s, E_s) = of_gas, of_solid
    d, wall, clamp, clamp_velocity = len(like), data.wall, data.clamp, data.clamp_velocity
    gas, solid, moved = data.gas, data.solid, one.clamped or one.given_solid
    if M_s > 0.0:
        D = per(D, M_s)
    if one.clamped:
        P_s = scale(M_s, node(like, clamp_velocity, p))
    if one.placed:
        D = node(like, clamp, p)
    if one.given_solid:
        D, P_s = node(like, solid, p), scale(M_s, part_of(like, solid, p, d))
    if one.at_wall:
        P = scale(M, node(like, wall, p))
    if one.sticks:
        both = per(P_s, M_s) if moved else per(add(P, P_s), M + M_s)
        first, P, P_s = kinetic(P_s, M_s), scale(M, both), scale(M_s, both)
        if not moved:
            change = kinetic(P_s, M_s) - first
            E, E_s = E - change, E_s + change
    if one.given_gas:
        M, P, E = V * gas[p, 0], scale(V, part_of(like, gas, p, 1)), V * gas[p, d + 1]
    return (V, M, P, E), (M_s, D, P_s, E_s)


# normals, and what members store


@njit(**CALL)
def end_normals(all, turning):
    """Normals of particles, or how they turn, from the rows of all members, which are cleared."""
    total, table = all.turning if turning else all.normals, all.of_normals
    particle, row = all.of_particle, all.row_of
    total[:] = 0.0
    for m in range(particle.size):
        for c in range(table.shape[1]):
            total[particle[m], c] += table[row[m], c]
    table[:] = 0.0


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


# constraints


@njit(**CALL)
def impose_conditions(all, s, gain):
    """What constraints and heat make of the sums, for the members of this rank; what came in is
    added to the auxiliary unknowns.
    """
    if all.slips:
        slide(all, gain)
    for_each_law(share_heat, all.laws, all, gain)
    give_state(all.table, all.like, all.stored, s, all.state)
    came = sum_up(gain)
    for c in range(all.auxiliary):
        s[s.size - all.auxiliary + c] += came[c]


@njit(**INLINED_CALL)
def sum_up(gain):
    """The numbers of what came in, with the sum of energies."""
    numbers, energy, total = gain.numbers, gain.energy, gain.total
    total[0] = 0.0
    for c in range(energy.size):
        total[0] += energy[c]
    return numbers


@njit(**INLINED_CALL)
def give_state(table, like, stored, y, state):
    """Members of this rank get what their particle has; each keeps its own J."""
    d, facts, begin, row, kind = len(like), table.facts, table.begin, table.row, table.kind
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
            if facts[p].one_T:
                y[at + 2 * d] = kinetic + stored[r, 0] + heat * alpha[r] / capacity[p]
            else:
                y[at + 2 * d] += e[p] - mean_energy[p]


@njit(**CALL)
def end_rates(all, y, f, gain):
    """Rates of members from the sums of their rates, under the constraints of their particles."""
    accelerate(all, gain)
    give_rates(all.table, all.like, y, f, all.state, gain.lost)
    came = sum_up(gain)
    for c in range(all.auxiliary):
        f[f.size - all.auxiliary + c] = came[c]


@njit(**INLINED_CALL)
def accelerate(all, gain):
    """U_t of the gas and acceleration of the solid of each particle."""
    table, like, rows, data, state = all.table, all.like, all.rows, all.data, all.state
    normals, turning, wall, wall_rate = all.normals, all.turning, data.wall, data.wall_rate
    facts, constraint = table.facts, table.constraint
    mass, solid_mass, V, U, vs = state.mass, state.solid_mass, state.V, state.U, state.v
    U_t, acceleration, clamp_rate = state.U_t, state.acceleration, data.clamp_rate
    d, K = len(like), constraint.shape[1]
    pi, room = np.zeros(K), (np.zeros((K, K)), np.zeros(K))
    for p in range(facts.size):
        one = facts[p]
        (J_t, R, R_m, R_E), (_, _, F, _) = summed(table, like, p, rows)
        M, M_s, v, w = mass[p], solid_mass[p], node(like, vs, p), node(like, wall, p)
        u = per(part_of(like, U, p, 1), U[p, 0]) if M > 0.0 else like
        a = per(sub(R_m, scale(R, u)), M) if M > 0.0 else like
        b = per(F, M_s) if M_s > 0.0 else like
        force, force_s = scale(-M, a), scale(-M_s, b)
        b = node(like, clamp_rate, p) if one.clamped else b
        a = node(like, wall_rate, p) if one.at_wall else a
        if one.sticks:
            a = b if one.clamped else per(add(scale(M, a), scale(M_s, b)), M + M_s)
            b = a
        if one.count > 0:
            w_t = node(like, wall_rate, p)
            right_sides(one, like, p, normals, turning, constraint, u, v, w, w_t, pi)
            a, b = solve(one, like, p, normals, pi, M, M_s, a, b, room)
        force, force_s = along(force, M, a), along(force_s, M_s, b)
        power, of_solid = powers(one, like, p, normals, constraint, pi, force, u, v, w)
        if one.mine:
            forces = force, force_s, power, of_solid
            book(one, like, p, normals, constraint, pi, v, w, *forces, gain)
        power += of_solid
        put_part(acceleration, p, 0, b)
        if M > 0.0:
            momentum = sub(add(R_m, force), scale(J_t, part_of(like, U, p, 1)))
            put_part(U_t, p, 1, per(momentum, V[p]))
            U_t[p, 0] = (R - U[p, 0] * J_t) / V[p]
            U_t[p, d + 1] = (R_E + power - U[p, d + 1] * J_t) / V[p]


@njit(**INLINED_CALL)
def give_rates(table, like, y, f, state, lost):
    """(J U)_t = J U_t + U J_t of gas members; accelerations of solid ones, and their power."""
    d, begin, row, kind, starts = len(like), table.begin, table.row, table.kind, table.at
    inertia, U, U_t, b, v = table.inertia, state.U, state.U_t, state.acceleration, state.v
    for p in range(begin.size - 1):
        for m in range(begin[p], begin[p + 1]):
            r = row[m]
            if r >= starts.size:
                continue
            at = starts[r]
            if kind[r] == GAS:
                J, J_t = y[at], f[at]
                for c in range(d + 2):
                    f[at + 1 + c] = J * U_t[p, c] + U[p, c] * J_t
                continue
            for c in range(d):
                push = b[p, c] - f[at + d + c]
                f[at + d + c] += push
                f[at + 2 * d] += push * v[p, c]
                if inertia[r] > 0.0:
                    lost[0] += inertia[r] * push * v[p, c]
