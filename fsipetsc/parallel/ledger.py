"""Integrals over the layers: what the balances of mass and energy are made of. Compiled.

Quadrature with the norm of the operator, per cross-section; the strip between an embedded boundary and its ghost
point does not count. Sums over ranks may differ by round-off: nothing that is computed on depends on them.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.operators.reductions import total, total_of_squares
from fsipetsc.parallel.exchange import work_point
from fsipetsc.parallel.plan import WORK
from fsipetsc.parallel.settle import boundary_distance
from fsipetsc.physics.layer import FLUID


@njit(**OPTIONS)
def integrals(head, layers, memory):
    """This rank's share of the gas in each layer, masses[k] [kg/m2], and behind them of the total energy [J/m2].

    The energy is the integral of e over the fluids and of m0 (u^2/2 + alpha T) over the solids.
    """
    energy, masses = 0.0, U64(head.masses)
    for k in range(U64(layers.size)):
        layer = layers[k]
        memory[masses + k] = 0.0
        if layer.present == 0:
            continue
        if layer.kind == FLUID:
            memory[masses + k] = layer.h * integral(head, layer, memory, 0, False)
            energy += layer.h * integral(head, layer, memory, 2, False)
        else:
            kinetic = 0.5 * integral(head, layer, memory, 0, True)
            energy += layer.h * layer.m0 * (kinetic + layer.alpha * integral(head, layer, memory, 2, False))
    memory[masses + U64(layers.size)] = energy


@njit(**OPTIONS)
def integral(head, layer, memory, column, squared):
    """Sum of an unknown, or of its square, over the owned active points with the weights of the norm, without h."""
    op, a, b = head.op, max(layer.own_lo, layer.lo), min(layer.own_hi, layer.hi + 1)
    at, count = U64(work_point(head, layer, WORK, a) + column * layer.stride), U64(max(b - a, 0))
    result = total_of_squares(memory, at, count) if squared else total(memory, at, count)
    for r in range(op.rows):
        for i in (layer.lo + r, layer.hi - r):
            if a <= i < b:
                v = memory[U64(work_point(head, layer, WORK, i) + column * layer.stride)]
                result += (op.norm[r] - 1.0) * (v * v if squared else v)
    for side in range(2):
        ghost, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
        if layer.kind == FLUID and layer.end_kind[side] != INTERFACE_END and a <= ghost < b:
            strip = (layer.hi - layer.lo) - boundary_distance(layer, side)
            result -= strip_integral(memory, work_point(head, layer, WORK, ghost) + column * layer.stride, step, strip)
    return result


@njit(**OPTIONS)
def strip_integral(memory, at, step, delta):
    """Integral from the ghost point (0) to the boundary (delta) of the cubic through the last four points."""
    d2, d3, d4 = delta * delta, delta**3, delta**4
    a0 = delta - 11.0 / 12.0 * d2 + d3 / 3.0 - d4 / 24.0
    a1 = 1.5 * d2 - 5.0 / 6.0 * d3 + d4 / 8.0
    a2 = -0.75 * d2 + 2.0 / 3.0 * d3 - d4 / 8.0
    a3 = d2 / 6.0 - d3 / 6.0 + d4 / 24.0
    near = a0 * memory[U64(at)] + a1 * memory[U64(at + step)]
    return near + a2 * memory[U64(at + 2 * step)] + a3 * memory[U64(at + 3 * step)]
