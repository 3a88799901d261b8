"""What Python calls of a layer in two dimensions. Compiled; for the laws GAS and SOLID, see fsipetsc.scheme.plane.laws.

layers: PLANE_LAYER records, k the number of one; operators: the operator, and that which is loose at its ends (see ``sweep``);
s: scratch; y: the unknowns of the points that are held; lines: (2, 4, columns held), displacement in x, y, and velocity of the
lower and the upper line of a gas's grid.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.coupling.plane import meet, meet_sliding, slide
from fsipetsc.operators.kernels import ENTRY
from fsipetsc.scheme.burst import goes_on
from fsipetsc.scheme.plane.account import give_account, give_bounds, put_away, put_away_behind
from fsipetsc.scheme.plane.fields import gas_fields, solid_fields
from fsipetsc.scheme.plane.gains import edge_sums
from fsipetsc.scheme.plane.geometry import find_normals, jacobian, lay
from fsipetsc.scheme.plane.joints import hold, join, load, note_gains, note_power
from fsipetsc.scheme.plane.laws import GAS, SOLID
from fsipetsc.scheme.plane.look import look_at_gas, look_at_solid
from fsipetsc.scheme.plane.sweep import block_width, place_of, sweep
from fsipetsc.scheme.plane.targets import Target, advance


@njit(**ENTRY)
def gas_rates(layers, k, operators, s, y, lines, f, source, onward, base, total, stages, kept, a, b):
    """Rates of gas layer k at the points that are owned, to f or a Runge-Kutta stage: see fsipetsc.scheme.plane.targets."""
    target = Target(f, source, onward, a, base, total, b, stages, kept)
    sweep(GAS, layers[k], operators[0], operators[1], s, y, lines, target)


@njit(**ENTRY)
def solid_rates(layers, k, operators, s, y, lines, f, source, onward, base, total, stages, kept, a, b):
    """Rates of solid layer k."""
    target = Target(f, source, onward, a, base, total, b, stages, kept)
    sweep(SOLID, layers[k], operators[0], operators[1], s, y, lines, target)


@njit(**ENTRY)
def settle(layers, k, operators, y, points, joined, lines, heights, held, numbers, sums):
    """What interfaces and edges make of the points of layer k: see fsipetsc.scheme.plane.joints.

    sums: (3, GAINED) for what the points at the edges have of mass, momentum and energy before, between and after, or (0, ...).
    """
    layer, op = layers[k], operators[0]
    if sums.shape[0] > 0:
        edge_sums(layer, op, y, sums[0])
    join(layer, y, points, joined, lines, heights)
    if sums.shape[0] > 0:
        edge_sums(layer, op, y, sums[1])
    hold(GAS, layer, y, held, numbers)
    if sums.shape[0] > 0:
        edge_sums(layer, op, y, sums[2])


@njit(**ENTRY)
def end_stage(
    layers, k, operators, y, f, tractions, loaded, kinetic, words, changes, at, source, onward, base, total, stages, kept, a, b
):
    """What is left to do when the rates f of layer k are there: interfaces, and the rates of what stands behind the layers.

    words: (GAINED,) of room; changes: the rates of all that the rank has, at: where those of what the layer gains are.
    """
    layer, op = layers[k], operators[0]
    load(layer, op, f, tractions, loaded)
    note_power(layer, y, f, kinetic, changes)
    note_gains(layer, op, y, words, changes, at)
    if onward.size > 0:
        advance(layer, Target(f, source, onward, a, base, total, b, stages, kept))


@njit(**ENTRY)
def advance_behind(changes, source, onward, base, total, a, b):
    """The same stage for what stands behind the layers."""
    for n in range(changes.size):
        onward[n] = source[n] + a * changes[n]
        if total.size > 0:
            total[n] = base[n] + b * changes[n]


@njit(**ENTRY)
def meet_at(faces, k, points, held):
    """What gas and solid have together at points of interface k: see fsipetsc.coupling.plane."""
    meet(GAS, faces[k], points, held)


@njit(**ENTRY)
def meet_sliding_at(faces, k, points, held, operators, normals, s, stride, count, first, last, h, places):
    """The same where the gas slips, with the normals of the line: see ``find_normals``."""
    find_normals(operators[0], points, normals, s, stride, count, first, last, h, places)
    meet_sliding(GAS, faces[k], points, held, normals)


@njit(**ENTRY)
def slide_at(faces, sliding, operators, points, rates, held, normals):
    """What the traction between a gas that slips and its solid adds to the rates of both: see fsipetsc.coupling.plane.

    sliding: (n, 2), interface and number of a point.
    """
    for n in range(sliding.shape[0]):
        k, point = sliding[n]
        slide(faces[k], operators[0].norm[0], points[point], rates[n], held[point], normals[point])


@njit(**ENTRY)
def line_normals(operators, points, normals, s, stride, count, first, last, h, places):
    """Normals of another line: see ``find_normals``."""
    find_normals(operators[0], points, normals, s, stride, count, first, last, h, places)


@njit(**ENTRY)
def gas_look(layers, k, operators, s, y, lines, words, kept, mend):
    """Extremes and integrals of gas layer k: see fsipetsc.scheme.plane.look."""
    look_at_gas(GAS, layers[k], operators[0], s, y, lines, words)


@njit(**ENTRY)
def solid_look(layers, k, operators, s, y, lines, words, kept, mend):
    """Of solid layer k; kept, mend: see fsipetsc.scheme.plane.kinetic."""
    look_at_solid(SOLID, layers[k], operators[0], s, y, words, kept, mend)


@njit(**ENTRY)
def put_away_points(layers, memory, begin, starts, solution):
    """Put the points of a completed step in the solution: see fsipetsc.scheme.plane.account."""
    put_away(layers, memory, begin, starts, solution)


@njit(**ENTRY)
def put_away_others(layers, gains, sums, points, ends, state, solution):
    """Likewise what stands behind the layers."""
    put_away_behind(layers, gains, sums, points, ends, state, solution)


@njit(**ENTRY)
def plan_next(notes, memory):
    """Whether another step follows in the same burst; notes: where things stand in ``memory``. See fsipetsc.scheme.burst."""
    return goes_on(notes, memory)


@njit(**ENTRY)
def account_of(layers, words, gains, extremes, rates, account, solution):
    """Put what is known of all layers together: see fsipetsc.scheme.plane.account."""
    give_account(layers, words, gains, solution, extremes, rates, account)


@njit(**ENTRY)
def bounds_of(extremes, layers, results, least_J):
    """What bounds the next step, of all layers on all ranks: see fsipetsc.scheme.plane.account."""
    give_bounds(extremes, layers, results, least_J)


@njit(**ENTRY)
def edges_of(layers, k, operators, y, words):
    """What the points at the edges of layer k have of mass, momentum and energy: see fsipetsc.scheme.plane.gains."""
    edge_sums(layers[k], operators[0], y, words)


@njit(**ENTRY)
def grid_jacobian(layers, k, operators, s, lines, J):
    """J of the grid of gas layer k at the points that are owned."""
    layer = layers[k]
    for first in range(layer.own_x[0], layer.own_x[1], block_width(layer)):
        place = place_of(layer, first)
        lay(layer, operators[0], s, place, lines)
        jacobian(layer, s, place, J)


@njit(**ENTRY)
def save_gas(layers, k, operators, s, y, lines, X, out):
    """What is saved of the points of gas layer k: see fsipetsc.scheme.plane.fields."""
    gas_fields(GAS, layers[k], y, lines, X, out)


@njit(**ENTRY)
def save_solid(layers, k, operators, s, y, lines, X, out):
    """Of solid layer k."""
    solid_fields(SOLID, layers[k], operators[0], s, y, X, out)
