"""What the edges of a layer do to its points in a stage, before the sweep over its rows and behind it. Compiled.

Before it: unknowns at interfaces and at edges that hold them. Behind it: what gas and solid do to each other where the gas
slips, and rates of what stands behind the layers (fsipetsc.parallel.plane.layout).
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.plane.layer import DOF, GAINED
from fsipetsc.scheme.plane.gains import gain, pull

#: what may hold a point, all that do: no velocity along X, none along Y, a temperature; or all unknowns are given
STILL_X, STILL_Y, WARM, SET = 1, 2, 4, 8
#: numbers that it may need: T where it is WARM, or what is SET: (rho, u, v, e / rho), or the unknowns of a solid
NUMBERS = DOF


@njit(**OPTIONS)
def join(layer, y, points, joined, lines, heights):
    """Put what gas and solid have together at points (n, COLUMNS) of interfaces in its place.

    joined: (n, 3), number of the point, column of those held, lower or upper edge; heights: of these edges. lines: (2, 4,
    width) of the grid of a gas, displacement in x, y, velocity.
    """
    gas = layer.kind == FLUID
    first = 2 if gas else 7
    for n in range(joined.shape[0]):
        point, column, side = joined[n]
        row = layer.end_y[side]
        if 0 <= row < layer.height:
            at = (row * layer.width + column) * DOF + 2
            for c in range(3):
                y[U64(at + c)] = points[point, first + c]
        if gas:
            lines[side, 0, column], lines[side, 1, column] = points[point, 5], heights[side] + points[point, 6]
            lines[side, 2, column], lines[side, 3, column] = points[point, 7], points[point, 8]


@njit(**OPTIONS)
def hold(law, layer, y, held, numbers):
    """Give points at edges what these hold. held: (n, 2), where a point's unknowns begin in y, what holds it; numbers: (n,
    NUMBERS).
    """
    for n in range(held.shape[0]):
        at, what = U64(held[n, 0]), held[n, 1]
        if what == SET:
            if layer.kind == FLUID:
                r = y[at] * numbers[n, 0]
                y[at + U64(1)], y[at + U64(2)] = r, r * numbers[n, 1]
                y[at + U64(3)], y[at + U64(4)] = r * numbers[n, 2], r * numbers[n, 3]
            else:
                for c in range(DOF):
                    y[at + U64(c)] = numbers[n, c]
            continue
        if what & STILL_X:
            y[at + U64(2)] = 0.0
        if what & STILL_Y:
            y[at + U64(3)] = 0.0
        if what & WARM:
            r = y[at + U64(1)]
            y[at + U64(4)] = r * law.gas.energy(law.gas.constants(layer), r / y[at], numbers[n, 0])


@njit(**OPTIONS)
def load(layer, op, rates, tractions, loaded):
    """Add to the rates at edges what tractions (n, RATES) do: to those of J (rho u, rho v, e), or to those of the velocity.

    loaded: (n, 4), number of the traction, column of those held, lower or upper edge, 1 where the solid is clamped: what a gas
    gets there comes from outside.
    """
    count = (layer.own_x[1] - layer.own_x[0]) * DOF
    for n in range(loaded.shape[0]):
        point, column, side, clamped = loaded[n]
        row = layer.end_y[side]
        at = (row - layer.own_y[0]) * count + (column - layer.own_x[0]) * DOF + 2
        if layer.kind == FLUID:
            for c in range(3):
                rates[U64(at + c)] += tractions[point, c]
            if clamped == 1:
                gain(layer, op, row, column, 0.0, tractions[point, 0], tractions[point, 1], 0.0)
        else:
            for c in range(2):
                rates[U64(at + c)] += tractions[point, 3 + c]


@njit(**OPTIONS)
def note_power(layer, y, rates, kinetic, changes):
    """Rates of the kinetic energies of end points of a solid. kinetic: (n, 3), where in ``changes``, column, edge."""
    count = (layer.own_x[1] - layer.own_x[0]) * DOF
    for n in range(kinetic.shape[0]):
        to, column, side = kinetic[n]
        row = layer.end_y[side]
        q = (row * layer.width + column) * DOF
        k = (row - layer.own_y[0]) * count + (column - layer.own_x[0]) * DOF
        changes[U64(to)] = layer.m0 * (y[U64(q + 2)] * rates[U64(k + 2)] + y[U64(q + 3)] * rates[U64(k + 3)])


@njit(**OPTIONS)
def note_gains(layer, op, y, words, changes, at):
    """Rates of what comes in through the edges, and by the body force, to changes[at:]; the record is ready for the next."""
    for c in range(GAINED):
        changes[U64(at + c)], layer.gained[c] = layer.gained[c], 0.0
    if layer.force[0] != 0.0 or layer.force[1] != 0.0:
        pull(layer, op, y, words)
        for c in range(GAINED):
            changes[U64(at + c)] += words[c]
