"""Steps of the classical Runge-Kutta method: its stages, what is noted of a completed step, how
long the next one is, and how many steps one call of C makes.

A batch of steps ends when as many are made as are allowed (-ts_max_steps, room in the journal),
when a time to be saved is reached, or at a failure or a signal. Each step fills a journal's row.

Procedures take and fill ``found``, a record of the solution y, its stages, total: the sum that
becomes the next one, gain (fsipetsc.scheme.part), plan: see `plan_next`, time: (1,) of recorded
data, stage: (2,) what sweeps make of rates (fsipetsc.scheme.sweep), left: (runs, 2) begin and end
of the numbers of a world vector of which sweeps give rates in any case, at_ends: 4 (interfaces,),
and what fsipetsc.stepping.block_state has.
"""

import numpy as np

from fsipetsc.kernels.loops import each, when, whole
from fsipetsc.scheme.sweep import LAST

# where what stands among the results of a completed step
#: OFF_GRID: 1 + number of a layer that has run off its grid, or that is too short; SAID_STOP: what
#: this rank has to say of STOP. RESULTS: how many these are
OFF_GRID, RATE, BAD, STOP, SAID_STOP, RESULTS = range(6)
#: steps that the journal holds; they must be written then
CAPACITY = 4096
#: places in the numbers of a batch: TIME before a step or, once it is made, after it; DT, its
#: length; NEXT, the time after it; TARGET, the next time that must be hit; COURANT number; FIXED,
#: the step that is given, or 0; steps ALLOWED and MADE; the LONGEST of these; FIRST row of the
#: journal to be filled. BATCH: how many these are
TIME, DT, NEXT, TARGET, COURANT, FIXED, ALLOWED, MADE, LONGEST, FIRST, BATCH = range(11)

#: a step may be longer than its bound by this fraction, so that round-off costs no extra step
SLACK = 1e-9
#: stages of a step; the number of the solution that comes of them
STAGES = SOLUTION = 4
#: times of the stages, and of what comes of them, in steps
FRACTIONS = 0.0, 0.5, 0.5, 1.0, 1.0
#: stages at another time than what is before them, with other data
NEW_DATA = 1, 3


def time_of(part, batch):
    """The time at a part of the step. Its end is exactly where the next one begins."""
    return batch[NEXT] if part == 1.0 else batch[TIME] + part * batch[DT]


def begin_stage(kind, number, found):
    """Let sweeps store this kind from now on, of the stage of this number. Nothing came in yet."""
    dt, found.stage[0] = found.plan.batch[DT], float(kind)
    found.stage[1] = dt / 6.0 if kind == LAST else dt if number == 2 else 0.5 * dt
    found.gain.numbers[:] = 0.0


def advance(number, found, f):
    """The stage of this number, 0 to 3, from the rates k, which sweeps have left in f, and the sum
    that becomes the solution; y: the solution before the step.

        stage = y + a k,   sum = total + b k      a = dt/2, dt/2, dt;  b = dt/6, dt/3, dt/3
        stage = sum = total + dt/6 k              after the last one: the solution
    """
    y, total, dt = found.y, found.total, found.plan.batch[DT]
    a, b = dt if number == 2 else 0.5 * dt, dt / 3.0 if number in (1, 2) else dt / 6.0
    for run in each(found.left.shape[0]):
        for i in each(found.left[run, 0], found.left[run, 1], vector=True):
            k, before = f[i], y[i] if number == 0 else total[i]
            f[i] = before + b * k if number == 3 else y[i] + a * k
            if number < 3:
                total[i] = before + b * k


def longest_step(courant, fixed, rate):
    """Return the bound on a step [s]: the one that is given (-ts_dt), or, if that is 0, the Courant
    number divided by ``rate``; nan if the rate is 0.
    """
    return np.where(fixed != 0.0, fixed, courant / np.where(rate > 0.0, rate, np.nan))


def next_step(t, target, bound):
    """Return the next step and the time after it [s]. The step is at most ``bound``; if less than
    two steps remain to the target, they are equal.
    """
    left = target - t
    last = left <= bound * (1.0 + SLACK)
    step = np.where(last, left, np.where(left < 2.0 * bound, 0.5 * left, bound))
    return step, np.where(last, target, t + step)


def plan_next(plan):
    """Write the step just made into batch and journal, and plan the next one. If none follows,
    ALLOWED becomes 0. All ranks come to the same plan.

    plan: batch: a batch that has ended, or was never planned, allows no steps. results: see above.
    journal: (rows, columns), each row time, step, and the numbers in latest.
    """
    batch, results, journal, latest = plan.batch, plan.results, plan.journal, plan.latest
    allowed, t, dt, made = batch[ALLOWED], batch[NEXT], batch[DT], batch[MADE]
    target, rate = batch[TARGET], results[RATE]
    goes_on = (rate > 0.0) & (rate < 1e300) & (t < target) & (made + 1.0 < allowed)
    for flag in (OFF_GRID, BAD, STOP):
        goes_on = goes_on & (results[flag] == 0.0)
    batch[ALLOWED] = 0.0
    with when(allowed != 0.0):
        row = whole(batch[FIRST] + made)
        journal[row, 0], journal[row, 1] = t, dt
        for c in each(latest.size):
            journal[row, 2 + c] = latest[c]
        batch[TIME], batch[MADE] = t, made + 1.0
        batch[LONGEST] = np.maximum(batch[LONGEST], dt)
        with when(goes_on):
            bound = longest_step(batch[COURANT], batch[FIXED], rate)
            batch[DT], batch[NEXT] = next_step(t, target, bound)
            batch[ALLOWED] = allowed
