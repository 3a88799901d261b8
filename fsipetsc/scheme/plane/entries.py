"""What Python calls of a layer in two dimensions. Compiled; for the laws GAS and SOLID, see fsipetsc.scheme.plane.laws.

layers: PLANE_LAYER records, k the number of one; operators: the operator, and that which is loose at its ends (see ``sweep``);
s: scratch of ``scratch_size`` doubles, stride from one row of it to the next; y: the unknowns of the points that are held.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.coupling.plane import meet
from fsipetsc.operators.kernels import ENTRY, U64
from fsipetsc.operators.rows import along
from fsipetsc.physics.plane.gas import LINE_ROWS
from fsipetsc.scheme.plane.laws import GAS, SOLID
from fsipetsc.scheme.plane.look import look_at_gas, look_at_solid
from fsipetsc.scheme.plane.sweep import columns, lines_of, places, sweep


@njit(**ENTRY)
def gas_rates(layers, k, operators, s, stride, y, f):
    """Rates of gas layer k at the points that are owned, to f."""
    sweep(GAS, layers[k], operators[0], operators[1], s, places(stride), y, f)


@njit(**ENTRY)
def solid_rates(layers, k, operators, s, stride, y, f):
    """Rates of solid layer k."""
    sweep(SOLID, layers[k], operators[0], operators[1], s, places(stride), y, f)


@njit(**ENTRY)
def meet_at(faces, k, points):
    """What gas and solid have together at points of interface k: see fsipetsc.coupling.plane."""
    meet(GAS, faces[k], points)


@njit(**ENTRY)
def gas_look(layers, k, operators, s, stride, y, words):
    """Extremes and integrals of gas layer k: see fsipetsc.scheme.plane.look."""
    look_at_gas(GAS, layers[k], operators[0], s, places(stride), y, words)


@njit(**ENTRY)
def solid_look(layers, k, operators, s, stride, y, words):
    """Of solid layer k."""
    look_at_solid(SOLID, layers[k], operators[0], s, places(stride), y, words)


@njit(**ENTRY)
def lay_lines(layers, k, operators, s, stride, lines):
    """Put the lines of a gas layer's grid into scratch, (2, 4, width) of displacement in x, y, velocity; and their slopes."""
    layer, op, place = layers[k], operators[0], places(stride)
    a, b = columns(layer, op)
    for side in range(2):
        row = lines_of(place) + side * LINE_ROWS * stride
        for c in range(4):
            for i in range(layer.width):
                s[U64(row + c * stride + i)] = lines[side, c, i]
        for c in range(2):
            to = row + (4 + c) * stride
            along(op, s, row + c * stride, to, a, b, layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
