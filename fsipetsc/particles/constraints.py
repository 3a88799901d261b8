"""Constraints of a particle: of its motion, and of temperatures: one of gas and solid where both
conduct, or those that are given.

With a_g = (R_m - u R_rho)/M and a_s = F/M_s without constraints, Gauss's principle minimises

    1/2 M |a_g' - a_g|^2 + 1/2 M_s |a_s' - a_s|^2     where     G_c . a_g' + S_c . a_s' = b_c:

forces pi_c G_c on the gas and pi_c S_c on the solid, with pi from the symmetric system

    sum_e (G_c . G_e / M + S_c . S_e / M_s) pi_e  =  b_c - G_c . a_g - S_c . a_s.

G_c is the sum of the area vectors of gas faces, S_c minus that of those at a solid, G_c + S_c so
that of walls: what they push comes in from outside. Sticking gas and solid are one body of mass M +
M_s. A body whose motion is given counts as infinitely heavy.

one: the facts of a particle; p: its number. Accelerations, or velocities, a of the gas and b of the
solid are lists of variables where constraints change them.
"""

from types import SimpleNamespace

import numpy as np

from fsipetsc.equations.vectors import add, along, choose, dot, per, scale, sub
from fsipetsc.kernels.loops import each, otherwise, pick, row, stop, variable, when
from fsipetsc.particles.members import NUMBERS, SLIPS, SOLID

#: a pivot below this part of its size before elimination belongs to a constraint that others imply
REDUNDANT = 1e-9


def every(record):
    """Yield the number of each particle and its facts: some NUMBERS, and flags."""
    for p in each(record.mass.size):
        facts = {name: of[p] for name, of in vars(record.facts).items()}
        flags = {name: number == 1 for name, number in facts.items() if name not in NUMBERS}
        yield p, SimpleNamespace(**{**facts, **flags})


def value_of(variables):
    """The numbers of several variables, as a tuple."""
    return tuple(one.value for one in variables)


def vectors(d, normals, p, k):
    """G and S of constraint k of particle p, of d numbers each."""
    return row(d, normals, p, 2 * d * k), row(d, normals, p, 2 * d * k + d)


def solve(record, p, one, M, M_s, a, b):
    """Change a of the gas and b of the solid least in their masses so that G_c . a + S_c . b =
    wanted_c, which record.pi has, and which becomes pi.
    """
    d, normals, pi, A, K = record.d, record.normals, record.pi, record.matrix, one.count
    sticks = one.sticks
    body = np.where(sticks, M + M_s, M)
    per_gas = np.where((body > 0.0) & one.free_gas, 1.0 / body, 0.0)
    per_solid = np.where((M_s > 0.0) & one.free_solid & ~sticks, 1.0 / M_s, 0.0)

    def pull(k):
        """G and S of a constraint; of what sticks their sum and S, which does not matter then."""
        G, S = vectors(d, normals, p, k)
        return choose(sticks, add(G, S), G), S

    for k in each(K):
        G, S = pull(k)
        pi[k] -= dot(G, value_of(a)) + np.where(sticks, 0.0, dot(S, value_of(b)))
        for i in each(K):
            G_i, S_i = pull(i)
            A[k, i] = dot(G, G_i) * per_gas + dot(S, S_i) * per_solid
    eliminate(K, A, pi, record.pivots)
    for k in each(K):
        G, S = pull(k)
        on_gas, on_solid = pi[k] * per_gas, pi[k] * per_solid
        for c in range(d):
            a[c].value += on_gas * G[c]
            b[c].value += on_solid * S[c]
    with when(sticks):
        for c in range(d):
            b[c].value = a[c].value


def eliminate(K, A, x, size):
    """Solve A pi = x in place of x; redundant constraints get 0. size: room for K numbers."""
    for k in each(K):
        size[k] = A[k, k]
    for k in each(K):
        with when(A[k, k] > REDUNDANT * size[k]):
            for e in each(k + 1, K):
                factor = A[e, k] / A[k, k]
                x[e] -= factor * x[k]
                for c in each(k, K):
                    A[e, c] -= factor * A[k, c]
        with otherwise():
            size[k] = -1.0
    for j in each(K):
        k = K - 1 - j
        with when(size[k] < 0.0):
            x[k] = 0.0
        with otherwise():
            for e in each(k + 1, K):
                x[k] -= A[k, e] * x[e]
            x[k] /= A[k, k]


def slide(record, p, one):
    """Project velocities on what constraints allow; the gas gets the energy the solid loses."""
    d, U, pi, M, M_s = record.d, record.U, record.pi, record.mass[p], record.solid_mass[p]
    rho, v, w = U[p, 0], row(d, record.v, p), row(d, record.data.wall, p)
    for k in each(one.count):
        G, S = vectors(d, record.normals, p, k)
        pi[k] = np.where(record.constraint[p, k] == SLIPS, dot(add(G, S), w), 0.0)
    new_u, new_v = list(map(variable, velocity(d, U, p, M))), list(map(variable, v))
    solve(record, p, one, M, M_s, new_u, new_v)
    new_u, new_v, nothing = value_of(new_u), value_of(new_v), (0.0,) * d
    change = 0.5 * M_s * dot(sub(new_v, v), add(new_v, v))  # of the solid's kinetic energy
    for k in each(pick(one.mine, one.count, 0)):  # what forces do to bodies they move
        G, S = vectors(d, record.normals, p, k)
        moved = add(choose(one.free_gas, G, nothing), choose(one.free_solid, S, nothing))
        accumulate(record.gain.impulse, scale(pi[k], moved))
    with when(M_s > 0.0):  # without a solid v stays 0: it is read, and a failed step has NaN
        record.v[p] = new_v
    with when(M > 0.0):
        U[p, 1:] = scale(rho, new_u)
    with when((M_s > 0.0) & (M > 0.0)):
        record.e[p] += change / M_s
        given = one.given_gas  # the gas keeps what it has; the energy comes in
        U[p, d + 1] -= np.where(given, 0.0, change / record.V[p])
        record.gain.energy[one.moves_gas] += np.where(given & one.mine, change, 0.0)


def accumulate(total, values):
    """Add several numbers to the first ones of an array."""
    for c, value in enumerate(values):
        total[c] += value


def velocity(d, U, p, M):
    """u of the gas of particle p; 0 if it has none."""
    return choose(M > 0.0, per(row(d, U, p, 1), U[p, 0]), (0.0,) * d)


def accelerate(record, p, one, of_gas, F):
    """U_t of the gas and acceleration of the solid of a particle, from the sums of rates, F that of
    the momentum of the solid. A gas that is given has none: it gets its velocity in each stage, and
    the solid with it.
    """
    d, data, U = record.d, record.data, row(record.d + 2, record.U, p)
    (J_t, R, R_m, R_E), nothing = of_gas, (0.0,) * d
    M, M_s, v = record.mass[p], record.solid_mass[p], row(d, record.v, p)
    u, w = velocity(d, record.U, p, M), row(d, data.wall, p)
    w_t = row(d, data.wall_rate, p)
    a_g = choose(M > 0.0, per(along(R_m, -R, u), M), nothing)
    a_s = choose(M_s > 0.0, per(F, M_s), nothing)
    clamped, given = one.clamp, one.given_gas
    b = choose(clamped, row(d, data.clamp_rate, p), a_s)
    a = choose(given, nothing, choose(one.wall, w_t, a_g))
    both = choose(given, a, per(add(scale(M, a), scale(M_s, b)), M + M_s))
    both = choose(clamped, b, both)
    a, b = (list(map(variable, choose(one.sticks, both, x))) for x in (a, b))
    with when(one.count > 0):
        for k in each(one.count):  # walls accelerate, area vectors turn under relative velocities
            (G, S), (G_t, S_t) = (vectors(d, n, p, k) for n in (record.normals, record.turning))
            turns = dot(S_t, sub(u, v)) - dot(add(G_t, S_t), sub(u, w))
            slips = record.constraint[p, k] == SLIPS
            record.pi[k] = np.where(slips, turns + dot(add(G, S), w_t), 0.0)
        solve(record, p, one, M, M_s, a, b)
    a, b = value_of(a), value_of(b)
    force, force_s = scale(M, sub(a, a_g)), scale(M_s, sub(b, a_s))
    power, from_solid = powers(record, p, one, force, force_s, u, v, w)
    record.acceleration[p] = b
    with when(M > 0.0):
        rates = R, *add(R_m, force), R_E + power + from_solid
        record.U_t[p] = per(along(rates, -J_t, U), record.V[p])


def powers(record, p, one, force, force_s, u, v, w):
    """Two powers that the gas gets: from walls, and from the solid. Where the gas slips, a face
    moves as the wall or the solid there, not as the gas. To ``gain`` goes what walls and clamps do.
    """
    power, of_solid = variable(dot(force, u)), variable(0.0)
    with when((one.count > 0) & one.free_gas & ~one.sticks):
        power.value = 0.0
        for k in each(one.count):
            with when(record.constraint[p, k] == SLIPS):
                G, S = vectors(record.d, record.normals, p, k)
                power.value += record.pi[k] * dot(add(G, S), w)
                of_solid.value -= record.pi[k] * dot(S, v)
    both = one.free_gas & one.free_solid
    # forces of two free bodies on each other must cancel: those of the constraints alone count
    with when(one.mine & both):
        for k in each(one.count):
            push = scale(record.pi[k], add(*vectors(record.d, record.normals, p, k)))
            accumulate(record.gain.impulse, push)
            slips = record.constraint[p, k] == SLIPS
            at = pick(slips, one.moves_gas, one.moves_solid)
            record.gain.energy[at] += dot(push, choose(slips, w, v))
    with when(one.mine & ~both):
        accumulate(record.gain.impulse, add(force, force_s))
        record.gain.energy[one.moves_gas] += power.value
        record.gain.energy[one.moves_solid] += of_solid.value + dot(force_s, v)
    return power.value, of_solid.value


def weigh_heat(record):
    """Mass of the solid members of each particle, mean specific heat, mean of what they store."""
    for p in each(record.mass.size):
        mass, heat, energy = sums = variable(), variable(), variable()
        for r in each(record.begin[p], record.begin[p + 1]):
            with when(record.kind[r] == SOLID):
                mass.value += record.weight[r]
                heat.value += record.weight[r] * record.alpha[r]
                energy.value += record.weight[r] * record.stored[r, 0]
        M_s, heat, energy = value_of(sums)
        record.solid_mass[p] = M_s
        with when(M_s > 0.0):
            record.capacity[p] = heat / M_s
            record.potential[p] = energy / M_s


def share_heat(law, which, record):
    """One temperature of gas and solid where both conduct, or that which is given: of a wall, of
    the gas, or of the solid. Of particles whose gas has this law, the one of this number.
    """
    for p, one in every(record):
        U, M, at_E = record.U, record.mass[p], record.d + 1
        warm, solid = one.warm_gas, one.warm_solid
        gas, both = one.given_gas & ~warm, one.shares_heat
        with when((one.law == which) & (warm | both) & (M > 0.0)):
            u = velocity(record.d, U, p, M)
            of_gas, of_solid = 0.5 * dot(u, u), rest_of(record, p)
            with when(warm | (solid & ~gas)):
                T = np.where(warm, record.data.T[p], record.data.T_solid[p])
                E = U[p, 0] * (law.internal_energy(U[p, 0], T) + of_gas)
                came = np.where(one.mine, record.V[p] * (E - U[p, at_E]), 0.0)
                record.gain.energy[one.heats_gas] += came
                record.gain.heat[one.heats_gas] += np.where(warm, came, 0.0)
                U[p, at_E] = E
            with when(gas & ~solid):
                rho, E = U[p, 0], U[p, at_E]
                T = law.temperature(rho, E / rho - of_gas)
                warm_the_solid(record, p, one, of_solid, T)
            with when(~warm & ~gas & ~solid):
                rho, c, M_s, e = U[p, 0], record.capacity[p], record.solid_mass[p], record.e[p]
                heat = M * (U[p, at_E] / rho - of_gas) + M_s * (e - of_solid)
                T = common_temperature(law, rho, M, M_s * c, heat, (e - of_solid) / c)
                sum_of_both = M * U[p, at_E] / rho + M_s * e  # it stays
                e = of_solid + c * T
                record.e[p] = e
                U[p, at_E] = rho * (sum_of_both - M_s * e) / M


def warm_solids(record):
    """The solids whose temperature is given get it."""
    for p, one in every(record):
        with when(one.warm_solid & (record.solid_mass[p] > 0.0)):
            warm_the_solid(record, p, one, rest_of(record, p), record.data.T_solid[p])


def rest_of(record, p):
    """Energy per mass of a solid that is no heat."""
    v = row(record.d, record.v, p)
    return record.potential[p] + 0.5 * dot(v, v)


def warm_the_solid(record, p, one, of_solid, T):
    """Let the solid have a temperature."""
    given = one.given_solid | ~one.warm_solid  # it comes with all unknowns
    e = of_solid + record.capacity[p] * T
    came = np.where(one.mine, record.solid_mass[p] * (e - record.e[p]), 0.0)
    record.gain.energy[one.heats_solid] += came
    record.gain.heat[one.heats_solid] += np.where(given, 0.0, came)
    record.e[p] = e


def common_temperature(law, rho, M, capacity, heat, first):
    """T at which a gas of mass M and a solid have this heat, by Newton's method from a first T."""
    found = variable(first)
    for _ in each(20):
        T = found.value
        missing = heat - M * law.internal_energy(rho, T) - capacity * T
        change = missing / (M * law.heat_capacity(rho, T) + capacity)
        found.value = T + change
        stop(~(abs(change) > 1e-15 * abs(T + change)))
    return found.value
