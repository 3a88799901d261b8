"""Extremes and sums of many nodes, found column by column, so that loops become vector code.

A room has rows of numbers, one for each extreme, then one for each sum. A node counts in a column;
at the end that which all columns have is collected, in their order.
"""

import numpy as np

from fsipetsc.kernels.loops import each, named, variable

#: columns of a tile of nodes
COLUMNS = 64


def clear(room, extremes, sums, columns):
    """Forget what so many columns of the first rows have."""
    for row in range(extremes + sums):
        for c in each(columns, vector=True):
            room[row, c] = -np.inf if row < extremes else 0.0


def tiled(begin, end):
    """(node, column) of the nodes begin .. end-1, tile by tile."""
    for tile in each((end - begin + (COLUMNS - 1)) // COLUMNS):
        first = named(begin + tile * COLUMNS)
        for c in each(np.minimum(COLUMNS, end - first), vector=True):
            yield first + c, c


def count(room, column, extremes, sums):
    """Let numbers count in a column; what is no number is no extreme."""
    for row, number in enumerate(extremes):
        room[row, column] = np.where(number > room[row, column], number, room[row, column])
    for row, number in enumerate(sums, len(extremes)):
        room[row, column] += number


def collected(room, least, sums, columns):
    """Variables: the extremes of so many columns, which are at least so, and their sums."""
    largest, totals = [variable(x) for x in least], [variable() for _ in range(sums)]
    for c in each(columns):
        for row, found in enumerate(largest):
            larger(found, room[row, c])
        for row, total in enumerate(totals, len(least)):
            total.value += room[row, c]
    return largest, totals


def larger(found, x):
    """Let a variable be x if this is larger; what is not a number is never."""
    found.value = np.where(x > found.value, x, found.value)
