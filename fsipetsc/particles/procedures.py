"""Particles: sums over members, constraints by Gauss's principle, and what each member gets back.

Gas members of a particle share U = (rho, rho u, E), solid members share displacement and
velocity, and have one temperature or each its own. With the sums

    gas    V = sum H J,  M = sum H J rho,  P = sum H J rho u,  E = sum H J e
    solid  M_s = sum H J0 m0,  and those of M_s times displacement, velocity, energy per mass e_s

`end_sums` finds what all members have in common; sums are linear in the unknowns, so that a
Runge-Kutta method keeps them. `end_rates` does the same for rates. With a_g = (R_m - u R_rho)/M and
a_s = F/M_s the accelerations without constraints, it minimises

    1/2 M |a_g' - a_g|^2 + 1/2 M_s |a_s' - a_s|^2     where     G_c . a_g' + S_c . a_s' = b_c:

forces pi_c G_c on the gas and pi_c S_c on the solid, with pi from the symmetric system

    sum_e (G_c . G_e / M + S_c . S_e / M_s) pi_e  =  b_c - G_c . a_g - S_c . a_s.

G_c is the sum of the area vectors of gas faces, S_c minus that of those at a solid, so that G_c +
S_c is the sum over walls: what they push comes in from outside. Sticking gas and solid are one body
of mass M + M_s. A body whose motion is given counts as infinitely heavy.

What comes in is added to ``gain``, see fsipetsc.scheme.part: the work of constraints, and the
change of unknowns that data replace. fsipetsc.blockrun.phases has the order of all this.
"""

import numpy as np

from fsipetsc.equations.vectors import add, choose, dot, per, scale, sub
from fsipetsc.kernels.arrays import row
from fsipetsc.kernels.loops import each, otherwise, pick, variable, when
from fsipetsc.particles import constraints
from fsipetsc.particles.members import GAS, SOLID


def weigh(record, y):
    """Rows of this rank's members: H q of gas, (M_s D, M_s v, M_s e) of a solid; or their rates."""
    rows, d = record.rows, len(record.like)
    for _, r in own_members(record):
        weight, own = record.weight[r], Unknowns(record, r, y)
        for c in each(pick(record.kind[r] == GAS, d + 3, 2 * d + 1)):
            rows[r, c] = weight * own[c]


def summed(record, p):
    """(V, M, P, E) of the gas and (M_s, M_s D, M_s v, M_s e) of the solid of particle p."""
    rows, d = record.rows, len(record.like)
    gas, solid = ([variable() for _ in range(n)] for n in (d + 3, 2 * d + 2))
    for r in each(record.begin[p], record.begin[p + 1]):
        with when(record.kind[r] == GAS):
            for c in range(d + 3):
                gas[c].value += rows[r, c]
        with otherwise():
            solid[0].value += record.weight[r]
            for c in range(2 * d + 1):
                solid[1 + c].value += rows[r, c]
    (V, M, *P, E), (M_s, *Ds, E_s) = constraints.value_of(gas), constraints.value_of(solid)
    return (V, M, tuple(P), E), (M_s, tuple(Ds[:d]), tuple(Ds[d:]), E_s)


def kinetic(P, M):
    """Energy of a body with this momentum."""
    return np.where(M > 0.0, 0.5 * dot(P, P) / M, 0.0)


def end_sums(record, gain):
    """Find from the sums of all members one U, one displacement and velocity. Gas and solid that
    stick have one velocity, and the gas gets the kinetic energy that the solid loses by that.
    """
    gain.numbers[:] = 0.0
    for p in each(record.mass.size):
        one = constraints.Facts(record, p)
        of_gas, of_solid = summed(record, p)
        (V, M, P, E), (M_s, D, P_s, E_s) = obeyed(record, p, one, of_gas, of_solid)
        record.mass[p], record.V[p], record.solid_mass[p] = M, V, M_s
        with when(V > 0.0):
            record.U[p] = M / V, *per(P, V), E / V
        with when(M_s > 0.0):
            record.mean_energy[p], record.e[p] = of_solid[3] / M_s, E_s / M_s
            record.v[p] = per(P_s, M_s)
            record.D[p] = D
        held = (one.wall == 1) | (one.clamp == 1)
        with when((one.mine == 1) & (held | (one.given_gas == 1) | (one.given_solid == 1))):
            with when(V > 0.0):
                gain.mass[one.column] += M - of_gas[1]
            constraints.accumulate(gain.impulse, add(sub(P, of_gas[2]), sub(P_s, of_solid[2])))
            gain.energy[one.moves_gas] += (E - of_gas[3]) + (E_s - of_solid[3])


def obeyed(record, p, one, of_gas, of_solid):
    """The sums of particle p, as walls, clamps and data have them; D is the mean displacement."""
    (V, M, P, E), (M_s, D, P_s, E_s) = of_gas, of_solid
    like, data, d, given = record.like, record.data, len(record.like), one.given_solid == 1
    moved = (one.clamp == 1) | given
    D = choose(M_s > 0.0, per(D, M_s), D)
    D = choose(one.placed == 1, row(like, data.clamp, p), D)
    D = choose(given, row(like, data.solid, p), D)
    P_s = choose(one.clamp == 1, scale(M_s, row(like, data.clamp_velocity, p)), P_s)
    P_s = choose(given, scale(M_s, row(like, data.solid, p, d)), P_s)
    P = choose(one.wall == 1, scale(M, row(like, data.wall, p)), P)
    # a gas that is given, and what sticks
    given, (rho, *rho_u, of_data) = one.given_gas == 1, row((*like, 0.0, 0.0), data.gas, p)
    sticks, before = one.sticks == 1, kinetic(P_s, M_s)
    v = choose(given, per(tuple(rho_u), rho), per(add(P, P_s), M + M_s))
    v = choose(moved, per(P_s, M_s), v)
    P, P_s = choose(sticks, scale(M, v), P), choose(sticks, scale(M_s, v), P_s)
    change = np.where(sticks & ~moved, kinetic(P_s, M_s) - before, 0.0)
    E, E_s = E - change, E_s + change
    M, E = np.where(given, V * rho, M), np.where(given, V * of_data, E)
    return (V, M, choose(given, scale(V, tuple(rho_u)), P), E), (M_s, D, P_s, E_s)


# normals, and what members store


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
    for p, r in own_members(record):
        with when(record.kind[r] == SOLID):
            own, D = Unknowns(record, r, y), row(record.like, record.D, p)
            for c in range(len(record.like)):
                own[c] = D[c]


class Unknowns:
    """The numbers in a world vector of the member of a row, of this rank."""

    def __init__(self, record, r, y):
        self._at, self._apart, self._y = record.at[r], record.apart[r], y

    def __getitem__(self, c):
        return self._y[self._at + c * self._apart]

    def __setitem__(self, c, value):
        self._y[self._at + c * self._apart] = value


def own_members(record):
    """Particle and row of each member of this rank."""
    for m in each(record.mine.shape[0]):
        r = record.mine[m]
        yield record.of_particle[r], r


# constraints


def impose_conditions(record, gain, y):
    """What constraints and heat make of the sums, for the members of this rank; what came in is
    added to the auxiliary unknowns.
    """
    if record.slips:
        for p in each(record.mass.size):
            with when(record.facts.count[p] > 0):
                constraints.slide(record, gain, p, constraints.Facts(record, p))
    for number, law in enumerate(record.laws):
        constraints.share_heat(law, number, record, gain)
    constraints.warm_solids(record, gain)
    give_state(record, y)
    sum_up(gain)
    for c in each(record.auxiliary):
        y[record.first_auxiliary + c] += gain.numbers[c]


def sum_up(gain):
    """Add up the energies that came in."""
    gain.total[0] = 0.0
    for c in each(gain.energy.shape[0]):
        gain.total[0] += gain.energy[c]


def give_state(record, y):
    """Members of this rank get what their particle has; each keeps its own J."""
    like, d = record.like, len(record.like)
    for p, r in own_members(record):
        own = Unknowns(record, r, y)
        with when(record.kind[r] == GAS):
            J = own[0]
            for c in range(d + 2):
                own[1 + c] = J * record.U[p, c]
        with otherwise():
            D, v, e = row(like, record.D, p), row(like, record.v, p), record.e[p]
            kinetic, change = 0.5 * dot(v, v), e - record.mean_energy[p]
            heat = (e - kinetic - record.potential[p]) * record.alpha[r] / record.capacity[p]
            shared = kinetic + record.stored[r, 0] + heat
            alone = own[2 * d] + change
            for c in range(d):
                own[c], own[d + c] = D[c], v[c]
            own[2 * d] = np.where(record.facts.one_T[p] == 1, shared, alone)


def end_rates(record, gain, y, f):
    """Rates of members from the sums of their rates, under the constraints of their particles."""
    for p in each(record.mass.size):
        constraints.accelerate(record, gain, p, constraints.Facts(record, p), *summed(record, p))
    give_rates(record, gain, y, f)
    sum_up(gain)
    for c in each(record.auxiliary):
        f[record.first_auxiliary + c] = gain.numbers[c]


def give_rates(record, gain, y, f):
    """(J U)_t = J U_t + U J_t of gas members; accelerations of solid ones, and their power."""
    like, d = record.like, len(record.like)
    for p, r in own_members(record):
        rates = Unknowns(record, r, f)
        with when(record.kind[r] == GAS):
            J, J_t = Unknowns(record, r, y)[0], rates[0]
            for c in range(d + 2):
                rates[1 + c] = J * record.U_t[p, c] + record.U[p, c] * J_t
        with otherwise():
            push = sub(row(like, record.acceleration, p), tuple(rates[d + c] for c in range(d)))
            power = dot(push, row(like, record.v, p))
            for c in range(d):
                rates[d + c] += push[c]
            rates[2 * d] += power
            with when(record.inertia[r] > 0.0):
                gain.lost[0] += record.inertia[r] * power
