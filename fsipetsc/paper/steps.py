"""What is done in a stage and after a step: procedures, of which a step is a list.

C makes all calls of a batch of steps, and exchanges between ranks among them
(fsipetsc.parallel.exchange). Procedures of layers take a Part, and those after a step Steps, too;
those of interfaces are in fsipetsc.paper.coupling.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.boundaries import Boundary
from fsipetsc.kernels.arrays import Array
from fsipetsc.kernels.loops import each, named, number, variable, when
from fsipetsc.kernels.procedure import Code, Procedure
from fsipetsc.paper import ends, rates
from fsipetsc.paper.stencils import Stencils, derivative
from fsipetsc.scheme.monitor import larger
from fsipetsc.scheme.plan import DT, RATE, SAID_STOP, STOP, TOO_SHORT
from fsipetsc.scheme.runge_kutta import STAGES, factors

#: numbers of an interface that are noted
NOTES = 8


class Part(NamedTuple):
    """A rank's part of a layer. op: facts; ends: what stands at the left and right end, None at an
    interface; law: Gas or Elastic; layers: the record, (1,).

    local: the points of the stage with halos, (unknowns, points); y, total, k, forcing: the
    completed solution, the sum of the stages, rates and what is added to these, if anything,
    (unknowns, owned points). rates: see fsipetsc.paper.rates. batch: fsipetsc.scheme.plan.
    """

    op: Stencils
    ends: tuple[Boundary | None, ...]
    law: Any
    layers: Array
    local: Array
    y: Array
    total: Array
    k: Array
    forcing: Array | None
    scratch: Array
    rates: Array
    batch: Array


class Steps(NamedTuple):
    """told: what ranks tell each other of a step: results (fsipetsc.scheme.plan), the rates of all
    layers, notes of interfaces. sums: what is noted after that, from the masses of gases on.
    """

    told: Array
    results: Array
    rates: Array
    notes: Array
    sums: Array


# stages


def fill(of):
    """Fill the ghost point of a gas."""
    ends.fill_ghost(of)


def advance(stage: int) -> Callable[[Part], None]:
    """What makes the next stage, and the sum that becomes the solution, of the rates k of a stage
    of the classical method.
    """

    def advance_stage(of):
        """Make the next stage and the sum of stages."""
        a, b = factors(stage, of.batch[DT])
        before = named(of.layers[0].halo_lo)
        for c in each(of.y.shape[0]):
            y, k, total, q = of.y[c], of.k[c], of.total[c], of.local[c]
            for i in each(of.y.shape[1], vector=True):
                found = (y[i] if stage == 0 else total[i]) + b * k[i]
                if stage == 3:
                    q[before + i] = found
                else:
                    total[i], q[before + i] = found, y[i] + a * k[i]

    return advance_stage


# after a step


def forget(steps):
    """Forget what is known of the step before; notes and rates are those of the owners."""
    steps.results[:STOP] = 0.0
    steps.rates[:] = -np.inf
    steps.notes[:] = -np.inf
    steps.sums[:] = 0.0


def keep(of):
    """Let the stage be the solution."""
    before = named(of.layers[0].halo_lo)
    for c in each(of.y.shape[0]):
        y, q = of.y[c], of.local[c]
        for i in each(of.y.shape[1], vector=True):
            y[i] = q[before + i]


def complete_gas(of, steps):
    """Fill the ghost point, let the boundary move over the grid, monitor the points."""
    layer, side = of.layers[0], ends.outer_side(of.ends)
    ends.fill_ghost(of)
    ends.move_boundary(of, steps.results)
    with when(ends.distance(layer, side) <= number(layer.least - 2) + 1e-9):
        steps.results[TOO_SHORT] = 1.0 + number(layer.number)
    rates.monitor_gas(of, steps)
    keep(of)


def complete_solid(of, steps):
    """Monitor the points."""
    rates.monitor_solid(of, steps)
    keep(of)


def stretch(of):
    """scratch[0] = h x_X of a solid, at the active ones of this rank's points with halos."""
    a, b, A, B = rates.own_range(of.layers[0])
    derivative(of.op, of.local, 3, of.scratch, 0, 1, a, b, A, B, 1.0)


def tell(steps):
    """Let what is no number be inf: the largest of numbers and of what is none would depend on
    their order.
    """
    told = steps.told
    for i in each(told.size):
        told[i] = np.where(told[i] == told[i], told[i], np.inf)


def finish(steps):
    """Find the bound on the next step, from the rates of all ranks.

    1/dt at Courant number 1 is the 4-norm of the largest rates of convection and diffusion: the
    smaller of the two steps alone is too long.
    """
    results, rates = steps.results, steps.rates
    convection, diffusion = variable(), variable()
    for k in each(rates.size // 2):
        larger(convection, rates[2 * k])
        larger(diffusion, rates[2 * k + 1])
    results[RATE] = np.sqrt(np.sqrt(convection.value**4 + diffusion.value**4))
    results[STOP] = results[SAID_STOP]


# all of them


def of_layer(code: Code, place: str, of: Part, steps: Steps) -> dict[str, Procedure]:
    """Record those of a layer that stands at a place: left, solid or right."""
    gas = place != "solid"
    functions = {
        **({"fill": fill} if gas else {"close": ends.close_solid, "stretch": stretch}),
        "rates": rates.gas_rates if gas else rates.elastic_rates,
        **{f"advance_{stage}": advance(stage) for stage in range(STAGES)},
    }
    found = {name: code.procedure(f"{name}_{place}", f, of) for name, f in functions.items()}
    complete = complete_gas if gas else complete_solid
    return {**found, "complete": code.procedure(f"complete_{place}", complete, of, steps)}
