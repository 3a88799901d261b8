"""What a layer gains through its edges: mass, momentum along x and y, energy; this rank's points. Compiled.

Two parts of it are known apart. What ``amend`` of the equations adds to the rates is summed up with them (``gained`` of the
record of a layer) and integrated by the same Runge-Kutta method as the unknowns, so that balances close to round-off. What
holds a point, a wall that the gas sticks to, a clamp, gives it its values after the step: the difference that makes is the
rest. Energy, mass: of gases alone; a solid is held without work. A body force counts as gained, too.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.plane.layer import DOF
from fsipetsc.scheme.plane.sums import norm_at


@njit(**OPTIONS)
def area(layer, op, j, i):
    """Weight of a point in an integral over the reference coordinates."""
    along, across = norm_at(op, i, layer.end_x[0], layer.end_x[1]), norm_at(op, j, layer.end_y[0], layer.end_y[1])
    return along * across * layer.h_x * layer.h_y


@njit(**OPTIONS)
def gain(layer, op, j, i, mass, x, y, energy):
    """Note rates that have been added to the unknowns of a point."""
    part, gained = area(layer, op, j, i), layer.gained
    gained[0] += part * mass
    gained[1] += part * x
    gained[2] += part * y
    gained[3] += part * energy


@njit(**OPTIONS)
def edge_sums(layer, op, y, words):
    """(4,) what the points at the four edges have of each."""
    words[:] = 0.0
    first, last = layer.own_x[0], layer.own_x[1] - 1
    for j in range(layer.own_y[0], layer.own_y[1]):
        whole = j == layer.end_y[0] or j == layer.end_y[1]
        for i in range(first, last + 1, 1 if whole else max(last - first, 1)):
            if whole or i == layer.end_x[0] or i == layer.end_x[1]:
                part, n = area(layer, op, j, i), (j * layer.width + i) * DOF
                if layer.kind == FLUID:
                    for c in range(4):
                        words[c] += part * y[U64(n + 1 + c)]
                else:
                    words[1] += part * layer.m0 * y[U64(n + 2)]
                    words[2] += part * layer.m0 * y[U64(n + 3)]


@njit(**OPTIONS)
def pull(layer, op, y, words):
    """(4,) rates at which the body force on all points gives each of them."""
    words[:] = 0.0
    f_x, f_y, gas = layer.force[0], layer.force[1], layer.kind == FLUID
    for j in range(layer.own_y[0], layer.own_y[1]):
        for i in range(layer.own_x[0], layer.own_x[1]):
            part, n = area(layer, op, j, i), (j * layer.width + i) * DOF
            mass = y[U64(n + 1)] if gas else layer.m0
            along, up = (y[U64(n + 2)], y[U64(n + 3)]) if gas else (layer.m0 * y[U64(n + 2)], layer.m0 * y[U64(n + 3)])
            words[1] += part * mass * f_x
            words[2] += part * mass * f_y
            words[3] += part * (f_x * along + f_y * up)
