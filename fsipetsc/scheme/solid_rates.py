"""Rates of the nodes of a solid block, boundary-flux-free, tile by tile.

fsipetsc.equations.solid has the equations, fsipetsc.operators.bands the weights S_il of pairs. With
the pair sums of an axis

    (S f)_i = sum_l S_il f_l,      s_i = sum_l S_il  (not 0 only near the ends)

the derivative of f is (S f - s f)/(2 weight), that without the flux through the ends is
(S f + s f)/(2 weight), and the power of the tractions t^k = P A^k is

    sum_l S_il (t_i . v_l + t_l . v_i)/2 = (t . S v + v . S t)/2,    divided by the weight.

A tile is a box of nodes. F and t^k are found in the box that its pairs reach, from unknowns in the
box that these reach in turn; conduction reaches once more. What two tiles need is found twice, by
the same operations: rates do not depend on the tiles, nor on how a block is cut.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit, types
from numba.extending import overload, register_jitable
from numpy.typing import NDArray

from fsipetsc.equations.tensors import (
    add_unit,
    apply,
    apply_transposed,
    outer,
    product_transposed,
    scale_rows,
    transposed_product,
)
from fsipetsc.operators.loops import CALL, LOOP, add, along, column, dot, scale, sub
from fsipetsc.operators.loops import _by_length as by_length
from fsipetsc.operators.loops import _lines as each
from fsipetsc.operators.loops import _tuple as numbers

Array = NDArray[np.float64]
#: most nodes of a tile along each axis, for d = 1, 2, 3
TILES = ((1024, 1, 1), (128, 32, 1), (64, 16, 16))
#: rows of Scratch.lines: 1/(2 weight), s, and of each distance the weights ahead and behind
HALF, ONE, PAIRS = 0, 1, 2
#: indices of arrays: with signed ones, which might be negative, LLVM makes no vector code
U64 = np.uint64

put_column = by_length("put_column", "array, i, values", each("array[@, i] = values[@]"))
#: as many of three numbers as like has
first_of = by_length("first_of", "like, a, b, c", lambda n: f" return ({','.join('abc'[:n])},)")
#: a_k b_k
multiply = by_length("multiply", "a, b", numbers("a[@] * b[@]"))


class Scratch(NamedTuple):
    """Room for a tile, by node of a box of their own behind a margin, and for a row of nodes.

    unknowns: q, strains: F, tractions: t^1 … t^d, temps: T, heats: A^k . h. lines: (3, rows, nodes)
    data of the axes. sums, found: pair sums and rates of a row.
    """

    unknowns: Array
    strains: Array
    tractions: Array
    temps: Array
    heats: Array
    lines: Array
    sums: Array
    found: Array


class Row(NamedTuple):
    """n nodes along axis 0; g: number of the first in the patch; x, y, z: its places in lines."""

    n: int
    g: int
    x: int
    y: int
    z: int


def solid_scratch(d: int, reach: int) -> Scratch:
    """Room for solid_rates in d dimensions with bands of this reach."""
    extent = [n + 6 * reach if k < d else 1 for k, n in enumerate(TILES[d - 1])]
    size = int(np.prod(extent)) + 2 * even(reach)
    by_node = [np.zeros((count, size)) for count in (2 * d + 1, d * d, d * d, 1, d)]
    lines = np.zeros((3, PAIRS + 2 * even(reach), max(extent)))
    return Scratch(
        *by_node, lines, np.zeros((2 * d * d, extent[0])), np.zeros((2 * d + 1, extent[0]))
    )


@register_jitable
def even(n):
    """The even number that is not below n."""
    return n + n % 2


@njit(**CALL)
def solid_rates(solid, like, q, metrics, S0, S1, S2, w0, w1, w2, patch, rates, scratch):
    """Fill rates (M, 2d + 1) of the owned nodes of a patch.

    solid: fsipetsc.equations.solid.Solid; like: d zeros; q: (N, 2d + 1) unknowns of the nodes with
    halo; metrics: (d*d + 1, N) A^1 … A^d and J0; S0, S1, S2, w0, w1, w2: pair weights and weights
    along the axes, of the nodes with halo; patch: own, ghosted, first. The halo is of two interior
    reaches, of three for conduction with heat 'elastic'. scratch: solid_scratch(d, reach).
    """
    bands = ((S0, w0), (S1, w1), (S2, w2))
    most, first, own = TILES[len(like) - 1], patch.first, patch.own
    for z in range(first[2], first[2] + own[2], most[2]):
        for y in range(first[1], first[1] + own[1], most[1]):
            for x in range(first[0], first[0] + own[0], most[0]):
                box = (
                    (x, min(x + most[0], first[0] + own[0])),
                    (y, min(y + most[1], first[1] + own[1])),
                    (z, min(z + most[2], first[2] + own[2])),
                )
                tile_rates(solid, like, q, metrics, bands, patch, box, rates, scratch)


@njit(**CALL)
def tile_rates(solid, like, q, metrics, bands, patch, box, rates, scratch):
    """Rates of the nodes of a box, ((begin, end) along each axis)."""
    conducts, elastic = solid.kappa > 0.0, solid.coupled == 0.0
    near = reached(bands, box)
    warm = reached(bands, near)
    strained = warm if conducts and elastic else near
    known = reached(bands, warm) if conducts and elastic else warm
    spans = fill_lines(bands, known, scratch.lines)
    load(q, patch, known, scratch)
    for z in range(strained[2][0], strained[2][1]):
        for y in range(strained[1][0], strained[1][1]):
            strain_row(solid, like, metrics, patch, spans, strained, known, y, z, scratch)
    if conducts:
        for z in range(warm[2][0], warm[2][1]):
            for y in range(warm[1][0], warm[1][1]):
                warm_row(solid, like, patch, elastic, warm, strained, known, y, z, scratch)
        for z in range(near[2][0], near[2][1]):
            for y in range(near[1][0], near[1][1]):
                heat_row(
                    solid, like, metrics, patch, spans, near, warm, strained, known, y, z, scratch
                )
    for z in range(box[2][0], box[2][1]):
        for y in range(box[1][0], box[1][1]):
            row = rate_row(solid, like, metrics, patch, spans, box, strained, known, y, z, scratch)
            if conducts:
                add_heat(solid, like, metrics, spans, box, near, row, y, z, scratch)
            give(scratch.found, rates, owned(patch, box[0][0], y, z), row.n)


@njit(**CALL)
def reached(bands, box):
    """The box of nodes that are in pairs with nodes of a box."""
    return (
        reached_along(bands[0][0], box[0]),
        reached_along(bands[1][0], box[1]),
        reached_along(bands[2][0], box[2]),
    )


@njit(**CALL)
def reached_along(S, nodes):
    """The range of nodes that are in pairs with a range of nodes."""
    begin, end = nodes
    lowest, highest = begin, end
    for n in range(1, S.shape[0]):
        for i in range(max(end - n, begin), end):
            if S[n, i] != 0.0:
                highest = max(highest, i + n + 1)
        for i in range(max(begin, n), min(begin + n, end)):
            if S[n, i - n] != 0.0:
                lowest = min(lowest, i - n)
    return lowest, min(highest, S.shape[1])


@njit(**CALL)
def fill_lines(bands, known, lines):
    """Data of the axes for the nodes of a box; the largest distance of a pair along each axis."""
    return (
        fill_line(bands[0][0], bands[0][1], known[0], lines[0]),
        fill_line(bands[1][0], bands[1][1], known[1], lines[1]),
        fill_line(bands[2][0], bands[2][1], known[2], lines[2]),
    )


@njit(**CALL)
def fill_line(S, w, nodes, line):
    """1/(2 weight), s and weights of pairs of a range of nodes; the largest distance of a pair."""
    span = 0
    for i in range(nodes[0], nodes[1]):
        line[HALF, i - nodes[0]], s = 0.5 / w[i], 0.0
        for n in range(1, S.shape[0]):
            ahead, behind = S[n, i], -S[n, i - n] if i >= n else 0.0
            line[PAIRS + 2 * n - 2, i - nodes[0]] = ahead
            line[PAIRS + 2 * n - 1, i - nodes[0]] = behind
            s += ahead + behind
            if ahead != 0.0 or behind != 0.0:
                span = max(span, n)
        line[ONE, i - nodes[0]] = s
    return span


@njit(**CALL)
def row_of(patch, box, known, y, z):
    """The row of a box at y, z."""
    x = box[0][0]
    g = (z * patch.ghosted[1] + y) * patch.ghosted[0] + x
    return Row(box[0][1] - x, g, x - known[0][0], y - known[1][0], z - known[2][0])


@njit(**CALL)
def owned(patch, x, y, z):
    """Number of a node in rates."""
    own, first = patch.own, patch.first
    return ((z - first[2]) * own[1] + y - first[1]) * own[0] + x - first[0]


@njit(**CALL)
def index(lines, box, x, y, z):
    """Number of a node in the arrays of a box, whose margin is as wide as pairs are long."""
    (x0, x1), (y0, y1), (z0, _) = box
    return lines.shape[1] // 2 + ((z - z0) * (y1 - y0) + y - y0) * (x1 - x0) + x - x0


@njit(**CALL)
def load(q, patch, known, scratch):
    """Take the interlaced unknowns apart."""
    for z in range(known[2][0], known[2][1]):
        for y in range(known[1][0], known[1][1]):
            row = row_of(patch, known, known, y, z)
            at = index(scratch.lines, known, known[0][0], y, z)
            take(q, row.g, scratch.unknowns, at, row.n)


@njit(**LOOP)
def take(q, g, unknowns, at, n):
    """From interlaced numbers."""
    for c in range(q.shape[1]):
        for i in range(n):
            unknowns[U64(c), U64(at + i)] = q[U64(g + i), U64(c)]


@njit(**LOOP)
def give(found, rates, first, n):
    """To interlaced numbers."""
    for c in range(rates.shape[1]):
        for i in range(n):
            rates[U64(first + i), U64(c)] = found[U64(c), U64(i)]


@njit(**CALL)
def pair_sums(like, k, span, row, f, box, lines, x, y, z, out):
    """out = S f along the axis k, of the numbers f of the nodes of a row of n that begins at x, y, z.

    box: that of f. Two distances at a time; pairs that are not there have the weight 0.
    """
    nx, ny = box[0][1] - box[0][0], box[1][1] - box[1][0]
    at, step = index(lines, box, x, y, z), 1 if k == 0 else nx if k == 1 else nx * ny
    i, line = row.x if k == 0 else row.y if k == 1 else row.z, lines[k]
    for m in range(1, span + 1, 2):
        w = PAIRS + 2 * m - 2
        if k == 0:
            end = i + row.n
            weights = line[w, i:end], line[w + 1, i:end], line[w + 2, i:end], line[w + 3, i:end]
            far = (m + 1) * (m + 1 <= span)
            add_pairs(like, f, at, m, -m, far, -far, weights, m == 1, out, row.n)
        else:
            a, b, c, d = line[w, i], line[w + 1, i], line[w + 2, i], line[w + 3, i]
            ahead, behind = m * step * (a != 0.0), -m * step * (b != 0.0)
            farther, back = (m + 1) * step * (c != 0.0), -(m + 1) * step * (d != 0.0)
            add_pairs(like, f, at, ahead, behind, farther, back, (a, b, c, d), m == 1, out, row.n)


def weight(weights, i):
    """A number, or one of an array."""
    return weights[i] if isinstance(weights, np.ndarray) else weights


@overload(weight)
def _weight(weights, i):
    if isinstance(weights, types.Array):
        return lambda weights, i: weights[i]
    return lambda weights, i: weights


@register_jitable
def four_pairs(like, f, ahead, behind, farther, back, weights, i):
    """The sum over four nodes."""
    value = scale(weight(weights[0], i), column(like, f, U64(ahead)))
    value = along(value, weight(weights[1], i), column(like, f, U64(behind)))
    value = along(value, weight(weights[2], i), column(like, f, U64(farther)))
    return along(value, weight(weights[3], i), column(like, f, U64(back)))


@njit(**LOOP)
def add_pairs(like, f, at, ahead, behind, farther, back, weights, fresh, out, n):
    """Pair sums of n nodes with four others each, from their distances in f."""
    a, b, c, d = at + ahead, at + behind, at + farther, at + back
    if fresh:
        for i in range(n):
            put_column(out, i, four_pairs(like, f, a + i, b + i, c + i, d + i, weights, U64(i)))
    else:
        for i in range(n):
            value = four_pairs(like, f, a + i, b + i, c + i, d + i, weights, U64(i))
            put_column(out, i, add(column(like, out, i), value))


@register_jitable
def factors(like, lines, row, i):
    """1/(2 weight) and s of each axis at a node of a row."""
    x, y, z = U64(row.x + i), U64(row.y), U64(row.z)
    half = first_of(like, lines[0, HALF, x], lines[1, HALF, y], lines[2, HALF, z])
    return half, first_of(like, lines[0, ONE, x], lines[1, ONE, y], lines[2, ONE, z])


@njit(**CALL)
def strain_row(solid, like, metrics, patch, spans, strained, known, y, z, scratch):
    """F and t^k of a row."""
    d, x, nine, lines = len(like), strained[0][0], outer(like, like), scratch.lines
    row, unknowns, sums = row_of(patch, strained, known, y, z), scratch.unknowns, scratch.sums
    for k in range(d):
        pair_sums(like, k, spans[k], row, unknowns, known, lines, x, y, z, sums[k * d :])
    at, to = index(lines, known, x, y, z), index(lines, strained, x, y, z)
    deform(like, nine, metrics, row, lines, sums, unknowns, at, scratch.strains, to)
    pull(solid, like, nine, metrics, row, unknowns, at, scratch.strains, scratch.tractions, to)


@njit(**LOOP)
def deform(like, nine, metrics, row, lines, sums, unknowns, at, strains, to):
    """F = 1 + 1/J0 sum_k D_k D A^k."""
    for i in range(row.n):
        g, (half, s) = U64(row.g + i), factors(like, lines, row, i)
        slopes = sub(column(nine, sums, i), outer(s, column(like, unknowns, U64(at + i))))
        per_J0 = 1.0 / metrics[len(nine), g]
        A = scale_rows(scale(per_J0, half), column(nine, metrics, g))
        put_column(strains, U64(to + i), add_unit(1.0, transposed_product(slopes, A)))


@njit(**LOOP)
def pull(solid, like, nine, metrics, row, unknowns, at, strains, tractions, to):
    """t^k = P A^k."""
    d = len(like)
    velocities = unknowns[d:]
    for i in range(row.n):
        F, v = column(nine, strains, U64(to + i)), column(like, velocities, U64(at + i))
        T = solid.temperature(v, unknowns[2 * d, U64(at + i)], F)
        A = column(nine, metrics, U64(row.g + i))
        put_column(tractions, U64(to + i), product_transposed(A, solid.stress_at(F, T)))


@njit(**CALL)
def warm_row(solid, like, patch, elastic, warm, strained, known, y, z, scratch):
    """T of a row."""
    x, lines, n = warm[0][0], scratch.lines, warm[0][1] - warm[0][0]
    at, to = index(lines, known, x, y, z), index(lines, warm, x, y, z)
    nine, unknowns, temps = outer(like, like), scratch.unknowns, scratch.temps
    if elastic:  # F is known in the same box
        temperatures(solid, like, nine, unknowns, at, scratch.strains, temps, to, n)
    else:
        coupled_temperatures(solid, like, nine, unknowns, at, temps, to, n)


@njit(**LOOP)
def temperatures(solid, like, nine, unknowns, at, strains, temps, to, n):
    """T with heat 'elastic'."""
    d = len(like)
    velocities = unknowns[d:]
    for i in range(n):
        v, F = column(like, velocities, U64(at + i)), column(nine, strains, U64(to + i))
        temps[0, U64(to + i)] = solid.temperature(v, unknowns[2 * d, U64(at + i)], F)


@njit(**LOOP)
def coupled_temperatures(solid, like, nine, unknowns, at, temps, to, n):
    """T with heat 'coupled', for which F does not matter."""
    d = len(like)
    velocities, F = unknowns[d:], add_unit(1.0, nine)
    for i in range(n):
        v, e = column(like, velocities, U64(at + i)), unknowns[2 * d, U64(at + i)]
        temps[0, U64(to + i)] = solid.temperature(v, e, F)


@njit(**CALL)
def heat_row(solid, like, metrics, patch, spans, near, warm, strained, known, y, z, scratch):
    """A^k . h of a row."""
    x, lines, temps, sums = near[0][0], scratch.lines, scratch.temps, scratch.sums
    row = row_of(patch, near, known, y, z)
    for k in range(len(like)):
        pair_sums((0.0,), k, spans[k], row, temps, warm, lines, x, y, z, sums[k:])
    at, to = index(lines, warm, x, y, z), index(lines, near, x, y, z)
    strains, F = scratch.strains, index(lines, strained, x, y, z)
    conduct(
        solid,
        like,
        outer(like, like),
        metrics,
        row,
        lines,
        sums,
        temps,
        at,
        strains,
        F,
        scratch.heats,
        to,
    )


@njit(**LOOP)
def conduct(solid, like, nine, metrics, row, lines, sums, temps, at, strains, F, heats, to):
    """A^k . h with grad T = 1/J0 sum_k A^k D_k T."""
    for i in range(row.n):
        g, (half, s) = U64(row.g + i), factors(like, lines, row, i)
        differences = along(column(like, sums, i), -temps[0, U64(at + i)], s)
        per_J0, A = 1.0 / metrics[len(nine), g], column(nine, metrics, g)
        gradient = apply_transposed(A, scale(per_J0, multiply(half, differences)))
        h = solid.heat_flux(column(nine, strains, U64(F + i)), gradient)
        put_column(heats, U64(to + i), apply(A, h))


@njit(**CALL)
def rate_row(solid, like, metrics, patch, spans, box, strained, known, y, z, scratch):
    """Rates of a row without conduction, to scratch.found; the row."""
    d, x, nine, lines = len(like), box[0][0], outer(like, like), scratch.lines
    row, sums, t, q = (
        row_of(patch, box, known, y, z),
        scratch.sums,
        scratch.tractions,
        scratch.unknowns,
    )
    for k in range(d):
        pair_sums(like, k, spans[k], row, t[k * d :], strained, lines, x, y, z, sums[k * d :])
        pair_sums(like, k, spans[k], row, q[d:], known, lines, x, y, z, sums[(d + k) * d :])
    at, tractions = index(lines, known, x, y, z), index(lines, strained, x, y, z)
    accelerate(solid, like, nine, metrics, row, lines, sums, q, at, t, tractions, scratch.found)
    return row


@njit(**LOOP)
def accelerate(solid, like, nine, metrics, row, lines, sums, unknowns, at, tractions, t_at, found):
    """(v, Div P/m0 + b, Div (P^T v)/m0 + b . v)."""
    velocities, velocity_sums = unknowns[len(like) :], sums[len(nine) :]
    for i in range(row.n):
        half, s = factors(like, lines, row, i)
        per_mass = 1.0 / (metrics[len(nine), U64(row.g + i)] * solid.m0)
        t, v = column(nine, tractions, U64(t_at + i)), column(like, velocities, U64(at + i))
        of_t, of_v = column(nine, sums, i), column(nine, velocity_sums, i)
        force = apply_transposed(add(of_t, scale_rows(s, t)), half)
        power = dot(scale_rows(half, of_v), t) + dot(apply_transposed(of_t, half), v)
        acceleration = along(solid.force, per_mass, force)
        put_column(found, i, (*v, *acceleration, per_mass * power + dot(solid.force, v)))


@njit(**CALL)
def add_heat(solid, like, metrics, spans, box, near, row, y, z, scratch):
    """Add conduction to the rates of a row."""
    x, lines, heats, sums = box[0][0], scratch.lines, scratch.heats, scratch.sums
    for k in range(len(like)):
        pair_sums((0.0,), k, spans[k], row, heats[k:], near, lines, x, y, z, sums[k:])
    heat_up(
        solid, like, metrics, row, lines, sums, heats, index(lines, near, x, y, z), scratch.found
    )


@njit(**LOOP)
def heat_up(solid, like, metrics, row, lines, sums, heats, at, found):
    """Add Div h/m0."""
    d = len(like)
    for i in range(row.n):
        half, s = factors(like, lines, row, i)
        per_mass = 1.0 / (metrics[d * d, U64(row.g + i)] * solid.m0)
        h = multiply(s, column(like, heats, U64(at + i)))
        found[2 * d, i] += per_mass * dot(half, add(column(like, sums, i), h))
