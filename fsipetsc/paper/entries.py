"""What Python calls of the compiled method, where PETSc's exchange stands between: one call where
several things can be done.

What they take is in a fsipetsc.operators.boxed.Box each: numba takes tens of microseconds to see
what an array of records is. Records are arrays of length one.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from fsipetsc.paper import batch, sums
from fsipetsc.paper.coupling import couple, put_rows, take_rows
from fsipetsc.paper.ends import close_solid, fill_ghost
from fsipetsc.paper.layer import FLUID
from fsipetsc.paper.rates import elastic_rates, gas_rates
from fsipetsc.paper.stencils import CALL, INNER, OLD
from fsipetsc.scheme.plan import RATE, SAID_STOP, STOP

#: sides of an interface
GAS, SOLID = 0, 1
#: numbers of a layer that all ranks learn after a step, beside those that are seen
FRAME = 4


class LayerData(NamedTuple):
    """What calls of a layer take: this rank's ``local`` points with halos, ``stage`` without; the
    rest is as in fsipetsc.paper.parts.
    """

    ops: Any
    law: Any
    layers: Any
    local: Any
    stage: Any
    forcing: Any
    scratch: Any
    rooms: Any


class SidesData(NamedTuple):
    """The same of an interface: records, points and rows of both sides."""

    ops: Any
    face: Any
    jump: Any
    gases: Any
    solids: Any
    q_gas: Any
    q_solid: Any
    f: Any
    s: Any
    rooms: Any


class SharedData(NamedTuple):
    """What all ranks learn after a step: records of all layers, their numbers among three, those of
    the interfaces among two, whether this rank notes them; told: (numbers,), as ``tell`` fills it.
    """

    rooms: Any
    records: Any
    layers: Any
    interfaces: Any
    noted: Any
    told: Any


class StepData(NamedTuple):
    """What follows from all that has been seen of a layer, and the end of a step, take."""

    ops: Any
    law: Any
    rooms: Any
    journal: Any


@njit(**CALL)
def take_side(of, side):
    """The rows of one side of an interface, of its owner."""
    points = batch.interface_points(of.face, of.gases[0], of.solids[0])
    if side == GAS:
        take_rows(of.ops[0], of.q_gas, points[0], points[1], of.f)
    else:
        take_rows(of.ops[0], of.q_solid, points[2], points[3], of.s)


@njit(**CALL)
def couple_side(of, side):
    """Couple both sides, put back the rows of one, and let the frame follow."""
    gas, f, s = of.gases[0], of.f, of.s
    points = batch.interface_points(of.face, gas, of.solids[0])
    couple(of.ops[0], of.face, of.jump, f, s)
    if side == GAS:
        put_rows(of.ops[0], of.q_gas, points[0], points[1], f)
    else:
        put_rows(of.ops[0], of.q_solid, points[2], points[3], s)
    gas.s, gas.x_interface = f[0, 1] / f[0, 0], s[0, 3]


@njit(**CALL)
def join(of):
    """See fsipetsc.paper.batch.join."""
    sides = of.gases[0], of.q_gas, of.solids[0], of.q_solid
    batch.join(of.ops[0], of.face, of.jump, *sides, of.f, of.s)


@njit(**CALL)
def close_end(of):
    """See fsipetsc.paper.ends.close_solid."""
    close_solid(of.ops[0], of.law, of.layers[0], of.stage)


@njit(**CALL)
def fill(of, side):
    """See fsipetsc.paper.ends.fill_ghost."""
    fill_ghost(of.ops[0], of.law, of.layers[0], of.local, side, OLD)


@njit(**CALL)
def evaluate_gas(of, side, out):
    """The rates of a gas, with its ghost point filled first, but for side < 0."""
    if side >= 0:
        fill_ghost(of.ops[0], of.law, of.layers[0], of.local, side, OLD)
    gas_rates(of.ops[0], of.law, of.layers[0], of.local, of.forcing, of.scratch, out)


@njit(**CALL)
def evaluate_solid(of, out):
    """The rates of a solid."""
    elastic_rates(of.ops[0], of.law, of.layers[0], of.local, of.forcing, of.scratch, out)


@njit(**CALL)
def look_at_gas(of, side, number, entropy):
    """After a step: fill the ghost point, let the boundary move, look at the points."""
    room, k, op, q = of.rooms[0], 2 * side, of.ops[0], of.local
    fill_ghost(op, of.law, of.layers[0], q, side, OLD)
    batch.boundary_moves(op, of.law, of.layers[0], q, side, number, room.results)
    seen = room.seen[k], room.shares[k]
    sums.look_at_gas(op, of.law, of.layers[0], q, of.scratch, entropy, *seen)


@njit(**CALL)
def look_at_solid(of, entropy):
    """After a step: look at the points."""
    seen = of.rooms[0].seen[1], of.rooms[0].shares[1]
    sums.look_at_solid(of.ops[0], of.law, of.layers[0], of.local, of.scratch, entropy, *seen)


@njit(**CALL)
def note_interface(of, k):
    """See fsipetsc.paper.batch.note_interface."""
    room = of.rooms[0]
    batch.note_interface(of.ops[0], of.face, room.jumps[k], room.f[k], room.s[k], room.notes[k])


def told_size(layers, interfaces):
    """Numbers that ``tell`` fills."""
    return layers * (sums.SEEN + FRAME) + interfaces * batch.NOTES + RATE + 1


@njit(**INNER)
def _sign(gas, c):
    """1 for a number of which the largest counts, -1 for the least, see fsipetsc.paper.sums."""
    return 1.0 if c >= 3 or (gas and c == 0) else -1.0


@njit(**CALL)
def tell(of):
    """Put what this rank knows of the step in ``told``: the largest of all ranks is what counts."""
    room, told = of.rooms[0], of.told
    told[:] = -np.inf
    at = 0
    for n in range(len(of.layers)):
        record, k = of.records[n], of.layers[n]
        if record.present != 0:
            for c in range(sums.SEEN):
                told[at + c] = _sign(record.kind == FLUID, c) * room.seen[k, c]
            end = at + sums.SEEN
            told[end], told[end + 1] = record.lo, record.hi
            told[end + 2], told[end + 3] = record.s, record.x_interface
        at += sums.SEEN + FRAME
    for n in range(len(of.interfaces)):
        if of.noted[n]:
            for c in range(batch.NOTES):
                told[at + c] = room.notes[of.interfaces[n], c]
        at += batch.NOTES
    for flag in range(RATE):
        told[at + flag] = room.results[flag]
    told[at + RATE] = room.results[SAID_STOP]
    for c in range(told.size):
        if np.isnan(told[c]):  # the largest of numbers and what is none would depend on their order
            told[c] = np.inf


@njit(**CALL)
def hear(of):
    """Take what all ranks know from ``told``."""
    room, told, at = of.rooms[0], of.told, 0
    for n in range(len(of.layers)):
        record, k = of.records[n], of.layers[n]
        for c in range(sums.SEEN):
            room.seen[k, c] = _sign(record.kind == FLUID, c) * told[at + c]
        end = at + sums.SEEN
        record.lo, record.hi = int(told[end]), int(told[end + 1])
        record.s, record.x_interface = told[end + 2], told[end + 3]
        if record.present == 0:
            for c in range(sums.SHARES):
                room.shares[k, c] = 0.0
        at += sums.SEEN + FRAME
    for n in range(len(of.interfaces)):
        for c in range(batch.NOTES):
            room.notes[of.interfaces[n], c] = told[at + c]
        at += batch.NOTES
    for flag in range(RATE):
        room.results[flag] = told[at + flag]
    room.results[STOP] = told[at + RATE]


@njit(**CALL)
def gas_rates_of_step(of, h, k):
    """Rates of convection and diffusion, from what all ranks have seen; whether the gas is
    physical."""
    room = of.rooms[0]
    good, room.rates[k, 0], room.rates[k, 1] = sums.layer_rates(
        of.ops[0], sums.gas_speeds(of.law, room.seen[k]), h
    )
    return good


@njit(**CALL)
def solid_rates_of_step(of, h, k):
    """The same of a solid."""
    room = of.rooms[0]
    good, room.rates[k, 0], room.rates[k, 1] = sums.layer_rates(
        of.ops[0], sums.solid_speeds(of.law, room.seen[k]), h
    )
    return good


@njit(**CALL)
def finish_step(of, good):
    """The limits, and the record of the step."""
    batch.bound_step(of.ops[0], of.rooms[0], good)
    batch.note_step(of.rooms[0])


@njit(**CALL)
def goes_on(of):
    """See fsipetsc.paper.batch.goes_on."""
    return batch.goes_on(of.rooms[0], of.journal)


@njit(**CALL)
def gas_fields(gas, layers, q, out):
    """See fsipetsc.paper.sums."""
    sums.gas_fields(gas, layers[0], q, out)


@njit(**CALL)
def solid_fields(ops, solid, layers, q, out):
    """See fsipetsc.paper.sums."""
    sums.solid_fields(ops[0], solid, layers[0], q, out)
