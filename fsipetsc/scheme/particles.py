"""Particles: sums over members, constraints by Gauss's principle, and what each member gets back. Compiled.

Gas members of a particle share U = (rho, rho u, E), solid members share displacement, velocity and energy. With the sums

    gas    V = sum H J,  M = sum H J rho,  P = sum H J rho u,  E = sum H J e
    solid  M_s = sum H J0 m0,  and those of M_s times displacement, velocity, energy per mass e_s

`share` gives all members what follows from the sums; sums are linear in the unknowns, so that a Runge-Kutta method keeps them.
`constrain` does the same for rates. With a_g = (R_m - u R_rho)/M and a_s = F/M_s the accelerations without constraints, it
minimises

    1/2 M |a_g' - a_g|^2 + 1/2 M_s |a_s' - a_s|^2      where  N_c . (gamma_c a_g' + sigma_c a_s') = b_c:

forces gamma_c pi_c N_c on the gas and sigma_c pi_c N_c on the solid, with pi from the symmetric system

    sum_e N_c . N_e (gamma_c gamma_e / M + sigma_c sigma_e / M_s) pi_e  =  b_c - N_c . (gamma_c a_g + sigma_c a_s).

Sticking gas and solid are one body of mass M + M_s. A body whose motion is given counts as infinitely heavy.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fsipetsc.blocks.particles import ROLLS, SLIDES, WALL
from fsipetsc.operators.loops import CALL, formulas

Array = NDArray[Any]
formulas("internal_energy", "heat_capacity", "temperature")

GAS, SOLID = 0, 1
#: a pivot below this part of its size before elimination belongs to a constraint that others imply
REDUNDANT = 1e-9


class Table(NamedTuple):
    """Particles on a rank. Rows are members; those of this rank come first, in any order.

    begin: (p + 1,), rows of particle p are row[begin[p]:begin[p + 1]], in the order that all ranks have. kind: (rows,) GAS or
    SOLID. at: (own,) where the unknowns of a member begin in the world's vector. weight: (rows,) H of a gas member, M_s of a
    solid one. count: (p,) number of constraints; constraint: (p, K) their kinds. All others are 1 or 0 for each particle; see
    fsipetsc.blocks.particles.
    """

    begin: Array
    row: Array
    kind: Array
    at: Array
    weight: Array
    count: Array
    constraint: Array
    sticks: Array
    held_gas: Array
    held_solid: Array
    given_gas: Array
    given_solid: Array
    warm: Array
    shares_heat: Array
    shares_energy: Array


class Data(NamedTuple):
    """What conditions prescribe at an instant, for each particle: velocity and acceleration of walls (p, d), displacement,
    velocity and acceleration of clamps (p, d), temperatures (p,), all unknowns: (p, d + 2) of a gas, (rho, rho u, E), and
    (p, 2d + 1) of a solid, (displacement, velocity, energy per mass).
    """

    wall: Array
    wall_rate: Array
    clamp: Array
    clamp_velocity: Array
    clamp_rate: Array
    T: Array
    gas: Array
    solid: Array


class State(NamedTuple):
    """What `share` found, for each particle: mass of gas and solid (p,), V (p,), U of the gas (p, d + 2), displacement D and
    velocity v (p, d) and energy per mass e (p,) of the solid. mean_energy: (p,) that of its members before a change.
    """

    mass: Array
    solid_mass: Array
    V: Array
    U: Array
    D: Array
    v: Array
    e: Array
    mean_energy: Array


@njit(**CALL)
def fill_state(table, d, y, out):
    """Rows of this rank's members: H q of a gas, (M_s D, M_s v, M_s e, M_s) of a solid. out: (rows, columns)."""
    for r in range(table.at.size):
        gas = table.kind[r] == GAS
        for c in range(d + 3 if gas else 2 * d + 1):
            out[r, c] = table.weight[r] * y[table.at[r] + c]
        if not gas:
            out[r, 2 * d + 1] = table.weight[r]


@njit(**CALL)
def fill_rates(table, d, f, out):
    """The same of rates."""
    for r in range(table.at.size):
        for c in range(d + 3 if table.kind[r] == GAS else 2 * d + 1):
            out[r, c] = table.weight[r] * f[table.at[r] + c]


@njit(**CALL)
def _add(table, p, rows, gas, solid):
    """Sums over the members of particle p; gas: (d + 3,), solid: (2d + 2,)."""
    gas[:], solid[:] = 0.0, 0.0
    for m in range(table.begin[p], table.begin[p + 1]):
        r = table.row[m]
        if table.kind[r] == GAS:
            for c in range(gas.size):
                gas[c] += rows[r, c]
        else:
            for c in range(solid.size):
                solid[c] += rows[r, c]


@njit(**CALL)
def _kinetic(P, M):
    total = 0.0
    for c in range(P.size):
        total += P[c] * P[c]
    return 0.5 * total / M if M > 0.0 else 0.0


@njit(**CALL)
def share(table, d, rows, data, state):
    """From the sums in ``rows``: one U, one displacement, velocity and energy; what sticks has one velocity.

    The kinetic energy that the solid loses goes to the gas.
    """
    gas, solid = np.zeros(d + 3), np.zeros(2 * d + 2)
    for p in range(table.begin.size - 1):
        _add(table, p, rows, gas, solid)
        V, M, P, E = gas[0], gas[1], gas[2 : 2 + d], gas[2 + d]
        M_s, P_s = solid[2 * d + 1], solid[d : 2 * d]
        state.V[p], state.mass[p], state.solid_mass[p] = V, M, M_s
        if M_s > 0.0:
            state.mean_energy[p] = solid[2 * d] / M_s
            for c in range(d):
                state.D[p, c] = solid[c] / M_s
        if table.held_solid[p]:
            for c in range(d):
                state.D[p, c] = data.clamp[p, c]
                P_s[c] = M_s * data.clamp_velocity[p, c]
        if table.held_gas[p]:
            for c in range(d):
                P[c] = M * data.wall[p, c]
        if table.sticks[p]:
            before = _kinetic(P_s, M_s)
            for c in range(d):
                both = P_s[c] / M_s if table.held_solid[p] else (P[c] + P_s[c]) / (M + M_s)
                if table.held_gas[p] and not table.held_solid[p]:
                    both = data.wall[p, c]
                P[c], P_s[c] = M * both, M_s * both
            change = 0.0 if table.held_solid[p] else _kinetic(P_s, M_s) - before
            solid[2 * d] += change
            E -= change
        if table.given_gas[p]:
            V = V if V > 0.0 else 1.0
            M, E = V * data.gas[p, 0], V * data.gas[p, d + 1]
            for c in range(d):
                P[c] = V * data.gas[p, 1 + c]
            state.mass[p] = M
        if table.given_solid[p]:
            for c in range(d):
                state.D[p, c], P_s[c] = data.solid[p, c], M_s * data.solid[p, d + c]
            solid[2 * d] = M_s * data.solid[p, 2 * d]
        _put(state, p, d, V, M, P, E, M_s, P_s, solid[2 * d])


@njit(**CALL)
def _put(state, p, d, V, M, P, E, M_s, P_s, E_s):
    if V > 0.0:
        state.U[p, 0], state.U[p, d + 1] = M / V, E / V
        for c in range(d):
            state.U[p, 1 + c] = P[c] / V
    if M_s > 0.0:
        state.e[p] = E_s / M_s
        for c in range(d):
            state.v[p, c] = P_s[c] / M_s


@njit(**CALL)
def slide(table, d, normals, data, state):
    """Project velocities on what the constraints allow; the kinetic energy that the solid loses goes to the gas.

    normals: (p, K, d).
    """
    u, v, wanted, room = np.zeros(d), np.zeros(d), np.zeros(normals.shape[1]), room_for(normals.shape[1])
    for p in range(table.begin.size - 1):
        if table.count[p] == 0:
            continue
        M, M_s = state.mass[p], state.solid_mass[p]
        for c in range(d):
            u[c] = state.U[p, 1 + c] / state.U[p, 0] if M > 0.0 else 0.0
            v[c] = state.v[p, c]
        before = 0.0
        for c in range(d):
            before += 0.5 * M_s * v[c] * v[c]
        for k in range(table.count[p]):
            wanted[k] = 0.0
            if table.constraint[p, k] == WALL:
                for c in range(d):
                    wanted[k] += normals[p, k, c] * data.wall[p, c]
        solve(table, p, normals, wanted, M, M_s, u, v, room)
        after = 0.0
        for c in range(d):
            after += 0.5 * M_s * v[c] * v[c]
            state.v[p, c] = v[c]
            if M > 0.0:
                state.U[p, 1 + c] = state.U[p, 0] * u[c]
        if M_s > 0.0 and M > 0.0:
            state.e[p] += (after - before) / M_s
            state.U[p, d + 1] -= (after - before) / state.V[p]


@njit(**CALL)
def room_for(K):
    """Room for `solve` with at most K constraints: rows of A, then multipliers pi, gamma, sigma and sizes of pivots."""
    return np.zeros((K + 4, K))


@njit(**CALL)
def solve(table, p, normals, wanted, M, M_s, a, b, room):
    """Change the vectors a of the gas and b of the solid, least in their masses, so that
    N_c . (gamma_c a + sigma_c b) = wanted_c; the multipliers are room[K_most].
    """
    K, d = table.count[p], a.size
    sticks = table.sticks[p] == 1 and M > 0.0 and M_s > 0.0
    per_gas = 0.0 if table.held_gas[p] or M == 0.0 else 1.0 / M
    per_solid = 0.0 if table.held_solid[p] or M_s == 0.0 else 1.0 / M_s
    if sticks:
        held = table.held_gas[p] or table.held_solid[p]
        per_gas = per_solid = 0.0 if held else 1.0 / (M + M_s)
    most, N = room.shape[1], normals[p]
    A, pi, gamma, sigma = room[:K, :K], room[most, :K], room[most + 1], room[most + 2]
    for k in range(K):
        kind = table.constraint[p, k]
        gamma[k] = 0.0 if kind == ROLLS and not sticks else 1.0
        sigma[k] = 0.0 if sticks else (-1.0 if kind == SLIDES else (1.0 if kind == ROLLS else 0.0))
    for k in range(K):
        pi[k] = wanted[k]
        for c in range(d):
            pi[k] -= N[k, c] * (gamma[k] * a[c] + sigma[k] * b[c])
    for k in range(K):
        for e in range(K):
            A[k, e] = 0.0
            both = gamma[k] * gamma[e] * per_gas + sigma[k] * sigma[e] * per_solid
            for c in range(d):
                A[k, e] += N[k, c] * N[e, c] * both
    eliminate(A, pi, room[most + 3])
    for k in range(K):
        for c in range(d):
            a[c] += gamma[k] * pi[k] * N[k, c] * per_gas
            b[c] += (gamma[k] if sticks else sigma[k]) * pi[k] * N[k, c] * per_solid


@njit(**CALL)
def eliminate(A, x, size):
    """Solve A pi = x in place of x for a symmetric semidefinite A; constraints that others imply get no force."""
    K = x.size
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
def share_heat(table, law, d, table_energy, data, state):
    """One temperature of gas and solid where both conduct, or that which is given.

    law: of the gas. table_energy: (p, 2), of the solid: its energy per mass that is neither kinetic nor heat, and alpha.
    """
    for p in range(table.begin.size - 1):
        if not (table.shares_heat[p] or table.warm[p]):
            continue
        rho, M, M_s = state.U[p, 0], state.mass[p], state.solid_mass[p]
        of_gas, of_solid = 0.0, 0.0
        for c in range(d):
            if M > 0.0:
                of_gas += 0.5 * (state.U[p, 1 + c] / rho) ** 2
            of_solid += 0.5 * state.v[p, c] ** 2
        of_solid += table_energy[p, 0]
        alpha = table_energy[p, 1]
        T = data.T[p]
        if not table.warm[p]:
            heat = M * (state.U[p, d + 1] / rho - of_gas) + M_s * (state.e[p] - of_solid)
            T = (state.e[p] - of_solid) / alpha
            for _ in range(20):
                missing = heat - M * law.internal_energy(rho, T) - M_s * alpha * T
                change = missing / (M * law.heat_capacity(rho, T) + M_s * alpha)
                T += change
                if not abs(change) > 1e-15 * abs(T):
                    break
        if M > 0.0:
            energy = law.internal_energy(rho, T) + of_gas
            if M_s > 0.0 and not table.warm[p]:  # the sum stays to the last bit
                of_both = M * state.U[p, d + 1] / rho + M_s * state.e[p]
                state.e[p] = of_solid + alpha * T
                state.U[p, d + 1] = rho * (of_both - M_s * state.e[p]) / M
                continue
            state.U[p, d + 1] = rho * energy
        if M_s > 0.0 and alpha > 0.0:
            state.e[p] = of_solid + alpha * T


@njit(**CALL)
def give_state(table, d, y, state):
    """Members of this rank get what their particle has; each keeps its own J."""
    for p in range(table.begin.size - 1):
        for m in range(table.begin[p], table.begin[p + 1]):
            r = table.row[m]
            if r >= table.at.size:
                continue
            at = table.at[r]
            if table.kind[r] == GAS:
                for c in range(d + 2):
                    y[at + 1 + c] = y[at] * state.U[p, c]
            else:
                for c in range(d):
                    y[at + c], y[at + d + c] = state.D[p, c], state.v[p, c]
                if table.shares_energy[p] or table.given_solid[p]:
                    y[at + 2 * d] = state.e[p]
                else:
                    y[at + 2 * d] += state.e[p] - state.mean_energy[p]


@njit(**CALL)
def constrain(table, d, rows, normals, turning, data, state, rates):
    """Rates of particles from sums of members' rates in ``rows``, under their constraints.

    normals, turning: (p, K, d), N and how it turns. rates: (p, 2d + 3): of (rho, rho u, E) of the gas, then accelerations
    and energy of the solid.
    """
    gas, solid = np.zeros(d + 3), np.zeros(2 * d + 2)
    u, v, a, b, wanted = np.zeros(d), np.zeros(d), np.zeros(d), np.zeros(d), np.zeros(normals.shape[1])
    free_a, free_b, room = np.zeros(d), np.zeros(d), room_for(normals.shape[1])
    pi = room[normals.shape[1]]
    for p in range(table.begin.size - 1):
        _add(table, p, rows, gas, solid)
        M, M_s, V = state.mass[p], state.solid_mass[p], state.V[p]
        for c in range(d):
            u[c] = state.U[p, 1 + c] / state.U[p, 0] if M > 0.0 else 0.0
            v[c] = state.v[p, c]
            a[c] = (gas[2 + c] - u[c] * gas[1]) / M if M > 0.0 else 0.0
            b[c] = solid[d + c] / M_s if M_s > 0.0 else 0.0
            free_a[c], free_b[c] = a[c], b[c]
        _hold(table, p, data, M, M_s, a, b)
        for k in range(table.count[p]):
            wanted[k] = 0.0
            for c in range(d):
                if table.constraint[p, k] == SLIDES:
                    wanted[k] -= turning[p, k, c] * (u[c] - v[c])
                elif table.constraint[p, k] == WALL:
                    wanted[k] += normals[p, k, c] * data.wall_rate[p, c]
                    wanted[k] -= turning[p, k, c] * (u[c] - data.wall[p, c])
        if table.count[p] > 0:
            solve(table, p, normals, wanted, M, M_s, a, b, room)
        E, E_s = gas[2 + d], solid[2 * d]
        for c in range(d):
            force, force_s = M * (a[c] - free_a[c]), M_s * (b[c] - free_b[c])
            gas[2 + c] += force
            E_s += force_s * v[c]
            if table.sticks[p] or table.held_gas[p] or table.count[p] == 0:
                E += force * u[c]
        if table.count[p] > 0 and not (table.sticks[p] or table.held_gas[p]):
            for k in range(table.count[p]):
                for c in range(d):
                    if table.constraint[p, k] == SLIDES:
                        E += pi[k] * normals[p, k, c] * v[c]
                    elif table.constraint[p, k] == WALL:
                        E += pi[k] * normals[p, k, c] * data.wall[p, c]
        if M > 0.0:
            rates[p, 0] = (gas[1] - state.U[p, 0] * gas[0]) / V
            for c in range(d):
                rates[p, 1 + c] = (gas[2 + c] - state.U[p, 1 + c] * gas[0]) / V
            rates[p, d + 1] = (E - state.U[p, d + 1] * gas[0]) / V
        for c in range(d):
            rates[p, d + 2 + c] = b[c]
        rates[p, 2 * d + 2] = E_s / M_s if M_s > 0.0 else 0.0


@njit(**CALL)
def _hold(table, p, data, M, M_s, a, b):
    """Accelerations of bodies whose motion is given, and of what sticks together."""
    for c in range(a.size):
        if table.held_solid[p]:
            b[c] = data.clamp_rate[p, c]
        if table.held_gas[p]:
            a[c] = data.wall_rate[p, c]
        if table.sticks[p]:
            if table.held_solid[p]:
                a[c] = b[c]
            elif table.held_gas[p]:
                b[c] = a[c]
            else:
                a[c] = b[c] = (M * a[c] + M_s * b[c]) / (M + M_s)


@njit(**CALL)
def give_rates(table, d, y, f, state, rates):
    """(J U)_t = J U_t + U J_t of gas members; accelerations and energies of solid ones."""
    for p in range(table.begin.size - 1):
        for m in range(table.begin[p], table.begin[p + 1]):
            r = table.row[m]
            if r >= table.at.size:
                continue
            at = table.at[r]
            if table.kind[r] == GAS:
                for c in range(d + 2):
                    f[at + 1 + c] = y[at] * rates[p, c] + state.U[p, c] * f[at]
            else:
                for c in range(d):
                    force = rates[p, d + 2 + c] - f[at + d + c]
                    f[at + d + c] += force
                    f[at + 2 * d] += force * state.v[p, c]
                if table.shares_energy[p]:
                    f[at + 2 * d] = rates[p, 2 * d + 2]
