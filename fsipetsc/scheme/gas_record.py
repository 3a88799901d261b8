"""A rank's part of a gas block as one record, and what is done with it in a step."""

from typing import Any, NamedTuple


from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import CALL
from fsipetsc.scheme.block_monitor import gas_monitor
from fsipetsc.scheme.part import add_normals, ghosted, note, owned
from fsipetsc.scheme.rows import Array


class GasRecord(NamedTuple):
    """A part of a gas block.

    volume: gas_rates of fsipetsc/scheme/gas.c, of_volume: the address of its struct. potential,
    supplied: as GasVolume (fsipetsc.scheme.gas_volume) has them.
    like: d zeros. laws: fsipetsc.equations.gas. faces: fsipetsc.scheme.faces. block: its number,
    begin: of its unknowns in the world vector. X, places: (d, N) of the reference map, and where
    the monitor finds the nodes. metrics: (d d + d + 1, N), a^1 … a^d, velocity of the grid, J_t,
    and around an axis A before it. halo: (N, d + 3), its nodes with a halo, or none; wraps: whether
    it is filled by fsipetsc.scheme.part. S, weight: of three bands. masses: (M,) weights of its own
    nodes.

    follows: (n,) particles by which its grid moves, here: (n, 2d) their displacement and velocity,
    known: (m, 2d) those of all ranks; grid: see fsipetsc.blocks.grid. at_particles: faces at
    constraints, see fsipetsc.scheme.normals. reference: (M,) J of the reference map. forcing: (d +
    2, M), or (d + 2, 0). column: of its mass in what comes in; columns: of its sums in the record
    of a step, level: of the potential energy. axis: fsipetsc.scheme.radial; signs: of images, see
    fsipetsc.parallel.block_layout.
    """

    volume: Any
    of_volume: int
    potential: Array
    supplied: Array
    like: Any
    laws: Any
    form: Any
    dissipation: Any
    axis: Any
    faces: Any
    block: int
    begin: int
    column: int
    halo: Array
    wraps: int
    signs: Array
    X: Array
    places: Array
    metrics: Array
    S: Any
    weight: Any
    patch: Any
    per_h: Array
    room: Array
    masses: Array
    follows: Array
    here: Array
    known: Array
    grid: Any
    at_particles: Any
    reference: Array
    forcing: Array
    seen: Array
    sums: Array
    columns: Array
    level: int


@njit(**CALL)
def follow(part, particles):
    """Note displacement and velocity of the particles here by which the grid moves."""
    follows, here, state, wall = part.follows, part.here, particles.state, particles.data.wall
    moves, place, d = particles.moves, particles.place, len(part.like)
    for m in range(follows.size):
        n = follows[m]
        alone = moves[n] == 1 and state.solid_mass[n] == 0.0
        for c in range(d):
            here[m, c] = place[n, c] if alone else state.D[n, c]
            here[m, d + c] = wall[n, c] if alone else state.v[n, c]


@njit(**CALL)
def move(part):
    """a^k of the grid where it is now."""
    if part.known.shape[0] > 0:
        part.grid.move(part.known, part.metrics)
        part.form.force.follow(part)


@njit(**CALL)
def swing(part):
    """Velocity of the grid and J_t."""
    if part.known.shape[0] > 0:
        part.grid.swing(part.known, part.metrics)


@njit(**CALL)
def turn(part, particles):
    """Add how area vectors at constraints turn."""
    part.axis.turn(part, particles.of_normals)


@njit(**CALL)
def store(part, particles, s):
    """Gases store nothing."""


@njit(**CALL)
def rates(part, s, f, gain):
    """Fill a gas's part of f, from that of a completed s; what comes in goes to ``gain``."""
    d = len(part.like)
    q, own = ghosted(part, s, d + 3), owned(part, f, d + 3)
    part.volume(part.of_volume, q.ctypes.data, own.ctypes.data)
    part.axis.add(part, q, own, gain)
    part.dissipation.add(part, q, own, gain)
    part.faces.add(part, q, own, gain)
    supply(part, owned(part, s, d + 3), own, gain)


@njit(**CALL)
def supply(part, q, rates, gain):
    """Add a constant force and the case's forcing; q, rates: of the owned nodes."""
    forcing, masses, d = part.forcing, part.masses, len(part.like)
    mass, impulse, energy, inside = gain.mass, gain.impulse, gain.energy, gain.energy.size - 1
    part.form.force.add(part, q, rates, gain)
    for c in range(d + 2):
        for i in range(forcing.shape[1]):
            supplied = q[i, 0] * forcing[c, i]
            rates[i, 1 + c] += supplied
            if c == 0:
                mass[part.column] += masses[i] * supplied
            elif c <= d:
                impulse[c - 1] += masses[i] * supplied
            else:
                energy[inside] += masses[i] * supplied


@njit(**CALL)
def monitor(part, s, found):
    """Note extremes and sums of a part: see fsipetsc.scheme.block_monitor."""
    if part.known.shape[0] > 0:
        part.grid.find_places(part.X, part.places)
    metrics = part.axis.bounds(part.metrics)
    q = owned(part, s, len(part.like) + 3)
    gas_monitor(part, q, metrics)
    note(part, found)
    part.form.force.note(part, q, found)


#: what is called of a gas: fsipetsc.scheme.part.PartCalls, without ``part``
FUNCTIONS = follow, move, swing, add_normals, turn, store, rates, monitor
