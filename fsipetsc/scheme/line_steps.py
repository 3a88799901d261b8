"""Steps in one dimension: all of a stage, or many steps, in one compiled call.

The right-hand side is that of fsipetsc.blockrun.block_scheme, and its parts are those of
fsipetsc.scheme.line_parts. Where ranks exchange numbers between its parts, Python calls them one by
one; a rank that has all blocks, and no data that depend on time, makes many steps at a time.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import literal_unroll, njit

from fsipetsc.operators.loops import CALL, INNER_LOOP, MERGED_CALL
from fsipetsc.scheme.after_step import note_extremes
from fsipetsc.scheme.burst import DT, plan_next
from fsipetsc.scheme.line_parts import clear
from fsipetsc.scheme.plan import BAD, SAID_STOP
from fsipetsc.scheme.rows import Array
from fsipetsc.scheme.runge_kutta import STAGES, advance

#: what `run` does
COMPLETE, RATES, LOOK, STEPS = range(4)


class Found(NamedTuple):
    """What steps take and fill: the solution y, memory for stages, a copy to go back to; gain: what
    came in. The rest is that of fsipetsc.blockrun.block_state; at_ends: (4, interfaces). now: (2,)
    time and length of the step that is made.
    """

    y: Array
    stage: Array
    k: Array
    total: Array
    before: Array
    gain: Array
    extremes: Array
    rates: Array
    results: Array
    latest: Array
    at_ends: Array
    pace: float
    burst: Array
    journal: Array
    now: Array


class Line(NamedTuple):
    """All of a rank that has all blocks: its parts and particles with their functions, as
    fsipetsc.scheme.line_parts and particle_steps hold them, and a box of Found.
    """

    parts: Any
    particles: Any
    found: Any


@njit(**CALL)
def run(box, what, s, f):
    """COMPLETE s, find the RATES f of a completed s, LOOK at it, or make STEPS as the burst allows.
    False, and the state before it, if a step ends badly. box: of a Line.

    What is called stands here once; parts and particles are called by address.
    """
    found, held, parts, steps = box.found, box.particles, box.parts, what == STEPS
    y, gain, total, now = found.y, found.gain, found.total, found.now
    particles, stages, more, good = held.all, STAGES + 1 if steps else 1, True, True
    while more:
        if steps:
            copy(y, found.before)
            copy(y, s)
        for stage in range(stages):
            if steps or what == COMPLETE:
                held.begin_sums(particles, s, gain)
                held.end_sums(particles, gain)
                if particles.stores:
                    held.begin_stored(particles, s)
                    for one in literal_unroll(parts):
                        one.store(one.part, particles, s)
                    held.end_stored(particles)
                held.settle(particles, s, gain)
                for one in literal_unroll(parts):
                    one.follow(one.part, particles)
            if steps and (stage == 0 or stage == STAGES):
                copy(s, y)
            if what == RATES or (steps and stage < STAGES):
                clear(gain)
                for one in literal_unroll(parts):
                    one.rates(one.part, s, f, gain)
                held.begin_rates(particles, f)
                held.end_rates(particles, s, f, gain)
            if steps and stage < STAGES:
                advance(y, f, s, total, stage, now[1])
        if steps or what == LOOK:
            for one in literal_unroll(parts):
                one.look(one.part, s)
        more = False
        if steps:
            clear(found.latest)
            found.extremes[0] = found.results[SAID_STOP]
            for one in literal_unroll(parts):
                one.note(one.part, found)
            good = note_step(found)
            if good:
                now[0] += now[1]
                more = plan_next(found.burst, found.results, found.journal, found.latest)
                now[1] = found.burst[DT] if more else now[1]
    return good


@njit(**MERGED_CALL)
def note_step(found):
    """Flags, bound on the next step, what came in; whether all is well, else y is as before."""
    latest, y, n = found.latest, found.y, found.gain.size
    note_extremes(found.extremes, found.rates, found.results, latest)
    for c in range(n):
        latest[latest.size - n + c] = y[y.size - n + c]
        y[y.size - n + c] = 0.0
    if found.results[BAD] != 0.0:
        copy(found.before, y)
    return found.results[BAD] == 0.0


@njit(**INNER_LOOP)
def copy(of, to):
    """to = of."""
    for i in range(of.size):
        to[i] = of[i]
