"""A constant force on a gas, such as gravity: there is none, or it acts node by node or pair by
pair.

Node by node, J rho b and its power are added to the rates. A gas at rest then stays so to the order
of the scheme only, and small motions may grow. With the two-point fluxes that conserve entropy, the
force comes from its potential Phi = - b . x, pair by pair (fsipetsc.equations.gas). Then a gas of
uniform temperature stays at rest to round-off, and on a grid at rest energy plus rho Phi is kept.

Dissipation (fsipetsc.scheme.gas_dissipation) must not disturb that rest, and mass that diffuses in
the potential does work. The energy with rho Phi has the entropy variables

    z~ = ((h - |u|^2/2 + Phi)/T - s, u/T, -1/T),

all of which are constant in a gas at rest. Let Phi_m be the potential in the middle of a
difference. In F = sigma/4^q lambda U_z Delta z (see there) Delta z is replaced by

    c = (Delta (z_1 + (Phi - Phi_m)/T), Delta u/T, Delta -1/T),

and a node i gets - (F_rho, F_m, F_E + (Phi_m - Phi_i) F_rho). So the energy with rho Phi is kept,
and entropy does not fall: it grows by c . U_z c > 0.

At shocks the link from m to m + 1 exerts the force {a} rho^ (Phi_m+1 - Phi_m)/2 of its areas on
both nodes, as a pair does. This gives back what pairs lose, so rest is kept whatever alpha is. The
flux of Lax and Friedrichs takes the states of both nodes, moved in the force to their mean
potential at their own temperatures. Entropy variables of these two states differ by c, so that by
convexity c . (U*_m+1 - U*_m) > 0; in a gas at rest both states are equal.
"""

from typing import Any, NamedTuple

from fsipetsc.equations.vectors import add_last, along, scale, sub
from fsipetsc.kernels.loops import each, variable
from fsipetsc.scheme.part import ghosted_node


class NoForce(NamedTuple):
    """No constant force. Its methods add nothing, and cost nothing in the printed kernels."""

    kind: int = 0

    def sums(self, like):
        """Return zeros, as many as a sweep sums at each node: a flux, perhaps a force too."""
        return (*like, 0.0, 0.0)

    def linked(self, like):
        """Return zeros, as many as links at shocks sum at each node; with PairForce also a force
        and a power.
        """
        return (*like, 0.0, 0.0)

    def diffused(self, like):
        """Return zeros, as many as the flux of a difference has; perhaps Phi_m F_rho."""
        return (*like, 0.0, 0.0)

    def rise(self, potential, i, j):
        """Return the difference Phi_j - Phi_i."""
        return 0.0

    def near(self, gas, F, l, r, a_l, a_r, rise):
        """Return what one of two similar nodes loses and what the other gains: F, and the force."""
        return F, F

    def any(self, gas, F, l, r, a_l, a_r, rise):
        """Return the same for any two nodes."""
        return F, F

    def level(self, potential, i, first, w):
        """Return z_1 of a node, with PairForce plus Phi/T."""
        return first

    def at_middle(self, change, potential, l, r):
        """Return c from Delta z; l, r: the nodes in the middle of the difference."""
        return change

    def with_level(self, F, potential, l, r):
        """Return the flux F of a difference, with PairForce followed by Phi_m F_rho."""
        return F

    def parted(self, F):
        """Take apart what ``with_level`` put together: return F, and Phi_m F_rho."""
        return F, 0.0

    def lifted(self, potential, i, F, level):
        """Return the energy Phi_i F_rho - Phi_m F_rho that diffusing mass takes up."""
        return 0.0

    def jump(self, gas, l, r, rise):
        """Return the difference of the densities of two neighbours of which Lax and Friedrichs's
        flux is made.
        """
        return sub(gas.densities(r), gas.densities(l))

    def link(self, gas, F, speed, jump, l, r, a, rise):
        """Return what one of two neighbours loses and the other gains: F - speed jump, the force,
        the power.
        """
        F = along(F, -speed, jump)
        return F, F

    def collect(self, sums, per_weight, power, supplied, own):
        """Add the force of links to that on an owned node, and the power of what diffuses; sums: of
        the node, as many as ``linked``.
        """

    def follow(self, part):
        """Phi of the nodes where they are now."""

    def add(self, part, q, rates, gain):
        """Add the force and its power to the rates, and to what comes in."""

    def note(self, part, q, found):
        """Note the potential energy in a fsipetsc.scheme.runge_kutta.Found."""


class NodeForce(NoForce):
    """A force node by node: for the divergence form."""

    def note(self, part, q, found):
        note_potential(part, q, found)

    def add(self, part, q, rates, gain):
        add_node_force(part, q, rates, gain)


class PairForce(NoForce):
    """A force from its potential, pair by pair: for fluxes that conserve entropy."""

    def sums(self, like):
        return (*like, 0.0, 0.0, *like)

    def linked(self, like):
        return (*like, 0.0, 0.0, *like, 0.0)

    def diffused(self, like):
        return (*like, 0.0, 0.0, 0.0)

    def rise(self, potential, i, j):
        return potential[j] - potential[i]

    def near(self, gas, F, l, r, a_l, a_r, rise):
        force = gas.near_pair_force(l, r, a_l, a_r, rise)
        return (*F, *force), (*F, *scale(-1.0, force))

    def any(self, gas, F, l, r, a_l, a_r, rise):
        force = gas.pair_force(l, r, a_l, a_r, rise)
        return (*F, *force), (*F, *scale(-1.0, force))

    def level(self, potential, i, first, w):
        return first + potential[i] * w[-1]

    def at_middle(self, change, potential, l, r):
        level = 0.5 * (potential[l] + potential[r])
        return (change[0] + level * change[-1], *change[1:])

    def with_level(self, F, potential, l, r):
        return (*F, 0.5 * (potential[l] + potential[r]) * F[0])

    def parted(self, F):
        return F[:-1], F[-1]

    def lifted(self, potential, i, F, level):
        return potential[i] * F[0] - level

    def jump(self, gas, l, r, rise):
        above, below = gas.raised(l, 0.5 * rise), gas.raised(r, -0.5 * rise)
        return sub(gas.densities(below), gas.densities(above))

    def link(self, gas, F, speed, jump, l, r, a, rise):
        F, force = along(F, -speed, jump), gas.pair_force(l, r, a, a, rise)
        power = -0.5 * speed * jump[0] * rise
        return (*F, *force, power), (*F, *scale(-1.0, force), -power)

    def collect(self, sums, per_weight, power, supplied, own):
        count = (len(sums) - 1) // 2
        more = add_last(power, sums[-count:])
        before = tuple(supplied[own * count + c] for c in range(count))
        for c, force in enumerate(along(before, per_weight, more)):
            supplied[own * count + c] = force

    def follow(self, part):
        find_potential(part)

    def add(self, part, q, rates, gain):
        add_pair_force(part, q, rates, gain)

    def note(self, part, q, found):
        note_potential(part, q, found)


def force_of(force: Any, divergence: bool) -> Any:
    """The class for a body force per mass (d,) in the divergence form, or in the entropy form."""
    if not any(force):
        return NoForce()
    return NodeForce() if divergence else PairForce()


def find_potential(part):
    """Fill in Phi = - b . x of the nodes of the ghosted array."""
    potential, places, force = part.potential, part.places, part.laws.force
    part.grid.find_places(part.X, places)
    for i in each(potential.size, vector=True):
        level = 0.0
        for c, b in enumerate(force):
            level = level - b * places[c, i]
        potential[i] = level


def add_pair_force(part, q, rates, gain):
    """Add the force that the sweep and links have summed, and the power of what diffuses."""
    supplied, d = part.supplied, len(part.like)

    def of_node(i):
        forces = tuple(supplied[i * (d + 1) + c] for c in range(d))
        power = supplied[i * (d + 1) + d]
        for c, force in enumerate(forces):
            power = power + force * (q[i, 2 + c] / q[i, 1])
        return (*forces, power)

    push(part, rates, gain, of_node)


def add_node_force(part, q, rates, gain):
    """Add J rho b of each node."""
    force = part.laws.force

    def of_node(i):
        power = 0.0
        for c, b in enumerate(force):
            power = power + b * q[i, 2 + c]
        return (*scale(q[i, 1], force), power)

    push(part, rates, gain, of_node)


def push(part, rates, gain, of_node):
    """Add to rates and gain the force on each owned node, which of_node returns, and its power."""
    d, masses = len(part.like), part.masses
    sums = [variable(0.0) for _ in range(d + 1)]
    for i in each(masses.size):
        for c, (total, value) in enumerate(zip(sums, of_node(i), strict=True)):
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
