"""A constant force b on a gas, such as gravity: it acts node by node or pair by pair.

Node by node, J rho b and its power are added to the rates. A gas at rest then stays so to the order
of the scheme only, and small motions may grow. With the two-point fluxes that conserve entropy, the
force comes from its potential Phi = - b . x, pair by pair (fsipetsc.equations.gas). Then a gas of
uniform temperature stays at rest to round-off, and on a grid at rest energy plus rho Phi is kept.

Dissipation (fsipetsc.scheme.gas_dissipation) must not disturb that rest, and mass that diffuses in
the potential does work. The energy with rho Phi has the entropy variables

    z~ = ((h - |u|^2/2 + Phi)/T - s, u/T, -1/T),

all of which are constant in a gas at rest. With Phi_m in the middle of a difference, Delta z in
F = sigma/4^q lambda U_z Delta z is replaced by

    c = (Delta (z_1 + (Phi - Phi_m)/T), Delta u/T, Delta -1/T),

and a node i gets - (F_rho, F_m, F_E + (Phi_m - Phi_i) F_rho). So the energy with rho Phi is kept,
and entropy grows by c . U_z c > 0.

At shocks the link from m to m + 1 exerts the force {a} rho^ (Phi_m+1 - Phi_m)/2 of its areas on
both nodes, as a pair does, so rest is kept whatever alpha is. The flux of Lax and Friedrichs takes
the states of both nodes, moved in the force to their mean potential at their own temperatures,
which are equal in a gas at rest. Their entropy variables differ by c, so c . (U*_m+1 - U*_m) > 0.
"""

from fsipetsc.equations.vectors import add_last, along, scale
from fsipetsc.kernels.loops import each, variable
from fsipetsc.scheme.part import ghosted_node


def with_force(gas, form, near, F, l, r, a_l, a_r, rise):
    """Return what one of two nodes loses and what the other gains: the flux F and, where form
    raises, the force; rise: Phi of r less that of l.
    """
    if not form.raises:
        return F, F
    force = gas.pair_force(l, r, a_l, a_r, rise, near)
    return (*F, *force), (*F, *scale(-1.0, force))


def collect_force(part, sums, per_weight, power, own):
    """Add the force of links, the last of the sums of an owned node, and the power of what diffuses
    to what is supplied there.
    """
    supplied, count = part.volume.supplied, len(part.like) + 1
    before = tuple(supplied[own * count + c] for c in range(count))
    for c, force in enumerate(along(before, per_weight, add_last(power, sums[-count:]))):
        supplied[own * count + c] = force


def find_potential(part):
    """Fill in Phi = - b . x of the nodes of the ghosted array."""
    potential, places, force = part.volume.potential, part.places, part.laws.force
    part.grid.find_places(part.X, places)
    for i in each(potential.size, vector=True):
        level = 0.0
        for c, b in enumerate(force):
            level = level - b * places[c, i]
        potential[i] = level


def add_force(part, q, rates, gain):
    """Add the force on each owned node and its power to the rates, and to what comes in; pair by
    pair these are what the sweep and links have summed.
    """
    d, masses, supplied, b = len(part.like), part.masses, part.volume.supplied, part.laws.force
    sums = [variable(0.0) for _ in range(d + 1)]
    for i in each(masses.size):
        if part.form.raises:
            force = tuple(supplied[i * (d + 1) + c] for c in range(d))
            power, u = supplied[i * (d + 1) + d], [q[i, 2 + c] / q[i, 1] for c in range(d)]
            for c in range(d):
                power = power + force[c] * u[c]
        else:
            force, power = scale(q[i, 1], b), 0.0
            for c in range(d):
                power = power + b[c] * q[i, 2 + c]
        for c, (total, value) in enumerate(zip(sums, (*force, power), strict=True)):
            rates[i, 2 + c] += value
            total.value += masses[i] * value
    for c in range(d):
        gain.impulse[c] += sums[c].value
    gain.energy[-1] += sums[d].value
    gain.work[0] += sums[d].value


def note_potential(part, q, found):
    """Note the potential energy - sum M b . x of the owned nodes."""
    force, masses, places, total = part.laws.force, part.masses, part.places, variable(0.0)
    for i in each(masses.size):
        n = ghosted_node(i, part.patch)
        for c, b in enumerate(force):
            total.value -= masses[i] * q[i, 1] * b * places[c, n]
    found.latest[part.level] += total.value
