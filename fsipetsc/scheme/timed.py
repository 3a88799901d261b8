"""Data of a case that depend on time, where they are recorded: C fills them at each stage."""

from collections.abc import Callable
from typing import NamedTuple

from fsipetsc.kernels.formula import Formula
from fsipetsc.kernels.loops import each
from fsipetsc.scheme.rows import Array
from fsipetsc.scheme.runge_kutta import AT

#: names of procedures that set the time of data -> which part of the step it is after its begin
TIMES = {"at_begin": 0.0, "at_middle": 0.5, "at_end": 1.0}
#: which of them comes before a stage; the third one has the data of the second
OF_STAGES = "at_begin", "at_middle", None, "at_end"


class Timed(NamedTuple):
    """A function of place and time, and where its values go.

    formula: returns for each target a number or a tuple of numbers, a row. numbers: its constants.
    x: d arrays (n,), the places; at: (n,) rows of targets, which differ, or None: 0, 1, ….
    """

    formula: Formula
    numbers: Array
    x: tuple[Array, ...]
    at: Array | None
    targets: tuple[Array, ...]


def set_data(timed, now):
    """Fill data that depend on time."""
    for one in timed:
        formula = one.formula(one.numbers, now[AT])
        for i in each(one.x[0].shape[0], vector=True):
            row = i if one.at is None else one.at[i]
            values = formula(tuple(x[i] for x in one.x))
            for array, value in zip(one.targets, values, strict=True):
                if isinstance(value, tuple):
                    for c, number in enumerate(value):
                        array[row, c] = number
                else:
                    array[row] = value


def set_time(part: float) -> Callable[..., None]:
    """Return the procedure that evaluates data at a part of the step."""

    def at(now):
        """Set the time of data."""
        now[AT] = now[0] + part * now[1]

    return at
