"""A rank's part of a gas block as one record, and what is done with it in a step."""

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.equations.vectors import dot
from fsipetsc.kernels.arrays import Array
from fsipetsc.kernels.loops import each, variable
from fsipetsc.scheme.block_monitor import gas_monitor, note
from fsipetsc.scheme.gas_force import add_force, find_potential, note_potential
from fsipetsc.scheme.gas_sweep import gas_sweep
from fsipetsc.scheme.part import area, ghosted_node, ghosted_planes, moving, owned, owned_planes


class Ends(NamedTuple):
    """Nodes at the ends of axes, one at an edge once for each axis. at, own, axis: (n,) numbers in
    the ghosted array and among the owned nodes, axis; factor: sign of the outward normal over the
    weight of the axis.
    """

    at: Array
    own: Array
    axis: Array
    factor: Array


class GasRecord(NamedTuple):
    """A part of a gas block.

    volume: fsipetsc.scheme.gas_sweep. free: first node and first beyond along each axis, first,
    second one of three, last one, of the owned nodes to whose rates nothing is added after the
    sweep. like: d zeros. laws: fsipetsc.equations.gas. forced: whether a constant force acts.
    faces: fsipetsc.scheme.face_kernels. block: its number, begin: of its unknowns in the world
    vector. X, places: (d, N) of the reference map, and where the monitor finds the nodes. metrics:
    (d d + d, N), a^1 … a^d, velocity of the grid, and around an axis A. ends: of the axes. halo: (d
    + 3, N), its nodes with a halo, or (d + 3, 0) without. S, weight: of three bands. masses: (M,)
    weights of its own nodes.

    known: (m, 2d) displacements and velocities by which its grid moves, if it moves;
    follows: (n,) particles here that have them, rows: (n,) where; grid: see fsipetsc.blocks.grid.
    at_particles: faces at constraints, see fsipetsc.scheme.normals. reference, J: (M,) J of the
    reference map, and of the grid, by `find_volumes`. forcing: (d + 2, M), or None. column: of its
    mass in what comes in; columns: of its sums in the record of a step, level: of the potential
    energy. axis: fsipetsc.scheme.radial; signs: of images, see fsipetsc.parallel.block_layout.
    """

    volume: Any
    free: Any
    like: Any
    laws: Any
    form: Any
    forced: bool
    dissipation: Any
    axis: Any
    faces: Any
    block: int
    begin: int
    column: int
    halo: Array
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
    rows: Array
    known: Array
    moves: bool
    ends: Ends
    grid: Any
    at_particles: Any
    reference: Array
    J: Array
    forcing: Array | None
    seen: Array
    sums: Array
    columns: Array
    level: int


def follow(part, particles):
    """Note displacement and velocity of the particles here by which the grid moves."""
    follows, known, state, wall = part.follows, part.known, particles.state, particles.data.wall
    d, place = len(part.like), particles.place
    for m in each(follows.shape[0]):
        n, row = follows[m], part.rows[m]
        alone = (particles.moves[n] == 1) & (state.solid_mass[n] == 0.0)
        for c in range(d):
            known[row, c] = np.where(alone, place[n, c], state.D[n, c])
            known[row, d + c] = np.where(alone, wall[n, c], state.v[n, c])


def begin_grid(part):
    """Find a^k of a grid before it moves."""
    part.grid.move(part.known, part.metrics)


def move(part):
    """Find where the grid is now, and a^k."""
    part.grid.move(part.known, part.metrics)
    if part.form.raises:
        find_potential(part)


def swing(part):
    """Find the velocity of the grid."""
    part.grid.swing(part.known, part.metrics)


def turn(part, particles):
    """Add how area vectors at constraints turn."""
    part.axis.turn(part, particles.of_normals)


def rates(part, gain, found, y, f):
    """Fill a gas's part of f, from that of a completed y: with rates, or where nothing adds to them
    with a stage (fsipetsc.scheme.sweep). What comes in goes to ``gain``.
    """
    d = len(part.like)
    planes, of_f = ghosted_planes(part, y, d + 3), owned_planes(part, f, d + 3)
    gas_sweep(part, found, owned_planes(part, y, d + 3), planes, of_f)
    q, own = planes.turned(), of_f.turned()
    if part.moves:
        add_ends(part, own)
    part.axis.add(part, q, own, gain)
    part.dissipation.add(part, q, own, gain)
    part.faces.add(part, q, own, gain)
    q = owned(part, y, d + 3)
    if part.forced:
        add_force(part, q, own, gain)
    if part.forcing is not None:
        supply(part, q, own, gain)


def add_ends(part, rates):
    """Add a^k . v / weight, outward, to J_t at the ends of axes: fluxes of pairs do not have it."""
    ends = part.ends
    for i in each(ends.at.shape[0]):
        a = area(part, ends.axis[i], ends.at[i])
        rates[ends.own[i], 0] += ends.factor[i] * dot(a, moving(part, ends.at[i]))


def supply(part, q, rates, gain):
    """Add the case's forcing; q, rates: of the owned nodes."""
    masses, sums = part.masses, [variable(0.0) for _ in range(len(part.like) + 2)]
    for i in each(masses.shape[0]):
        for c, total in enumerate(sums):
            supplied = q[i, 0] * part.forcing[c, i]
            rates[i, 1 + c] += supplied
            total.value += masses[i] * supplied
    mass, *impulse, energy = (total.value for total in sums)
    gain.mass[part.column] += mass
    for c, number in enumerate(impulse):
        gain.impulse[c] += number
    gain.energy[-1] += energy


def find_places(part):
    """Find where the nodes are."""
    part.grid.find_places(part.X, part.places)


def find_volumes(part):
    """Find J of the grid at the owned nodes."""
    part.grid.find_volumes()
    for i in each(part.J.shape[0]):
        part.J[i] = part.grid.jacobian(part.metrics, ghosted_node(i, part.patch))


def monitor(part, found, y):
    """Note extremes and sums of a part: see fsipetsc.scheme.block_monitor."""
    if part.moves:
        find_places(part)
        part.grid.find_volumes()
    q = owned(part, y, len(part.like) + 3)
    gas_monitor(part, q, part.axis.bounds(part.metrics))
    note(part, found)
    if part.forced:
        note_potential(part, q, found)
