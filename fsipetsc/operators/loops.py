"""Functions of tuples, once for one, two and three dimensions.

Equations and laws are NamedTuple classes whose methods are scalar formulas, as
``gas.pressure(rho, T)``. The same source runs on floats, on numpy arrays, and on the symbols of
fsipetsc.kernels. Functions of tuples are written out for the length of their arguments.
"""

from collections.abc import Callable
from typing import Any

import numpy as np


def by_length(name: str, arguments: str, body: Callable[[int], str]) -> Any:
    """A function of tuples, by its source for tuples of length n."""
    made: dict[int, Any] = {}

    def source(n: int) -> Any:
        if n not in made:
            space: dict[str, Any] = {}
            exec(f"def {name}({arguments}):\n{body(n)}", space)
            made[n] = space[name]
        return made[n]

    space: dict[str, Any] = {"source": source}
    length = "max(len(v) for v in (" + arguments + ",) if isinstance(v, tuple))"
    exec(f"def {name}({arguments}):\n return source({length})({arguments})", space)
    return space[name]


def numbers(item: str) -> Callable[[int], str]:
    """Source of a tuple of so many numbers; @: the number of one."""
    return lambda n: " return (" + "".join(item.replace("@", str(k)) + "," for k in range(n)) + ")"


def _last(item: str) -> Callable[[int], str]:
    others = " return ({}" + item.replace("@", "{}") + ",)"
    return lambda n: others.format("".join(f"a[{k}], " for k in range(n - 1)), n - 1)


def _lines(line: str) -> Callable[[int], str]:
    return lambda n: "\n".join(" " + line.replace("@", str(k)) for k in range(n))


def total_of(term: str) -> Callable[[int], str]:
    """Source of a sum."""
    return lambda n: " return " + " + ".join(term.replace("@", str(k)) for k in range(n))


dot = by_length("dot", "a, b", total_of("a[@] * b[@]"))
add = by_length("add", "a, b", numbers("a[@] + b[@]"))
sub = by_length("sub", "a, b", numbers("a[@] - b[@]"))
scale = by_length("scale", "c, a", numbers("c * a[@]"))
mean = by_length("mean", "a, b", numbers("0.5 * (a[@] + b[@])"))
per = by_length("per", "a, c", numbers("a[@] / c"))
#: a + c b
along = by_length("along", "a, c, b", numbers("a[@] + c * b[@]"))
total = by_length("total", "a", total_of("a[@]"))
larger = by_length("larger", "a, b", numbers("max(a[@], b[@])"))
#: (a_1, …, c a_n), and (a_1, …, a_n + c)
last_times = by_length("last_times", "c, a", _last("c * a[@]"))
add_last = by_length("add_last", "c, a", _last("a[@] + c"))
zeros = by_length("zeros", "a", numbers("0.0 * a[@]"))


def choose(condition: Any, a: Any, b: Any) -> Any:
    """The numbers of a where a condition holds, else those of b."""
    return tuple(np.where(condition, p, q) for p, q in zip(a, b, strict=True))


#: rows[c][i], as a tuple
load = by_length("load", "rows, i", numbers("rows[@][i]"))
store = by_length("store", "rows, i, values", _lines("rows[@][i] = values[@]"))
#: array[c, a:b] for each c of like
rows = by_length("rows", "like, array, a, b", numbers("array[@, a:b]"))
#: array[c, n] for each c of like: the numbers of one node of an array by components
column = by_length("column", "like, array, n", numbers("array[@, n]"))
#: the same from array[first, n] on
column_of = by_length("column_of", "like, array, first, n", numbers("array[first + @, n]"))
#: array[n, c] for each c of like: the numbers of one node of an interlaced array
node = by_length("node", "like, array, n", numbers("array[n, @]"))
#: the same from array[n, first] on
part_of = by_length("part_of", "like, array, n, first", numbers("array[n, first + @]"))
#: array[first + c, n] = values[c]
put_column = by_length(
    "put_column", "array, n, first, values", _lines("array[first + @, n] = values[@]")
)
put_part = by_length(
    "put_part", "array, n, first, values", _lines("array[n, first + @] = values[@]")
)
