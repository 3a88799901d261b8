"""All of a stage, or many steps, in one compiled call: of a rank that has all blocks.

The right-hand side is that of fsipetsc.blockrun.scheme, and what is done with parts and particles
is called by address. Where ranks exchange numbers in between, Python calls the same functions.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import CALL, LOOP, MERGED_CALL, by_length
from fsipetsc.scheme.batch import DT, plan_next
from fsipetsc.scheme.block_monitor import MONITORED
from fsipetsc.scheme.part import clear, copy_row
from fsipetsc.scheme.plan import BAD, RATE, SAID_STOP, STOP
from fsipetsc.scheme.rows import Array

STAGES = 4


@njit(**LOOP)
def advance(y, k, stage, total, number, dt):
    """The classical Runge-Kutta method of fourth order: what follows from the rates k of stage
    ``number``, 0 to 3, in one pass over memory. With base y at first, then total,

        stage = y + a k,   total = base + b k   a = dt/2, dt/2, dt;  b = dt/6, dt/3, dt/3
        stage = total + dt/6 k                  after the last one: the solution

    The paper's method has its own, which rounds each operation by itself. It cannot compile this
    one otherwise: on the disk numba takes two compilations of one function for each other.
    """
    a = dt if number == 2 else 0.5 * dt
    b = dt / 3.0 if 0 < number < 3 else dt / 6.0
    for i in range(y.size):
        found = (y[i] if number == 0 else total[i]) + b * k[i]
        if number < 3:
            total[i] = found
            found = y[i] + a * k[i]
        stage[i] = found


#: what `run` does
COMPLETE, RATES, MONITOR, STEPS = range(4)


class Found(NamedTuple):
    """What steps take and fill: the solution y, memory for stages, a copy to go back to; gain: a
    box of fsipetsc.scheme.part.Gain. The rest is that of fsipetsc.blockrun.block_state; at_ends:
    (4, interfaces). now: (2,) time and length of the step that is made.
    """

    y: Array
    stage: Array
    k: Array
    total: Array
    before: Array
    gain: Any
    extremes: Array
    rates: Array
    results: Array
    latest: Array
    at_ends: Array
    pace: float
    batch: Array
    journal: Array
    now: Array


class All(NamedTuple):
    """Of a rank that has all blocks its parts and particles with their functions, as
    fsipetsc.scheme.part and particles have them, and a box of Found.
    """

    parts: Any
    particles: Any
    found: Any


def _each(name: str, more: str = "") -> Any:
    """A function of all parts and ``more`` that calls one function of each part."""

    def body(n: int) -> str:
        lines = (f" parts[{k}].{name}(parts[{k}].part{more})\n" for k in range(n))
        return "".join(lines) + " return"

    return by_length(f"each_{name}", "parts" + more, body)


follow, store = _each("follow", ", particles"), _each("store", ", particles, s")
normals, turn = _each("normals", ", particles"), _each("turn", ", particles")
move, swing, monitor = _each("move"), _each("swing"), _each("monitor", ", s, found")
rates = _each("rates", ", s, f, gain")


@njit(**CALL)
def run(box, what, s, f):
    """COMPLETE s, find the RATES f of a completed s, MONITOR it, or make the STEPS of a batch.
    False, and the state before it, if a step ends badly. box: of an All.

    What is called stands here once; parts and particles are called by address.
    """
    found, calls, parts, steps = box.found, box.particles, box.parts, what == STEPS
    y, gain, total, now = found.y, found.gain, found.total, found.now
    particles, stages, more, good = calls.all, STAGES + 1 if steps else 1, True, True
    while more:
        if steps:
            copy_row(y, found.before)
        for stage in range(stages):
            at = y if steps and stage == 0 else s
            if steps or what == COMPLETE:
                calls.weigh(particles, at)
                calls.end_sums(particles, gain)
                follow(parts, particles)
                move(parts)
                if particles.slips:
                    normals(parts, particles)
                    calls.end_normals(particles, False)
                if particles.stores:
                    calls.begin_stored(particles, at)
                    store(parts, particles, at)
                    calls.weigh_heat(particles)
                calls.impose_conditions(particles, at, gain)
                follow(parts, particles)
                swing(parts)
            if what == RATES or (steps and stage < STAGES):
                clear(gain.numbers)
                if particles.slips:
                    turn(parts, particles)
                    calls.end_normals(particles, True)
                rates(parts, at, f, gain)
                calls.weigh(particles, f)
                calls.end_rates(particles, at, f, gain)
            if steps and stage < STAGES:
                advance(y, f, s, total, stage, now[1])
        if steps:
            clear(found.latest)
            found.extremes[0] = found.results[SAID_STOP]
        if steps or what == MONITOR:
            monitor(parts, s, found)
        more = False
        if steps:
            good = note_step(found)
            if good:
                now[0] += now[1]
                more = plan_next(found.batch, found.results, found.journal, found.latest)
                now[1] = found.batch[DT] if more else now[1]
    return good


@njit(**MERGED_CALL)
def note_step(found):
    """Flags, bound on the next step, what came in; whether all is well, and y is the new state,
    else it is as before.
    """
    latest, s = found.latest, found.stage
    note_extremes(found.extremes, found.rates, found.results, latest)
    note_gained(latest, s[s.size - found.gain.numbers.size :])
    good = found.results[BAD] == 0.0
    copy_row(s if good else found.before, found.y)
    return good


@njit(**MERGED_CALL)
def note_extremes(extremes, rates, results, latest):
    """Put the extremes of all ranks where they belong.

    extremes: (1 + MONITORED blocks,), what a rank says of stopping, and those of each block. rates:
    (blocks, 2). latest: begins with the least J and the departure of J of each block. The bound on
    the step is the 4-norm of both rates.
    """
    blocks = rates.shape[0]
    convection, diffusion, bad = 0.0, 0.0, 0.0
    for k in range(blocks):
        at = 1 + MONITORED * k
        bad = max(bad, extremes[at])
        rates[k, 0], rates[k, 1] = extremes[at + 1], extremes[at + 2]
        latest[k], latest[blocks + k] = -extremes[at + 3], extremes[at + 4]
        convection = np.maximum(convection, extremes[at + 1])  # what is no number stays one
        diffusion = np.maximum(diffusion, extremes[at + 2])
    results[RATE] = np.sqrt(np.sqrt(convection**4 + diffusion**4))
    results[BAD], results[STOP] = bad, extremes[0]


@njit(**MERGED_CALL)
def note_gained(latest, auxiliary):
    """Put what came in, the auxiliary unknowns, into the last columns of ``latest``.

    The monitor leaves minus the energy E of solids where what they lost of it will be. So E stays
    in an auxiliary unknown, which after the next step is W + E, W the work: W + E - E' is lost.
    """
    first = latest.size - auxiliary.size
    for c in range(auxiliary.size):
        latest[first + c] += auxiliary[c]
        auxiliary[c] -= latest[first + c]
