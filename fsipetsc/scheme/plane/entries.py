"""What Python calls of a layer in two dimensions. Compiled; for the laws GAS and SOLID, see fsipetsc.scheme.plane.laws.

layers: PLANE_LAYER records, k the number of one; operators: the operator, and that which is loose at its ends (see ``sweep``);
s: scratch, stride from one row of it to the next; y: the unknowns of the points that are held.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.coupling.plane import meet, meet_sliding, slide
from fsipetsc.operators.kernels import ENTRY, U64
from fsipetsc.operators.rows import MARGIN, along
from fsipetsc.physics.plane.gas import LINE_ROWS
from fsipetsc.scheme.plane.fields import gas_fields, solid_fields
from fsipetsc.scheme.plane.gains import edge_sums, pull
from fsipetsc.scheme.plane.geometry import lay
from fsipetsc.scheme.plane.laws import GAS, SOLID
from fsipetsc.scheme.plane.look import blended, look_at_gas, look_at_solid
from fsipetsc.scheme.plane.sweep import places, sweep
from fsipetsc.scheme.plane.targets import Target, advance


@njit(**ENTRY)
def gas_rates(layers, k, operators, s, stride, y, f, source, onward, a, base, total, b):
    """Rates of gas layer k at the points that are owned, to f or a Runge-Kutta stage: see fsipetsc.scheme.plane.targets."""
    target = Target(f, source, onward, a, base, total, b)
    sweep(GAS, layers[k], operators[0], operators[1], s, places(layers[k], stride), y, target)


@njit(**ENTRY)
def solid_rates(layers, k, operators, s, stride, y, f, source, onward, a, base, total, b):
    """Rates of solid layer k."""
    target = Target(f, source, onward, a, base, total, b)
    sweep(SOLID, layers[k], operators[0], operators[1], s, places(layers[k], stride), y, target)


@njit(**ENTRY)
def advance_ends(layers, k, f, source, onward, a, base, total, b):
    """Send on the rates f of layer k at interfaces."""
    advance(layers[k], Target(f, source, onward, a, base, total, b))


@njit(**ENTRY)
def meet_at(faces, k, points, held):
    """What gas and solid have together at points of interface k: see fsipetsc.coupling.plane."""
    meet(GAS, faces[k], points, held)


@njit(**ENTRY)
def meet_sliding_at(faces, k, points, held, normals):
    """The same where the gas slips."""
    meet_sliding(GAS, faces[k], points, held, normals)


@njit(**ENTRY)
def slide_at(faces, k, operators, points, rates, held, normals):
    """What the traction between a gas that slips and its solid adds to the rates of both: see fsipetsc.coupling.plane."""
    slide(faces[k], operators[0].norm[0], points, rates, held, normals)


@njit(**ENTRY)
def line_normals(operators, s, stride, count, first, last, h, places, points, normals):
    """N = (-y_xi, x_xi) and its rate at points of a line of ``count``, of which (x, y, u, v) are columns 5 to 8; s: 8 rows.

    places: where on the line the points are; closures stand at first and last.
    """
    for n in range(places.size):
        for c in range(4):
            s[U64(MARGIN + c * stride + places[n])] = points[n, 5 + c]
    for c in range(4):
        along(operators[0], s, MARGIN + c * stride, MARGIN + (4 + c) * stride, 0, count, first, last, 1.0 / h)
    for n in range(places.size):
        slope = MARGIN + 4 * stride + places[n]
        normals[n, 0], normals[n, 1] = -s[U64(slope + stride)], 1.0 + s[U64(slope)]
        normals[n, 2], normals[n, 3] = -s[U64(slope + 3 * stride)], s[U64(slope + 2 * stride)]


@njit(**ENTRY)
def gas_look(layers, k, operators, s, stride, y, words):
    """Extremes and integrals of gas layer k: see fsipetsc.scheme.plane.look."""
    look_at_gas(GAS, layers[k], operators[0], s, places(layers[k], stride), y, words)


@njit(**ENTRY)
def solid_look(layers, k, operators, s, stride, y, words):
    """Of solid layer k."""
    look_at_solid(SOLID, layers[k], operators[0], s, places(layers[k], stride), y, words)


@njit(**ENTRY)
def edges_of(layers, k, operators, y, words):
    """What the points at the edges of layer k have of mass, momentum and energy: see fsipetsc.scheme.plane.gains."""
    edge_sums(layers[k], operators[0], y, words)


@njit(**ENTRY)
def pull_on(layers, k, operators, y, words):
    """Momentum and energy that a body force gives to layer k over time: see fsipetsc.scheme.plane.gains."""
    pull(layers[k], operators[0], y, words)


@njit(**ENTRY)
def lay_lines(layers, k, operators, s, stride, lines):
    """Put the lines of a gas layer's grid into scratch, and what follows from them: see fsipetsc.scheme.plane.geometry."""
    lay(layers[k], operators[0], s, places(layers[k], stride), lines)


@njit(**ENTRY)
def grid_jacobian(layers, k, s, stride, J):
    """J of the grid of gas layer k at the points that are owned, whose lines stand in scratch."""
    layer, place = layers[k], places(layers[k], stride)
    low = place.lines
    high = low + LINE_ROWS * stride
    height = (layer.ny - 1) * layer.h_y
    for j in range(J.shape[0]):
        zeta = (layer.first_y + layer.own_y[0] + j) / (layer.ny - 1)
        for n in range(J.shape[1]):
            i = layer.own_x[0] + n
            x_xi, y_xi = 1.0 + blended(s, low, high, 4 * stride + i, zeta), blended(s, low, high, 5 * stride + i, zeta)
            x_eta = (s[U64(high + i)] - s[U64(low + i)]) / height
            J[j, n] = x_xi * (s[U64(high + stride + i)] - s[U64(low + stride + i)]) / height - x_eta * y_xi


@njit(**ENTRY)
def save_gas(layers, k, operators, s, stride, y, X, out):
    """What is saved of the points of gas layer k: see fsipetsc.scheme.plane.fields."""
    gas_fields(GAS, layers[k], operators[0], s, places(layers[k], stride), y, X, out)


@njit(**ENTRY)
def save_solid(layers, k, operators, s, stride, y, X, out):
    """Of solid layer k."""
    solid_fields(SOLID, layers[k], operators[0], s, places(layers[k], stride), y, X, out)
