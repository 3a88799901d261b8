"""All of a stage, or many steps, in one compiled call: of a rank that has all blocks.

The right-hand side is that of fsipetsc.blockrun.scheme, and what is done with parts and particles
is called by address. Where ranks exchange numbers in between, Python calls the same functions.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import njit

from fsipetsc.operators.loops import CALL, MERGED_CALL
from fsipetsc.operators.loops import _by_length as by_length
from fsipetsc.scheme.after_step import note_extremes, note_gained
from fsipetsc.scheme.batch import DT, plan_next
from fsipetsc.scheme.part import clear, copy_row
from fsipetsc.scheme.plan import BAD, SAID_STOP
from fsipetsc.scheme.rows import Array
from fsipetsc.scheme.runge_kutta import STAGES, advance

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
move, swing, monitor = _each("move"), _each("swing"), _each("monitor", ", s")
rates, note = _each("rates", ", s, f, gain"), _each("note", ", found")


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
                calls.begin_sums(particles, at, gain)
                calls.end_sums(particles, gain)
                follow(parts, particles)
                move(parts)
                if particles.slips:
                    calls.begin_normals(particles)
                    normals(parts, particles)
                    calls.end_normals(particles, False)
                if particles.stores:
                    calls.begin_stored(particles, at)
                    store(parts, particles, at)
                    calls.end_stored(particles)
                calls.impose_conditions(particles, at, gain)
                follow(parts, particles)
                swing(parts)
            if what == RATES or (steps and stage < STAGES):
                clear(gain.numbers)
                if particles.slips:
                    calls.begin_normals(particles)
                    turn(parts, particles)
                    calls.end_normals(particles, True)
                rates(parts, at, f, gain)
                calls.begin_rates(particles, f)
                calls.end_rates(particles, at, f, gain)
            if steps and stage < STAGES:
                advance(y, f, s, total, stage, now[1])
        if steps or what == MONITOR:
            monitor(parts, s)
        more = False
        if steps:
            clear(found.latest)
            found.extremes[0] = found.results[SAID_STOP]
            note(parts, found)
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
