"""Read and store several numbers of an array at once, as a tuple. The array may be a stand-in that
a procedure records.

Columns are of arrays by components, (components, nodes); nodes are rows of interlaced ones, (nodes,
components). like: a tuple that is as long as what is read.
"""

from typing import Any

Numbers = tuple[Any, ...]


def column(like: Numbers, array: Any, n: Any) -> Numbers:
    """Return the numbers array[c, n]."""
    return column_of(like, array, 0, n)


def column_of(like: Numbers, array: Any, first: Any, n: Any) -> Numbers:
    """Return the numbers array[first + c, n]."""
    return tuple(array[first + c, n] for c in range(len(like)))


def put_column(array: Any, n: Any, first: Any, values: Numbers) -> None:
    """Store values in array[first + c, n]."""
    for c, value in enumerate(values):
        array[first + c, n] = value


def node(like: Numbers, array: Any, n: Any) -> Numbers:
    """Return the numbers array[n, c]."""
    return part_of(like, array, n, 0)


def part_of(like: Numbers, array: Any, n: Any, first: Any) -> Numbers:
    """Return the numbers array[n, first + c]."""
    return tuple(array[n, first + c] for c in range(len(like)))


def put_part(array: Any, n: Any, first: Any, values: Numbers) -> None:
    """Store values in array[n, first + c]."""
    for c, value in enumerate(values):
        array[n, first + c] = value
