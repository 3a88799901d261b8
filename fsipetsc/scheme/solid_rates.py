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

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable
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
from fsipetsc.operators.loops import CALL, LOOP, add, along, dot, put_node, scale, sub
from fsipetsc.operators.loops import _by_length as by_length
from fsipetsc.operators.loops import _lines as lines
from fsipetsc.operators.loops import _tuple as numbers

Array = NDArray[np.float64]
#: ((begin, end) along each axis)
Box = tuple[tuple[int, int], tuple[int, int], tuple[int, int]]
#: most nodes of a tile along each axis, for d = 1, 2, 3
TILES = ((1024, 1, 1), (128, 32, 1), (64, 16, 16))

#: of indices of arrays: signed ones might be negative, and loops with these are not vectorised
U64 = np.uint64
#: array[:, i], as many numbers as like has
column = by_length("column", "like, array, i", numbers("array[@, i]"))
put_column = by_length("put_column", "array, i, values", lines("array[@, i] = values[@]"))
#: as many of three numbers as like has
shortened = by_length("shortened", "like, a, b, c", lambda n: f" return ({', '.join('abc'[:n])},)")
#: a_k b_k
multiply = by_length("multiply", "a, b", numbers("a[@] * b[@]"))


class Scratch(NamedTuple):
    """Room for a tile: by node q, F, t^1 … t^d, T and A^k . h.

    line: 1/(2 weight) and s along axis 0. sums: pair sums of a row of nodes.
    """

    q: Array
    F: Array
    t: Array
    T: Array
    h: Array
    line: Array
    sums: Array


class Tile(NamedTuple):
    """Data of the patch, and the box where the unknowns of a tile are known."""

    metrics: Array
    bands: Any
    ghosted: tuple[int, int, int]
    known: Box


class Row(NamedTuple):
    """A row of n nodes along axis 0.

    at: number of the first in the arrays of the tile, g: in those of the patch, x: in ``line``;
    half_y, half_z, s_y, s_z: 1/(2 weight) and s of the axes across it.
    """

    n: int
    at: int
    g: int
    x: int
    half_y: float
    half_z: float
    s_y: float
    s_z: float


def solid_scratch(d: int, reach: int) -> Scratch:
    """Room for solid_rates in d dimensions with bands of this reach."""
    extent = [n + 6 * reach if k < d else 1 for k, n in enumerate(TILES[d - 1])]
    by_node = [np.zeros((count, int(np.prod(extent)))) for count in (2 * d + 1, d * d, d * d, 1, d)]
    return Scratch(*by_node, np.zeros((2, extent[0])), np.zeros((2 * d * d, extent[0])))


@njit(**CALL)
def solid_rates(solid, like, q, metrics, S0, S1, S2, w0, w1, w2, patch, rates, scratch):
    """Fill rates (M, 2d + 1) of the owned nodes of a patch.

    solid: fsipetsc.equations.solid.Solid; like: d zeros; q: (N, 2d + 1) unknowns of the nodes with
    halo; metrics: (d*d + 1, N) A^1 … A^d and J0; S0, S1, S2, w0, w1, w2: pair weights and weights
    along the axes, of the nodes with halo; patch: own, ghosted, first. The halo is of two interior
    reaches, of three for conduction with heat 'elastic'. scratch: solid_scratch(d, reach).
    """
    bands = ((S0, w0), (S1, w1), (S2, w2))
    tile, first, own = TILES[len(like) - 1], patch.first, patch.own
    for z in range(first[2], first[2] + own[2], tile[2]):
        for y in range(first[1], first[1] + own[1], tile[1]):
            for x in range(first[0], first[0] + own[0], tile[0]):
                box = (
                    (x, min(x + tile[0], first[0] + own[0])),
                    (y, min(y + tile[1], first[1] + own[1])),
                    (z, min(z + tile[2], first[2] + own[2])),
                )
                tile_rates(solid, like, q, metrics, bands, patch, box, rates, scratch)


@njit(**CALL)
def tile_rates(solid, like, q, metrics, bands, patch, box, rates, scratch):
    """Rates of the nodes of a box."""
    conducts, elastic = solid.kappa > 0.0, solid.coupled == 0.0
    near = reached(bands, box)
    wide = reached(bands, near)
    strained = wide if conducts and elastic else near
    tile = Tile(
        metrics, bands, patch.ghosted, reached(bands, wide) if conducts and elastic else wide
    )
    load_box(q, tile, scratch.q)
    fill_line(bands[0][0], bands[0][1], tile.known[0], scratch.line)
    for z in range(strained[2][0], strained[2][1]):
        for y in range(strained[1][0], strained[1][1]):
            strain_row(solid, like, tile, strained, y, z, scratch)
    if conducts:
        for z in range(wide[2][0], wide[2][1]):
            for y in range(wide[1][0], wide[1][1]):
                row = row_of(tile, wide, y, z)
                temperatures(solid, like, outer(like, like), elastic, row, scratch)
        for z in range(near[2][0], near[2][1]):
            for y in range(near[1][0], near[1][1]):
                heat_row(solid, like, tile, near, wide, y, z, scratch)
    for z in range(box[2][0], box[2][1]):
        for y in range(box[1][0], box[1][1]):
            own = ((z - patch.first[2]) * patch.own[1] + y - patch.first[1]) * patch.own[0]
            own += box[0][0] - patch.first[0]
            rates_row(solid, like, tile, box, near, y, z, conducts, rates, own, scratch)


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
def row_of(tile, box, y, z):
    """The row of a box at y, z."""
    (begin, end), known, bands = box[0], tile.known, tile.bands
    nx, ny = known[0][1] - known[0][0], known[1][1] - known[1][0]
    x = begin - known[0][0]
    at = ((z - known[2][0]) * ny + y - known[1][0]) * nx + x
    g = (z * tile.ghosted[1] + y) * tile.ghosted[0] + begin
    half_y, half_z = 0.5 / bands[1][1][y], 0.5 / bands[2][1][z]
    s_y, s_z = sum_of_weights(bands[1][0], y), sum_of_weights(bands[2][0], z)
    return Row(end - begin, at, g, x, half_y, half_z, s_y, s_z)


@njit(**CALL)
def sum_of_weights(S, i):
    """s_i."""
    s = 0.0
    for n in range(1, S.shape[0]):
        s += S[n, i] - (S[n, i - n] if i >= n else 0.0)
    return s


@register_jitable
def factors(like, line, row, i):
    """1/(2 weight) and s of each axis, at a node of a row."""
    half = shortened(like, line[0, U64(row.x + i)], row.half_y, row.half_z)
    return half, shortened(like, line[1, U64(row.x + i)], row.s_y, row.s_z)


@njit(**CALL)
def load_box(q, tile, to):
    """Take the interlaced unknowns of the known nodes apart."""
    for z in range(tile.known[2][0], tile.known[2][1]):
        for y in range(tile.known[1][0], tile.known[1][1]):
            row = row_of(tile, tile.known, y, z)
            take_apart(q, row.g, to, row.at, row.n)


@njit(**LOOP)
def take_apart(q, g, to, at, n):
    for i in range(n):
        for c in range(q.shape[1]):
            to[c, U64(at + i)] = q[U64(g + i), c]


@njit(**CALL)
def fill_line(S, w, nodes, line):
    """1/(2 weight) and s of a range of nodes."""
    for i in range(nodes[0], nodes[1]):
        line[0, i - nodes[0]] = 0.5 / w[i]
        line[1, i - nodes[0]] = sum_of_weights(S, i)


@njit(**CALL)
def pair_sums(tile, k, f, first, count, row, box, here, y, z, out, to):
    """out[to + c] = S f[first + c] along the axis k for a row of the box here, c < count.

    box: where f is known.
    """
    S, known = tile.bands[k][0], tile.known
    nx, ny = known[0][1] - known[0][0], known[1][1] - known[1][0]
    if k == 0:
        before, after = here[0][0] - box[0][0], box[0][1] - here[0][1]
        sums_along(S, here[0][0], f, first, row.at, count, row.n, before, after, out, to)
    else:
        i = y if k == 1 else z
        step, before, after = nx if k == 1 else nx * ny, i - box[k][0], box[k][1] - 1 - i
        sums_across(S, i, f, first, row.at, step, count, row.n, before, after, out, to)


@njit(**LOOP)
def sums_along(S, x, f, first, at, count, n, before, after, out, to):
    """Pair sums along a row; before, after: how many values of f are known beside it."""
    for c in range(count):
        a, b = U64(first + c), U64(to + c)
        for i in range(n):
            out[b, i] = 0.0
        for m in range(1, S.shape[0]):
            begin, end = max(0, m - before), min(n, n + after - m)
            for i in range(begin, end):
                ahead = S[m, U64(x + i)] * f[a, U64(at + i + m)]
                out[b, U64(i)] += ahead - S[m, U64(x + i - m)] * f[a, U64(at + i - m)]
            for i in range(min(begin, end)):
                out[b, U64(i)] += S[m, U64(x + i)] * f[a, U64(at + i + m)]
            for i in range(max(begin, end), n):
                out[b, U64(i)] -= S[m, U64(x + i - m)] * f[a, U64(at + i - m)]


@njit(**LOOP)
def sums_across(S, y, f, first, at, step, count, n, before, after, out, to):
    """Pair sums of a row with others; step: distance of neighbours; before, after: rows known."""
    for c in range(count):
        a, b = U64(first + c), U64(to + c)
        for i in range(n):
            out[b, i] = 0.0
        for m in range(1, S.shape[0]):
            ahead = S[m, y] if m <= after else 0.0
            behind = S[m, y - m] if m <= before else 0.0
            up, down = at + m * step * (m <= after), at - m * step * (m <= before)
            if ahead != 0.0 or behind != 0.0:
                for i in range(n):
                    above, below = f[a, U64(up + i)], f[a, U64(down + i)]
                    out[b, i] += ahead * above - behind * below


@njit(**CALL)
def strain_row(solid, like, tile, strained, y, z, scratch):
    """F and t^k of a row."""
    row, d, nine = row_of(tile, strained, y, z), len(like), outer(like, like)
    for k in range(d):
        pair_sums(tile, k, scratch.q, 0, d, row, tile.known, strained, y, z, scratch.sums, k * d)
    deform(like, nine, tile.metrics, row, scratch)
    pull(solid, like, nine, tile.metrics, row, scratch)


@njit(**LOOP)
def deform(like, nine, metrics, row, scratch):
    """F = 1 + 1/J0 sum_k D_k D A^k."""
    d = len(like)
    line, q, sums, F = scratch.line, scratch.q, scratch.sums, scratch.F
    for i in range(row.n):
        half, s = factors(like, line, row, i)
        D = column(like, q, U64(row.at + i))
        slopes = sub(column(nine, sums, U64(i)), outer(s, D))
        A, J0 = column(nine, metrics, U64(row.g + i)), metrics[d * d, U64(row.g + i)]
        F = add_unit(1.0, transposed_product(slopes, scale_rows(scale(1.0 / J0, half), A)))
        put_column(F, U64(row.at + i), F)


@njit(**LOOP)
def pull(solid, like, nine, metrics, row, scratch):
    """t^k = P A^k."""
    d = len(like)
    F, q, t = scratch.F, scratch.q, scratch.t
    velocity = q[d:]
    for i in range(row.n):
        F, v = column(nine, F, U64(row.at + i)), column(like, velocity, U64(row.at + i))
        P = solid.stress_at(F, solid.temperature(v, q[2 * d, U64(row.at + i)], F))
        t = product_transposed(column(nine, metrics, U64(row.g + i)), P)
        put_column(t, U64(row.at + i), t)


@njit(**LOOP)
def temperatures(solid, like, nine, elastic, row, scratch):
    """T; with heat 'coupled' F does not matter, and may be unknown."""
    d = len(like)
    q, T, F = scratch.q, scratch.T, scratch.F
    velocity = q[d:]
    unit = add_unit(1.0, nine)
    for i in range(row.at, row.at + row.n):
        v, e = column(like, velocity, U64(i)), q[2 * d, U64(i)]
        T[0, U64(i)] = solid.temperature(v, e, unit)
    if elastic:
        for i in range(row.at, row.at + row.n):
            v, e = column(like, velocity, U64(i)), q[2 * d, U64(i)]
            T[0, U64(i)] = solid.temperature(v, e, column(nine, F, U64(i)))


@njit(**CALL)
def heat_row(solid, like, tile, near, warm, y, z, scratch):
    """A^k . h of a row, from T in the box warm."""
    row = row_of(tile, near, y, z)
    for k in range(len(like)):
        pair_sums(tile, k, scratch.T, 0, 1, row, warm, near, y, z, scratch.sums, k)
    conduct(solid, like, outer(like, like), tile.metrics, row, scratch)


@njit(**LOOP)
def conduct(solid, like, nine, metrics, row, scratch):
    """A^k . h with grad T = 1/J0 sum_k A^k D_k T."""
    d = len(like)
    line, T, sums, F, h = scratch.line, scratch.T, scratch.sums, scratch.F, scratch.h
    for i in range(row.n):
        half, s = factors(like, line, row, i)
        T, J0 = T[0, U64(row.at + i)], metrics[d * d, U64(row.g + i)]
        slopes = multiply(half, along(column(like, sums, U64(i)), -T, s))
        A = column(nine, metrics, U64(row.g + i))
        gradient = scale(1.0 / J0, apply_transposed(A, slopes))
        h = solid.heat_flux(column(nine, F, U64(row.at + i)), gradient)
        put_column(h, U64(row.at + i), apply(A, h))


@njit(**CALL)
def rates_row(solid, like, tile, box, near, y, z, conducts, rates, own, scratch):
    """Rates of a row of nodes; own: number of the first in rates."""
    row, d, sums = row_of(tile, box, y, z), len(like), scratch.sums
    for k in range(d):
        pair_sums(tile, k, scratch.t, k * d, d, row, near, box, y, z, sums, k * d)
        pair_sums(tile, k, scratch.q, d, d, row, tile.known, box, y, z, sums, (d + k) * d)
    accelerate(solid, like, outer(like, like), tile.metrics, row, rates, own, scratch)
    if conducts:
        for k in range(d):
            pair_sums(tile, k, scratch.h, k, 1, row, near, box, y, z, sums, k)
        warm(solid, like, tile.metrics, row, rates, own, scratch)


@njit(**LOOP)
def accelerate(solid, like, nine, metrics, row, rates, own, scratch):
    """(v, Div P/m0 + b, Div (P^T v)/m0 + b . v)."""
    d = len(like)
    line, t, q, sums = scratch.line, scratch.t, scratch.q, scratch.sums
    of_velocity = sums[d * d :]
    velocity = q[d:]
    for i in range(row.n):
        half, s = factors(like, line, row, i)
        per_mass = 1.0 / (metrics[d * d, U64(row.g + i)] * solid.m0)
        t, v = column(nine, t, U64(row.at + i)), column(like, velocity, U64(row.at + i))
        of_t, of_v = column(nine, sums, U64(i)), column(nine, of_velocity, U64(i))
        force = apply_transposed(add(of_t, scale_rows(s, t)), half)
        power = dot(scale_rows(half, of_v), t) + dot(apply_transposed(of_t, half), v)
        acceleration = along(solid.force, per_mass, force)
        energy = per_mass * power + dot(solid.force, v)
        put_node(rates, U64(own + i), (*v, *acceleration, energy))


@njit(**LOOP)
def warm(solid, like, metrics, row, rates, own, scratch):
    """Add Div h/m0 to the rate of energy."""
    d = len(like)
    line, h, sums = scratch.line, scratch.h, scratch.sums
    for i in range(row.n):
        half, s = factors(like, line, row, i)
        h = multiply(s, column(like, h, U64(row.at + i)))
        heat = dot(half, add(column(like, sums, U64(i)), h))
        rates[U64(own + i), 2 * d] += heat / (metrics[d * d, U64(row.g + i)] * solid.m0)
