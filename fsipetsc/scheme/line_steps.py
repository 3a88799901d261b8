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
from fsipetsc.scheme.line_parts import LINE, clear
from fsipetsc.scheme.particles import (
    constrain,
    fill_rates,
    fill_state,
    give_rates,
    give_state,
    share,
    share_heat,
    slide,
)
from fsipetsc.scheme.plan import BAD, SAID_STOP
from fsipetsc.scheme.rows import Array
from fsipetsc.scheme.runge_kutta import further_stage, last_stage, next_stage

#: what `run` does
COMPLETE, RATES, LOOK, STEPS = range(4)


class Particles(NamedTuple):
    """The particles of a rank: see fsipetsc.scheme.particles. law: of the gas. stored: (rows,) what
    members store. rows: (rows, columns) of the exchange. rates: (p, 4). slips: whether any has
    constraints; normals, turning: (p, K, 2), which stay. moves: (p,) whether a wall there moves,
    place: (p,) its displacement.
    """

    table: Any
    law: Any
    data: Any
    state: Any
    stored: Array
    rows: Array
    rates: Array
    slips: int
    normals: Array
    turning: Array
    moves: Array
    place: Array


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
    """All of a rank that has all blocks: boxes of its parts and of Particles, and Found."""

    parts: Any
    particles: Any
    found: Any


# parts of a stage


@njit(**CALL)
def begin_sums(particles, s, gain):
    """Rows of the members of this rank."""
    p = particles.value
    clear(gain)
    fill_state(p.table, LINE, s, p.rows)


@njit(**CALL)
def end_sums(particles, gain):
    """What particles share, from the rows of all members."""
    p = particles.value
    share(p.table, LINE, p.rows, p.data, p.state, gain)


@njit(**CALL)
def settle(particles, s, gain):
    """What constraints and heat make of it, for the members of this rank; s has what came in."""
    p = particles.value
    if p.slips:
        slide(p.table, LINE, p.normals, p.data, p.state, gain)
    share_heat(p.table, p.law, LINE, p.data, p.state, gain)
    give_state(p.table, LINE, p.stored, s, p.state)
    for c in range(gain.size):
        s[s.size - gain.size + c] += gain[c]


@njit(**CALL)
def begin_rates(particles, f):
    """Rows of the rates of the members of this rank."""
    p = particles.value
    fill_rates(p.table, LINE, f, p.rows)


@njit(**CALL)
def end_rates(particles, s, f, gain):
    """Rates of the members under the constraints of their particles."""
    p = particles.value
    constrain(p.table, LINE, p.rows, p.normals, p.turning, p.data, p.state, p.rates, gain)
    give_rates(p.table, LINE, s, f, p.state, p.rates)
    for c in range(gain.size):
        f[f.size - gain.size + c] = gain[c]


# a rank that has all


@njit(**CALL)
def run(box, what, s, f):
    """COMPLETE s, find the RATES f of a completed s, LOOK at it, or make STEPS as the burst allows.
    False, and the state before it, if a step ends badly. box: of a Line.

    What is called stands here once, so that it is compiled once.
    """
    line, steps = box.value, what == STEPS
    found, particles = line.found, line.particles
    y, gain, more, good = found.y, found.gain, True, True
    while more:
        if steps:
            copy(y, found.before)
            copy(y, s)
        for stage in range(5 if steps else 1):
            if steps or what == COMPLETE:
                begin_sums(particles, s, gain)
                end_sums(particles, gain)
                settle(particles, s, gain)
                for part in literal_unroll(line.parts):
                    part.follow(particles)
                    part.move()
            if steps and (stage == 0 or stage == 4):
                copy(s, y)
            if what == RATES or (steps and stage < 4):
                clear(gain)
                for part in literal_unroll(line.parts):
                    part.rates(s, f, gain)
                begin_rates(particles, f)
                end_rates(particles, s, f, gain)
            if steps and stage < 4:
                next_of(found, stage, s, f)
        if steps or what == LOOK:
            for part in literal_unroll(line.parts):
                part.look(s)
        more = False
        if steps:
            clear(found.latest)
            found.extremes[0] = found.results[SAID_STOP]
            for part in literal_unroll(line.parts):
                part.note(found)
            good = note_step(found)
            if good:
                found.now[0] += found.now[1]
                more = plan_next(found.burst, found.results, found.journal, found.latest)
                found.now[1] = found.burst[DT] if more else found.now[1]
    return good


@njit(**MERGED_CALL)
def next_of(found, stage, s, k):
    """What follows from the rates k of a stage s: see fsipetsc.scheme.runge_kutta."""
    y, total, dt = found.y, found.total, found.now[1]
    if stage == 0:
        next_stage(y, k, 0.5 * dt, dt / 6.0, s, total)
    elif stage < 3:
        further_stage(y, k, 0.5 * dt if stage == 1 else dt, dt / 3.0, s, total)
    else:
        last_stage(total, k, dt / 6.0, s)


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
