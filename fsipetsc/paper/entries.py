"""What Python calls of the compiled method, where PETSc's exchange stands between: one call where
several things can be done.

Records are handed over as arrays of length one, which takes numba a third of the time.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.paper import batch, sums
from fsipetsc.paper.coupling import couple, put_rows, take_rows
from fsipetsc.paper.ends import close_solid, fill_ghost
from fsipetsc.paper.rates import elastic_rates, gas_rates
from fsipetsc.paper.stencils import CALL, OLD

#: sides of an interface
GAS, SOLID = 0, 1


@njit(**CALL)
def take_side(ops, face, gases, solids, side, q, rows):
    """The rows of one side of an interface, of its owner."""
    points = batch.interface_points(face, gases[0], solids[0])
    if side == GAS:
        take_rows(ops[0], q, points[0], points[1], rows)
    else:
        take_rows(ops[0], q, points[2], points[3], rows)


@njit(**CALL)
def couple_side(ops, face, jump, gases, solids, side, q, f, s):
    """Couple both sides, put back the rows of one, and let the frame follow."""
    points, gas = batch.interface_points(face, gases[0], solids[0]), gases[0]
    couple(ops[0], face, jump, f, s)
    if side == GAS:
        put_rows(ops[0], q, points[0], points[1], f)
    else:
        put_rows(ops[0], q, points[2], points[3], s)
    gas.s, gas.x_interface = f[0, 1] / f[0, 0], s[0, 3]


@njit(**CALL)
def join(ops, face, jump, gases, q_gas, solids, q_solid, f, s):
    """See fsipetsc.paper.batch.join."""
    batch.join(ops[0], face, jump, gases[0], q_gas, solids[0], q_solid, f, s)


@njit(**CALL)
def close_end(ops, solid, layers, q):
    """See fsipetsc.paper.ends.close_solid."""
    close_solid(ops[0], solid, layers[0], q)


@njit(**CALL)
def fill(ops, gas, layers, q, side):
    """See fsipetsc.paper.ends.fill_ghost."""
    fill_ghost(ops[0], gas, layers[0], q, side, OLD)


@njit(**CALL)
def evaluate_gas(ops, gas, layers, q, side, forcing, w, out):
    """The rates of a gas, with its ghost point filled first, but for side < 0."""
    if side >= 0:
        fill_ghost(ops[0], gas, layers[0], q, side, OLD)
    gas_rates(ops[0], gas, layers[0], q, forcing, w, out)


@njit(**CALL)
def evaluate_solid(ops, solid, layers, q, forcing, w, out):
    """The rates of a solid."""
    elastic_rates(ops[0], solid, layers[0], q, forcing, w, out)


@njit(**CALL)
def look_at_gas(ops, gas, layers, q, w, side, number, entropy, rooms):
    """After a step: fill the ghost point, let the boundary move, look at the points."""
    room, k = rooms[0], 2 * side
    fill_ghost(ops[0], gas, layers[0], q, side, OLD)
    batch.boundary_moves(ops[0], gas, layers[0], q, side, number, room.results)
    sums.look_at_gas(ops[0], gas, layers[0], q, w, entropy, room.seen[k], room.shares[k])


@njit(**CALL)
def look_at_solid(ops, solid, layers, q, w, entropy, rooms):
    """After a step: look at the points."""
    sums.look_at_solid(
        ops[0], solid, layers[0], q, w, entropy, rooms[0].seen[1], rooms[0].shares[1]
    )


@njit(**CALL)
def note_interface(ops, face, k, rooms):
    """See fsipetsc.paper.batch.note_interface."""
    room = rooms[0]
    batch.note_interface(ops[0], face, room.jumps[k], room.f[k], room.s[k], room.notes[k])


@njit(**CALL)
def gas_rates_of_step(ops, gas, h, k, rooms):
    """Rates of convection and diffusion, from what all ranks have seen; whether the gas is
    physical."""
    room = rooms[0]
    good, room.rates[k, 0], room.rates[k, 1] = sums.layer_rates(
        ops[0], sums.gas_speeds(gas, room.seen[k]), h
    )
    return good


@njit(**CALL)
def solid_rates_of_step(ops, solid, h, k, rooms):
    """The same of a solid."""
    room = rooms[0]
    good, room.rates[k, 0], room.rates[k, 1] = sums.layer_rates(
        ops[0], sums.solid_speeds(solid, room.seen[k]), h
    )
    return good


@njit(**CALL)
def finish_step(ops, rooms, good):
    """The limits, and the record of the step."""
    batch.bound_step(ops[0], rooms[0], good)
    batch.note_step(rooms[0])


@njit(**CALL)
def goes_on(rooms, journal):
    """See fsipetsc.paper.batch.goes_on."""
    return batch.goes_on(rooms[0], journal)


@njit(**CALL)
def gas_fields(gas, layers, q, out):
    """See fsipetsc.paper.sums."""
    sums.gas_fields(gas, layers[0], q, out)


@njit(**CALL)
def solid_fields(ops, solid, layers, q, out):
    """See fsipetsc.paper.sums."""
    sums.solid_fields(ops[0], solid, layers[0], q, out)
