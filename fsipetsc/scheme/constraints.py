"""Constraints of a particle, by Gauss's principle: see fsipetsc.scheme.particles. Compiled."""

import numpy as np

from fsipetsc.blocks.particles import SLIPS
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

#: a pivot below this part of its size before elimination belongs to a constraint that others imply
REDUNDANT = 1e-9


@njit(**INLINED_CALL)
def vectors(like, normals, p, k):
    """G and S of constraint k of particle p."""
    d = len(like)
    return part_of(like, normals, p, 2 * k * d), part_of(like, normals, p, (2 * k + 1) * d)


@njit(**INLINED_CALL)
def solve(one, like, p, normals, wanted, M, M_s, a, b, room):
    """The vectors a of the gas and b of the solid, changed least in their masses so that G_c . a +
    S_c . b = wanted_c. one: its facts. room: A, sizes of pivots; wanted becomes pi.
    """
    K, (A, size) = one.count, room
    per_gas = 1.0 / M if M > 0.0 and one.free_gas else 0.0
    per_solid = 1.0 / M_s if M_s > 0.0 and one.free_solid else 0.0
    sticks = one.sticks == 1
    if sticks:
        per_gas, per_solid = 1.0 / (M + M_s) if one.free_gas else 0.0, 0.0
    for k in range(K):
        G, S = vectors(like, normals, p, k)
        G = add(G, S) if sticks else G
        wanted[k] -= dot(G, a) if sticks else dot(G, a) + dot(S, b)
        for i in range(K):
            G_i, S_i = vectors(like, normals, p, i)
            G_i = add(G_i, S_i) if sticks else G_i
            A[k, i] = dot(G, G_i) * per_gas + dot(S, S_i) * per_solid
    eliminate(K, A, wanted, size)
    for k in range(K):
        G, S = vectors(like, normals, p, k)
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


@njit(**INLINED_CALL)
def slide(all, gain):
    """Project velocities on what the constraints allow; the kinetic energy that the solid loses
    goes to the gas.
    """
    table, like, normals, state = all.table, all.like, all.normals, all.state
    facts, constraint, wall = table.facts, table.constraint, all.data.wall
    mass, solid_mass, V, U, vs, e = state.mass, state.solid_mass, state.V, state.U, state.v, state.e
    d, K, impulse = len(like), constraint.shape[1], gain.impulse
    pi, room = np.zeros(K), (np.zeros((K, K)), np.zeros(K))
    for p in range(facts.size):
        one = facts[p]
        if one.count == 0:
            continue
        M, M_s, v = mass[p], solid_mass[p], node(like, vs, p)
        u = per(part_of(like, U, p, 1), U[p, 0]) if M > 0.0 else like
        for k in range(one.count):
            pi[k] = 0.0
            if constraint[p, k] == SLIPS:
                G, S = vectors(like, normals, p, k)
                pi[k] = dot(add(G, S), node(like, wall, p))
        before = 0.5 * M_s * dot(v, v)
        u, v = solve(one, like, p, normals, pi, M, M_s, u, v, room)
        change = 0.5 * M_s * dot(v, v) - before
        for k in range(one.count if one.mine else 0):  # what forces do to bodies they move
            G, S = vectors(like, normals, p, k)
            for c in range(d):
                both = one.free_gas * G[c] + one.free_solid * S[c]
                impulse[c] += pi[k] * both
        if M_s > 0.0:  # without a solid v stays 0: it is read, and a failed step has NaN
            put_part(vs, p, 0, v)
        if M > 0.0:
            put_part(U, p, 1, scale(U[p, 0], u))
        if M_s > 0.0 and M > 0.0:
            e[p] += change / M_s
            U[p, d + 1] -= change / V[p]


@njit(**INLINED_CALL)
def powers(one, like, p, normals, constraint, pi, force, u, v, w):
    """Two powers that the gas gets: from walls, and from the solid. Where the gas slips, a face
    moves as the wall or the solid there, not as the gas.
    """
    if one.count == 0 or not one.free_gas or one.sticks:
        return dot(force, u), 0.0
    power, of_solid = 0.0, 0.0
    for k in range(one.count):
        if constraint[p, k] == SLIPS:
            G, S = vectors(like, normals, p, k)
            power += pi[k] * dot(add(G, S), w)
            of_solid -= pi[k] * dot(S, v)
    return power, of_solid


@njit(**INLINED_CALL)
def book(one, like, p, normals, constraint, pi, v, w, force, force_s, power, of_solid, gain):
    """Add what walls and clamps do to the particle. Where gas and solid are both free, their forces
    on each other must cancel, so that those of the constraints alone count.
    """
    d, impulse, energies = len(like), gain.impulse, gain.energy
    if not (one.free_gas and one.free_solid):
        for c in range(d):
            impulse[c] += force[c] + force_s[c]
        energies[one.moves_gas] += power
        energies[one.moves_solid] += of_solid + dot(force_s, v)
        return
    for k in range(one.count):
        G, S = vectors(like, normals, p, k)
        N = add(G, S)
        for c in range(d):
            impulse[c] += pi[k] * N[c]
        slips = constraint[p, k] == SLIPS
        at = one.moves_gas if slips else one.moves_solid
        energies[at] += pi[k] * dot(N, w if slips else v)


@njit(**INLINED_CALL)
def right_sides(one, like, p, normals, turning, constraint, u, v, w, w_t, wanted):
    """The right-hand sides of constraints: walls accelerate, and area vectors turn under relative
    velocities.
    """
    for k in range(one.count):
        wanted[k] = 0.0
        if constraint[p, k] == SLIPS:
            (G, S), (G_t, S_t) = vectors(like, normals, p, k), vectors(like, turning, p, k)
            wanted[k] = dot(S_t, sub(u, v)) - dot(add(G_t, S_t), sub(u, w))
            wanted[k] += dot(add(G, S), w_t)
