"""What is done with a rank's part of a solid block in a step.

Its monitor bounds the next step as that of a gas (fsipetsc.scheme.gas_procedures), but with
convection sqrt(sum_k (c |A^k| / (J0 h_k))^2),  c^2 the largest wave modulus over m0.
"""

import numpy as np

from fsipetsc.equations.tensors import add_unit, product, transpose
from fsipetsc.equations.vectors import add, dot, per
from fsipetsc.kernels.arrays import column, row
from fsipetsc.kernels.loops import each, variable, when, whole
from fsipetsc.operators.sbp import STIFFNESS_OF_WIDE
from fsipetsc.scheme.face_kernels import strain_at
from fsipetsc.scheme.monitor import along_axes, moment, note, observe, turning
from fsipetsc.scheme.part import area, ghosted_node, ghosted_planes, owned, owned_planes, rows_of


def store(part, particles, y):
    """Tell particles what members of a solid store: energy per mass [J/kg] that is neither kinetic
    nor heat. See fsipetsc.particles.system.
    """
    rows, at, solid = part.rows_of_stored, part.stored_at, part.laws
    if solid.coupled:
        for i in each(rows.shape[0]):
            particles.stored[rows[i], 0] = 0.0
        return
    q = ghosted_planes(part, y, 2 * len(part.like) + 1).T
    for i in each(rows.shape[0]):
        F = strain_at(part, q, at[i])
        energy = solid.energy(F) / solid.m0 + prestress_energy(part, F, at[i])
        particles.stored[rows[i], 0] = energy


def rates(part, gain, found, y, f):
    """Fill the part of f, from that of a completed y, with rates or stages (fsipetsc.scheme.sweep).
    What comes in goes to ``gain``.
    """
    dof = 2 * len(part.like) + 1
    planes, of_f = ghosted_planes(part, y, dof), owned_planes(part, f, dof)
    part.volume.sweep(part, found, owned_planes(part, y, dof), planes, of_f)
    q, own = planes.T, of_f.T
    work = part.dissipation.add(part, q, own, gain)
    work += part.faces.add(part, q, own, gain)
    work += supply(part, owned(part, y, dof), own, gain)
    if part.loses:
        gain.lost[0] += work


def supply(part, q, rates, gain):
    """Add the case's forcing to the rates, and book what it and body forces give; q, rates: of the
    owned nodes. Returns the work of body forces.
    """
    masses, forcing, d, total = part.masses, part.forcing, len(part.like), variable(0.0)
    impulse, energy, inside = gain.impulse, gain.energy, gain.energy.size - 1
    for c in range(d):
        b = part.laws.force[c]
        with when(b != 0.0):
            work, push = variable(0.0), variable(0.0)
            for i in each(masses.size):
                work.value += masses[i] * b * q[i, d + c]
                push.value += masses[i] * b
            total.value += work.value
            impulse[c] += push.value
            energy[inside] += work.value
            gain.work[0] += work.value
    if forcing is None:
        return total.value
    for i in each(masses.size):
        heat = part.laws.alpha * forcing[d, i]
        for c in range(d):
            push = forcing[c, i]
            heat = heat + q[i, d + c] * push
            rates[i, c] += forcing[d + 1 + c, i]
            rates[i, d + c] += push
            impulse[c] += masses[i] * push
        rates[i, 2 * d] += heat
        energy[inside] += masses[i] * heat
    return total.value


def solid_integrals(d):
    """Return the names of the integrals of a solid in the order of its sums; one more sum follows,
    minus the last integral.
    """
    return *along_axes("momentum", d), "energy", *turning(d), "solid_energy"


def monitor(part, found, y):
    """Note extremes and sums, and what is recorded of interfaces in one dimension; fill F."""
    d = len(part.like)
    own = owned(part, y, 2 * d + 1)
    find(part, owned_planes(part, y, 2 * d + 1), ghosted_planes(part, y, 2 * d + 1))
    note(part, found)
    note_potential(part, own, found)
    if d == 1:
        note_ends(part, own, found)


def measure(part, y, q):
    """Fill seen, sums and F of a part of a solid block; y, q: planes of its owned nodes, and of
    those with a halo.
    """
    dof = 2 * len(part.like) + 1
    find(part, y.reshape(dof, part.masses.shape[0]), q.reshape(dof, part.metrics.shape[1]))


def find(part, y, q):
    """Fill seen, F and sums; y, q: planes of the owned nodes, and of those of the halo."""
    part.volume.sweep_strains(part, y, q, part.F)
    names = solid_integrals(len(part.like))
    observe(part, names, lambda own, node: seen_at(part, y.T, own, node))
    part.sums[-1] = -part.sums[part.sums.size - 2]


def stressed(part, q, out):
    """Fill planes of the owned nodes with T, p, the Cauchy stress P F^T/J and that of hoops, by the
    last F; q: planes of the ghosted nodes.
    """
    d, solid, M = len(part.like), part.laws, part.masses.shape[0]
    zeros, q = (0.0,) * d, q.reshape(2 * d + 1, part.metrics.shape[1]).T
    for node, own, n in rows_of(part):
        for i in each(n, vector=True):
            at, F = node + i, column(solid.unstrained(zeros), part.F, own + i)
            v, e = row(zeros, q, at, d), q[at, 2 * d]
            extra = 0.0 if solid.coupled else prestress_energy(part, F, at)
            T, J = solid.temperature(v, e - extra, F), solid.volume(F)
            P = solid.stress_at(F, T)
            if part.prestress is not None:
                P = add(P, column((0.0,) * d * d, part.prestress, at))
            stress = per(product(P, transpose(F[: d * d])), J)
            hoops = (solid.hoop_stress(F, T),) if solid.around else ()
            for c, number in enumerate((T, solid.pressure_at(J, T), *stress, *hoops)):
                out[c * M + own + i] = number


def seen_at(part, q, own, node):
    """Return the extremes at a node, and name -> what integrals have of it per mass. Convection is
    inf where the state is not physical; a J that is no number is left out.
    """
    solid, metrics, d = part.laws, part.metrics, len(part.like)
    zeros = (0.0,) * d
    displacement, v, e = row(zeros, q, own), row(zeros, q, own, d), q[own, 2 * d]
    F = column(solid.unstrained(zeros), part.F, own)
    extra = prestress_energy(part, F, node)
    T, J = solid.temperature(v, e if solid.coupled else e - extra, F), solid.volume(F)
    squares, J0 = 0.0, metrics[d * d, node]
    for k in range(d):
        A = area(part, k, node)
        squares = squares + dot(A, A) * part.per_h[k] * part.per_h[k]
    squares = squares / (J0 * J0)
    if solid.around:
        squares = squares + solid.curvature(metrics[d * d + 1, node])
    modulus = solid.wave_modulus_at(F, T)
    speed = np.sqrt(np.maximum(modulus, 0.0) / solid.m0 * squares)
    fastest = np.where((J > 0.0) & (T > 0.0) & (modulus > -1e-300), speed, np.inf)
    fastest = np.where(fastest < np.inf, fastest, np.inf)
    diffusion = STIFFNESS_OF_WIDE * solid.kappa / (solid.m0 * solid.alpha) * squares
    bad, least = np.where(fastest < np.inf, 0.0, 1.0), -np.where(J < np.inf, J, np.inf)
    energy = 0.5 * dot(v, v) + solid.energy(F) / solid.m0 + extra if part.loses else 0.0
    x = add(column(zeros, part.X, node), displacement)
    densities = {
        **dict(zip(along_axes("momentum", d), v, strict=True)),
        "energy": e,
        **dict(zip(turning(d), moment(x, v), strict=True)),
        "solid_energy": energy,
    }
    return (bad, fastest, diffusion, least, 0.0), densities


def prestress_energy(part, F, node):
    """S : (F - 1)/m0 of a prestress S [J/kg], of which T knows with heat 'elastic' alone."""
    if part.prestress is None:
        return 0.0
    zeros = (0.0,) * len(part.like) ** 2
    S, strain = column(zeros, part.prestress, node), F[: len(zeros)]
    return dot(S, add_unit(-1.0, strain)) / part.laws.m0


def note_potential(part, q, found):
    """Note - sum M b . x of the owned nodes, the potential energy of a constant force."""
    masses, X = part.masses, part.X
    for c in range(len(part.like)):
        b = part.laws.force[c]
        with when(b != 0.0):
            total = variable(0.0)
            for i in each(masses.size):
                place = X[c, ghosted_node(i, part.patch)] + q[i, c]
                total.value -= masses[i] * b * place
            found.latest[part.level] += total.value


def note_ends(part, q, found):
    """Note displacement, velocity, sigma and T of nodes at interfaces, in one dimension."""
    solid, ends = part.laws, part.interfaces
    for m in each(ends.shape[0]):
        number, own, X, S = whole(ends[m, 0]), whole(ends[m, 1]), ends[m, 2], ends[m, 3]
        F, v, e = column(solid.unstrained((0.0,)), part.F, own), (q[own, 1],), q[own, 2]
        stored = 0.0 if solid.coupled else S * (F[0] - 1.0) / solid.m0
        of_end = X + q[own, 0], v[0], solid.line_stress(F) + S, solid.temperature(v, e - stored, F)
        for c, value in enumerate(of_end):
            found.at_ends[c][number] = value
