"""Extremes and sums over many nodes, found column by column, so that loops become vector code.

A room has a row for each extreme, then a row for each sum. Each node counts in one column; in the
end the columns are combined in their order, so the bits do not depend on the vector length.
"""

import numpy as np

from fsipetsc.kernels.loops import each, named, variable

#: columns of a tile of nodes
COLUMNS = 64


def clear(room, extremes, sums, columns):
    """Set the columns to -inf in rows of extremes, and to 0 in rows of sums."""
    for row in range(extremes + sums):
        for c in each(columns, vector=True):
            room[row, c] = -np.inf if row < extremes else 0.0


def tiled(begin, end):
    """Yield (node, column) for the nodes begin .. end-1, tile by tile."""
    for tile in each((end - begin + (COLUMNS - 1)) // COLUMNS):
        first = named(begin + tile * COLUMNS)
        for c in each(np.minimum(COLUMNS, end - first), vector=True):
            yield first + c, c


def count(room, column, extremes, sums):
    """Let the numbers of one node count in a column. NaN is never an extreme."""
    for row, number in enumerate(extremes):
        room[row, column] = np.where(number > room[row, column], number, room[row, column])
    for row, number in enumerate(sums, len(extremes)):
        room[row, column] += number


def collected(room, least, sums, columns):
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
