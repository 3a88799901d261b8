"""What is done in a stage and after a step, a compiled function each; on one rank a batch of
steps calls them.

On several ranks fsipetsc.paper.state calls the same functions in the same order, with PETSc's
exchange between: both make the same numbers. The rod with its default options takes 45 us a step
in a batch and 170 us without. What the functions take is in boxes (fsipetsc.operators.boxed); a gas
that there is not is None.
"""

from collections import namedtuple

import numpy as np

from fsipetsc.operators.loops import njit
from fsipetsc.paper import coupling, ends, rates, sums
from fsipetsc.paper.rates import outer_side, own_range
from fsipetsc.paper.stencils import CALL, INNER, OLD, U, derivative
from fsipetsc.scheme.batch import DT, plan_next
from fsipetsc.scheme.plan import BAD, EXHAUSTED, RATE, SAID_STOP, STOP, TOO_SHORT

#: of the method; the number of a stage of which only the rates are wanted
STAGES, RATES_ALONE = 4, -1
#: numbers of an interface that are noted
NOTES = 8

#: a rank's part of a layer. ops, layers: records, (1,); law: Gas or Elastic; local: the points of
#: the stage with halos, of which ``owned`` is a view; y, total, k, forcing: the completed solution,
#: the sum of the stages, rates and what is added to these, (owned, unknowns)
Part = namedtuple("Part", "ops law layers local owned y total k forcing scratch")
#: an interface: record of the gas; owned points of both sides, and which of them are the rows f, s;
#: prescribed jumps; what is noted of all, (NOTES, interfaces), and its own number
Sides = namedtuple("Sides", "ops face gases q_gas q_solid at_gas at_solid f s jump notes number")
#: of all layers: records; results, batch, journal and latest: see fsipetsc.scheme.plan; sums: the
#: end of latest, from the masses of gases on
Steps = namedtuple("Steps", "records results batch journal latest sums")


# conditions


@njit(**INNER)
def move(q, at, rows, back):
    """Take rows from the points of one side of an interface, or put them back."""
    for j in range(len(at)):
        for c in range(rows.shape[1]):
            if back:
                q[at[j], c] = rows[j, c]
            else:
                rows[j, c] = q[at[j], c]


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
    move(of.q_gas, of.at_gas, of.f, False)
    move(of.q_solid, of.at_solid, of.s, False)
    couple(of)
    move(of.q_gas, of.at_gas, of.f, True)
    move(of.q_solid, of.at_solid, of.s, True)


@njit(**CALL)
def close(of):
    """Apply the conditions at the outer ends of a solid."""
    ends.close_solid(of.ops[0], of.law, of.layers[0], of.owned)


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
    op, law, layer, q = of.ops[0], of.law, of.layers[0], of.local
    if number != 0:
        ends.fill_ghost(op, law, layer, q, outer_side(layer), OLD)
    rates.gas_rates(op, law, layer, q, of.forcing, of.scratch, of.k)
    advance(of, number, dt)


@njit(**CALL)
def solid_stage(of, number, dt):
    """The same of a solid."""
    rates.elastic_rates(of.ops[0], of.law, of.layers[0], of.local, of.forcing, of.scratch, of.k)
    advance(of, number, dt)


# after a step


@njit(**CALL)
def forget(steps):
    """Forget flags, limits and integrals of the step before."""
    for flag in range(STOP):
        steps.results[flag] = 0.0
    for k in range(len(steps.sums)):
        steps.sums[k] = 0.0


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
    side = outer_side(layer)
    ends.fill_ghost(op, of.law, layer, q, side, OLD)
    if not ends.move_boundary(op, of.law, layer, q, side):
        results[EXHAUSTED] = 1.0 + layer.number
    if ends.distance(layer, side) <= layer.least - 2 + 1e-9:
        results[TOO_SHORT] = 1.0 + layer.number
    if not sums.monitor_gas(op, of.law, layer, q, steps.sums):
        results[BAD] = 1.0
    keep(of)


@njit(**CALL)
def complete_solid(of, steps):
    """Monitor the points."""
    if not sums.monitor_solid(of.ops[0], of.law, of.layers[0], of.local, steps.sums):
        steps.results[BAD] = 1.0
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
    s, notes, k = of.s, of.notes, of.number
    notes[0, k], notes[1, k], notes[2, k], notes[3, k] = s[0, 3], s[0, 0], s[0, 1], s[0, 2]
    found = coupling.residuals(of.ops[0], of.face, of.jump, of.f, s)
    notes[4, k], notes[5, k], notes[6, k], notes[7, k] = found


@njit(**CALL)
def finish(steps):
    """The bound on the next step, from the rates of all ranks.

    1/dt at Courant number 1 is the 4-norm of the largest rates of convection and diffusion: the
    smaller of the two steps alone is too long.
    """
    results, records = steps.results, steps.records
    convection, diffusion = 0.0, 0.0
    for k in range(len(records)):
        convection = max(convection, records[k].rates[0])
        diffusion = max(diffusion, records[k].rates[1])
    results[RATE] = np.sqrt(np.sqrt(convection**4 + diffusion**4))
    results[STOP] = results[SAID_STOP]


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
        forget(steps)
        complete_gas(left, steps)
        complete_solid(solid, steps)
        complete_gas(right, steps)
        note(faces[0])
        note(faces[1])
        finish(steps)
        more = plan_next(steps.batch, steps.results, steps.journal, steps.latest)
        dt = steps.batch[DT]
