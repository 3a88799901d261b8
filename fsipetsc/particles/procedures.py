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
from fsipetsc.kernels.arrays import node, part_of, put_part
from fsipetsc.kernels.loops import each, otherwise, pick, variable, when
from fsipetsc.particles import constraints as of
from fsipetsc.particles.members import GAS, SOLID
from fsipetsc.scheme.part import clear


def weigh(all, y):
    """Rows of this rank's members: H q of gas, (M_s D, M_s v, M_s e) of a solid; or their rates."""
    rows, d = all.rows, len(all.like)
    for _, r in own_members(all):
        weight, own = all.weight[r], Unknowns(all, r, y)
        for c in each(pick(all.kind[r] == GAS, d + 3, 2 * d + 1)):
            rows[r, c] = weight * own[c]


def summed(all, p):
    """(V, M, P, E) of the gas and (M_s, M_s D, M_s v, M_s e) of the solid of particle p."""
    rows, d = all.rows, len(all.like)
    gas, solid = ([variable() for _ in range(n)] for n in (d + 3, 2 * d + 2))
    for r in each(all.begin[p], all.begin[p + 1]):
        with when(all.kind[r] == GAS):
            for c in range(d + 3):
                gas[c].value += rows[r, c]
        with otherwise():
            solid[0].value += all.weight[r]
            for c in range(2 * d + 1):
                solid[1 + c].value += rows[r, c]
    (V, M, *P, E), (M_s, *Ds, E_s) = of.value_of(gas), of.value_of(solid)
    return (V, M, tuple(P), E), (M_s, tuple(Ds[:d]), tuple(Ds[d:]), E_s)


def kinetic(P, M):
    """Energy of a body with this momentum."""
    return np.where(M > 0.0, 0.5 * dot(P, P) / M, 0.0)


def end_sums(all, gain):
    """Find from the sums of all members one U, one displacement and velocity. Gas and solid that
    stick have one velocity, and the gas gets the kinetic energy that the solid loses by that.
    """
    clear(gain.numbers)
    for p in each(all.facts.shape[0]):
        one = all.facts[p]
        of_gas, of_solid = summed(all, p)
        (V, M, P, E), (M_s, D, P_s, E_s) = obeyed(all, p, one, of_gas, of_solid)
        all.mass[p], all.V[p], all.solid_mass[p] = M, V, M_s
        with when(V > 0.0):
            put_part(all.U, p, 0, (M / V, *per(P, V), E / V))
        with when(M_s > 0.0):
            all.mean_energy[p], all.e[p] = of_solid[3] / M_s, E_s / M_s
            put_part(all.v, p, 0, per(P_s, M_s))
            put_part(all.D, p, 0, D)
        held = (one.wall == 1) | (one.clamp == 1)
        with when((one.mine == 1) & (held | (one.given_gas == 1) | (one.given_solid == 1))):
            with when(V > 0.0):
                gain.mass[one.column] += M - of_gas[1]
            of.accumulate(gain.impulse, add(sub(P, of_gas[2]), sub(P_s, of_solid[2])))
            gain.energy[one.moves_gas] += (E - of_gas[3]) + (E_s - of_solid[3])


def obeyed(all, p, one, of_gas, of_solid):
    """The sums of particle p, as walls, clamps and data have them; D is the mean displacement."""
    (V, M, P, E), (M_s, D, P_s, E_s) = of_gas, of_solid
    like, data, d, given = all.like, all.data, len(all.like), one.given_solid == 1
    moved = (one.clamp == 1) | given
    D = choose(M_s > 0.0, per(D, M_s), D)
    D = choose(one.placed == 1, node(like, data.clamp, p), D)
    D = choose(given, node(like, data.solid, p), D)
    P_s = choose(one.clamp == 1, scale(M_s, node(like, data.clamp_velocity, p)), P_s)
    P_s = choose(given, scale(M_s, part_of(like, data.solid, p, d)), P_s)
    P = choose(one.wall == 1, scale(M, node(like, data.wall, p)), P)
    # a gas that is given, and what sticks
    given, (rho, *rho_u, of_data) = one.given_gas == 1, part_of((*like, 0.0, 0.0), data.gas, p, 0)
    sticks, before = one.sticks == 1, kinetic(P_s, M_s)
    v = choose(given, per(tuple(rho_u), rho), per(add(P, P_s), M + M_s))
    v = choose(moved, per(P_s, M_s), v)
    P, P_s = choose(sticks, scale(M, v), P), choose(sticks, scale(M_s, v), P_s)
    change = np.where(sticks & ~moved, kinetic(P_s, M_s) - before, 0.0)
    E, E_s = E - change, E_s + change
    M, E = np.where(given, V * rho, M), np.where(given, V * of_data, E)
    return (V, M, choose(given, scale(V, tuple(rho_u)), P), E), (M_s, D, P_s, E_s)


# normals, and what members store


def gather(all, total):
    """Add up area vectors of members, or how they turn, and clear those of the members."""
    clear(total.reshape(-1))
    for r in each(all.of_particle.shape[0]):
        p = all.of_particle[r]
        for c in each(total.shape[1]):
            total[p, c] += all.of_normals[r, c]
    clear(all.of_normals.reshape(-1))


def begin_stored(all, y):
    """Solid members get the displacement of their particle, for which solids find energies."""
    for p, r in own_members(all):
        with when(all.kind[r] == SOLID):
            own, D = Unknowns(all, r, y), node(all.like, all.D, p)
            for c in range(len(all.like)):
                own[c] = D[c]


class Unknowns:
    """The numbers in a world vector of the member of a row, of this rank."""

    def __init__(self, all, r, y):
        self._at, self._apart, self._y = all.at[r], all.apart[r], y

    def __getitem__(self, c):
        return self._y[self._at + c * self._apart]

    def __setitem__(self, c, value):
        self._y[self._at + c * self._apart] = value


def own_members(all):
    """Particle and row of each member of this rank."""
    for m in each(all.mine.shape[0]):
        r = all.mine[m]
        yield all.of_particle[r], r


# constraints


def impose_conditions(all, gain, y):
    """What constraints and heat make of the sums, for the members of this rank; what came in is
    added to the auxiliary unknowns.
    """
    if all.slips:
        for p in each(all.facts.shape[0]):
            with when(all.facts[p].count > 0):
                of.slide(all, gain, p, all.facts[p])
    for number, law in enumerate(all.laws):
        of.share_heat(law, number, all, gain)
    of.warm_solids(all, gain)
    give_state(all, y)
    sum_up(gain)
    for c in each(all.auxiliary):
        y[y.size - all.auxiliary + c] += gain.numbers[c]


def sum_up(gain):
    """Add up the energies that came in."""
    gain.total[0] = 0.0
    for c in each(gain.energy.shape[0]):
        gain.total[0] += gain.energy[c]


def give_state(all, y):
    """Members of this rank get what their particle has; each keeps its own J."""
    like, d = all.like, len(all.like)
    for p, r in own_members(all):
        own = Unknowns(all, r, y)
        with when(all.kind[r] == GAS):
            J = own[0]
            for c in range(d + 2):
                own[1 + c] = J * all.U[p, c]
        with otherwise():
            D, v, e = node(like, all.D, p), node(like, all.v, p), all.e[p]
            kinetic, change = 0.5 * dot(v, v), e - all.mean_energy[p]
            heat = (e - kinetic - all.potential[p]) * all.alpha[r] / all.capacity[p]
            shared = kinetic + all.stored[r, 0] + heat
            alone = own[2 * d] + change
            for c in range(d):
                own[c], own[d + c] = D[c], v[c]
            own[2 * d] = np.where(all.facts[p].one_T == 1, shared, alone)


def end_rates(all, gain, y, f):
    """Rates of members from the sums of their rates, under the constraints of their particles."""
    for p in each(all.facts.shape[0]):
        of.accelerate(all, gain, p, all.facts[p], *summed(all, p))
    give_rates(all, gain, y, f)
    sum_up(gain)
    for c in each(all.auxiliary):
        f[f.size - all.auxiliary + c] = gain.numbers[c]


def give_rates(all, gain, y, f):
    """(J U)_t = J U_t + U J_t of gas members; accelerations of solid ones, and their power."""
    like, d = all.like, len(all.like)
    for p, r in own_members(all):
        rates = Unknowns(all, r, f)
        with when(all.kind[r] == GAS):
            J, J_t = Unknowns(all, r, y)[0], rates[0]
            for c in range(d + 2):
                rates[1 + c] = J * all.U_t[p, c] + all.U[p, c] * J_t
        with otherwise():
            push = sub(node(like, all.acceleration, p), tuple(rates[d + c] for c in range(d)))
            power = dot(push, node(like, all.v, p))
            for c in range(d):
                rates[d + c] += push[c]
            rates[2 * d] += power
            with when(all.inertia[r] > 0.0):
                gain.lost[0] += all.inertia[r] * power
