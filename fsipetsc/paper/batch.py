"""Several steps of the classical Runge-Kutta method in one compiled call, on one rank.

Below some thousand points Python's calls would take longer than the arithmetic. What is called here
are the loops that the right-hand side of fsipetsc.paper.parts calls, in the same order, so both
make the same numbers. A layer that there is not is None.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.paper.coupling import couple, put_rows, residuals, take_rows
from fsipetsc.paper.ends import close_solid, distance, fill_ghost, move_boundary
from fsipetsc.paper.rates import elastic_rates, gas_rates
from fsipetsc.paper.stencils import CALL, INNER, LEFT, OLD, RIGHT, U
from fsipetsc.paper.sums import (
    SEEN,
    SHARES,
    bound,
    gas_speeds,
    layer_rates,
    look_at_gas,
    look_at_solid,
    solid_speeds,
)
from fsipetsc.scheme.burst import DT, plan_next
from fsipetsc.scheme.plan import (
    BAD,
    BURST,
    EXHAUSTED,
    FLAGS,
    LIMITS,
    LOW,
    MOVED,
    RATE,
    SAID_STOP,
    STOP,
    TOO_SHORT,
)

#: of the method
STAGES = 4
#: numbers of an interface that are noted
NOTES = 8
#: what ``run_task`` does: stage ``number`` of a step dt, or for STAGES its completion; a step dt
#: from the completed solution, its completion, and further steps as the burst allows
STAGE, STEPS = 0, 1


@njit(**CALL)
def advance(y, k, stage, total, number, dt):
    """What a stage of the classical method does with its rates k: the next stage, and the sum that
    becomes the solution."""
    a = dt if number == 2 else 0.5 * dt
    b = dt / 3.0 if 0 < number < 3 else dt / 6.0
    if number == 0:
        for i in range(y.size):
            total[U(i)] = y[U(i)] + b * k[U(i)]
            stage[U(i)] = y[U(i)] + a * k[U(i)]
    elif number < 3:
        for i in range(y.size):
            total[U(i)] += b * k[U(i)]
            stage[U(i)] = y[U(i)] + a * k[U(i)]
    else:
        for i in range(y.size):
            stage[U(i)] = total[U(i)] + b * k[U(i)]


@njit(**INNER)
def interface_points(face, gas, solid):
    """(point of the gas, step into it, point of the solid, step into it), among the owned points of
    their owners."""
    if face.n > 0.0:
        return gas.lo - gas.own_lo, 1, solid.hi - solid.own_lo, -1
    return gas.hi - gas.own_lo, -1, solid.lo - solid.own_lo, 1


@njit(**INNER)
def join(op, face, jump, gas, q_gas, solid, q_solid, f, s):
    """Couple gas and solid, both owned by this rank, and let the frame follow; f, s: room for the
    rows, which stay there."""
    at_gas, into_gas, at_solid, into_solid = interface_points(face, gas, solid)
    take_rows(op, q_gas, at_gas, into_gas, f)
    take_rows(op, q_solid, at_solid, into_solid, s)
    couple(op, face, jump, f, s)
    put_rows(op, q_gas, at_gas, into_gas, f)
    put_rows(op, q_solid, at_solid, into_solid, s)
    gas.s, gas.x_interface = f[0, 1] / f[0, 0], s[0, 3]


@njit(**INNER)
def boundary_moves(op, law, gas, q, side, number, flags):
    """Let the embedded boundary of layer ``number`` move over the grid; flags: see
    fsipetsc.scheme.plan."""
    moved, exhausted = move_boundary(op, law, gas, q, side)
    if moved:
        flags[MOVED] = 1.0
    if exhausted:
        flags[EXHAUSTED] = 1.0 + number
    if (gas.lo == 0) if side == 0 else (gas.hi == gas.n - 1):
        flags[LOW] = 1.0 + number
    if distance(gas, side) <= gas.least - 2 + 1e-9:
        flags[TOO_SHORT] = 1.0 + number


@njit(**INNER)
def note_interface(op, face, jump, f, s, out):
    """x, u, sigma, T and the residuals of the four conditions."""
    out[0], out[1], out[2], out[3] = s[0, 3], s[0, 0], s[0, 1], s[0, 2]
    residuals(op, face, jump, f, s, out[4:])


@njit(**INNER)
def goes_on(room, journal):
    """See fsipetsc.scheme.burst.plan_next."""
    return plan_next(room.burst, room.results, journal, room.latest[: room.numbers])


_F = np.float64
#: what a state works with; layers and interfaces are counted as if there were three and two. there:
#: whether they are, as gases; rows f, s and jumps of the interfaces; seen, shares, rates (of
#: convection and diffusion) of the layers: see fsipetsc.paper.sums; notes: of ``note_interface``;
#: results, burst, latest (of so many ``numbers``): see fsipetsc.scheme.plan
ROOM = np.dtype(
    [
        *[("there", np.int64, (3,)), ("numbers", np.int64)],
        *[("jumps", _F, (2, 4)), ("f", _F, (2, 8, 3)), ("s", _F, (2, 8, 4)), ("notes", _F, (2, NOTES))],
        *[("seen", _F, (3, SEEN)), ("shares", _F, (3, SHARES)), ("rates", _F, (3, 2))],
        *[("results", _F, (FLAGS + LIMITS,)), ("burst", _F, (BURST,)), ("latest", _F, (24,))],
    ],
    align=True,
)


@njit(**INNER)
def note_step(room):
    """Fill ``latest`` from notes and shares: see fsipetsc.scheme.plan.step_record."""
    latest, shares, at = room.latest, room.shares, 0
    for c in range(NOTES):
        for face in range(2):
            if room.there[2 * face] != 0:
                latest[at] = room.notes[face, c]
                at += 1
    for k in range(3):
        if room.there[k] != 0:
            latest[at] = shares[k, 0]
            at += 1
    for c in range(1, SHARES):
        if at == room.numbers:
            return  # entropy and heating are not wanted
        latest[at] = shares[0, c] + shares[1, c] + shares[2, c]
        at += 1
        if c == 3:
            latest[at] = 0.0  # the impulse of ends: none has been given its velocity by one
            at += 1


@njit(**INNER)
def bound_step(op, room, good):
    """The limits among the results, from the rates of the layers; good: all of them are
    physical."""
    convection = max(max(room.rates[0, 0], room.rates[1, 0]), room.rates[2, 0])
    diffusion = max(max(room.rates[0, 1], room.rates[1, 1]), room.rates[2, 1])
    room.results[RATE] = bound(convection, diffusion)
    room.results[BAD] = 0.0 if good else 1.0


# one rank; a layer may be None


@njit(**INNER)
def _join(op, face, k, gas, solid, room):
    if gas is not None:
        join(
            op,
            face,
            room.jumps[k],
            gas.record[0],
            gas.stage,
            solid.record[0],
            solid.stage,
            room.f[k],
            room.s[k],
        )


@njit(**INNER)
def _fill(op, gas, side):
    if gas is not None:
        fill_ghost(op, gas.law, gas.record[0], gas.stage, side, OLD)


@njit(**INNER)
def _advance(op, gas, number, dt):
    if gas is not None:
        gas_rates(op, gas.law, gas.record[0], gas.stage, gas.forcing, gas.scratch, gas.k)
        advance(gas.y.ravel(), gas.k.ravel(), gas.stage.ravel(), gas.total.ravel(), number, dt)


@njit(**INNER)
def _look(op, face, gas, side, number, entropy, room):
    """Move the boundary and look at the layer; whether it is physical."""
    if gas is None:
        return True
    k = 2 * side
    boundary_moves(op, gas.law, gas.record[0], gas.stage, side, number, room.results)
    look_at_gas(
        op, gas.law, gas.record[0], gas.stage, gas.scratch, entropy, room.seen[k], room.shares[k]
    )
    note_interface(op, face, room.jumps[side], room.f[side], room.s[side], room.notes[side])
    good, room.rates[k, 0], room.rates[k, 1] = layer_rates(
        op, gas_speeds(gas.law, room.seen[k]), gas.record[0].h
    )
    return good


@njit(**INNER)
def _conditions(op, left, solid, right, faces, room):
    """Fulfil all conditions in the stage."""
    _join(op, faces[0], LEFT, left, solid, room)
    _join(op, faces[1], RIGHT, right, solid, room)
    close_solid(op, solid.law, solid.record[0], solid.stage)
    _fill(op, left, LEFT)
    _fill(op, right, RIGHT)


@njit(**INNER)
def _complete(op, left, solid, right, faces, entropy, room):
    """Let boundaries move in the stage, which fulfils the conditions, and look at it."""
    for flag in range(RATE):
        room.results[flag] = 0.0
    middle = room.there[0]
    good = _look(op, faces[0], left, LEFT, LEFT, entropy, room)
    look_at_solid(
        op,
        solid.law,
        solid.record[0],
        solid.stage,
        solid.scratch,
        entropy,
        room.seen[1],
        room.shares[1],
    )
    speeds = solid_speeds(solid.law, room.seen[1])
    fine, room.rates[1, 0], room.rates[1, 1] = layer_rates(op, speeds, solid.record[0].h)
    good = _look(op, faces[1], right, RIGHT, middle + 1, entropy, room) and fine and good
    room.results[STOP] = room.results[SAID_STOP]
    bound_step(op, room, good)
    note_step(room)


@njit(**INNER)
def _keep(part):
    if part is not None:
        for i in range(part.y.shape[0]):
            for c in range(part.y.shape[1]):
                part.y[U(i), U(c)] = part.stage[U(i), U(c)]


@njit(**CALL)
def run_task(task, ops, left, solid, right, faces, entropy, rooms, journal, number, dt):
    """One of the tasks; the completed solution is y, and the stage is the same where a step
    begins."""
    op, room = ops[0], rooms[0]
    first, end, completes = (
        (0, STAGES, True) if task == STEPS else (number, number + 1, number == STAGES)
    )
    more = True
    while more:
        for stage in range(first, end):
            if stage > 0:
                _conditions(op, left, solid, right, faces, room)
            if stage < STAGES:
                _advance(op, left, stage, dt)
                _advance(op, right, stage, dt)
                elastic_rates(
                    op,
                    solid.law,
                    solid.record[0],
                    solid.stage,
                    solid.forcing,
                    solid.scratch,
                    solid.k,
                )
                advance(
                    solid.y.ravel(),
                    solid.k.ravel(),
                    solid.stage.ravel(),
                    solid.total.ravel(),
                    stage,
                    dt,
                )
        if completes:
            if task == STEPS:
                _conditions(op, left, solid, right, faces, room)
            _complete(op, left, solid, right, faces, entropy, room)
            _keep(left)
            _keep(solid)
            _keep(right)
        more = task == STEPS and goes_on(room, journal)
        if more:
            dt = room.burst[DT]
