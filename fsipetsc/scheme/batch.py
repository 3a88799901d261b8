"""The length of a step; several steps in one call: the plan of a batch, what came of it.

A batch ends when it has as many steps as are allowed (-ts_max_steps, room in the journal), or for a
time to be saved, a failure or a signal. Each step fills a row of the journal.
"""


from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import CALL, MERGED_CALL
from fsipetsc.scheme.plan import BAD, EXHAUSTED, RATE, STOP, TOO_SHORT

#: TIME before a step or, once it is made, after it; DT, its length; NEXT, the time after it;
#: TARGET, the next time that must be hit; COURANT number; FIXED, the step that is given, or 0;
#: steps ALLOWED and MADE; the LONGEST of these; FIRST row of the journal to be filled
TIME, DT, NEXT, TARGET, COURANT, FIXED, ALLOWED, MADE, LONGEST, FIRST = range(10)

#: a step may be longer than its bound by this fraction, so that round-off costs no extra step
SLACK = 1e-9


def longest_step(courant, fixed, rate):
    """Bound on a step [s]: the one that is given (-ts_dt), or, if that is 0, the Courant number
    times 1/``rate``.
    """
    return fixed if fixed != 0.0 else courant / rate


def next_step(t, target, bound):
    """(step, time after it) [s]: at most ``bound``; with less than two steps to the target they are
    equal.
    """
    left = target - t
    if left <= bound * (1 + SLACK):
        return left, target
    step = left / 2 if left < 2 * bound else bound
    return step, t + step


_longest_step, _next_step = njit(**CALL)(longest_step), njit(**CALL)(next_step)


@njit(**MERGED_CALL)
def plan_next(batch, results, journal, latest):
    """Note the step just made in batch and journal, plan the next one; False if none follows.

    The same on all ranks. batch: one that has ended, or was never planned, allows no steps.
    results: see fsipetsc.scheme.plan. journal: (rows, columns), each row time, step, and what is in
    latest.
    """
    allowed, batch[ALLOWED] = batch[ALLOWED], 0.0
    if allowed == 0.0:
        return False
    t, dt, made = batch[NEXT], batch[DT], batch[MADE]
    row = int(batch[FIRST] + made)
    journal[row, 0], journal[row, 1] = t, dt
    for c in range(latest.size):  # an assignment of arrays compiles for seconds
        journal[row, 2 + c] = latest[c]
    batch[TIME], batch[MADE] = t, made + 1
    batch[LONGEST] = max(batch[LONGEST], dt)
    rate = results[RATE]
    ends = not 0.0 < rate < 1e300
    for flag in (EXHAUSTED, TOO_SHORT, BAD, STOP):
        ends = ends or results[flag] != 0.0
    if ends or t >= batch[TARGET] or made + 1 >= allowed:
        return False
    bound = _longest_step(batch[COURANT], batch[FIXED], rate)
    batch[DT], batch[NEXT] = _next_step(t, batch[TARGET], bound)
    batch[ALLOWED] = allowed
    return True
