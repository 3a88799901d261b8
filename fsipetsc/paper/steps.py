"""What is done in a stage and after a step: procedures, of which a step is a list.

Where there are several ranks, exchanges stand between them in the list (fsipetsc.paper.parts). C
makes all calls of a batch of steps. Procedures of layers take a Part, and those after a step Steps,
too; those of interfaces take Sides.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.kernels.loops import each, number, variable, when, whole
from fsipetsc.kernels.procedure import Code, Procedure
from fsipetsc.paper import coupling, embedded, outer_ends, rates, sums
from fsipetsc.paper.layout import DOF
from fsipetsc.paper.stencils import Stencils, derivative
from fsipetsc.scheme.batch import DT
from fsipetsc.scheme.columns import larger
from fsipetsc.scheme.plan import RATE, SAID_STOP, STOP, TOO_SHORT
from fsipetsc.scheme.rows import Array

#: of the method; the number of a stage of which only the rates are wanted
STAGES, RATES_ALONE = 4, -1
#: numbers of an interface that are noted
NOTES = 8
#: numbers of a layer that ranks tell each other after a step
TOLD = 6


class Part(NamedTuple):
    """A rank's part of a layer. op, ends: facts; law: Gas or Elastic; layers: the record, (1,).

    local: the points of the stage with halos, (points, unknowns), of which ``owned`` is a view; y,
    total, k, forcing: the completed solution, the sum of the stages, rates and what is added to
    these, if anything, (owned, unknowns). batch: fsipetsc.scheme.batch.
    """

    op: Stencils
    ends: outer_ends.Ends
    law: Any
    layers: Array
    local: Array
    owned: Array
    y: Array
    total: Array
    k: Array
    forcing: Array | None
    scratch: Array
    batch: Array


class Sides(NamedTuple):
    """An interface. gases: the record of the gas, (1,); q_gas, q_solid: owned points of both sides;
    at_gas, at_solid: which of them are the rows f, s; jump: what is prescribed; notes: what is
    noted of all, (NOTES, interfaces), of this one in the column ``number``.
    """

    op: Stencils
    face: coupling.Face
    gases: Array
    q_gas: Array
    q_solid: Array
    at_gas: Array
    at_solid: Array
    f: Array
    s: Array
    jump: Array
    notes: Array
    number: int


class Steps(NamedTuple):
    """Of all layers: records; results: see fsipetsc.scheme.plan; notes: what is noted of
    interfaces, sums: of a step after this, from the masses of gases on. told: room for what ranks
    tell each other, TOLD numbers of each layer, notes, results.
    """

    records: Array
    results: Array
    notes: Array
    sums: Array
    told: Array


# conditions


def take(of):
    """Take the rows of both sides of an interface from their points."""
    for j in range(of.op.n):
        for c in range(DOF["fluid"]):
            of.f[j, c] = of.q_gas[of.at_gas[j], c]
        for c in range(DOF["solid"]):
            of.s[j, c] = of.q_solid[of.at_solid[j], c]


def put(of):
    """Put the rows of both sides of an interface back."""
    for j in range(of.op.n):
        for c in range(DOF["fluid"]):
            of.q_gas[of.at_gas[j], c] = of.f[j, c]
        for c in range(DOF["solid"]):
            of.q_solid[of.at_solid[j], c] = of.s[j, c]


def couple(of):
    """Couple the rows of both sides; the frame of the gas follows."""
    gas, f, s = of.gases[0], of.f, of.s
    coupling.couple(of.op, of.face, of.jump, f, s)
    gas.s, gas.x_interface = f[0, 1] / f[0, 0], s[0, 3]


def note(of):
    """Note x, u, sigma, T and the residuals of the four conditions of an interface."""
    s, notes, k = of.s, of.notes, of.number
    found = coupling.residuals(of.op, of.face, of.jump, of.f, s)
    for row, value in enumerate((s[0, 3], s[0, 0], s[0, 1], s[0, 2], *found)):
        notes[row, k] = value


# stages


def fill(of):
    """Fill the ghost point of a gas."""
    outer_ends.fill_ghost(of, outer_ends.outer_side(of.ends))


def advance(stage: int) -> Callable[[Part], None]:
    """What makes the next stage, and the sum that becomes the solution, of the rates k of a stage
    of the classical method.
    """

    def advance_stage(of):
        """Make the next stage and the sum of stages."""
        y, k, q, total = (v.reshape(-1) for v in (of.y, of.k, of.owned, of.total))
        dt = of.batch[DT]
        a, b = dt if stage == 2 else 0.5 * dt, dt / (3.0 if 0 < stage < 3 else 6.0)
        for i in each(y.size, vector=True):
            found = (y[i] if stage == 0 else total[i]) + b * k[i]
            if stage == 3:
                q[i] = found
            else:
                total[i], q[i] = found, y[i] + a * k[i]

    return advance_stage


# after a step


def forget(steps):
    """Forget flags, limits and integrals of the step before; notes are those of the owners."""
    steps.results[:STOP] = 0.0
    steps.notes[:] = -np.inf
    steps.sums[:] = 0.0


def keep(of):
    """Let the stage be the solution."""
    y, stage = of.y.reshape(-1), of.owned.reshape(-1)
    for i in each(y.size, vector=True):
        y[i] = stage[i]


def complete_gas(of, steps):
    """Fill the ghost point, let the boundary move over the grid, monitor the points."""
    layer, side = of.layers[0], outer_ends.outer_side(of.ends)
    outer_ends.fill_ghost(of, side)
    outer_ends.move_boundary(of, side, steps.results)
    with when(embedded.distance(layer, side) <= number(layer.least - 2) + 1e-9):
        steps.results[TOO_SHORT] = 1.0 + number(layer.number)
    sums.monitor_gas(of, steps)
    keep(of)


def complete_solid(of, steps):
    """Monitor the points."""
    sums.monitor_solid(of, steps)
    keep(of)


def stretch(of):
    """scratch[1] = h x_X of a solid, at the active ones of this rank's points with halos."""
    a, b, A, B = rates.own_range(of.layers[0])
    q, x = of.local, of.scratch[0]
    for i in each(q.shape[0], vector=True):
        x[i] = q[i, 3]
    derivative(of.op, of.scratch, 0, 1, 1, a, b, A, B, 1.0)


def of_layers(record):
    """What ranks that own points of a layer tell the others: TOLD numbers."""
    frame = number(record.lo), number(record.hi), record.s, record.x_interface
    return record.rates[0], record.rates[1], *frame


def tell(steps):
    """Fill what this rank tells the others. The largest number counts, so what is none is inf: the
    largest of numbers and of what is none would depend on their order.
    """
    records, told = steps.records, steps.told
    layers = records.shape[0]
    for k in each(layers):
        for c, value in enumerate(of_layers(records[k])):
            told[TOLD * k + c] = np.where(records[k].present == 1, value, -np.inf)
    after = told[TOLD * layers :]
    for array, first in ((steps.notes, 0), (steps.results, steps.notes.size)):
        for i in each(array.size):
            after[first + i] = array[i]
    for i in each(told.size):
        told[i] = np.where(told[i] == told[i], told[i], np.inf)


def hear(steps):
    """Take what all ranks have told."""
    records, told = steps.records, steps.told
    layers = records.shape[0]
    for k in each(layers):
        record, of_layer = records[k], told[TOLD * k :]
        record.rates[0], record.rates[1] = of_layer[0], of_layer[1]
        record.lo, record.hi = whole(of_layer[2]), whole(of_layer[3])
        record.s, record.x_interface = of_layer[4], of_layer[5]
    after = told[TOLD * layers :]
    for array, first in ((steps.notes, 0), (steps.results, steps.notes.size)):
        for i in each(array.size):
            array[i] = after[first + i]


def finish(steps):
    """Find the bound on the next step, from the rates of all ranks.

    1/dt at Courant number 1 is the 4-norm of the largest rates of convection and diffusion: the
    smaller of the two steps alone is too long.
    """
    results, records = steps.results, steps.records
    convection, diffusion = variable(), variable()
    for k in each(records.shape[0]):
        larger(convection, records[k].rates[0])
        larger(diffusion, records[k].rates[1])
    results[RATE] = np.sqrt(np.sqrt(convection.value**4 + diffusion.value**4))
    results[STOP] = results[SAID_STOP]


# all of them


def of_layer(code: Code, place: str, of: Part, steps: Steps) -> dict[str, Procedure]:
    """Record those of a layer that stands at a place: left, solid or right."""
    gas = place != "solid"
    functions = {
        **({"fill": fill} if gas else {"close": outer_ends.close_solid, "stretch": stretch}),
        "rates": rates.gas_rates if gas else rates.elastic_rates,
        **{f"advance_{stage}": advance(stage) for stage in range(STAGES)},
    }
    found = {name: code.procedure(f"{name}_{place}", f, of) for name, f in functions.items()}
    complete = complete_gas if gas else complete_solid
    return {**found, "complete": code.procedure(f"complete_{place}", complete, of, steps)}


def of_interface(code: Code, place: str, of: Sides) -> dict[str, Procedure]:
    """Record those of the interface of the gas at a place."""
    functions = {"take": take, "couple": couple, "put": put, "note": note}
    return {name: code.procedure(f"{name}_{place}", f, of) for name, f in functions.items()}


def of_step(code: Code, steps: Steps) -> dict[str, Procedure]:
    """Record the procedures of a step."""
    functions = forget, tell, hear, finish
    return {f.__name__: code.procedure(f.__name__, f, steps) for f in functions}
