"""What is done with a rank's part of a solid block in a step.

Its monitor bounds the next step as that of a gas (fsipetsc.scheme.gas_terms), but with
convection sqrt(sum_k (c |A^k| / (J0 h_k))^2),  c^2 the largest wave modulus over m0.
"""

import numpy as np

from fsipetsc.equations.tensors import add_unit, product, transpose
from fsipetsc.equations.vectors import add, dot, per
from fsipetsc.kernels.loops import column, each, row
from fsipetsc.operators.sbp import STIFFNESS_OF_WIDE
from fsipetsc.scheme.face_terms import strain_at
from fsipetsc.scheme.monitor import note_points, observe
from fsipetsc.scheme.part import book, ghosted_planes, nodes_of, owned_planes


def store(part, record, y):
    """Tell particles the energy per mass of members [J/kg] that is neither kinetic nor heat."""
    rows, q = part.rows_of_stored, ghosted_planes(part, y).T
    for i in each(rows.shape[0]):
        at, energy = part.stored_at[i], 0.0
        if not part.laws.coupled:
            energy = stored_energy(part, strain_at(part, q, at), at)
        record.stored[rows[i], 0] = energy


def book_force(part, q, ghosted, rates, gain):
    """Book what a constant force gives, and its work. The sweep has added it to rates."""
    d, force = part.d, part.laws.force
    work = book(part, gain, lambda i: (*force, dot(force, row(d, q, i, d))))
    gain.work[0] += work
    if part.loses:
        gain.lost[0] += work


def supply(part, q, ghosted, rates, gain):
    """Add the case's forcing to the rates, and book it."""
    forcing, d = part.forcing, part.d

    def supplied(i):
        push, heat = column(d, forcing, i), part.laws.alpha * forcing[d, i]
        for c in range(d):
            heat = heat + q[i, d + c] * push[c]
            rates[i, c] += forcing[d + 1 + c, i]
            rates[i, d + c] += push[c]
        rates[i, 2 * d] += heat
        return *push, heat

    book(part, gain, supplied)


def monitor(part, found, y):
    """Note extremes and sums, and what is recorded of interfaces in one dimension; fill F."""
    own, halo = owned_planes(part, y), ghosted_planes(part, y)
    part.volume.sweep_strains(part, own, halo, part.F)
    q = own.T
    observe(part, found, lambda own, node: seen_at(part, q, own, node))
    if part.d == 1:
        note_ends(part, q, found)
    if part.points is not None:
        note_points(part, found, lambda own, n: point_at(part, q, own, n))


def measure(part, y, q):
    """Fill F of a solid block's part; y, q: planes of its owned nodes, and of all with a halo."""
    y, q = y.reshape(part.dof, part.masses.shape[0]), q.reshape(part.dof, part.metrics.shape[1])
    part.volume.sweep_strains(part, y, q, part.F)


def stressed(part, q, out):
    """Fill planes of the owned nodes with T, p, the Cauchy stress and that of hoops, by the last F;
    q: planes of the ghosted nodes.
    """
    d, solid, M = part.d, part.laws, part.masses.shape[0]
    q = q.reshape(part.dof, part.metrics.shape[1]).T
    for at, own in nodes_of(part):
        _, _, F, T = state_at(part, row(2 * d + 1, q, at), own, at)
        p, (stress, hoops) = solid.pressure_at(solid.volume(F), T), stress_at(part, F, T, at)
        for c, number in enumerate((T, p, *stress, *hoops)):
            out[c * M + own] = number


def state_at(part, unknowns, own, node):
    """Return place, velocity, the last F, and T of a node."""
    d, solid = part.d, part.laws
    F, place = column(solid.strains(d), part.F, own), add(column(d, part.X, node), unknowns[:d])
    v, e = unknowns[d : 2 * d], unknowns[2 * d]
    stored = 0.0 if solid.coupled else prestress_energy(part, F, node)
    return place, v, F, solid.temperature(v, e - stored, F)


def stress_at(part, F, T, node):
    """The Cauchy stress P F^T/J of a node, and that of hoops, if any."""
    solid, size = part.laws, part.d * part.d
    P = solid.stress_at(F, T)
    if part.prestress is not None:
        P = add(P, column(size, part.prestress, node))
    hoops = (solid.hoop_stress(F, T),) if solid.around else ()
    return per(product(P, transpose(F[:size])), solid.volume(F)), hoops


def point_at(part, q, own, node):
    """Return what `note_points` asks for; p: minus the mean of normal and hoop stresses."""
    d = part.d
    place, v, F, T = state_at(part, row(2 * d + 1, q, own), own, node)
    stress, hoops = stress_at(part, F, T, node)
    normal = [one - part.p_ref for one in stress[:: d + 1]] + [*hoops] * len(part.laws.around)
    return *place, *v, T, -sum(normal) / float(len(normal))


def seen_at(part, q, own, node):
    """Return what `observe` asks for. Convection is inf where the state is not physical."""
    solid, d = part.laws, part.d
    place, v, F, T = state_at(part, row(2 * d + 1, q, own), own, node)
    J, modulus, squares = solid.volume(F), solid.wave_modulus_at(F, T), part.squares[own]
    speed = np.sqrt(np.maximum(modulus, 0.0) * squares)
    good = (J > 0.0) & (T > 0.0) & (modulus > -1e-300) & (speed < np.inf)
    diffusion = STIFFNESS_OF_WIDE * solid.kappa / solid.alpha * squares
    bad, fastest = np.where(good, 0.0, 1.0), np.where(good, speed, np.inf)
    least = -np.where(J < np.inf, J, np.inf)
    energy = 0.5 * dot(v, v) + stored_energy(part, F, node) if part.loses else 0.0
    densities = {"energy": q[own, 2 * d], "potential_energy": -dot(solid.force, place)}
    densities |= {"solid_energy": energy, "lost_energy": -energy}
    return (bad, fastest, diffusion, least, 0.0), place, v, densities


def stored_energy(part, F, node):
    return part.laws.energy(F) / part.laws.m0 + prestress_energy(part, F, node)


def prestress_energy(part, F, node):
    """S : (F - 1)/m0 of a prestress S [J/kg], of which T knows with heat 'elastic' alone."""
    if part.prestress is None:
        return 0.0
    S = column(part.d * part.d, part.prestress, node)
    return dot(S, add_unit(-1.0, F[: len(S)])) / part.laws.m0


def note_ends(part, q, found):
    """Note place, velocity, sigma and T of nodes at interfaces, in one dimension."""
    solid, ends = part.laws, part.interfaces
    for m in each(ends.shape[0]):
        own, node = ends[m, 1], part.patch.ghosted_rows(ends[m, 1])
        S = 0.0 if part.prestress is None else part.prestress[0, node]
        (x,), (v,), F, T = state_at(part, row(3, q, own), own, node)
        for c, value in enumerate((x, v, solid.line_stress(F) + S - part.p_ref, T)):
            found.at_ends[c][ends[m, 0]] = value
