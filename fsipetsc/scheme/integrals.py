"""Integrals over the layers: mass, momentum, energy, entropy, and what changes them. See also ``conservation_check``. Compiled.

Quadrature with the norm of the operator, per cross-section; the strip between an embedded boundary and its ghost
point does not count. Sums over ranks may differ by round-off: nothing that is computed on depends on them.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import with_chosen
from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.parallel.exchange import work_point
from fsipetsc.physics.layer import FLUID
from fsipetsc.scheme.end_forces_and_entropy import norm_sum, strip_integral
from fsipetsc.scheme.extremes_and_sums import SIZE, SUMS
from fsipetsc.scheme.laws import LAWS, of_layer
from fsipetsc.scheme.layer_ends import boundary_distance, embedded
from fsipetsc.scheme.plan import ENERGY, ENTROPY, FORCE, HEATING, IMPULSE, MOMENTUM, WORK


@njit(**OPTIONS)
def integrals(head, layers, memory):
    """This rank's shares: the gas in each fluid layer [kg/m2], and behind these at ENERGY .. HEATING

    the total energy, of e over the fluids and of m0 (u^2/2 + alpha T) over the solids [J/m2]; the momentum [kg/(m s)];
    the force of the outer ends and of the body force on all of it [Pa], but for ends that have been given a velocity: their
    impulse in this step [kg/(m s)], which is exact; and, if asked for, the entropy of
    gas and solids [J/(m2 K)] and the rate at which sigma u_X heats the solids, over T [W/(m2 K)].
    """
    energy, momentum, force, impulse, entropy, heating = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    mass = U64(head.masses)
    for k in range(layers.size):
        layer = layers[k]
        fluid = layer.kind == FLUID
        if fluid:
            memory[mass] = 0.0
            mass += U64(1)
        if layer.present == 0:
            continue
        h, sums = layer.h, U64(head.extremes + SIZE * k + SUMS)
        for q in range(3):  # fluid: rho, rho u, e; solid: u, u^2, T
            column = q if fluid or q == 2 else 0
            value = h * integral(head, layer, memory, memory[sums + U64(q)], column, q == 1 and not fluid)
            if q == (0 if not fluid else 1):
                momentum += value if fluid else layer.m0 * value
            elif q == 0:
                memory[mass - U64(1)] = value
                force += layer.force * value
            elif fluid:
                energy += value
            else:
                energy += layer.m0 * (0.5 if q == 1 else layer.alpha) * value
        if not fluid:
            force += layer.force * layer.m0 * h * norm_sum(head, layer)
        impulse += end_impulses(layer)
        force += with_chosen(of_layer.end_forces, LAWS, layer.law, head, layer, memory)
        if head.entropy == 1:
            gained, source = with_chosen(of_layer.entropy, LAWS, layer.law, head, layer, memory)
            entropy += h * gained
            heating += h * source
    memory[U64(head.integrals + ENERGY)] = energy
    memory[U64(head.integrals + MOMENTUM)] = momentum
    memory[U64(head.integrals + FORCE)] = force
    memory[U64(head.integrals + IMPULSE)] = impulse
    memory[U64(head.integrals + ENTROPY)] = entropy
    memory[U64(head.integrals + HEATING)] = heating


@njit(**OPTIONS)
def end_impulses(layer):
    """Of the ends that this rank owns and that have been given a velocity; see fsipetsc.scheme.layer_ends."""
    impulse = 0.0
    for side in range(2):
        if layer.own_lo <= (layer.lo if side == 0 else layer.hi) < layer.own_hi:
            impulse += layer.end_impulse[side]
    return impulse


@njit(**OPTIONS)
def integral(head, layer, memory, result, column, squared):
    """Sum of an unknown, or of its square, over the owned active points with the weights of the norm, without h.

    result: their plain sum, of the layer's points.
    """
    op, a, b = head.op, max(layer.own_lo, layer.lo), min(layer.own_hi, layer.hi + 1)
    for r in range(op.rows):
        for i in (layer.lo + r, layer.hi - r):
            if a <= i < b:
                v = memory[U64(work_point(head, layer, WORK, i) + column * layer.stride)]
                result += (op.norm[r] - 1.0) * (v * v if squared else v)
    for side in range(2):
        ghost, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
        if embedded(layer, side) and a <= ghost < b:
            strip = (layer.hi - layer.lo) - boundary_distance(layer, side)
            result -= strip_integral(memory, work_point(head, layer, WORK, ghost) + column * layer.stride, step, strip)
    return result
