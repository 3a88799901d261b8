"""What procedures share for a rank's part of a block, of gas or solid: views of its unknowns, and
where the monitor's findings go. The records are in fsipetsc.scheme.gas_record and solid_record.
"""

from __future__ import annotations

from typing import NamedTuple

from fsipetsc.kernels.loops import each, either
from fsipetsc.kernels.memory import Array
from fsipetsc.scheme.block_monitor import CONVECTION, MONITORED
from fsipetsc.scheme.normals import add_areas


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


def owned(part, s, dof):
    """Return (M, dof), the owned numbers of this part in a world vector s: a transpose, as s has
    planes.
    """
    n = part.patch.own[0] * part.patch.own[1] * part.patch.own[2]
    return s[part.begin : part.begin + n * dof].reshape(dof, n).turned()


def ghosted(part, s, dof):
    """Return (N, dof), the numbers of this part with its halo, if it has one, which an exchange has
    filled. Where only sweeps read the halo, its owned nodes may be older than s
    (fsipetsc.blockrun.block_part).
    """
    n = part.patch.ghosted[0] * part.patch.ghosted[1] * part.patch.ghosted[2]
    own = s[part.begin : part.begin + n * dof]
    return either(part.halo.shape[1] > 0, part.halo.reshape(-1), own).reshape(dof, n).turned()


def ghosted_node(i, patch):
    """Return the number in the ghosted array of the owned node i."""
    (n0, n1, _), (g0, g1, _), (f0, f1, f2) = patch.own, patch.ghosted, patch.first
    return f0 + i % n0 + g0 * (f1 + i // n0 % n1 + g1 * (f2 + i // (n0 * n1)))


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


def note(part, found):
    """Put what the monitor found in a part into the extremes of its block and the record of the
    step.

    found: a fsipetsc.scheme.runge_kutta.Found.
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
