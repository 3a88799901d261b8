"""What is done with a rank's part of a gas block in a step.

Its monitor bounds the next step:

    convection   sum_k (|a^k . (u - v)| + c |a^k|) / (J h_k)
    diffusion    z nu sum_k |a^k|^2 / (J h_k)^2,  nu = max(4/3 mu/rho, kappa/(rho cv)),
                 z the stiffness of D twice
"""

import numpy as np

from fsipetsc.equations.vectors import add, dot, scale, sub
from fsipetsc.kernels.arrays import column, row
from fsipetsc.kernels.loops import each
from fsipetsc.operators.sbp import STIFFNESS_OF_WIDE
from fsipetsc.scheme.faces import add_areas, turn_plane
from fsipetsc.scheme.gas_terms import find_potential
from fsipetsc.scheme.monitor import along_axes, moment, note_potential, observe
from fsipetsc.scheme.part import area, book, ghosted_node, moving, owned_planes


def follow(part, particles):
    """Note displacement and velocity of the particles here by which the grid moves."""
    follows, known, data, d = part.follows, part.known, particles.data, len(part.like)
    for m in each(follows.shape[0]):
        n, row = follows[m], part.follower_rows[m]
        alone = (particles.facts.moves[n] == 1) & (particles.solid_mass[n] == 0.0)
        for c in range(d):
            known[row, c] = np.where(alone, data.place[n, c], particles.D[n, c])
            known[row, d + c] = np.where(alone, data.wall[n, c], particles.v[n, c])


def edge(part):
    """Find a^k of the grid of now on faces, as far as constraints need it."""
    part.grid.edge(part.known, part.metrics)


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
        add_areas(part, table, part.grid.ahead, part.grid.back)
    elif part.around:
        add_areas(part, table, part.grid.turning)
    elif d == 2:
        turn_plane(part, table)


def add_ends(part, own, q, rates, gain):
    """Add a^k . v / weight, outward, to J_t at the ends of axes: fluxes of pairs do not have it."""
    ends = part.ends
    for i in each(ends.at.shape[0]):
        a = area(part, ends.axis[i], ends.at[i])
        rates[ends.own[i], 0] += ends.factor[i] * dot(a, moving(part, ends.at[i]))


def supply(part, q, ghosted, rates, gain):
    """Add the case's forcing."""
    like = (*part.like, 0.0, 0.0)

    def supplied(i):
        """What a node gets per volume."""
        more = scale(q[i, 0], column(like, part.forcing, i))
        rates[i, 1:] = add(row(like, rates, i, 1), more)
        return more

    book(part, gain, supplied, mass=True)


def find_places(part):
    """Find where the nodes are."""
    part.grid.find_places(part.X, part.places)


def find_volumes(part):
    """Find J of the grid at the owned nodes."""
    part.grid.find_volumes()
    for i in each(part.J.shape[0]):
        part.J[i] = part.grid.volume[ghosted_node(i, part.patch)]


def begin_grid(part):
    """Find a^k and J of a grid where it is now."""
    edge(part)
    part.grid.move(part.metrics)
    find_volumes(part)


def monitor(part, found, y):
    """Note extremes and sums of the owned nodes."""
    if part.moves:
        find_places(part)
        part.grid.find_volumes()
    q, metrics = owned_planes(part, y).T, part.metrics
    if part.around:
        part.grid.bound(metrics)
        metrics = part.grid.bounds
    observe(part, found, lambda own, n: seen_at(part, q, metrics, own, n))
    if part.forced:
        masses, places = part.masses, part.places
        note_potential(part, found, lambda i: masses[i] * q[i, 1], lambda c, i, n: places[c, n])


def seen_at(part, q, metrics, own, n):
    """Return the extremes at a node, and name -> integrand per volume of the reference coordinates;
    metrics: those that bound the step, see the head of this file.
    """
    gas, d, convection, squares = part.laws, len(part.like), 0.0, 0.0
    here = row((0.0,) * (d + 3), q, own)
    w, per_J = gas.primitive(here), 1.0 / here[0]
    c, v = gas.speed_of_sound(w), column(part.like, metrics, n, d * d)
    relative = sub(gas.velocity(w), v)
    for k, per_h in enumerate(part.per_h[k] for k in range(d)):
        a = column(part.like, metrics, n, k * d)
        size = dot(a, a) * per_h * per_h
        convection = convection + (abs(dot(a, relative)) * per_h + c * np.sqrt(size))
        squares = squares + size
    convection = convection * per_J
    diffusion = STIFFNESS_OF_WIDE * gas.diffusivity(w) * (squares * per_J * per_J)
    J, of_map = part.grid.volume[n], part.reference[own]
    positive = np.minimum(np.minimum(w[0], w[2]), here[0]) > 0.0
    apart = abs(here[0] - J) / abs(J)
    known = (convection < np.inf) & (diffusion < np.inf) & (apart < np.inf)  # so are the places
    bad = np.where(known & positive, 0.0, 1.0)
    _, rho, *momentum, energy = here
    return (bad, convection, diffusion, -here[0] / of_map, apart), {
        "mass": rho,
        **along_axes("momentum", momentum),
        "energy": energy,
        "entropy": here[0] * gas.entropy_density(w),
        **moment(column(part.like, part.places, n), momentum),
    }
