"""What procedures share for a rank's part of a block, of gas or solid: views of its unknowns, and
its nodes. The records are in fsipetsc.scheme.gas_record and solid_record.
"""

from __future__ import annotations

from typing import NamedTuple

from fsipetsc.kernels.arrays import Array, column_of, node
from fsipetsc.kernels.loops import each, either


class Nothing(NamedTuple):
    """Stands for a term that is absent, as dissipation or fluxes at closed faces."""

    def add(self, part, q, rates, gain):
        """Add nothing; the work is 0."""
        return 0.0


class Gain(NamedTuple):
    """What comes into the problem from outside.

    numbers: all numbers that follow, in the order of fsipetsc.blockrun.saved.gained. mass: of
    each block of gas. lost: (1,) work on solids if it is booked, else (0,). work: (1,) work of
    constant forces if there are any, else (0,). impulse: (d,). energy: through each outer face; the
    last one is of what comes through no face. heat: the part of energy that is heat. total: (1,)
    the sum of energy.
    """

    numbers: Array
    mass: Array
    lost: Array
    work: Array
    impulse: Array
    energy: Array
    heat: Array
    total: Array


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
    return owned_planes(part, s, dof).turned()


def ghosted(part, s, dof):
    """Return (N, dof), the same as `ghosted_planes` by nodes."""
    return ghosted_planes(part, s, dof).turned()


def area(part, k, n):
    """Return a^k of a gas, or A^k of a solid, at a node of the ghosted array."""
    return column_of(part.like, part.metrics, k * len(part.like), n)


def moving(part, n):
    """Return the velocity of a gas's grid at a node of the ghosted array."""
    return area(part, len(part.like), n)


def gas_at(part, q, n):
    """Return the primitive variables of a gas at a node of q."""
    return part.laws.primitive(node((*part.like, 0.0, 0.0, 0.0), q, n))


def ghosted_node(i, patch):
    """Return the number in the ghosted array of the owned node i."""
    (n0, n1, _), (g0, g1, _), (f0, f1, f2) = patch.own, patch.ghosted, patch.first
    return f0 + i % n0 + g0 * (f1 + i // n0 % n1 + g1 * (f2 + i // (n0 * n1)))


def rows_of(part):
    """Yield each row of owned nodes: the first one in ghosted arrays, among the owned ones, how
    many.
    """
    (n0, n1, n2), (g0, g1, _), (f0, f1, f2) = part.patch.own, part.patch.ghosted, part.patch.first
    for z in each(n2):
        for y in each(n1):
            yield f0 + g0 * (f1 + y + g1 * (f2 + z)), n0 * (y + n1 * z), n0


def images(part):
    """Around an axis or a centre: fill the halo before r = 0 with mirror images of the nodes behind
    it, times part.signs.
    """
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
