"""Temperatures of particles: one of gas and solid where both conduct, or those that are given."""

import numpy as np

from fsipetsc.equations.vectors import dot
from fsipetsc.kernels.arrays import node
from fsipetsc.kernels.loops import each, stop, variable, when
from fsipetsc.particles.constraints import value_of, velocity
from fsipetsc.particles.records import SOLID


def weigh_heat(all):
    """Mean specific heat of the solid members of each particle, and mean of what they store."""
    table, stored, state = all.table, all.stored, all.state
    for p in each(table.facts.shape[0]):
        mass, heat, energy = sums = variable(), variable(), variable()
        for m in each(table.begin[p], table.begin[p + 1]):
            r = table.row[m]
            with when(table.kind[r] == SOLID):
                mass.value += table.weight[r]
                heat.value += table.weight[r] * table.alpha[r]
                energy.value += table.weight[r] * stored[r, 0]
        M_s, heat, energy = value_of(sums)
        with when(M_s > 0.0):
            state.capacity[p] = heat / M_s
            state.potential[p] = energy / M_s


def share_heat(law, number, all, gain):
    """One temperature of gas and solid where both conduct, or that which is given of the gas: of
    particles whose gas has this law, the one of this number.
    """
    for p in each(all.table.facts.shape[0]):
        one, M = all.table.facts[p], all.state.mass[p]
        warm, asked = one.warm_gas == 1, (one.warm_gas == 1) | (one.warm_solid == 1)
        with when((one.law == number) & (warm | (one.shares_heat == 1)) & (M > 0.0)):
            u = velocity(all.like, all.state.U, p, M)
            with when(warm):
                warm_the_gas(law, all, gain, p, one, 0.5 * dot(u, u))
            with when(~asked):
                share_one(law, all, p, 0.5 * dot(u, u), rest_of(all, p))


def warm_solids(all, gain):
    """The solids whose temperature is given get it."""
    for p in each(all.table.facts.shape[0]):
        one = all.table.facts[p]
        with when((one.warm_solid == 1) & (all.state.solid_mass[p] > 0.0)):
            warm_the_solid(all, gain, p, one, rest_of(all, p))


def rest_of(all, p):
    """Energy per mass of a solid that is no heat."""
    v = node(all.like, all.state.v, p)
    return all.state.potential[p] + 0.5 * dot(v, v)


def share_one(law, all, p, of_gas, of_solid):
    """One temperature of gas and solid. of_gas, of_solid: energies per mass that are no heat."""
    state, U, at_E = all.state, all.state.U, len(all.like) + 1
    rho, M, M_s, e, c = U[p, 0], state.mass[p], state.solid_mass[p], state.e[p], state.capacity[p]
    energy = U[p, at_E] / rho
    heat = M * (energy - of_gas) + M_s * (e - of_solid)
    T = common_temperature(law, rho, M, M_s * c, heat, (e - of_solid) / c)
    sum_of_both = M * U[p, at_E] / rho + M_s * e  # it stays
    e = of_solid + c * T
    state.e[p] = e
    U[p, at_E] = rho * (sum_of_both - M_s * e) / M


def warm_the_gas(law, all, gain, p, one, of_gas):
    """Let the gas have the temperature that is given."""
    U, at_E = all.state.U, len(all.like) + 1
    E = U[p, 0] * (law.internal_energy(U[p, 0], all.data.T[p]) + of_gas)
    came = np.where(one.mine == 1, all.state.V[p] * (E - U[p, at_E]), 0.0)
    gain.energy[one.heats_gas] += came
    gain.heat[one.heats_gas] += came
    U[p, at_E] = E


def warm_the_solid(all, gain, p, one, of_solid):
    """Let the solid have the temperature that is given."""
    e = of_solid + all.state.capacity[p] * all.data.T_solid[p]
    came = np.where(one.mine == 1, all.state.solid_mass[p] * (e - all.state.e[p]), 0.0)
    gain.energy[one.heats_solid] += came
    gain.heat[one.heats_solid] += np.where(one.given_solid == 0, came, 0.0)
    all.state.e[p] = e


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
