"""What is done with a rank's part of a gas block in a step.

Its monitor bounds the next step:

    convection   sum_k (|a^k . (u - v)| + c |a^k|) / (J h_k)
    diffusion    z nu sum_k |a^k|^2 / (J h_k)^2,  nu = max(4/3 mu/rho, kappa/(rho cv)),
                 z the stiffness of D twice
"""

import numpy as np

from fsipetsc.equations.vectors import dot, sub
from fsipetsc.kernels.arrays import column, row
from fsipetsc.kernels.loops import each, variable
from fsipetsc.operators.sbp import STIFFNESS_OF_WIDE
from fsipetsc.scheme.gas_force import add_force, find_potential, note_potential
from fsipetsc.scheme.monitor import along_axes, moment, note, observe, turning
from fsipetsc.scheme.normals import add_areas, turn_plane
from fsipetsc.scheme.part import area, ghosted_node, ghosted_planes, moving, owned, owned_planes
from fsipetsc.scheme.radial import add_radial


def follow(part, particles):
    """Note displacement and velocity of the particles here by which the grid moves."""
    follows, known, data, d = part.follows, part.known, particles.data, len(part.like)
    for m in each(follows.shape[0]):
        n, row = follows[m], part.rows[m]
        alone = (particles.moves[n] == 1) & (particles.solid_mass[n] == 0.0)
        for c in range(d):
            known[row, c] = np.where(alone, data.place[n, c], particles.D[n, c])
            known[row, d + c] = np.where(alone, data.wall[n, c], particles.v[n, c])


def edge(part):
    """Find a^k of the grid of now on faces, as far as constraints need it."""
    part.grid.edge(part.known, part.metrics)


def begin_grid(part):
    """Find a^k of a grid where it is now."""
    edge(part)
    part.grid.move(part.metrics)


def move(part):
    """Find where the grid is now, and a^k, as far as `edge` has not."""
    part.grid.move(part.metrics)
    if part.form.raises:
        find_potential(part)


def swing(part):
    """Find the velocity of the grid."""
    part.grid.swing(part.known, part.metrics)


def turn(part, particles):
    """Add how area vectors at constraints turn."""
    table, d = particles.of_normals, len(part.like)
    if d == 3:
        part.grid.turn()
        add_areas(part.at_particles, d, part.grid.ahead, table, part.grid.back)
    elif part.around:
        add_areas(part.at_particles, d, part.grid.turning, table)
    elif d == 2:
        turn_plane(part, table)


def rates(part, gain, found, y, f):
    """Fill the part of f, from that of a completed y, with rates or stages (fsipetsc.scheme.sweep).
    What comes in goes to ``gain``.
    """
    d = len(part.like)
    planes, of_f = ghosted_planes(part, y, d + 3), owned_planes(part, f, d + 3)
    part.volume.sweep(part, found, owned_planes(part, y, d + 3), planes, of_f)
    q, own = planes.T, of_f.T
    if part.moves:
        add_ends(part, own)
    if part.around:
        add_radial(part, q, own)
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
    """Note extremes and sums of the owned nodes."""
    if part.moves:
        find_places(part)
        part.grid.find_volumes()
    q, metrics = owned(part, y, len(part.like) + 3), part.metrics
    if part.around:
        part.grid.bound(metrics)
        metrics = part.grid.bounds
    names = gas_integrals(len(part.like))
    observe(part, names, lambda own, n: seen_at(part, q, metrics, own, n))
    note(part, found)
    if part.forced:
        note_potential(part, q, found)


def gas_integrals(d):
    """Return the names of the integrals of a gas, in the order of its sums."""
    return "mass", *along_axes("momentum", d), "energy", "entropy", *turning(d)


def seen_at(part, q, metrics, own, n):
    """Return the extremes at a node, and name -> integrand per volume of the reference coordinates;
    metrics: those that bound the step, see the head of this file.
    """
    gas, d, convection, squares = part.laws, len(part.like), 0.0, 0.0
    here = row((0.0,) * (d + 3), q, own)
    w, per_J = gas.primitive(here), 1.0 / here[0]
    c, relative = (
        gas.speed_of_sound(w),
        sub(gas.velocity(w), column(part.like, metrics, n, d * d)),
    )
    for k, per_h in enumerate(part.per_h[k] for k in range(d)):
        a = column(part.like, metrics, n, k * d)
        size = dot(a, a) * per_h * per_h
        convection = convection + (abs(dot(a, relative)) * per_h + c * np.sqrt(size))
        squares = squares + size
    convection = convection * per_J
    diffusion = STIFFNESS_OF_WIDE * gas.diffusivity(w) * (squares * per_J * per_J)
    J, of_map = part.grid.jacobian(part.metrics, n), part.reference[own]
    positive = np.minimum(np.minimum(w[0], w[2]), here[0]) > 0.0
    apart = abs(here[0] - J) / abs(J)
    known = (convection < np.inf) & (diffusion < np.inf) & (apart < np.inf)  # so are the places
    bad = np.where(known & positive, 0.0, 1.0)
    _, rho, *momentum, energy = here
    turns = moment(column(part.like, part.places, n), momentum)
    return (bad, convection, diffusion, -here[0] / of_map, apart), {
        "mass": rho,
        **dict(zip(along_axes("momentum", d), momentum, strict=True)),
        "energy": energy,
        "entropy": here[0] * gas.entropy_density(w),
        **dict(zip(turning(d), turns, strict=True)),
    }
