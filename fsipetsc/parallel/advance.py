"""The right-hand side, and the classical Runge-Kutta method of fourth order fused with it. Compiled.

The fused step moves each number as little as possible: a stage reads one work area and writes the next stage's values
straight into the other, and the sum that becomes the new solution is built up beside it; derivatives live in scratch.
It is the method of PETSc's ``-ts_type rk -ts_rk_type 4``, up to round-off.

There is one compiled entry, ``advance``, because every entry would compile all that it calls anew.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64, copy
from fsipetsc.parallel.completion import complete
from fsipetsc.parallel.exchange import exchange, load, store, unknowns, work_point
from fsipetsc.parallel.plan import BASE, FORCING, SUM, WORK
from fsipetsc.parallel.settle import settle
from fsipetsc.physics.emission import Target
from fsipetsc.physics.fluid import fluid_rhs
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.solid import solid_rhs

#: stages of the method; after the last one comes the completion of the step
STAGES = 4


@njit(**OPTIONS)
def rates(head, layers, memory, area, source, base, a, b):
    """Right-hand sides k of all layers from a settled work area: other work area = source + a k, SUM = base + b k."""
    for layer in layers:
        if layer.present == 0:
            continue
        own = layer.own_lo
        w = work_point(head, layer, area, own - layer.halo_lo)
        forcing = work_point(head, layer, FORCING, own) if head.area[FORCING] >= 0 else -1
        target = Target(
            work_point(head, layer, source, own),
            work_point(head, layer, 1 - area, own),
            work_point(head, layer, base, own),
            work_point(head, layer, SUM, own),
            forcing,
            layer.stride,
            a,
            b,
        )
        if layer.kind == FLUID:
            fluid_rhs(layer, head.op, memory, w, head.scratch, target)
        else:
            solid_rhs(layer, head.op, memory, w, head.scratch, target)


@njit(**OPTIONS)
def clear(head, layers, memory, area):
    """Zero in an area."""
    for layer in layers:
        at = U64(head.area[area] + layer.work)
        for i in range(U64(unknowns(layer) * layer.stride)):
            memory[at + i] = 0.0


@njit(**OPTIONS)
def advance(heads, layers, faces, memory, begin, end, raw, dt):
    """Stages begin .. end-1 of a step dt; stage ``STAGES`` completes it. Collective on all ranks.

    A stage settles its work area, except stage 0, which finds it settled by the completion of the step before, and
    evaluates the right-hand side into the other one. raw: where in the memory a state begins that somebody else has
    made, which is loaded and settled first; -1 to go on. With begin = end it is loaded as it is, settled already. With
    dt = 0 (and begin 0, end 1) the right-hand side itself is left where the state was.
    """
    head = heads[0]
    if raw >= 0:
        load(head, layers, memory, raw)
        if begin == end:
            exchange(head, layers, faces, memory, WORK)
            keep(head, layers, memory)
    for number in range(begin, end):
        area = number % 2
        if raw >= 0 or number > 0:
            settle(head, layers, faces, memory, area)
        if number == STAGES:
            complete(head, layers, faces, memory)
            keep(head, layers, memory)
        else:
            source, base = BASE, (BASE if number == 0 else SUM)
            a = dt if number == 2 else 0.5 * dt
            b = dt / 6.0 if number == 0 else dt / 3.0
            if number == STAGES - 1:
                source, a, b = SUM, dt / 6.0, 0.0
            if dt == 0.0:
                clear(head, layers, memory, SUM)
                base, b = SUM, 1.0
            rates(head, layers, memory, area, source, base, a, b)
            if dt == 0.0:
                store(head, layers, memory, SUM, raw)


@njit(**OPTIONS)
def keep(head, layers, memory):
    """The completed solution: to PETSc, and to where the next step starts from."""
    store(head, layers, memory, WORK, head.solution)
    for layer in layers:
        count = unknowns(layer) * layer.stride
        copy(memory, head.area[WORK] + layer.work, head.area[BASE] + layer.work, count)
