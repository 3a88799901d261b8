"""Several steps in one call: what a step leaves is noted, and the next one planned.

A burst of steps ends when it has as many as are allowed (-fsi_burst, -ts_max_steps, room in the journal), or something
has to be looked at: a time to be saved, a grid that must grow, a failure, a signal.
Its plan and what came of it stand in the words at ``head.burst`` in the memory; each step fills a row of the journal.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64, copy
from fsipetsc.scheme.plan import BAD, EXHAUSTED, LOW, RATE, STOP, TOO_SHORT
from fsipetsc.scheme.time_step import longest_step, next_step

#: time before or, once it is made, after the step; the step; time after it; the next time that must be hit;
#: Courant number, or the step that is given and else 0; steps that may be made, and have been; shortest and longest;
#: first row of the journal to be filled
TIME, DT, NEXT, TARGET, COURANT, FIXED, ALLOWED, MADE, SHORTEST, LONGEST, FIRST = range(11)


class Notes(NamedTuple):
    """Where things stand in the memory: what ``goes_on`` has to know of a head, for those who have no other.

    row: doubles of a record in the journal; states: what goes there behind the time and the step.
    """

    burst: int
    results: int
    journal: int
    row: int
    states: int


_longest_step, _next_step = njit(**OPTIONS)(longest_step), njit(**OPTIONS)(next_step)


@njit(**OPTIONS)
def goes_on(head, memory):
    """Note the step just made in burst and journal, and plan the next one; False if none follows. Same on all ranks.

    A burst that has ended, or was never planned, allows no steps.
    """
    burst, results = head.burst, head.results
    allowed = memory[U64(burst + ALLOWED)]
    memory[U64(burst + ALLOWED)] = 0.0
    if allowed == 0.0:
        return False
    t, dt, made = memory[U64(burst + NEXT)], memory[U64(burst + DT)], memory[U64(burst + MADE)]
    row = head.journal + head.row * int(memory[U64(burst + FIRST)] + made)
    memory[U64(row)], memory[U64(row + 1)] = t, dt
    copy(memory, head.states, row + 2, head.row - 2)
    memory[U64(burst + TIME)], memory[U64(burst + MADE)] = t, made + 1
    memory[U64(burst + SHORTEST)] = min(memory[U64(burst + SHORTEST)], dt)
    memory[U64(burst + LONGEST)] = max(memory[U64(burst + LONGEST)], dt)
    for flag in (LOW, EXHAUSTED, TOO_SHORT, BAD, STOP):
        if memory[U64(results + flag)] != 0.0:
            return False
    rate, target = memory[U64(results + RATE)], memory[U64(burst + TARGET)]
    if t >= target or made + 1 >= allowed or not 0.0 < rate < 1e300:
        return False
    bound = _longest_step(memory[U64(burst + COURANT)], memory[U64(burst + FIXED)], rate)
    memory[U64(burst + DT)], memory[U64(burst + NEXT)] = _next_step(t, target, bound)
    memory[U64(burst + ALLOWED)] = allowed
    return True
