"""A rank's part of a solid block as one record, and what is done with it in a stage."""

from typing import Any, NamedTuple

from fsipetsc.kernels.arrays import Array
from fsipetsc.kernels.loops import each, variable, when
from fsipetsc.scheme.face_kernels import strain_at
from fsipetsc.scheme.part import ghosted, ghosted_planes, owned, owned_planes
from fsipetsc.scheme.solid_monitor import prestress_energy
from fsipetsc.scheme.solid_sweep import solid_sweep


class SolidRecord(NamedTuple):
    """A part of a solid block; what has the same name as in GasRecord is the same. volume:
    fsipetsc.scheme.solid_sweep.

    X: (d, N) places at rest. metrics: (d d + 1, N), A^1 … A^d and J0, then R around an axis;
    prestress: (d d, N) what P has beside, or None. inertia: (N,) J0 m0, masses: (M,) weights times
    J0 m0. F: (d d, M), or one more with hoops, as monitored last. loses: whether work is booked,
    for what steps lose of kinetic and elastic energy. forcing: (2d + 1, M) of velocity, temperature
    and place, or None. room: (MONITORED and integrals, n) memory of the monitor, n the owned nodes
    along the first axis. interfaces: (n, 4) number of an interface at this
    part in one dimension, owned row of its node, X, prestress. stored_at: (n,) ghosted rows of
    members that tell what they store, rows_of_stored: (n,) where.
    """

    volume: Any
    free: Any
    like: Any
    laws: Any
    dissipation: Any
    faces: Any
    block: int
    begin: int
    halo: Array
    signs: Array
    loses: bool
    X: Array
    metrics: Array
    inertia: Array
    prestress: Array | None
    S: Any
    weight: Any
    patch: Any
    per_h: Array
    masses: Array
    F: Array
    at_particles: Any
    forcing: Array | None
    room: Array
    seen: Array
    sums: Array
    columns: Array
    level: int
    interfaces: Array
    stored_at: Array
    rows_of_stored: Array


def store(part, particles, y):
    """Tell particles what members of a solid store: energy per mass [J/kg] that is neither kinetic
    nor heat. See fsipetsc.particles.system.Particles.
    """
    rows, at, solid = part.rows_of_stored, part.stored_at, part.laws
    if solid.coupled:
        for i in each(rows.shape[0]):
            particles.stored[rows[i], 0] = 0.0
        return
    q = ghosted(part, y, 2 * len(part.like) + 1)
    for i in each(rows.shape[0]):
        F = strain_at(part, q, at[i])
        energy = solid.energy(F) / solid.m0 + prestress_energy(part, F, at[i])
        particles.stored[rows[i], 0] = energy


def rates(part, gain, found, y, f):
    """Fill a solid's part of f, from that of a completed y: with rates, or where nothing adds to
    them with a stage (fsipetsc.scheme.sweep). What comes in goes to ``gain``.
    """
    dof = 2 * len(part.like) + 1
    planes, of_f = ghosted_planes(part, y, dof), owned_planes(part, f, dof)
    solid_sweep(part, found, owned_planes(part, y, dof), planes, of_f)
    q, own = planes.turned(), of_f.turned()
    work = part.dissipation.add(part, q, own, gain)
    work += part.faces.add(part, q, own, gain)
    work += supply(part, owned(part, y, dof), own, gain)
    if part.loses:
        gain.lost[0] += work


def supply(part, q, rates, gain):
    """Add the case's forcing, and book what body forces give; q, rates: of the owned nodes.
    Returns the work of body forces.
    """
    masses, d, total = part.masses, len(part.like), variable(0.0)
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
    if part.forcing is not None:
        force(part, q, rates, gain)
    return total.value


def force(part, q, rates, gain):
    """Add the case's forcing to the rates, and book what it gives."""
    masses, forcing, d = part.masses, part.forcing, len(part.like)
    impulse, energy, inside = gain.impulse, gain.energy, gain.energy.size - 1
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
