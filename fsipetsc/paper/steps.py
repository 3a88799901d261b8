"""What is done in a stage and after a step, a compiled function each; on one rank a batch of
steps calls them.

On several ranks fsipetsc.paper.state calls the same functions in the same order, with PETSc's
exchange between: both make the same numbers. The rod with its default options takes 45 us a step
in a batch and 170 us without. What the functions take is in boxes (fsipetsc.operators.boxed); a gas
that there is not is None.
"""

from collections import namedtuple

import numpy as np
from numba import njit

from fsipetsc.paper import coupling, ends, rates, sums
from fsipetsc.paper.rates import outer_side, own_range
from fsipetsc.paper.stencils import CALL, INNER, OLD, U, derivative
from fsipetsc.scheme.batch import DT, plan_next
from fsipetsc.scheme.plan import BAD, EXHAUSTED, RATE, SAID_STOP, STOP, TOO_SHORT

#: of the method; the number of a stage of which only the rates are wanted
STAGES, RATES_ALONE = 4, -1
#: numbers of an interface that are noted
NOTES = 8
#: sides of an interface
GAS, SOLID = 0, 1


#: a rank's part of a layer. ops, layers: records, (1,); law: Gas or Elastic; local: the points of
#: the stage with halos, of which ``owned`` is a view; y, total, k: the completed solution, the sum
#: of the stages and rates, (owned, unknowns); forcing: the same or (0, unknowns)
Part = namedtuple("Part", "ops law layers local owned y total k forcing scratch")
#: an interface: records and owned points of both sides; prescribed jumps; rows f, s of gas and
#: solid; what is noted of it
Sides = namedtuple("Sides", "ops face gases solids q_gas q_solid jump f s notes")
#: of all layers: records; notes, (interfaces, NOTES); results, batch, journal and latest: see
#: fsipetsc.scheme.plan
Steps = namedtuple("Steps", "records notes results batch journal latest")


# conditions


@njit(**INNER)
def side_of(of, side):
    """(owned points, number of the one at the interface, step into the layer, rows) of a side."""
    gas, solid, right = of.gases[0], of.solids[0], of.face.n > 0.0
    if side == GAS:
        return of.q_gas, (gas.lo if right else gas.hi) - gas.own_lo, 1 if right else -1, of.f
    return of.q_solid, (solid.hi if right else solid.lo) - solid.own_lo, -1 if right else 1, of.s


@njit(**CALL)
def move_side(of, side, back):
    """Take the rows of one side of an interface, which this rank owns, as far as D reaches; or put
    them back."""
    q, end, step, rows = side_of(of, side)
    for j in range(of.ops[0].n):
        for c in range(rows.shape[1]):
            if back:
                q[end + step * j, c] = rows[j, c]
            else:
                rows[j, c] = q[end + step * j, c]


@njit(**CALL)
def couple(of):
    """Couple the rows of both sides; the frame of the gas follows."""
    gas, f, s = of.gases[0], of.f, of.s
    coupling.couple(of.ops[0], of.face, of.jump, f, s)
    gas.s, gas.x_interface = f[0, 1] / f[0, 0], s[0, 3]


@njit(**CALL)
def couple_here(of):
    """Couple both sides, which this rank owns."""
    if of is None:
        return
    for side in (GAS, SOLID):
        move_side(of, side, False)
    couple(of)
    for side in (GAS, SOLID):
        move_side(of, side, True)


@njit(**CALL)
def close(of):
    """Apply the conditions at the outer ends of a solid."""
    ends.close_solid(of.ops[0], of.law, of.layers[0], of.owned)


@njit(**CALL)
def fill(of):
    """Fill the ghost point of a gas, where this rank has it."""
    if of is None:
        return
    layer = of.layers[0]
    ends.fill_ghost(of.ops[0], of.law, layer, of.local, outer_side(layer), OLD)


# stages


@njit(**INNER)
def advance(of, number, dt):
    """What a stage of the classical method does with its rates k: the next stage, and the sum that
    becomes the solution."""
    if number == RATES_ALONE:
        return
    y, k, stage, total = of.y.ravel(), of.k.ravel(), of.owned.ravel(), of.total.ravel()
    a = dt if number == 2 else 0.5 * dt
    b = dt / 3.0 if 0 < number < 3 else dt / 6.0
    for i in range(y.size):
        j = U(i)
        if number == 3:
            stage[j] = total[j] + b * k[j]
        else:
            total[j] = (y[j] if number == 0 else total[j]) + b * k[j]
            stage[j] = y[j] + a * k[j]


@njit(**CALL)
def gas_stage(of, number, dt):
    """A stage, which fulfils the conditions, but for the ghost point: that of the first one, which
    is the completed solution, is filled."""
    if of is None:
        return
    if number != 0:
        fill(of)
    rates.gas_rates(of.ops[0], of.law, of.layers[0], of.local, of.forcing, of.scratch, of.k)
    advance(of, number, dt)


@njit(**CALL)
def solid_stage(of, number, dt):
    """The same of a solid."""
    rates.elastic_rates(of.ops[0], of.law, of.layers[0], of.local, of.forcing, of.scratch, of.k)
    advance(of, number, dt)


# after a step


@njit(**INNER)
def keep(of):
    """The stage is the solution."""
    y, stage = of.y.ravel(), of.owned.ravel()
    for i in range(y.size):
        y[U(i)] = stage[U(i)]


@njit(**CALL)
def complete_gas(of, steps):
    """Fill the ghost point, let the boundary move over the grid, monitor the points."""
    if of is None:
        return
    op, layer, q, results = of.ops[0], of.layers[0], of.local, steps.results
    fill(of)
    side = outer_side(layer)
    if not ends.move_boundary(op, of.law, layer, q, side):
        results[EXHAUSTED] = 1.0 + layer.number
    if ends.distance(layer, side) <= layer.least - 2 + 1e-9:
        results[TOO_SHORT] = 1.0 + layer.number
    sums.monitor_gas(op, of.law, layer, q)
    keep(of)


@njit(**CALL)
def complete_solid(of, steps):
    """Monitor the points."""
    sums.monitor_solid(of.ops[0], of.law, of.layers[0], of.local)
    keep(of)


@njit(**CALL)
def stretch(of, out):
    """out = h x_X of a solid, at the active ones of this rank's points with halos."""
    a, b, A, B = own_range(of.layers[0])
    x = of.scratch[0]
    for i in range(len(of.local)):
        x[i] = of.local[i, 3]
    derivative(of.ops[0], x, out, a, b, A, B, 1.0)


@njit(**CALL)
def note(of):
    """x, u, sigma, T and the residuals of the four conditions of an interface."""
    if of is None:
        return
    s, notes = of.s, of.notes
    notes[0], notes[1], notes[2], notes[3] = s[0, 3], s[0, 0], s[0, 1], s[0, 2]
    coupling.residuals(of.ops[0], of.face, of.jump, of.f, s, notes[4:])


@njit(**CALL)
def finish(left, solid, right, steps):
    """The bound on the next step, from what all ranks have seen, and the record of this one.

    1/dt at Courant number 1 is the 4-norm of the largest rates of convection and diffusion: the
    smaller of the two steps alone is too long.
    """
    results, records, latest = steps.results, steps.records, steps.latest
    good = sums.bound_of_solid(solid.ops[0], solid.law, solid.layers[0])
    if left is not None:
        good = sums.bound_of_gas(left.ops[0], left.law, left.layers[0]) and good
    if right is not None:
        good = sums.bound_of_gas(right.ops[0], right.law, right.layers[0]) and good
    convection, diffusion = 0.0, 0.0
    for k in range(len(records)):
        convection = max(convection, records[k].rates[0])
        diffusion = max(diffusion, records[k].rates[1])
    results[RATE] = np.sqrt(np.sqrt(convection**4 + diffusion**4))
    results[BAD] = 0.0 if good else 1.0
    results[STOP] = results[SAID_STOP]
    at = 0
    for c in range(NOTES):
        for face in range(len(steps.notes)):
            latest[at] = steps.notes[face, c]
            at += 1
    for k in range(len(records)):
        if records[k].fluid:
            latest[at] = records[k].shares[0]
            at += 1
    for c in range(1, sums.SHARES):
        latest[at] = 0.0
        for k in range(len(records)):
            latest[at] += records[k].shares[c]
        at += 1


@njit(**CALL)
def batch(left, solid, right, faces, steps, dt):
    """A step dt from the completed solution, and the others of its batch."""
    more = True
    while more:
        for number in range(STAGES):
            if number > 0:
                couple_here(faces[0])
                couple_here(faces[1])
                close(solid)
            gas_stage(left, number, dt)
            solid_stage(solid, number, dt)
            gas_stage(right, number, dt)
        couple_here(faces[0])
        couple_here(faces[1])
        close(solid)
        for flag in range(RATE):
            steps.results[flag] = 0.0
        complete_gas(left, steps)
        complete_solid(solid, steps)
        complete_gas(right, steps)
        note(faces[0])
        note(faces[1])
        finish(left, solid, right, steps)
        more = plan_next(steps.batch, steps.results, steps.journal, steps.latest)
        dt = steps.batch[DT]
