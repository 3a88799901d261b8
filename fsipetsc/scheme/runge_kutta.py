"""The right-hand side, and the classical Runge-Kutta method of fourth order fused with it. Compiled.

A stage reads one work area and writes the next stage's values straight into another; the sum that becomes the new
solution is built up beside it. It is the method of PETSc's ``-ts_type rk -ts_rk_type 4``, up to round-off.

On large grids a whole step goes over memory once. What the interfaces, outer ends and neighbouring ranks can reach within
a step is a few points at each end of a layer: there the stages are made one after the other, with the exchanges between
them, each on fewer points than the one before. The *middle* of the layer then needs nobody else. It is cut into tiles
that stay in cache while all four stages pass over them, each a stencil's reach behind the one before (time skewing):

    stage 3  E E|M . . .|. . . . .        E  ends     M  middle, tile by tile from the left
    stage 2  E E E|M . . .|. . . .        The values that a stage of the middle takes from the ends' side are still
    stage 1  E E E E|M . . .|. . .        there, because the ends stop short of them two stages later.
    stage 0  E E E E E|M . . .|. .

There is one compiled entry, ``advance``, because every entry would compile all that it calls anew.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from fsipetsc.operators.formulas import with_chosen
from fsipetsc.operators.kernels import ENTRY, INLINE, OPTIONS, U64
from fsipetsc.parallel.exchange import exchange, load_state, store_state, unknowns, work_point
from fsipetsc.scheme.burst import DT, goes_on
from fsipetsc.scheme.conditions import apply_conditions, note_gradients
from fsipetsc.scheme.finish_step import begin_looking, finish_step, look
from fsipetsc.scheme.laws import LAWS, of_layer
from fsipetsc.scheme.plan import FORCING, STAGES, SUM, WORK
from fsipetsc.scheme.stage_update import Target

#: points of a tile
TILE = 1024


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
    """The stages of the classical method; with dt = 0 the rates themselves are added to SUM."""
    area, onward = work_area(number), work_area(number + 1)
    if dt == 0.0:
        return Stage(area, onward, WORK, SUM, 0.0, 1.0)
    if number == STAGES - 1:
        return Stage(area, onward, SUM, -1, dt / 6.0, 0.0)
    a = dt if number == 2 else 0.5 * dt
    return Stage(area, onward, WORK, WORK if number == 0 else SUM, a, dt / 6.0 if number == 0 else dt / 3.0)


@njit(**OPTIONS)
def evaluate(head, layer, memory, stage, begin, end):
    """One stage at the points begin .. end-1 of a layer, whose work area is settled around them."""
    target = Target(
        work_point(head, layer, stage.source, 0),
        work_point(head, layer, stage.next, 0),
        work_point(head, layer, max(stage.base, 0), 0),
        work_point(head, layer, SUM, 0) if stage.base >= 0 else -1,
        work_point(head, layer, FORCING, 0) if head.area[FORCING] >= 0 else -1,
        layer.stride,
        stage.a,
        stage.b,
    )
    w = work_point(head, layer, stage.area, 0)
    with_chosen(of_layer.sweep, LAWS, layer.kind, layer, head.op, memory, w, head.scratch, target, begin, end)


@njit(**INLINE)
def find_middle(head, layer, wanted):
    """Note which points tiles complete: their range in the last stage. In a stage before, ends reach 2 p points further."""
    a, b = max(layer.own_lo, layer.lo), min(layer.own_hi, layer.hi + 1)
    layer.middle[0], layer.middle[1] = a + head.edge, b - head.edge
    if not wanted or layer.present == 0 or b - a < head.least:
        layer.middle[0] = layer.middle[1] = a


@njit(**INLINE)
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


@njit(**INLINE)
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
                layer.s = layer.stage_s[number]
                evaluate(head, layer, memory, stage_of(number, dt), min(begin + ahead, b - ahead), end)
            layer.s = layer.stage_s[STAGES]
            look(head, layer, k, memory, begin, min(begin + TILE, b))


@njit(**INLINE)
def clear(head, layers, memory, area):
    """Zero in an area."""
    for layer in layers:
        at = U64(head.area[area] + layer.work)
        for i in range(U64(unknowns(layer) * layer.stride)):
            memory[at + i] = 0.0


@njit(**ENTRY)
def advance(heads, layers, faces, memory, begin, end, raw, dt):
    """Stages begin .. end-1 of a step dt; stage ``STAGES`` completes it. Collective on all ranks.

    A stage settles its work area, except stage 0, which finds it settled by the completion of the step before, and
    evaluates the right-hand side into the next one. raw: where in the memory a state begins that somebody else has
    made, which is loaded and settled first; -1 to go on. What is asked for:

        begin, end       raw  dt
        0, STAGES + 1    -1   > 0  a whole step, and more of them as the pace allows
        n, n + 1         -1   > 0  a stage, or the completion: where data change with time
        0, 1             at   0    the right-hand side of a state, which is left where the state was
        STAGES, +1       at   0    a step made by others is completed
        0, 0             at   0    a state is loaded as it is, settled already
        0, 0             -1   0    nothing
    """
    head = heads[0]
    whole, rates = begin == 0 and end == STAGES + 1, end == 1 and dt == 0.0
    if raw >= 0:
        load_state(head, layers, memory, WORK, raw)
        if begin == end:
            exchange(head, layers, faces, memory, WORK)
            note_gradients(head, layers, memory, WORK)
    if rates:
        clear(head, layers, memory, SUM)
    more = begin < end
    while more:
        for layer in layers:
            find_middle(head, layer, whole)
        for number in range(begin, end):
            if raw >= 0 or number > 0:
                apply_conditions(head, layers, faces, memory, work_area(number))
            for layer in layers:
                layer.stage_s[number] = layer.s
            if number < STAGES:
                ends(head, layers, memory, stage_of(number, dt), number)
        if end == STAGES + 1:
            begin_looking(head, layers, memory)
            tiles(head, layers, memory, dt)
            finish_step(head, layers, faces, memory)
        elif rates:
            for layer in layers:
                store_state(head, layer, memory, SUM, raw, layer.own_lo, layer.own_hi)
        more = whole and goes_on(head, memory)
        dt = memory[U64(head.pace + DT)] if more else dt
