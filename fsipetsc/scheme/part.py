"""What compiled code knows of a rank's part of a block, of gas or solid: views of its unknowns,
what the monitor finds. The records are those of fsipetsc.scheme.gas_record and solid_record.
"""

from __future__ import annotations

from collections import namedtuple
from typing import NamedTuple

from numba import njit

from fsipetsc.operators.bands import mirror
from fsipetsc.operators.loops import CALL, INNER_CALL, INNER_LOOP, MERGED_CALL
from fsipetsc.scheme.block_monitor import CONVECTION, MONITORED
from fsipetsc.scheme.normals import add_areas
from fsipetsc.scheme.rows import Array

#: a part and what is done with it in a step, called by address (fsipetsc.operators.boxed)
PartCalls = namedtuple("PartCalls", "part follow move swing normals turn store rates monitor")


class Nothing(NamedTuple):
    """What adds nothing to rates: no dissipation, closed faces."""

    kind: int = 0

    def add(self, part, q, rates, gain):
        """No work."""
        return 0.0

    def power(self, part, q, rates):
        return 0.0


class Gain(NamedTuple):
    """What comes in from outside. numbers: all that follow, as fsipetsc.blockrun.columns.gained has
    them. mass: of each block of gas. lost: (1,) work on solids if it is booked, else (0,). work:
    (1,) that of constant forces if there are any, else (0,). impulse: (d,). energy: through each
    outer face, in the end what comes through none; heat: what of this is heat. total: (1,) the sum
    of energy.
    """

    numbers: Array
    mass: Array
    lost: Array
    work: Array
    impulse: Array
    energy: Array
    heat: Array
    total: Array


@njit(**MERGED_CALL)
def owned(part, s, dof):
    """(M, dof), this part of a world vector s."""
    n = part.patch.own[0] * part.patch.own[1] * part.patch.own[2]
    return s[part.begin : part.begin + n * dof].reshape((n, dof))


@njit(**MERGED_CALL)
def ghosted(part, s, dof):
    """(N, dof), the same with its halo, which a rank that has all blocks fills here."""
    if part.wraps:
        fill_halo(s, part.begin, dof, part.patch, part.halo)
        if part.signs.size > 0:
            mirror(part.halo, part.patch.first, part.patch.ghosted, part.signs)
    return part.halo if part.halo.shape[0] > 0 else owned(part, s, dof)


@njit(**INNER_CALL)
def ghosted_node(i, patch):
    """Number in the ghosted array of the owned node i."""
    (n0, n1, _), (g0, g1, _), (f0, f1, f2) = patch.own, patch.ghosted, patch.first
    return f0 + i % n0 + g0 * (f1 + i // n0 % n1 + g1 * (f2 + i // (n0 * n1)))


@njit(**INNER_CALL)
def fill_halo(s, begin, dof, patch, halo):
    """Copy a whole block, with its other end beyond each end of a periodic axis."""
    (n0, n1, n2), (g0, g1, g2), (f0, f1, f2) = patch.own, patch.ghosted, patch.first
    to = halo.reshape(halo.size)
    for z in range(g2):
        for y in range(g1):
            row = begin + ((z - f2) % n2 * n1 + (y - f1) % n1) * n0 * dof
            at = (z * g1 + y) * g0 * dof
            copy_row(s[row : row + n0 * dof], to[at + f0 * dof : at + (f0 + n0) * dof])
            for i in range(f0 * dof):
                to[at + i] = s[row + (n0 - f0) * dof + i]
            for i in range((g0 - f0 - n0) * dof):
                to[at + (f0 + n0) * dof + i] = s[row + i]


@njit(**INNER_LOOP)
def copy_row(of, to):
    """to = of."""
    for i in range(of.size):
        to[i] = of[i]


@njit(**INNER_LOOP)
def clear(numbers):
    """Zeros."""
    for i in range(numbers.size):
        numbers[i] = 0.0


@njit(**INNER_CALL)
def note(part, found):
    """Put the extremes and sums of the monitor where they belong; found: a box of
    fsipetsc.scheme.steps.Found.
    """
    begin, seen, sums, columns = 1 + MONITORED * part.block, part.seen, part.sums, part.columns
    extremes, latest = found.extremes, found.latest
    for c in range(seen.size):
        extremes[begin + c] = seen[c]
    extremes[begin + CONVECTION] *= found.pace
    for c in range(columns.size):
        latest[columns[c]] += sums[c]


@njit(**CALL)
def add_normals(part, particles):
    """Add area vectors of faces to the table of members at constraints."""
    add_areas(part.at_particles, len(part.like), part.metrics, particles.of_normals)
