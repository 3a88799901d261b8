"""The right-hand side, and the classical Runge-Kutta method of fourth order fused with it. Compiled.

The fused step moves each number as little as possible: a stage reads one work area and writes the next stage's values
straight into the other, and the sum that becomes the new solution is built up beside it; derivatives live in scratch.
It is the method of PETSc's ``-ts_type rk -ts_rk_type 4``, up to round-off.

There is one compiled entry, ``advance``, because every entry would compile all that it calls anew.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.parallel.completion import complete
from fsipetsc.parallel.exchange import exchange, load, work_point
from fsipetsc.parallel.settle import settle
from fsipetsc.physics.emission import Target
from fsipetsc.physics.fluid import fluid_rhs
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.solid import solid_rhs

#: stages of the method; after the last one comes the completion of the step
STAGES = 4


@njit(**OPTIONS)
def rates(head, layers, memory, area, source, a, b):
    """Right-hand sides k of all layers from a settled work area: other area = source + a k, sum += b k."""
    for layer in layers:
        if layer.present == 0:
            continue
        w = work_point(head, layer, area, layer.own_lo - layer.halo_lo)
        ahead = work_point(head, layer, 1 - area, layer.own_lo)
        forcing = head.forcing + layer.start if head.forcing >= 0 else -1
        target = Target(source + layer.start, ahead, head.sum + layer.start, forcing, a, b)
        if layer.kind == FLUID:
            fluid_rhs(layer, head.op, memory, w, head.scratch, target)
        else:
            solid_rhs(layer, head.op, memory, w, head.scratch, target)


@njit(**OPTIONS)
def advance(heads, layers, faces, memory, begin, end, raw, dt):
    """Stages begin .. end-1 of a step dt; stage ``STAGES`` completes it. Collective on all ranks.

    A stage settles its work area, except stage 0, which finds it settled by the completion of the step before, and
    evaluates the right-hand side into the other one. raw: where in the memory a state begins that somebody else has
    made, which is loaded and settled first; -1 to go on. With begin = end it is loaded as it is, settled already. With dt = 0
    the right-hand side itself is left in the sum (for begin 0, end 1).
    """
    head = heads[0]
    if raw >= 0:
        load(head, layers, memory, raw)
        if begin == end:
            exchange(head, layers, faces, memory, 0)
    for number in range(begin, end):
        area = number % 2
        if raw >= 0 or number > 0:
            settle(head, layers, faces, memory, area)
        if number == STAGES:
            complete(head, layers, faces, memory)
        elif dt == 0.0:
            begin_sum, length = U64(head.sum), U64(head.local)
            for i in range(length):
                memory[begin_sum + i] = 0.0
            rates(head, layers, memory, area, head.solution, 0.0, 1.0)
        elif number == STAGES - 1:
            rates(head, layers, memory, area, head.sum, dt / 6.0, 0.0)
        else:
            b = dt / 6.0 if number == 0 else dt / 3.0
            rates(head, layers, memory, area, head.solution, dt if number == 2 else 0.5 * dt, b)
