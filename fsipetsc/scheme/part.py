"""What procedures know of a rank's part of a block, of gas or solid: views of its unknowns, what
the monitor finds. The records are those of fsipetsc.scheme.gas_record and solid_record.
"""

from __future__ import annotations

from typing import NamedTuple

from fsipetsc.kernels.loops import each, either
from fsipetsc.scheme.block_monitor import CONVECTION, MONITORED
from fsipetsc.scheme.normals import add_areas
from fsipetsc.scheme.rows import Array


class Nothing(NamedTuple):
    """What adds nothing to rates: no dissipation, closed faces."""

    def add(self, part, q, rates, gain):
        """Add nothing; the work is 0."""
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


def owned(part, s, dof):
    """(M, dof), the numbers of this part in a world vector s, which has planes: a transpose."""
    n = part.patch.own[0] * part.patch.own[1] * part.patch.own[2]
    return s[part.begin : part.begin + n * dof].reshape(dof, n).turned()


def ghosted(part, s, dof):
    """(N, dof), the same with its halo, which an exchange has filled, if the part has one; its
    owned nodes are old ones where nothing but sweeps reads it (fsipetsc.blockrun.block_part).
    """
    n = part.patch.ghosted[0] * part.patch.ghosted[1] * part.patch.ghosted[2]
    own = s[part.begin : part.begin + n * dof]
    return either(part.halo.shape[1] > 0, part.halo.reshape(-1), own).reshape(dof, n).turned()


def ghosted_node(i, patch):
    """Number in the ghosted array of the owned node i."""
    (n0, n1, _), (g0, g1, _), (f0, f1, f2) = patch.own, patch.ghosted, patch.first
    return f0 + i % n0 + g0 * (f1 + i // n0 % n1 + g1 * (f2 + i // (n0 * n1)))


def images(part):
    """Let what the halo has before the first owned node along its last axis be the images of what
    is behind, with signs; around an axis or a centre.
    """
    values, signs = part.halo, part.signs
    (g0, _, _), (f0, f1, _) = part.patch.ghosted, part.patch.first
    rows, n = (f0, 1) if len(part.like) == 1 else (f1, g0)
    for c in each(signs.shape[0]):
        for i in each(rows * n):
            image = (rows - 1 - i // n) * n + i % n
            values[c, image] = signs[c] * values[c, rows * n + i]


def copy(of, to):
    """Copy numbers."""
    for i in each(of.size, vector=True):
        to[i] = of[i]


def clear(numbers):
    """Set numbers to 0."""
    for i in each(numbers.size, vector=True):
        numbers[i] = 0.0


def note(part, found):
    """Put what the monitor found of a part into the extremes of its block and the record of the
    step; found: fsipetsc.scheme.runge_kutta.Found.
    """
    begin, seen, sums, columns = 1 + MONITORED * part.block, part.seen, part.sums, part.columns
    extremes, latest = found.extremes, found.latest
    for c in range(MONITORED):
        extremes[begin + c] = (found.pace if c == CONVECTION else 1.0) * seen[c]
    for c in each(columns.size):
        latest[columns[c]] += sums[c]


def normals(part, particles):
    """Add area vectors of faces to the table of members at constraints."""
    add_areas(part.at_particles, len(part.like), part.metrics, particles.of_normals)
