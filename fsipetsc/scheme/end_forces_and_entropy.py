"""Forces at the outer ends and entropies of the layers, for the integrals. Compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.boundaries import ABSORBING, FREE, INTERFACE_END, NODES
from fsipetsc.operators.kernels import BLOCK, OPTIONS, U64, derivative, lagrange, row
from fsipetsc.parallel.exchange import work_point
from fsipetsc.parallel.pointers import rows_at
from fsipetsc.scheme.layer_ends import beyond_the_end, boundary_distance, embedded
from fsipetsc.scheme.plan import WORK


@njit(**OPTIONS)
def weight(head, layer, i):
    """Norm weight of an active point."""
    nearest = min(i - layer.lo, layer.hi - i)
    return head.op.norm[nearest] if nearest < head.op.rows else 1.0


@njit(**OPTIONS)
def norm_sum(head, layer):
    """Sum of the norm weights of the owned points."""
    result = float(layer.own_hi - layer.own_lo)
    for r in range(head.op.rows):
        for i in (layer.lo + r, layer.hi - r):
            if layer.own_lo <= i < layer.own_hi:
                result += head.op.norm[r] - 1.0
    return result


@njit(**OPTIONS)
def end_forces(law, head, layer, memory):
    """Force [Pa] of the outer ends that this rank owns: -n (rho u^2 + p - mu' u_X) of a fluid, n (sigma - p) of a solid."""
    force = 0.0
    for side in range(2):
        end, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
        if layer.end_kind[side] == INTERFACE_END or not layer.own_lo <= end < layer.own_hi:
            continue
        normal = 2.0 * side - 1.0
        if layer.unloaded[side] != 0:
            force += unloaded_force(layer, memory, side, work_point(head, layer, WORK, end))
            continue
        force -= normal * law.traction(law, head, layer, memory, side, end, step)
    return force


@njit(**OPTIONS)
def gas_traction(law, head, layer, memory, side, ghost, step):
    """rho u^2 + p - mu' u_x at an embedded boundary, from the cubic through the last four points; at the end of a stretched
    layer that is no wall from this point.
    """
    nodes = rows_at(memory, head.nodes, 5, NODES)
    lagrange(beyond_the_end(layer, side), 3, nodes[3], nodes[4])
    gas, c, flux, T = law.gas, law.gas.constants(layer), 0.0, 0.0
    for k in range(4):
        T += nodes[3, k] * gas_temperature(law, layer, memory, work_point(head, layer, WORK, ghost + k * step))
    mu = layer.mu * law.transport.relative(law.transport.constants(layer), T)[0]
    for k in range(4):
        w = work_point(head, layer, WORK, ghost + k * step)
        rho, m, e = memory[U64(w)], memory[U64(w + layer.stride)], memory[U64(w + 2 * layer.stride)]
        u, per_J = m / rho, 1.0 / layer.J
        flux += nodes[3, k] * (per_J * m * u + gas.pressure_of_energy(c, per_J * rho, per_J * (e - 0.5 * m * u)))
        if k == 0 and layer.end_apart[side] != 0:
            u = layer.end_gradient[side, 0]
        flux -= mu * nodes[4, k] * u * step / (layer.h * layer.J)
    return flux


@njit(**OPTIONS)
def unloaded_force(layer, memory, side, w):
    """The stress that is put in at an unloaded end of a solid, times its normal; what is given a velocity has an impulse."""
    normal = 2.0 * side - 1.0
    if layer.end_kind[side] == FREE:
        return normal * layer.end_data[side, 0]
    if layer.end_kind[side] == ABSORBING:
        return normal * layer.end_data[side, 0] - layer.end_impedance[side] * memory[U64(w)]
    return 0.0


@njit(**OPTIONS)
def solid_traction(law, head, layer, memory, side, end, step):
    """p - sigma at the end of a solid."""
    x_X = 0.0
    for j in range(head.rows):
        x_X += head.op.closure[0, j] * memory[U64(work_point(head, layer, WORK, end + step * j) + 3 * layer.stride)]
    x_X *= step / layer.h
    w = work_point(head, layer, WORK, end)
    p = law.pressing.pressure(law.pressing.constants(layer), memory[U64(w + 2 * layer.stride)], x_X)
    return p - memory[U64(w + layer.stride)]


@njit(**OPTIONS)
def gas_temperature(law, layer, memory, w):
    """T of the gas at a point."""
    rho = memory[U64(w)]
    u = memory[U64(w + layer.stride)] / rho
    return law.gas.temperature(law.gas.constants(layer), rho / layer.J, memory[U64(w + 2 * layer.stride)] / rho - 0.5 * u * u)


@njit(**OPTIONS)
def entropy_density(law, layer, memory, w):
    """Entropy of the gas per volume at rest at a point."""
    rho, T = memory[U64(w)], gas_temperature(law, layer, memory, w)
    return rho * law.gas.entropy(law.gas.constants(layer), rho / layer.J, T)


@njit(**OPTIONS)
def gas_entropy(law, head, layer, memory):
    """(this rank's part of the gas's entropy without h, 0): the density is that of ``entropy_density``."""
    result = 0.0
    for i in range(max(layer.own_lo, layer.lo), min(layer.own_hi, layer.hi + 1)):
        result += weight(head, layer, i) * entropy_density(law, layer, memory, work_point(head, layer, WORK, i))
    for side in range(2):
        ghost, step = (layer.lo, 1) if side == 0 else (layer.hi, -1)
        if embedded(layer, side) and layer.own_lo <= ghost < layer.own_hi:
            for k in range(4):
                at = work_point(head, layer, WORK, ghost + k * step)
                memory[U64(head.nodes + k)] = entropy_density(law, layer, memory, at)
            strip = layer.hi - layer.lo - boundary_distance(layer, side)
            result -= strip_integral(memory, head.nodes, 1, strip)
    return result, 0.0


@njit(**OPTIONS)
def solid_entropy(law, head, layer, memory):
    """(entropy, rate of heating by stress over T) of this rank's part without h: alpha m0 ln T, (sigma - p) u_X / T."""
    entropy, heating = 0.0, 0.0
    first, at = layer.own_lo - layer.halo_lo, head.scratch
    w = work_point(head, layer, WORK, first)
    pressing, c = law.pressing, law.pressing.constants(layer)
    for i0 in range(layer.own_lo, layer.own_hi, BLOCK):
        i1 = min(i0 + BLOCK, layer.own_hi)
        for q in range(2):  # u_X, x_X
            source = w if q == 0 else w + 3 * layer.stride
            derivative(head.op, memory, source, first, at + row(q), i0, i0, i1, layer.lo, layer.hi, 1.0 / layer.h)
        for i in range(i0, i1):
            p = w + i - first
            T, a = memory[U64(p + 2 * layer.stride)], weight(head, layer, i)
            u_X, x_X = memory[U64(at + row(0) + i - i0)], memory[U64(at + row(1) + i - i0)]
            entropy += a * np.log(T)
            heating += a * (memory[U64(p + layer.stride)] - pressing.pressure(c, T, x_X)) * u_X / T
    return layer.alpha * layer.m0 * entropy, heating


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
