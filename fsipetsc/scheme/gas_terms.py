"""What a gas has beside its sweep: fluxes of pairs, a constant force, what is done in a step.

A constant force b, such as gravity, acts node by node: J rho b and its power are added to rates.
With the two-point fluxes that conserve entropy, it comes from its potential Phi = - b . x, pair by
pair (fsipetsc.equations.gas). Then a gas of uniform temperature stays at rest to round-off, and on
a grid at rest energy plus rho Phi is kept (docs/derivation.md).

Dissipation (fsipetsc.scheme.dissipation) must not disturb that rest, and mass that diffuses in
the potential does work. The energy with rho Phi has the entropy variables

    z~ = ((h - |u|^2/2 + Phi)/T - s, u/T, -1/T),

all of which are constant in a gas at rest. With Phi_m in the middle of a difference, Delta z in
F = sigma/4^q lambda U_z Delta z is replaced by

    c = (Delta (z_1 + (Phi - Phi_m)/T), Delta u/T, Delta -1/T),

and a node i gets - (F_rho, F_m, F_E + (Phi_m - Phi_i) F_rho): entropy grows by c . U_z c > 0. At
shocks the link from m to m + 1 exerts the force {a} rho^ (Phi_m+1 - Phi_m)/2 of its areas on both
nodes, as a pair does. The flux of Lax and Friedrichs takes the states of both nodes, moved in the
force to their mean potential at their own temperatures, which are equal in a gas at rest. Their
entropy variables differ by c, so c . (U*_m+1 - U*_m) > 0.

The monitor bounds the next step:

    convection   sum_k (|a^k . (u - v)| + c |a^k|) / (J h_k)
    diffusion    z nu sum_k |a^k|^2 / (J h_k)^2,  nu = max(4/3 mu/rho, kappa/(rho cv)),
                 z the stiffness of D twice
"""

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.equations.gas import named
from fsipetsc.equations.vectors import add, dot, scale, sub
from fsipetsc.kernels.loops import column, each, row
from fsipetsc.kernels.symbols import exact
from fsipetsc.materials.stiffened_gas import PerfectGas, stiffened_gas
from fsipetsc.operators.sbp import STIFFNESS_OF_WIDE
from fsipetsc.scheme.face_terms import add_areas, turn_plane
from fsipetsc.scheme.monitor import note_points, observe
from fsipetsc.scheme.part import area, book, moving, nodes_of, owned_planes

#: laws whose entropy the two-point flux of fsipetsc.equations.gas conserves
CONSERVED = PerfectGas, stiffened_gas


class Form(NamedTuple):
    """A form of convection: which flux two nodes exchange. entropy: one that conserves entropy,
    else the mean of the nodes' fluxes, which exists for any law. raises: whether a constant force
    acts on the gas, which comes from its potential, pair by pair; else it acts node by node.
    """

    entropy: bool
    raises: bool

    def pair(self, gas, l, r, a_l, a_r, g, rise, near=False):
        """Return what one of two nodes loses and what the other gains: their flux and, if it
        raises, the force. rise: Phi of r less that of l. near: their states are near one another.
        """
        if not self.entropy:
            return (gas.mean_flux(l, r, a_l, a_r, g),) * 2
        F, force = gas.pair_flux(l, r, a_l, a_r, g, near), ()
        if self.raises:
            force = gas.pair_force(l, r, a_l, a_r, rise, near)
        return (*F, *force), (*F, *scale(-1.0, force))


def convection_of(option: str, gas: Any) -> Form:
    """The form that -fsi_convection asks for; auto: entropy, where the gas's law has it."""
    entropy = option != "divergence" and isinstance(gas.law, CONSERVED)
    return Form(entropy, entropy and any(gas.force))


def find_potential(part):
    """Fill in Phi = - b . x of the nodes of the ghosted array."""
    potential, places, force = part.volume.potential, part.places, part.laws.force
    part.grid.find_places(part.X, places)
    for i in each(potential.size, vector=True):
        level = 0.0
        for c, b in enumerate(force):
            level = level - b * places[c, i]
        potential[i] = level


def add_force(part, q, ghosted, rates, gain):
    """Add the force on each owned node and its power to the rates, and to what comes in; pair by
    pair these are what the sweep and links have summed.
    """
    d, supplied, b = part.d, part.volume.supplied, part.laws.force

    def pushed(i):
        if part.form.raises:
            *force, power = row(d + 1, supplied, i)
            for c in range(d):
                power = power + force[c] * (q[i, 2 + c] / q[i, 1])
        else:
            force, power = scale(q[i, 1], b), dot(b, row(d, q, i, 2))
        for c, value in enumerate((*force, power), 2):
            rates[i, c] += value
        return *force, power

    gain.work[0] += book(part, gain, pushed)


def follow(part, record):
    """Note displacement and velocity of the particles here by which the grid moves."""
    follows, known, data, d = part.follows, part.known, record.data, part.d
    for m in each(follows.shape[0]):
        n, to = follows[m], part.follower_rows[m]
        alone = (record.facts.moves[n] == 1) & (record.solid_mass[n] == 0.0)
        for c in range(d):
            known[to, c] = np.where(alone, data.place[n, c], record.D[n, c])
            known[to, d + c] = np.where(alone, data.wall[n, c], record.v[n, c])


def move(part):
    """Find where the grid is now, a^k, and the potential there if fluxes take it."""
    part.grid.move()
    if part.form.raises:
        find_potential(part)


def turn(part, record):
    """Add how area vectors at constraints turn."""
    table, d = record.of_normals, part.d
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
        outward = ends.sign[i] * ends.per_weight[i]
        rates[ends.own[i], 0] += outward * dot(a, moving(part, ends.at[i]))


def supply(part, q, ghosted, rates, gain):
    """Add the case's forcing."""
    count = part.d + 2

    def supplied(i):
        more = scale(q[i, 0], column(count, part.forcing, i))
        rates[i, 1:] = add(row(count, rates, i, 1), more)
        return more

    book(part, gain, supplied, mass=True)


def find_volumes(part):
    """Find J of the grid at the owned nodes."""
    part.grid.find_volumes()
    for node, own in nodes_of(part):
        part.J[own] = part.grid.volume[node]


def monitor(part, found, y):
    """Note extremes and sums of the owned nodes."""
    if part.moves:
        part.grid.find_places(part.X, part.places)
        part.grid.find_volumes()
    q, metrics = owned_planes(part, y).T, part.metrics
    if part.around:
        part.grid.bound()
        metrics = part.grid.bounds
    observe(part, found, lambda own, n: seen_at(part, q, metrics, own, n))
    if part.points is not None:
        note_points(part, found, lambda own, n: point_at(part, q, own, n))


def point_at(part, q, own, n):
    """Return what `note_points` asks for, with the bits of what is saved."""
    w = named(exact(part.laws.primitive(row(part.d + 3, q, own))))
    return *column(part.d, part.places, n), *w.u, w.T, w.p


def seen_at(part, q, metrics, own, n):
    """Return what `observe` asks for, integrands per volume of the reference coordinates; metrics:
    those that bound the step, see the head of this file.
    """
    gas, d, convection, squares = part.laws, part.d, 0.0, 0.0
    here = row(d + 3, q, own)
    w, per_J = gas.primitive(here), 1.0 / here[0]
    c, v = gas.speed_of_sound(w), column(d, metrics, n, d * d)
    relative = sub(gas.velocity(w), v)
    for k, per_h in enumerate(part.per_h[k] for k in range(d)):
        a = column(d, metrics, n, k * d)
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
    (_, rho, *momentum, energy), place = here, column(d, part.places, n)
    entropy, level = here[0] * gas.entropy_density(w), -rho * dot(gas.force, place)
    densities = {"mass": rho, "energy": energy, "entropy": entropy, "potential_energy": level}
    return (bad, convection, diffusion, -here[0] / of_map, apart), place, momentum, densities
