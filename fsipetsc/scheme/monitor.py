"""Extremes and sums over all nodes of a block after a step, found column by column, so that loops
become vector code.

A room has a row for each extreme, then a row for each sum. Each node counts in one column; in the
end the columns are combined in their order, so the bits do not depend on the vector length. The
last bits of an integral depend on which rank owns which nodes; no other number is computed from
integrals.
"""

import numpy as np

from fsipetsc.kernels.loops import each, named, variable
from fsipetsc.scheme.observables import PLACES
from fsipetsc.scheme.part import rows_of

#: columns of a tile of nodes
COLUMNS = 64
#: how many extremes a block has: 1 if a state is unphysical, largest rates of convection and of
#: diffusion [1/s], minus the least J, largest |J - det D x| / J; the places of two of them
MONITORED, CONVECTION, LEAST_J = 5, 1, 3


def clear(room, extremes, sums, columns=COLUMNS):
    """Set the columns to -inf in rows of extremes, and to 0 in rows of sums."""
    for row in range(extremes + sums):
        for c in each(columns, vector=True):
            room[row, c] = -np.inf if row < extremes else 0.0


def tiled(begin, end, columns=COLUMNS):
    """Yield (node, column) for the nodes begin .. end-1, tile by tile."""
    for tile in each((end - begin + (columns - 1)) // columns):
        first = named(begin + tile * columns)
        for c in each(np.minimum(columns, end - first), vector=True):
            yield first + c, c


def count(room, column, extremes, sums):
    """Let the numbers of one node count in a column. NaN is never an extreme."""
    for row, number in enumerate(extremes):
        room[row, column] = np.where(number > room[row, column], number, room[row, column])
    for row, number in enumerate(sums, len(extremes)):
        room[row, column] += number


def collected(room, least, sums, columns=COLUMNS):
    """Return variables with the extremes of all columns, each at least ``least``, and with the
    sums.
    """
    largest, totals = [variable(x) for x in least], [variable() for _ in range(sums)]
    for c in each(columns):
        for row, found in enumerate(largest):
            larger(found, room[row, c])
        for row, total in enumerate(totals, len(least)):
            total.value += room[row, c]
    return largest, totals


def larger(found, x):
    """Set a variable to x if x is larger than its value; NaN never is."""
    found.value = np.where(x > found.value, x, found.value)


def observe(part, names, seen):
    """Fill part.seen (MONITORED,), and part.sums with the integrals of these names. seen: returns,
    for an owned node's numbers among the owned ones and in the ghosted array, its extremes, and a
    dict: name of an integral -> what it has of the node per mass.
    """
    room, columns, sums = part.room, part.room.shape[1], len(names)
    least = [-np.inf if c == LEAST_J else 0.0 for c in range(MONITORED)]
    clear(room, MONITORED, sums, columns)
    for node, own, n in rows_of(part):
        for x, column in tiled(0, n, columns):
            extremes, found = seen(own + x, node + x)
            mass = part.masses[own + x]
            count(room, column, extremes, [mass * found[name] for name in names])
    found = collected(room, least, sums, columns)
    for of, numbers in zip((part.seen, part.sums), found, strict=True):
        for c, number in enumerate(numbers):
            of[c] = number.value


def note(part, found):
    """Put what the monitor found in a part into the extremes of its block and the record of the
    step; found: see fsipetsc.scheme.runge_kutta.
    """
    begin, seen, sums, columns = 1 + MONITORED * part.block, part.seen, part.sums, part.columns
    extremes, latest = found.extremes, found.latest
    for c in range(MONITORED):
        extremes[begin + c] = (found.pace if c == CONVECTION else 1.0) * seen[c]
    for c in each(columns.size):
        latest[columns[c]] += sums[c]


def along_axes(name, d):
    """Return the names of a vector's d components: name_x, name_y, …."""
    return [f"{name}_{x}" for x in PLACES[:d]]


def turning(d):
    """Return the names of the components of angular momentum about the origin: 0, 1 or 3."""
    return along_axes("angular_momentum", 3) if d == 3 else ["angular_momentum"] * (d - 1)


def moment(x, p):
    """Return the components of the cross product of x and p: none, one or three numbers."""
    pairs = {1: (), 2: ((0, 1),), 3: ((1, 2), (2, 0), (0, 1))}[len(x)]
    return tuple(x[a] * p[b] - x[b] * p[a] for a, b in pairs)
