"""What procedures share for a rank's part of a block, of gas or solid. They take the part as a
record: arrays and numbers with names, which fsipetsc.blockrun makes. Of M owned nodes, and of N in
the ghosted array, in d dimensions it has

    like: d zeros. laws: fsipetsc.equations.gas or solid. block: its number. patch, S, weight: its
    nodes, and three bands (fsipetsc.operators.bands). begin: of its unknowns in the world vector.
    halo: (unknowns, N), its nodes with a halo, or (unknowns, 0) without. signs: of images, see
    fsipetsc.parallel.block_layout. X: (d, N) of the reference map, or at rest. metrics: of a gas
    (d d + d, N), a^1 … a^d, velocity of the grid, and around an axis A; of a solid (d d + 1, N),
    A^1 … A^d and J0, then R around an axis. masses: (M,) weights of the nodes, of a solid times
    J0 m0. at_particles: faces at constraints, see fsipetsc.scheme.normals.

    volume: what the sweep takes (fsipetsc.scheme.gas_sweep, solid_sweep). free: first node and
    first beyond along each axis, first, second one of three, last one, of the owned nodes to whose
    rates nothing is added after the sweep. dissipation, faces: what adds to rates. forcing: by
    components of M nodes, or None: of mass, velocities and energy per mass of a gas; of velocity,
    temperature and place of a solid.

    per_h: (d,) cells of the block. room, seen, sums: of the monitor (fsipetsc.scheme.monitor).
    columns: of sums in the record of a step, level: of the potential energy.

    Of a gas: form: of convection. forced: whether a constant force acts. around, hoops: see
    fsipetsc.scheme.radial. column: of its mass in what comes in. places: (d, N) where the monitor
    finds the nodes. ends: nodes at the ends of axes, one at an edge once for each axis: at, own,
    axis: (n,) numbers in the ghosted array and among the owned nodes, axis; factor: sign of the
    outward normal over the weight of the axis. moves: whether its grid moves; grid: see
    fsipetsc.blocks.grid. known: (m, 2d) displacements and velocities by which it moves, follows:
    (n,) particles here that have them, rows: (n,) where. reference, J: (M,) J of the reference map,
    and of the grid, by `find_volumes`.

    Of a solid: inertia: (N,) J0 m0. prestress: (d d, N) what P has beside, or None. F: (d d, M), or
    one more with hoops, as monitored last. loses: whether work is booked, for what steps lose of
    kinetic and elastic energy. interfaces: (n, 4) number of an interface at this part in one
    dimension, owned row of its node, X, prestress. stored_at: (n,) ghosted rows of members that
    tell what they store, rows_of_stored: (n,) where.

``gain`` is a record of what comes into the problem from outside. numbers: all that follow, in the
order of the record of a step. mass: of each block of gas. lost: (1,) work on solids if it
is booked, else (0,). work: (1,) work of constant forces if there are any, else (0,). impulse: (d,).
energy: through each outer face; the last one is of what comes through no face. heat: the part of
energy that is heat. total: (1,) the sum of energy.
"""

from __future__ import annotations

from types import SimpleNamespace

from fsipetsc.kernels.arrays import column, row
from fsipetsc.kernels.loops import each, either


class Nothing(SimpleNamespace):
    """Stands for a term that is absent, as dissipation or fluxes at closed faces."""

    def add(self, part, q, rates, gain):
        """Add nothing; the work is 0."""
        return 0.0


def owned_planes(part, s, dof):
    """Return (dof, M), planes of the owned numbers of this part in a world vector s."""
    n = part.masses.shape[0]
    return s[part.begin : part.begin + n * dof].reshape(dof, n)


def ghosted_planes(part, s, dof):
    """Return (dof, N), planes of this part with its halo, if it has one, which an exchange has
    filled. Where only sweeps read the halo, its owned nodes may be older than s
    (fsipetsc.blockrun.block_part).
    """
    n = part.metrics.shape[1]
    own = s[part.begin : part.begin + n * dof]
    return either(part.halo.shape[1] > 0, part.halo.reshape(-1), own).reshape(dof, n)


def owned(part, s, dof):
    """Return (M, dof), the same as `owned_planes` by nodes."""
    return owned_planes(part, s, dof).T


def area(part, k, n):
    """Return a^k of a gas, or A^k of a solid, at a node of the ghosted array."""
    return column(part.like, part.metrics, n, k * len(part.like))


def moving(part, n):
    """Return the velocity of a gas's grid at a node of the ghosted array."""
    return area(part, len(part.like), n)


def gas_at(part, q, n):
    """Return the primitive variables of a gas at a node of q."""
    return part.laws.primitive(row((*part.like, 0.0, 0.0, 0.0), q, n))


def ghosted_node(i, patch):
    """Return the number in the ghosted array of the owned node i."""
    (n0, n1, _), (g0, g1, _), (f0, f1, f2) = patch.own, patch.ghosted, patch.first
    return f0 + i % n0 + g0 * (f1 + i // n0 % n1 + g1 * (f2 + i // (n0 * n1)))


def rows_of(part):
    """Yield rows of owned nodes: the first in ghosted arrays, among the owned ones, how many."""
    (n0, n1, n2), (g0, g1, _), (f0, f1, f2) = part.patch.own, part.patch.ghosted, part.patch.first
    for z in each(n2):
        for y in each(n1):
            yield f0 + g0 * (f1 + y + g1 * (f2 + z)), n0 * (y + n1 * z), n0


def images(part):
    """Fill the halo before r = 0 with mirror images of the nodes behind it, times part.signs."""
    values, signs = part.halo, part.signs
    (g0, _, _), (f0, f1, _) = part.patch.ghosted, part.patch.first
    rows, n = (f0, 1) if len(part.like) == 1 else (f1, g0)
    for c in each(signs.shape[0]):
        for i in each(rows * n):
            image = (rows - 1 - i // n) * n + i % n
            values[c, image] = signs[c] * values[c, rows * n + i]


def clear(numbers):
    """Set all numbers of an array to 0."""
    for i in each(numbers.size, vector=True):
        numbers[i] = 0.0
