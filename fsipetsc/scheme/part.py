"""What procedures share for a rank's part of a block, of gas or solid. They take the part as a
record: arrays and numbers with names (fsipetsc.stepping.block_part). Of M owned nodes, and of N in
the ghosted array, in d dimensions it has what fsipetsc.parallel.block_layout.Part has, and

    d: known when a procedure is recorded, as it says how many numbers tuples have; values of other
    numbers are not. laws: fsipetsc.equations.gas or solid. S, weight: bands of the three axes, with
    zeros behind. axes: (3, 3) of each axis its longest pair, nodes, and how far these are apart in
    the ghosted array. X: (d, N) of the reference map, or at rest. metrics: of a gas (d d + d, N),
    a^1 … a^d, velocity of the grid, and around an axis A; of a solid (d d + 1, N), A^1 … A^d and
    J0, then R around an axis. masses: (M,) weights of the nodes, of a solid times J0 m0.
    at_particles: see fsipetsc.particles.system.

    volume: the sweep. free: first node and first beyond along each axis, first, second one of
    three, last one, of the owned nodes to whose rates nothing is added after the sweep. terms:
    functions that add to rates, by owned and by ghosted unknowns, or records with such a function
    `add`. forcing: by components of M nodes, or None: of mass, velocities and energy per mass of a
    gas; of velocity, temperature and place of a solid. loses: whether work is booked. per_h: (d,)
    cells of the block. points: (n, 2) number and owned row of nodes that are recorded, or None.
    room: of fsipetsc.scheme.monitor.survey. columns: name -> where a series begins in the record of
    a step.

    Of a gas: form: of convection. around: whether it is around an axis. column: of its mass in what
    comes in. places: (d, N) where the monitor finds the nodes. ends: nodes at the ends of axes, one
    at an edge once for each axis, as in fsipetsc.scheme.face_terms. moves: whether its grid moves;
    grid: see fsipetsc.blocks.grid. known: (m, 2d) displacements and velocities by which it moves,
    follows: particles here that have them, follower_rows: where. reference, J: (M,) of the
    reference map, and of the grid, by `find_volumes`.

    Of a solid: inertia: (N,) J0 m0, inverses: (2, N) of J0 and of that. prestress: (d d, N) what P
    has beside, or None. F: (d d, M), or one more with hoops, as monitored last. interfaces: (n, 2)
    number of an interface at this part in one dimension, and owned row of its node. stored_at:
    ghosted rows of members that tell what they store, rows_of_stored: where.

``gain`` is a record of what comes into the problem from outside. numbers: all that follow, in the
order of the record of a step. mass: of each block of gas. lost, work: (1,) work on solids if it is
booked, work of constant forces if there are any, else (0,). impulse: (d,). energy: through each
outer face; the last one is of what comes through no face. heat: what of it is heat. total: (1,).
"""

from fsipetsc.kernels.loops import column, each, either, row, variable


def owned_planes(part, s):
    """Return (dof, M), planes of the owned numbers of this part in a world vector s."""
    n = part.masses.shape[0]
    return s[part.begin : part.begin + n * part.dof].reshape(part.dof, n)


def ghosted_planes(part, s):
    """Return (dof, N), planes of this part with its halo, if it has one, which an exchange has
    filled. Where only sweeps read the halo, its owned nodes may be older than s.
    """
    n = part.metrics.shape[1]
    own = s[part.begin : part.begin + n * part.dof]
    return either(part.halo.shape[1] > 0, part.halo.reshape(-1), own).reshape(part.dof, n)


def area(part, k, n):
    """Return a^k of a gas, or A^k of a solid, at a node of the ghosted array."""
    return column(part.d, part.metrics, n, k * part.d)


def moving(part, n):
    """Return the velocity of a gas's grid at a node of the ghosted array."""
    return area(part, part.d, n)


def gas_at(part, q, n):
    """Return the primitive variables of a gas at a node of q."""
    return part.laws.primitive(row(part.d + 3, q, n))


def rows_of(part):
    """Yield rows of owned nodes: the first in ghosted arrays, among the owned ones, how many."""
    (n0, n1, n2), (g0, g1, _), (f0, f1, f2) = part.patch
    for z in each(n2):
        for y in each(n1):
            yield f0 + g0 * (f1 + y + g1 * (f2 + z)), n0 * (y + n1 * z), n0


def nodes_of(part):
    """Yield the numbers of the owned nodes, in ghosted arrays and among the owned ones, in loops
    whose passes do not depend on one another.
    """
    for node, own, n in rows_of(part):
        for i in each(n, vector=True):
            yield node + i, own + i


def images(part):
    """Fill the halo before r = 0 with mirror images of the nodes behind it, times part.signs."""
    values, signs = part.halo, part.signs
    (g0, _, _), (f0, f1, _) = part.patch.ghosted, part.patch.first
    rows, n = (f0, 1) if part.d == 1 else (f1, g0)
    for c in each(signs.shape[0]):
        for i in each(rows * n):
            image = (rows - 1 - i // n) * n + i % n
            values[c, image] = signs[c] * values[c, rows * n + i]


def rates(part, gain, found, y, f):
    """Fill the part of f, from that of a completed y, with rates or stages; add to ``gain``."""
    own, q, of_f = owned_planes(part, y), ghosted_planes(part, y), owned_planes(part, f)
    part.volume.sweep(part, found, own, q, of_f)
    for term in part.terms:
        getattr(term, "add", term)(part, own.T, q.T, of_f.T, gain)


def book(part, gain, of, mass=False):
    """Add to what comes in through no face the sums over owned nodes of what of(i) returns per mass
    of node i: mass if there is any, momentum, energy. Return the energy.
    """
    sums = [variable(0.0) for _ in range(part.d + 1 + mass)]
    for i in each(part.masses.size):
        for total, value in zip(sums, of(i), strict=True):
            total.value += part.masses[i] * value
    if mass:
        gain.mass[part.column] += sums.pop(0).value
    for c, total in enumerate(sums[:-1]):
        gain.impulse[c] += total.value
    gain.energy[-1] += sums[-1].value
    return sums[-1].value
