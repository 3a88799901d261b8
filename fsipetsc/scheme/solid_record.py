"""A rank's part of a solid block as one record, and what is done with it in a step."""

from typing import Any, NamedTuple


from fsipetsc.equations.tensors import add_unit, outer
from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import CALL, INNER_CALL, column, dot
from fsipetsc.scheme.block_monitor import monitor_end
from fsipetsc.scheme.faces import strain_at
from fsipetsc.scheme.part import add_normals, ghosted, ghosted_node, note, owned
from fsipetsc.scheme.rows import U64, Array
from fsipetsc.scheme.solid_monitor import solid_monitor


class SolidRecord(NamedTuple):
    """A part of a solid block; what has the same name as in GasRecord is the same. volume:
    solid_rates of fsipetsc/scheme/solid.c.

    X: (d, N) places at rest. metrics: (d d + 1, N), A^1 … A^d and J0, then R around an axis;
    prestress: (d d, N) what P has beside, or (d d, 0). work: fsipetsc.scheme.solid_work. inertia:
    (N,) J0 m0, masses: (M,) weights times J0 m0. F: (d d, M), as monitored last. loses: 1 if work
    is booked, for what steps lose of kinetic and elastic energy. forcing: (2d + 1, M), or (2d + 1,
    0), of velocity, temperature and place. interfaces: (n, 4) number of an interface at this part
    in one dimension, owned row of its node, X, prestress. stored_at: (n,) ghosted rows of members
    that tell what they store, rows_of_stored: (n,) where.
    """

    volume: Any
    of_volume: int
    like: Any
    laws: Any
    dissipation: Any
    faces: Any
    block: int
    begin: int
    halo: Array
    wraps: int
    signs: Array
    loses: int
    X: Array
    metrics: Array
    inertia: Array
    prestress: Array
    S: Any
    weight: Any
    patch: Any
    work: Any
    per_h: Array
    masses: Array
    F: Array
    at_particles: Any
    forcing: Array
    seen: Array
    sums: Array
    columns: Array
    level: int
    interfaces: Array
    stored_at: Array
    rows_of_stored: Array


@njit(**CALL)
def stay(part):
    """Solids have no grid to move."""


@njit(**CALL)
def none_of(part, particles):
    """Solids have no grid that follows; their area vectors at rest do not turn."""


@njit(**CALL)
def store(part, particles, s):
    """Tell particles what members of a solid store: energy per mass [J/kg] that is neither kinetic
    nor heat. See fsipetsc.scheme.particle_records.Particles.
    """
    d, solid, extra = len(part.like), part.laws, part.prestress
    q, at, rows = ghosted(part, s, 2 * d + 1), part.stored_at, part.rows_of_stored
    for i in range(at.size):
        strain = strain_at(part, q, at[i])
        energy = solid.energy(strain)
        if extra.shape[1] > 0:
            S = column(outer(part.like, part.like), extra, U64(at[i]))
            energy += dot(S, add_unit(-1.0, strain))
        particles.stored[rows[i], 0] = (1.0 - solid.coupled) * energy / solid.m0


@njit(**CALL)
def rates(part, s, f, gain):
    """Fill a solid's part of f, from that of a completed s; what comes in goes to ``gain``."""
    d, damping = len(part.like), part.dissipation
    q, dof = ghosted(part, s, 2 * d + 1), 2 * d + 1
    own, own_q = owned(part, f, dof), owned(part, s, dof)
    part.volume(part.of_volume, q.ctypes.data, own.ctypes.data)
    work = -damping.power(part, own_q, own)
    damping.add(part, q, own, gain)
    work += damping.power(part, own_q, own)
    work += part.faces.add(part, q, own, gain)
    work += supply(part, own_q, own, gain)
    if part.loses == 1:
        gain.lost[0] += work


@njit(**CALL)
def supply(part, q, rates, gain):
    """Add the case's forcing, and book what body forces give; q, rates: of the owned nodes.
    Returns the work of body forces.
    """
    force, forcing, masses, d = part.laws.force, part.forcing, part.masses, len(part.like)
    impulse, energy, inside, total = gain.impulse, gain.energy, gain.energy.size - 1, 0.0
    for c in range(d):
        b = force[c]
        for i in range(masses.size if b != 0.0 else 0):
            work = masses[i] * b * q[i, d + c]
            total += work
            impulse[c] += masses[i] * b
            energy[inside] += work
            gain.work[0] += work
    for i in range(forcing.shape[1]):
        heat = part.laws.alpha * forcing[d, i]
        for c in range(d):
            push = forcing[c, i]
            rates[i, c] += forcing[d + 1 + c, i]
            rates[i, d + c] += push
            heat += q[i, d + c] * push
            impulse[c] += masses[i] * push
        rates[i, 2 * d] += heat
        energy[inside] += masses[i] * heat
    return total


@njit(**CALL)
def monitor(part, s, found):
    """Note extremes and sums of a part, and what is recorded of interfaces in one dimension; fill
    F.
    """
    laws, like, X, metrics = part.laws, part.like, part.X, part.metrics
    prestress, per_h, loses = part.prestress, part.per_h, part.loses
    q, masses, work, F = ghosted(part, s, 2 * len(like) + 1), part.masses, part.work, part.F
    filled = F, loses, part.seen, part.sums
    solid_monitor(laws, like, q, X, metrics, prestress, per_h, masses, work, *filled)
    note(part, found)
    note_potential(part, owned(part, s, 2 * len(like) + 1), found)
    at_ends, interfaces, own_q = found.at_ends, part.interfaces, owned(part, s, 2 * len(like) + 1)
    for m in range(interfaces.shape[0]):
        number, own, X_of_end, S = interfaces[m]
        of_end = at_ends[:, int(number)]
        monitor_end(laws, like, own_q, F, int(own), S, of_end)
        of_end[0] += X_of_end


@njit(**INNER_CALL)
def note_potential(part, q, found):
    """Note - sum M b . x of the owned nodes, the potential energy of a constant force."""
    masses, X = part.masses, part.X
    for c in range(len(part.like)):
        b, total = part.laws.force[c], 0.0
        for i in range(masses.size if b != 0.0 else 0):
            total -= masses[i] * b * (X[c, ghosted_node(i, part.patch)] + q[i, c])
        if b != 0.0:
            found.latest[part.level] += total


#: what is called of a solid: fsipetsc.scheme.part.PartCalls, without ``part``
FUNCTIONS = none_of, stay, stay, add_normals, none_of, store, rates, monitor
