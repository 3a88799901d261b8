"""Particles: sums over members, and what each member gets back (docs/derivation.md).

Gas members of a particle share U = (rho, rho u, E), solid members share displacement and
velocity, and have one temperature or each its own. With the sums

    gas    V = sum H J,  M = sum H J rho,  P = sum H J rho u,  E = sum H J e
    solid  M_s = sum H J0 m0,  and those of M_s times displacement, velocity, energy per mass e_s

`end_sums` finds what all members have in common; sums are linear in the unknowns, so that a
Runge-Kutta method keeps them. `end_rates` does the same for rates. To record.gain
(fsipetsc.scheme.part) goes the work of constraints, and the change of unknowns that data replace.
"""

import numpy as np

from fsipetsc.equations.vectors import add, choose, dot, per, scale, sub
from fsipetsc.kernels.loops import each, otherwise, pick, row, variable, when
from fsipetsc.particles import constraints
from fsipetsc.particles.members import GAS, SOLID


def weigh(record, y):
    """Rows of this rank's members: H q of gas, (M_s D, M_s v, M_s e) of a solid; or their rates."""
    rows, d = record.rows, record.d
    for _, r, at in own_members(record):
        weight = record.weight[r]
        for c in each(pick(record.kind[r] == GAS, d + 3, 2 * d + 1)):
            rows[r, c] = weight * y[at(c)]


def summed(record, p):
    """(V, M, P, E) of the gas and M_s (D, v, e) of the solid of particle p."""
    rows, d = record.rows, record.d
    gas, solid = ([variable() for _ in range(n)] for n in (d + 3, 2 * d + 1))
    for r in each(record.begin[p], record.begin[p + 1]):
        with when(record.kind[r] == GAS):
            for c in range(d + 3):
                gas[c].value += rows[r, c]
        with otherwise():
            for c in range(2 * d + 1):
                solid[c].value += rows[r, c]
    (V, M, *P, E), (*Ds, E_s) = constraints.value_of(gas), constraints.value_of(solid)
    return (V, M, tuple(P), E), (tuple(Ds[:d]), tuple(Ds[d:]), E_s)


def kinetic(P, M):
    return np.where(M > 0.0, 0.5 * dot(P, P) / M, 0.0)


def end_sums(record):
    """Find from the sums of all members one U, one displacement and velocity. Gas and solid that
    stick have one velocity, and the gas gets the kinetic energy that the solid loses by that.
    """
    gain = record.gain
    gain.numbers[:] = 0.0
    for p, one in constraints.every(record):
        (of_gas, of_solid), M_s = summed(record, p), record.solid_mass[p]
        (V, M, P, E), (D, P_s, E_s) = obeyed(record, p, one, of_gas, of_solid)
        record.mass[p], record.V[p] = M, V
        with when(V > 0.0):
            record.U[p] = M / V, *per(P, V), E / V
        with when(M_s > 0.0):
            record.mean_energy[p], record.e[p] = of_solid[2] / M_s, E_s / M_s
            record.v[p] = per(P_s, M_s)
            record.D[p] = D
        with when(one.mine & (one.wall | one.clamp | one.given_gas | one.given_solid)):
            with when(V > 0.0):
                gain.mass[one.column] += M - of_gas[1]
            constraints.accumulate(gain.impulse, add(sub(P, of_gas[2]), sub(P_s, of_solid[1])))
            gain.energy[one.moves_gas] += (E - of_gas[3]) + (E_s - of_solid[2])


def obeyed(record, p, one, of_gas, of_solid):
    """The sums of particle p, as walls, clamps and data have them; D is the mean displacement."""
    (V, M, P, E), (D, P_s, E_s), M_s = of_gas, of_solid, record.solid_mass[p]
    d, data, moved = record.d, record.data, one.clamp | one.given_solid
    D = choose(one.placed, row(d, data.clamp, p), choose(M_s > 0.0, per(D, M_s), D))
    P_s = choose(moved, scale(M_s, row(d, data.clamp_velocity, p)), P_s)
    P = choose(one.wall, scale(M, row(d, data.wall, p)), P)
    # a gas that is given, and what sticks
    given, (rho, *rho_u, of_data) = one.given_gas, row(d + 2, data.gas, p)
    sticks, before = one.sticks, kinetic(P_s, M_s)
    v = choose(given, per(tuple(rho_u), rho), per(add(P, P_s), M + M_s))
    v = choose(moved, per(P_s, M_s), v)
    P, P_s = choose(sticks, scale(M, v), P), choose(sticks, scale(M_s, v), P_s)
    change = np.where(sticks & ~moved, kinetic(P_s, M_s) - before, 0.0)
    E, E_s = E - change, E_s + change
    M, E = np.where(given, V * rho, M), np.where(given, V * of_data, E)
    return (V, M, choose(given, scale(V, tuple(rho_u)), P), E), (D, P_s, E_s)


def gather(record, total):
    """Add up area vectors of members, or how they turn, and clear those of the members."""
    total[:] = 0.0
    for r in each(record.of_particle.shape[0]):
        p = record.of_particle[r]
        for c in each(total.shape[1]):
            total[p, c] += record.of_normals[r, c]
    record.of_normals[:] = 0.0


def begin_stored(record, y):
    """Solid members get the displacement of their particle, for which solids find energies."""
    for p, r, at in own_members(record):
        with when(record.kind[r] == SOLID):
            for c in range(record.d):
                y[at(c)] = record.D[p, c]


def own_members(record):
    """Particle and row of each member of this rank, and where its numbers are in world vectors."""
    for m in each(record.mine.shape[0]):
        r = record.mine[m]
        first, apart = record.at[r], record.apart[r]
        yield record.of_particle[r], r, lambda c, at=first, apart=apart: at + c * apart


def impose_conditions(record, y):
    """What constraints and heat make of the sums, for the members of this rank; what came in."""
    if record.slips:
        for p, one in constraints.every(record):
            with when(one.count > 0):
                constraints.slide(record, p, one)
    for number, law in enumerate(record.laws):
        constraints.share_heat(law, number, record)
    constraints.warm_solids(record)
    give_state(record, y)
    book(record, y, True)


def book(record, vector, adds):
    """Sum up the energies that came in; the auxiliary unknowns of a vector get all that came in."""
    gain = record.gain
    gain.total[0] = 0.0
    for c in each(gain.energy.shape[0]):
        gain.total[0] += gain.energy[c]
    for c in each(record.auxiliary):
        at = record.first_auxiliary + c
        vector[at] = gain.numbers[c] + (vector[at] if adds else 0.0)


def give_state(record, y):
    """Members of this rank get what their particle has; each keeps its own J."""
    d = record.d
    for p, r, at in own_members(record):
        with when(record.kind[r] == GAS):
            J = y[at(0)]
            for c in range(d + 2):
                y[at(1 + c)] = J * record.U[p, c]
        with otherwise():
            D, v, e = row(d, record.D, p), row(d, record.v, p), record.e[p]
            kinetic, change = 0.5 * dot(v, v), e - record.mean_energy[p]
            heat = (e - kinetic - record.potential[p]) * record.alpha[r] / record.capacity[p]
            shared = kinetic + record.stored[r, 0] + heat
            alone = y[at(2 * d)] + change
            for c in range(d):
                y[at(c)], y[at(d + c)] = D[c], v[c]
            y[at(2 * d)] = np.where(record.facts.one_T[p] == 1, shared, alone)


def end_rates(record, y, f):
    """Rates of members from the sums of their rates, under the constraints of their particles."""
    for p, one in constraints.every(record):
        of_gas, (_, F, _) = summed(record, p)
        constraints.accelerate(record, p, one, of_gas, F)
    give_rates(record, y, f)
    book(record, f, False)


def give_rates(record, y, f):
    """(J U)_t = J U_t + U J_t of gas members; accelerations of solid ones, and their power."""
    d = record.d
    for p, r, at in own_members(record):
        with when(record.kind[r] == GAS):
            J, J_t = y[at(0)], f[at(0)]
            for c in range(d + 2):
                f[at(1 + c)] = J * record.U_t[p, c] + record.U[p, c] * J_t
        with otherwise():
            push = sub(row(d, record.acceleration, p), tuple(f[at(d + c)] for c in range(d)))
            power = dot(push, row(d, record.v, p))
            for c in range(d):
                f[at(d + c)] += push[c]
            f[at(2 * d)] += power
            with when(record.booked[r] == 1):
                record.gain.lost[0] += record.weight[r] * power
