"""What follows a time step: the new solution is projected in place, the embedded boundaries move over the grid,
and the bounds on the next step and the integrals of the ledgers are taken. Compiled; collective on all ranks.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.coupling import residuals
from fsipetsc.operators.kernels import OPTIONS
from fsipetsc.parallel.exchange import (
    boundary_distance,
    fill_embedded,
    ghost_point,
    layer_work,
    refresh,
)
from fsipetsc.parallel.mpi import mpi_allreduce
from fsipetsc.physics.fluid import fluid_limits
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.solid import solid_limits

#: results of ``complete``: a boundary changed its cell; 1 + number of a layer whose grid has no free point left,
#: that has run off its grid, or that is too short
MOVED, LOW, EXHAUSTED, SHORT = 0, 1, 2, 3
#: results of ``limits``; STOP is handed through: the largest over all ranks
RATE, BAD, STOP = 0, 1, 2


@njit(**OPTIONS)
def store(plan, y):
    """Copy the owned part of the work arrays back into the solution."""
    for layer in plan.layers:
        if layer.present == 1:
            dof = 3 if layer.kind == FLUID else 4
            count, own = dof * (layer.own_hi - layer.own_lo), layer.work + dof * layer.halo_lo
            y[layer.start : layer.start + count] = plan.work[own : own + count]


@njit(**OPTIONS)
def move_boundary(plan, layer, side):
    """Let the embedded boundary at one end of a fluid layer move over the grid; True if it changed its cell.

    The ghost point is the first grid point at or beyond the boundary. A grid point that comes in is extrapolated
    and becomes the ghost point, the old one keeps its value; where the boundary moves inwards the last interior
    point becomes the ghost. Returns (moved, the grid has no point left).
    """
    distance = boundary_distance(layer, side)
    if not distance < 1e15:
        return False, False  # not a number: the limits will report it
    target = int(np.ceil(distance - 1e-9))
    moved = False
    while layer.hi - layer.lo < target:
        if (side == 0 and layer.lo == 0) or (side == 1 and layer.hi == layer.n - 1):
            return moved, True
        if side == 0:
            layer.lo -= 1
        else:
            layer.hi += 1
        fill_embedded(plan, layer, side, True)
        moved = True
    if layer.hi - layer.lo > target >= layer.least - 1:
        if side == 0:
            layer.lo = layer.hi - target
        else:
            layer.hi = layer.lo + target
        fill_embedded(plan, layer, side, False)
        moved = True
    return moved, False


@njit(**OPTIONS)
def complete(plan, y, flags):
    """Project the solution y in place and move the embedded boundaries. Collective on all ranks.

    flags: what happened, see MOVED, LOW, EXHAUSTED, SHORT.
    """
    refresh(plan, y)
    flags[:] = 0
    for k in range(plan.layers.size):
        layer = plan.layers[k]
        for side in range(2):
            if layer.kind == FLUID and layer.end_kind[side] != INTERFACE_END:
                moved, exhausted = move_boundary(plan, layer, side)
                if moved:
                    flags[MOVED] = 1
                if exhausted:
                    flags[EXHAUSTED] = 1 + k
                if (side == 0 and layer.lo == 0) or (side == 1 and layer.hi == layer.n - 1):
                    flags[LOW] = 1 + k
                if boundary_distance(layer, side) <= layer.least - 2 + 1e-9:
                    flags[SHORT] = 1 + k
    store(plan, y)


@njit(**OPTIONS)
def limits(plan, send, receive):
    """Bounds on the time step from the work arrays: receive[RATE] = 1/dt at Courant number 1, receive[BAD] > 0 where
    the state is unphysical anywhere. Collective on all ranks; send and receive have three entries.

    dt = min( h / (|u-s| + c), h^2 / (2 max(mu'/rho, kappa/(rho cv))), h / c_s, h^2 alpha m0 x_X / (2 kappa_e) ).
    """
    rate, bad = 0.0, 0
    for k in range(plan.layers.size):
        layer = plan.layers[k]
        if layer.present == 0:
            continue
        w, h = layer_work(layer, plan.work), layer.h
        if layer.kind == FLUID:
            if layer.own_hi <= layer.lo or layer.own_lo > layer.hi:
                continue
            speed, volume, wrong = fluid_limits(layer, w, plan.scratch)
            diffusion = 2.0 * max(layer.mu, layer.kappa / layer.cv) * volume
            rate = max(rate, speed / h, diffusion / (h * h))
        else:
            c2, stretch, wrong = solid_limits(layer, w)
            diffusion = 2.0 * layer.kappa_e * stretch / (layer.alpha * layer.m0)
            rate = max(rate, np.sqrt(max(c2, 0.0)) / h, diffusion / (h * h))
        bad += wrong
    send[RATE], send[BAD] = rate, float(bad)
    if plan.world[0].size > 1:
        world = plan.world[0]
        mpi_allreduce(send.ctypes.data, receive.ctypes.data, 3, world.word, world.max, world.comm)
    else:
        receive[:] = send


@njit(**OPTIONS)
def interface_state(plan, out):
    """out[k] = (x, u, sigma, T, residuals of the four conditions) at interface k; all ranks know them after a refresh."""
    for k in range(plan.faces.size):
        solid = plan.traces[1, k, 0, 3:]
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = solid[3], solid[0], solid[1], solid[2]
        residuals(plan.faces[k], plan.op[0], plan.traces[1, k, :, :3], plan.traces[1, k, :, 3:], out[k, 4:])


@njit(**OPTIONS)
def point_weight(layer, op, i):
    """Norm weight of the active point i of a layer."""
    left, right = i - layer.lo, layer.hi - i
    nearest = min(left, right)
    return op.norm[nearest] if nearest < op.rows else 1.0


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc"}, nogil=True)
def integrals(plan, masses):
    """This rank's share of (mass of each layer's gas, total energy): masses[fluid layer], returned energy.

    Quadrature with the norm of the operator, per cross-section [kg/m2, J/m2]; the strip between an embedded
    boundary and its ghost point does not count. Sums over ranks may differ by round-off.
    """
    energy = 0.0
    masses[:] = 0.0
    op = plan.op[0]
    for k in range(plan.layers.size):
        layer = plan.layers[k]
        if layer.present == 0:
            continue
        w, first, h = layer_work(layer, plan.work), layer.own_lo - layer.halo_lo, layer.h
        a, b = max(layer.own_lo, layer.lo), min(layer.own_hi, layer.hi + 1)
        inner_a, inner_b = max(a, layer.lo + op.rows), min(b, layer.hi + 1 - op.rows)
        if layer.kind == FLUID:
            rho, e = 0.0, 0.0
            q = w[3 * (inner_a - first) :]
            for i in range(inner_b - inner_a):
                rho += q[3 * i]
                e += q[3 * i + 2]
            for i in range(a, b):
                if i < inner_a or i >= inner_b:
                    rho += point_weight(layer, op, i) * w[3 * (i - first)]
                    e += point_weight(layer, op, i) * w[3 * (i - first) + 2]
            for side in range(2):
                if layer.end_kind[side] != INTERFACE_END:
                    G, step = ghost_point(layer, side)
                    if layer.own_lo <= G < layer.own_hi:
                        strip = (layer.hi - layer.lo) - boundary_distance(layer, side)
                        rho -= strip_integral(w, 3 * (G - first), 3 * step, strip)
                        e -= strip_integral(w, 3 * (G - first) + 2, 3 * step, strip)
            masses[k] = h * rho
            energy += h * e
        else:
            q = w[4 * (inner_a - first) :]
            kinetic, heat = 0.0, 0.0
            for i in range(inner_b - inner_a):
                kinetic += q[4 * i] * q[4 * i]
                heat += q[4 * i + 2]
            for i in range(a, b):
                if i < inner_a or i >= inner_b:
                    weight, u = point_weight(layer, op, i), w[4 * (i - first)]
                    kinetic += weight * u * u
                    heat += weight * w[4 * (i - first) + 2]
            energy += h * layer.m0 * (0.5 * kinetic + layer.alpha * heat)
    return energy


@njit(**OPTIONS)
def strip_integral(w, i, step, delta):
    """Integral from the ghost point (0) to the boundary (delta) of the cubic through the last four points."""
    d2, d3, d4 = delta * delta, delta**3, delta**4
    a0 = delta - 11.0 / 12.0 * d2 + d3 / 3.0 - d4 / 24.0
    a1 = 1.5 * d2 - 5.0 / 6.0 * d3 + d4 / 8.0
    a2 = -0.75 * d2 + 2.0 / 3.0 * d3 - d4 / 8.0
    a3 = d2 / 6.0 - d3 / 6.0 + d4 / 24.0
    return a0 * w[i] + a1 * w[i + step] + a2 * w[i + 2 * step] + a3 * w[i + 3 * step]


@njit(**OPTIONS)
def finish_step(plan, y, flags, send, receive, faces, masses):
    """Everything that follows a step, in one call: ``complete``, ``limits``, ``interface_state``, ``integrals``.

    Returns this rank's share of the total energy. Collective on all ranks.
    """
    complete(plan, y, flags)
    limits(plan, send, receive)
    interface_state(plan, faces)
    return integrals(plan, masses)
