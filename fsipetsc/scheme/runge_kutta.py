"""The classical Runge-Kutta method of fourth order, fused with the right-hand side. Compiled.

A stage reads one work area and writes the next stage's values straight into another; the sum that becomes the new
solution is built up beside it. It is the method of PETSc's ``-ts_type rk -ts_rk_type 4``, up to round-off;
stepping.petsc_path is the right-hand side for that one, and the plain form of what is done here.

On large grids a whole step goes over memory once. What the interfaces, outer ends and neighbouring ranks can reach within
a step is a few points at each end of a layer: there the stages are made one after the other, with the exchanges between
them, each on fewer points than the one before. The *middle* of the layer then needs nobody else. It is cut into tiles
that stay in cache while all four stages pass over them, each a stencil's reach behind the one before (time skewing):

    stage 3  E E|M . . .|. . . . .        E  ends     M  middle, tile by tile from the left
    stage 2  E E E|M . . .|. . . .        The values that a stage of the middle takes from the ends' side are still
    stage 1  E E E E|M . . .|. . .        there, because the ends stop short of them two stages later.
    stage 0  E E E E E|M . . .|. .

What can be asked for are the functions of a plan at the end of this file. Behind them is one compiled entry, ``run_task``,
because all that an entry calls would be compiled for every entry anew; for the same reason each large function has one
place there.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from fsipetsc.operators.formulas import with_chosen
from fsipetsc.operators.kernels import ENTRY, OPTIONS, U64
from fsipetsc.parallel.exchange import exchange, load_state, work_point
from fsipetsc.scheme.burst import DT, goes_on
from fsipetsc.scheme.conditions import apply_conditions, note_gradients
from fsipetsc.scheme.finish_step import begin_looking, finish_step, look
from fsipetsc.scheme.laws import LAWS, of_layer
from fsipetsc.scheme.plan import FORCING, STAGES, SUM, WORK, Plan
from fsipetsc.scheme.stage_update import Target

#: points of a tile
TILE = 1024
#: what the compiled entry can be asked for: see the functions of these names
NOTHING, MAKE_STEPS, MAKE_STAGE, COMPLETE_STEP, LOAD_COMPLETED = range(5)


class Stage(NamedTuple):
    """Of the rates k in an area: next = source + a k, SUM = base + b k; areas, and SUM is left alone if base < 0."""

    area: int
    next: int
    source: int
    base: int
    a: float
    b: float


@njit(**OPTIONS)
def work_area(number):
    """Where stage ``number`` finds its values: the last one is the completed step in the place of the first."""
    return WORK + (number if number < 3 else STAGES - number)


@njit(**OPTIONS)
def stage_of(number, dt):
    """The stages of the classical method."""
    area, onward = work_area(number), work_area(number + 1)
    if number == STAGES - 1:
        return Stage(area, onward, SUM, -1, dt / 6.0, 0.0)
    a = dt if number == 2 else 0.5 * dt
    return Stage(area, onward, WORK, WORK if number == 0 else SUM, a, dt / 6.0 if number == 0 else dt / 3.0)


@njit(**OPTIONS)
def evaluate(head, layer, memory, stage, begin, end):
    """One stage at the points begin .. end-1 of a layer, whose work area fulfils the conditions around them."""
    target = Target(
        work_point(head, layer, stage.source, 0),
        work_point(head, layer, stage.next, 0),
        work_point(head, layer, max(stage.base, 0), 0),
        work_point(head, layer, SUM, 0) if stage.base >= 0 else -1,
        work_point(head, layer, FORCING, 0) if head.area[FORCING] >= 0 else -1,
        layer.stride,
        stage.a,
        stage.b,
        layer.J,
    )
    w = work_point(head, layer, stage.area, 0)
    with_chosen(of_layer.sweep, LAWS, layer.law, layer, head.op, memory, w, head.scratch, target, begin, end)


@njit(**OPTIONS)
def find_middles(head, layers, wanted):
    """Note which points tiles complete: their range in the last stage. In a stage before, ends reach 2 p points further."""
    for layer in layers:
        a, b = max(layer.own_lo, layer.lo), min(layer.own_hi, layer.hi + 1)
        layer.middle[0], layer.middle[1] = a + head.edge, b - head.edge
        if not wanted or layer.present == 0 or b - a < head.least:
            layer.middle[0] = layer.middle[1] = a


@njit(**OPTIONS)
def ends(head, layers, memory, stage, number):
    """One stage of all layers, but for what the tiles do of it."""
    given = 2 * head.op.p * (STAGES - 1 - number)
    for layer in layers:
        if layer.present == 0:
            continue
        a, b = layer.middle
        if a < b:
            evaluate(head, layer, memory, stage, layer.own_lo, a + given)
            evaluate(head, layer, memory, stage, b - given, layer.own_hi)
        else:
            evaluate(head, layer, memory, stage, layer.own_lo, layer.own_hi)


@njit(**OPTIONS)
def set_frame(layer, number):
    """Let the grid of a layer be what it was in stage ``number``."""
    layer.s, layer.spread = layer.stage_frame[number, 0], layer.stage_frame[number, 1]
    layer.J = layer.stage_frame[number, 2]


@njit(**OPTIONS)
def tiles(head, layers, memory, dt):
    """All stages of the middles, and the look at the new solution there."""
    reach = 2 * head.op.p
    for k in range(layers.size):
        layer = layers[k]
        a, b = layer.middle
        skew = reach * (STAGES - 1)
        for begin in range(a, b, TILE):
            last = begin + TILE >= b
            for number in range(STAGES):
                ahead = skew - reach * number
                end = b - ahead if last else min(begin + TILE + ahead, b - ahead)
                set_frame(layer, number)
                evaluate(head, layer, memory, stage_of(number, dt), min(begin + ahead, b - ahead), end)
            set_frame(layer, STAGES)
            look(head, layer, k, memory, begin, min(begin + TILE, b))


@njit(**OPTIONS)
def begin_stage(head, layers, faces, memory, number, conditions):
    """Apply the conditions, if wanted, where stage ``number`` finds its values, and note for the tiles how fast frames are."""
    if conditions:
        apply_conditions(head, layers, faces, memory, work_area(number))
    for layer in layers:
        layer.stage_frame[number, 0], layer.stage_frame[number, 1] = layer.s, layer.spread
        layer.stage_frame[number, 2] = layer.J


@njit(**OPTIONS)
def stage_at_ends(head, layers, faces, memory, number, conditions, dt):
    """A stage up to the values of the next one, but for what the tiles do of it: all of it where there are none."""
    begin_stage(head, layers, faces, memory, number, conditions)
    ends(head, layers, memory, stage_of(number, dt), number)


@njit(**OPTIONS)
def tiles_and_completion(head, layers, faces, memory, dt):
    """The stages of the middles, if there are any, and what follows on a step."""
    begin_stage(head, layers, faces, memory, STAGES, True)
    begin_looking(head, layers, memory)
    tiles(head, layers, memory, dt)
    finish_step(head, layers, faces, memory)


@njit(**OPTIONS)
def stages_of(task, number):
    """(first stage, stage behind the last one, whether the completion of the step follows) of a task."""
    if task == MAKE_STEPS:
        return 0, STAGES, True
    if task == MAKE_STAGE:
        return number, min(number + 1, STAGES), number == STAGES
    return 0, 0, task == COMPLETE_STEP


@njit(**ENTRY)
def run_task(task, heads, layers, faces, memory, number, state, dt):
    """One of the tasks. Collective on all ranks.

    number: of the stage that is to be made. state: where in the memory a state of somebody else's begins, or -1 to go on
    from the work area. Stage 0 of a step finds the conditions fulfilled, by the completion of the step before.
    """
    head = heads[0]
    if state >= 0:
        load_state(head, layers, memory, WORK, state)
    if task == LOAD_COMPLETED:
        exchange(head, layers, faces, memory, WORK)
        note_gradients(head, layers, memory, WORK)
    first, end, completes = stages_of(task, number)
    more = first < end or completes
    while more:
        find_middles(head, layers, task == MAKE_STEPS)
        for k in range(first, end):
            stage_at_ends(head, layers, faces, memory, k, k > 0, dt)
        if completes:
            tiles_and_completion(head, layers, faces, memory, dt)
        more = task == MAKE_STEPS and goes_on(head, memory)
        dt = memory[U64(head.burst + DT)] if more else dt


# What can be asked for; all are collective on the ranks of the plan. state: name of the part of its memory with a state of
# the layers as PETSc has it.


def make_steps(plan: Plan, dt: float) -> None:
    """A step dt [s] from the completed one in the work area, its completion, and further steps as the burst allows."""
    plan.compiled(run_task)(MAKE_STEPS, *plan, 0, -1, dt)


def make_stage(plan: Plan, number: int, dt: float) -> None:
    """Stage ``number`` of a step dt [s]; number ``STAGES``: its completion. Between them data may change with time."""
    plan.compiled(run_task)(MAKE_STAGE, *plan, number, -1, dt)


def complete_step(plan: Plan, state: str) -> None:
    """Complete a step that somebody else has made: see fsipetsc.scheme.finish_step."""
    plan.compiled(run_task)(COMPLETE_STEP, *plan, 0, plan.start(state), 0.0)


def load_completed(plan: Plan, state: str) -> None:
    """Go on from a state that fulfils the conditions: a completed one."""
    plan.compiled(run_task)(LOAD_COMPLETED, *plan, 0, plan.start(state), 0.0)


def do_nothing(plan: Plan) -> None:
    """Enter compiled code, which is compiled or loaded for it, and leave it."""
    plan.compiled(run_task)(NOTHING, *plan, 0, -1, 0.0)
