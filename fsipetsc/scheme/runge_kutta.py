"""Steps of the classical Runge-Kutta method: its stages, what is known after a step.

The procedures here are those between the phases of fsipetsc.blockrun.phases. What they take and
fill is ``found``, a record of the solution y, its stages, total: the sum that becomes the next one,
gain (fsipetsc.scheme.part), and what fsipetsc.blockrun.block_state has. at_ends: 4 (interfaces,).
time: (1,) of recorded data. stage: (2,) what sweeps make of rates (fsipetsc.scheme.sweep). left:
(runs, 2) begin and end of the numbers of a world vector of which sweeps give rates in any case.
"""

from collections.abc import Callable

import numpy as np

from fsipetsc.kernels.loops import each, variable
from fsipetsc.scheme.monitor import LEAST_J, MONITORED
from fsipetsc.scheme.part import clear
from fsipetsc.scheme.plan import BAD, DT, RATE, SAID_STOP, STOP
from fsipetsc.scheme.sweep import LAST, NEXT, RATES

STAGES = 4
#: times of the stages, and of what comes of them, in steps
FRACTIONS = 0.0, 0.5, 0.5, 1.0, 1.0


def begin_stage(number: int | None) -> Callable[..., None]:
    """The procedure that says what sweeps store: stages with this number, or rates."""

    def begin(found):
        """What sweeps store from now on."""
        kind = RATES if number is None else (NEXT, NEXT, NEXT, LAST)[number]
        a, b = factors(number or 0, found.plan.batch[DT])
        found.stage[0], found.stage[1] = float(kind), b if kind == LAST else a

    return begin


def factors(number, dt):
    """Return a and b of a stage, as `advance` uses them."""
    a = dt if number == 2 else 0.5 * dt
    return a, dt / 3.0 if 0 < number < 3 else dt / 6.0


def advance(number: int) -> Callable[..., None]:
    """Return the procedure of a stage, 0 to 3. It replaces the rates k, which sweeps have left in
    f, by the next stage. With the base y at first, and total after that,

        f = y + a k,   total = base + b k   a = dt/2, dt/2, dt;  b = dt/6, dt/3, dt/3
        f = total + dt/6 k                  after the last one: the solution
    """

    def stage(found, f):
        """The next stage from rates, and the sum that becomes the solution."""
        base, total, (a, b) = found.y, found.total, factors(number, found.plan.batch[DT])
        for run in each(found.left.shape[0]):
            for i in each(found.left[run, 0], found.left[run, 1], vector=True):
                k = f[i]
                sum_of_stages = (base[i] if number == 0 else total[i]) + b * k
                if number == 3:
                    f[i] = sum_of_stages
                else:
                    f[i] = base[i] + a * k
                    total[i] = sum_of_stages

    return stage


def begin_monitor(found):
    """Clear what the monitor found after the step before."""
    clear(found.latest)
    for i in each(found.extremes.size):  # a least J is found as the largest -J
        found.extremes[i] = np.where((i - 1) % MONITORED == LEAST_J, -np.inf, 0.0)
    found.extremes[0] = found.results[SAID_STOP]


def note_extremes(found):
    """From the extremes of all ranks find the bound on the next step, and whether a state is bad.

    extremes: (1 + MONITORED blocks,), what a rank says of stopping, and those of each block. rates:
    (blocks, 2). latest: begins with the least J and the departure of J of each block. The bound on
    the step is the 4-norm of both rates.
    """
    extremes, rates, results, latest = found.extremes, found.rates, found.results, found.latest
    convection, diffusion, bad = variable(0.0), variable(0.0), variable(0.0)
    blocks = rates.shape[0]
    for k in each(blocks):
        of_block = extremes[1 + MONITORED * k :]
        bad.value = np.maximum(bad.value, of_block[0])
        rates[k, 0], rates[k, 1] = of_block[1], of_block[2]
        latest[k], latest[blocks + k] = -of_block[3], of_block[4]
        convection.value = np.maximum(convection.value, of_block[1])  # what is no number stays one
        diffusion.value = np.maximum(diffusion.value, of_block[2])
    results[RATE] = np.sqrt(np.sqrt(convection.value**4 + diffusion.value**4))
    results[BAD], results[STOP] = bad.value, extremes[0]


def note_gained(found, y):
    """Move what came in during a step from auxiliary unknowns to the last columns of ``latest``.

    What a step loses of the energy of solids is W + E - E', with W the work on them, E before and
    E' after it. The auxiliary unknown has E and gets W; the monitor writes -E' into the column.
    Their sum is the loss, and with that subtracted the unknown has E', for the next step.
    """
    count, latest = found.gain.numbers.size, found.latest
    first, auxiliary = latest.size - count, found.y.size - count
    for c in each(count):
        gained = latest[first + c] + y[auxiliary + c]
        latest[first + c] = gained
        y[auxiliary + c] -= gained
