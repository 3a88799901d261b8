"""Temperatures of particles: one of gas and solid where both conduct, or those that are given.
Compiled.
"""


from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import CALL, INLINED_CALL, by_length, dot, node, part_of, per
from fsipetsc.scheme.particle_records import SOLID


@njit(**CALL)
def weigh_heat(all):
    """Mean specific heat of the solid members of each particle, and mean of what they store."""
    table, stored, state = all.table, all.stored, all.state
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


@njit(**INLINED_CALL)
def share_heat(law, number, all, gain):
    """One temperature of gas and solid where both conduct, or that which is given: of particles
    whose gas has this law, the one of this number.
    """
    table, like, data, state = all.table, all.like, all.data, all.state
    d, facts, T_gas, T_solid = len(like), table.facts, data.T, data.T_solid
    mass, solid_mass, V, U, v, e = state.mass, state.solid_mass, state.V, state.U, state.v, state.e
    capacity, potential, energies, heats = state.capacity, state.potential, gain.energy, gain.heat
    for p in range(facts.size):
        one = facts[p]
        warm_gas, warm_solid = one.warm_gas == 1, one.warm_solid == 1
        both = one.shares_heat == 1 and not warm_gas and not warm_solid
        if one.law != number or not (both or warm_gas or warm_solid):
            continue
        rho, M, M_s, mine = U[p, 0], mass[p], solid_mass[p], one.mine
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
            came, at = mine * V[p] * (E - U[p, d + 1]), one.heats_gas
            energies[at], heats[at] = energies[at] + came, heats[at] + came
            U[p, d + 1] = E
        if warm_solid and M_s > 0.0:
            found = of_solid + capacity[p] * T_solid[p]
            came, at = mine * M_s * (found - e[p]), one.heats_solid
            energies[at] += came
            heats[at] += came if one.given_solid == 0 else 0.0
            e[p] = found


def _of_each(n):
    """Source: share heat once for each law."""
    return "".join(f" heat(laws[{k}], {k}, all, gain)\n" for k in range(n)) + " return"


#: heat(law, number, all, gain) for each of the laws
for_each_law = by_length("for_each_law", "heat, laws, all, gain", _of_each)


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
