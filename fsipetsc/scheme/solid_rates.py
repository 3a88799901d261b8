"""Rates of the nodes of a solid block, boundary-flux-free, layer by layer.

fsipetsc.equations.solid has the equations, fsipetsc.operators.bands the weights S_il of pairs. With

    D_k f   = sum_l S_il (f_l - f_i) / (2 weight_i)     derivative along axis k
    D°_k f  = sum_l S_il (f_l + f_i) / (2 weight_i)     the same without the flux through the ends

and the tractions t^k = P A^k, the rates of displacement, velocity and energy are

    D_t = v,    J0 m0 v_t = sum_k D°_k t^k,    J0 m0 e_t = v . sum_k D°_k t^k + sum_k t^k . D_k v.

The power is, pair by pair, S_il (t_i . v_l + t_l . v_i)/2: nothing is lost or won.

A tile is a range of nodes along the first axis, and along the second one of three. Its layers along
the last axis are swept: a layer is loaded, F and t^k are found one reach behind, rates two reaches
behind. Arrays keep as many layers as are needed, in a ring. What two tiles need is found twice by
the same operations: rates do not depend on tiles, nor on how a block is cut.
"""

from __future__ import annotations

from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fsipetsc.equations.tensors import (
    add_unit,
    apply,
    apply_transposed,
    column_sums,
    outer,
    product_transposed,
    transposed_product,
)
from fsipetsc.operators.bands import Band
from fsipetsc.operators.loops import CALL, INNER_CALL, INNER_LOOP, add, along, dot, scale
from fsipetsc.operators.loops import _by_length as by_length
from fsipetsc.operators.patch import Patch
from fsipetsc.scheme.rows import U64, at, put

Array = NDArray[Any]
#: as numbers of numba's usual type: it compiles a function anew for each literal one
NONE, ONE = np.int64(0), np.int64(1)
PLAIN, FREE = NONE, ONE
#: most nodes of a tile along the first axis, and along the second one of three, for d = 1, 2, 3
TILES = ((1024, 1), (128, 1), (64, 16))
#: longest pairs of all operators; nodes of a row with all that they reach
REACH = 7
WIDTH = U64(1024 + 6 * REACH)
#: numbers between components of the nodes of a tile, for d = 1, 2, 3. LLVM makes vector code of loops
#: that store many components only if it knows how far they are apart
STEPS = 1096, 29 * 170 + 6, 29 * 58 * 106 + 12
step_of = by_length("step_of", "like", lambda d: f" return {STEPS[d - 1]}")
#: what is known of a tile's nodes: rates, t^k and heats, T, F, unknowns
OWN, NEAR, WARM, STRAINED, KNOWN = map(U64, range(5))

#: sum of weights w times f at some places, i nodes on
weighted = by_length(
    "weighted",
    "w, f, places, i",
    lambda n: " return " + " + ".join(f"w[{k}] * f[places[{k}] + i]" for k in range(n)),
)
#: a_1 + … + a_d
total = by_length("total", "a", lambda d: " return " + " + ".join(f"a[{k}]" for k in range(d)))


class Layout(NamedTuple):
    """Of a tile's arrays, row, layer: nodes of a row and of a layer; layers: how many are kept.

    begin, end: nodes of the first axis with the same neighbours, those of the interior.
    """

    row: int
    layer: int
    layers: int
    begin: int
    end: int


class Row(NamedTuple):
    """n nodes along the first axis from x, y, z on: numbers of the first one in arrays.

    patch, own: in those of a patch, and of its owned nodes; tile: in those of a tile, whose layer
    ``place`` it is in. From its node ``begin`` to ``end`` all have the neighbours of the interior.
    """

    n: int
    patch: int
    own: int
    tile: int
    x: int
    y: int
    z: int
    place: int
    begin: int
    end: int


class Work(NamedTuple):
    """What solid_rates knows of a patch, and its memory. The axes are first, inner and last one.

    patch: in this order. lags: layers from loading to t^k, conduction, rates. boxes: (tiles, 5, 3, 2)
    first node and first beyond of OWN … KNOWN. jumps: (3, n, 1 + most) of each axis and node how many
    neighbours there are, and how far; weights: sum_l S_il, and S_il of these, over 2 weight_i. In flat
    arrays by components, of the nodes of a tile: unknowns, strains F, tractions t^k, temps T, heats
    A^k . h; of the nodes of a row: slopes, found (rates).
    """

    patch: Patch
    layout: Layout
    lags: tuple[int, int, int]
    boxes: Array
    jumps: Array
    weights: Array
    unknowns: Array
    strains: Array
    tractions: Array
    temps: Array
    heats: Array
    slopes: Array
    found: Array


# What is known before


def solid_work(solid: Any, bands: Any, regular: tuple[int, int], patch: Patch) -> Work:
    """Work for a patch with these three bands of its ghosted nodes.

    regular: nodes of axis 0, from … to, whose rows of D are those of the interior.
    """
    d = len(solid.force)
    bands, patch = in_order(bands, d), Patch(*(in_order(of_axes, d) for of_axes in patch))
    conducts = int(solid.kappa > 0.0)
    tiles = tiles_of(patch, d)
    boxes = np.array([boxes_of(bands, own, conducts and not solid.coupled) for own in tiles])
    boxes[:, [NEAR, WARM]] *= conducts  # else no rows of T and heats
    row, inner = (int((b[:, 1] - b[:, 0]).max()) for b in (boxes[:, KNOWN, 0], boxes[:, KNOWN, 1]))
    reach = bands[2].reach
    layout = Layout(row, row * inner, (3 + conducts) * reach + 1, *regular)
    lags = reach, (1 + conducts) * reach, (2 + conducts) * reach
    memory = [np.zeros(count * STEPS[d - 1]) for count in (2 * d + 1, d * d, d * d, 1, d)]
    of_row = [np.zeros(count * int(WIDTH)) for count in (2 * d * d + d, 2 * d + 1)]
    return Work(patch, layout, lags, boxes, *neighbours(bands), *memory, *of_row)


def in_order(of_axes: Any, d: int) -> Any:
    """First axis, second one of three, last one."""
    return (of_axes[0], of_axes[2], of_axes[1]) if d == 2 else tuple(of_axes)


def tiles_of(patch: Patch, d: int) -> list[Any]:
    """Tiles of the owned nodes: (begin, end) along each axis."""
    cuts = []
    for first, count, most in zip(patch.first, patch.own, (*TILES[d - 1], patch.own[2])):
        ends = range(first, first + count, most)
        cuts.append([(begin, min(begin + most, first + count)) for begin in ends])
    return list(product(*cuts))


def boxes_of(bands: tuple[Band, ...], own: Any, further: bool) -> list[Any]:
    """OWN … KNOWN of a tile. further: T follows from F, so that both are needed around t^k."""

    def reached(box: Any) -> Any:
        return [reached_along(b.S, *ends) for b, ends in zip(bands, box, strict=True)]

    near = reached(own)
    warm = reached(near)
    return [own, near, warm, warm if further else near, reached(warm) if further else warm]


def reached_along(S: Array, begin: int, end: int) -> tuple[int, int]:
    """First node and first beyond of those in pairs with nodes begin … end - 1."""
    low, high = begin, end
    for m in range(1, len(S)):
        ahead = np.flatnonzero(S[m, begin:end])
        behind = np.flatnonzero(S[m, max(begin - m, 0) : end - m]) if end > m else ()
        high = max(high, begin + ahead[-1] + m + 1) if len(ahead) else high
        low = min(low, max(begin - m, 0) + behind[0]) if len(behind) else low
    return low, min(high, S.shape[1])


def neighbours(bands: Any) -> tuple[Array, Array]:
    """jumps and weights of Work."""
    most = max(2 * band.reach + 1 for band in bands)
    shape = 3, max(len(band.weight) for band in bands), 1 + most + -most % 4
    jumps, weights = np.zeros(shape, np.int64), np.zeros((2, *shape))
    for axis, (S, weight) in enumerate(bands):
        for i in range(len(weight)):
            pairs = [(m, S[m, i]) for m in range(1, min(len(S), len(weight) - i))]
            pairs += [(-m, -S[m, i - m]) for m in range(1, min(len(S), i + 1))]
            own = sum(S_il for _, S_il in pairs)
            pairs = [(m, S_il) for m, S_il in [*pairs, (0, own)] if abs(S_il) > 1e-12]
            here = slice(1, 1 + len(pairs))
            jumps[axis, i, 0], jumps[axis, i, here] = len(pairs), [m for m, _ in pairs]
            for kind, sign in ((PLAIN, -1.0), (FREE, 1.0)):
                signed = [S_il if m else sign * S_il for m, S_il in pairs]
                weights[kind, axis, i, here] = np.array(signed) / (2.0 * weight[i])
    return jumps, weights


# The sweep


@njit(**CALL)
def solid_rates(solid, like, q, metrics, prestress, rates, work):
    """Fill rates (M, 2d + 1) of the owned nodes of a patch.

    solid: fsipetsc.equations.solid.Solid; like: d zeros; q: (N, 2d + 1) unknowns of the nodes with
    halo; metrics: (d*d + 1, N) A^1 … A^d and J0; prestress: (d*d, N) what P has beside, or (d*d, 0).
    The halo is of two interior reaches, of three for conduction with heat 'elastic'.
    """
    patch, layout, lags, boxes, jumps, weights = work[:6]
    unknowns, strains, tractions, temps, heats, slopes, found = work[6:]
    q, metrics, rates = q.reshape(q.size), metrics.reshape(metrics.size), rates.reshape(rates.size)
    extra, table, d = prestress.reshape(prestress.size), (jumps, weights, layout), ONE * len(like)
    for tile in range(boxes.shape[0]):
        for z in range(boxes[tile, KNOWN, 2, 0], boxes[tile, OWN, 2, 1] + lags[2]):
            begin, end = rows_of(boxes, tile, KNOWN, z)
            for y in range(begin, end):
                take(like, q, row_of(patch, layout, boxes, tile, KNOWN, y, z), unknowns)
            begin, end = rows_of(boxes, tile, STRAINED, z - lags[0])
            for y in range(begin, end):
                row = row_of(patch, layout, boxes, tile, STRAINED, y, z - lags[0])
                differentiate(like, table, row, PLAIN, unknowns, NONE, NONE, d, slopes, NONE)
                strain(like, metrics, row, slopes, strains)
                relieve(solid, like, extra, row, strains, unknowns)
                pull(solid, like, metrics, row, unknowns, strains, tractions)
                pull_more(like, metrics, extra, row, tractions)
            begin, end = rows_of(boxes, tile, WARM, z - lags[0])
            for y in range(begin, end):
                row = row_of(patch, layout, boxes, tile, WARM, y, z - lags[0])
                find_temps(solid, like, row, unknowns, strains, temps)
            begin, end = rows_of(boxes, tile, NEAR, z - lags[1])
            for y in range(begin, end):
                row = row_of(patch, layout, boxes, tile, NEAR, y, z - lags[1])
                differentiate(like, table, row, PLAIN, temps, NONE, NONE, ONE, slopes, NONE)
                conduct(solid, like, metrics, row, slopes, strains, heats)
            begin, end = rows_of(boxes, tile, OWN, z - lags[2])
            for y in range(begin, end):
                row = row_of(patch, layout, boxes, tile, OWN, y, z - lags[2])
                differentiate(like, table, row, FREE, tractions, NONE, d, d, slopes, NONE)
                differentiate(like, table, row, PLAIN, unknowns, d, NONE, d, slopes, d * d)
                if solid.kappa > 0.0:
                    differentiate(like, table, row, FREE, heats, NONE, ONE, ONE, slopes, (d + d) * d)
                accelerate(solid, like, metrics, row, slopes, unknowns, tractions, found)
                give(like, found, row, rates)


@njit(**INNER_CALL)
def rows_of(boxes, tile, stage, z):
    """The rows of a layer that are in a box: begin, end."""
    here = boxes[tile, stage, 2, 0] <= z < boxes[tile, stage, 2, 1]
    return boxes[tile, stage, 1, 0], boxes[tile, stage, 1, 1] if here else boxes[tile, stage, 1, 0]


@njit(**INNER_CALL)
def row_of(patch, layout, boxes, tile, stage, y, z):
    """The row of a box at y, z."""
    x, n = boxes[tile, stage, 0, 0], boxes[tile, stage, 0, 1] - boxes[tile, stage, 0, 0]
    (nx, ny, _), (own_x, own_y, _), first = patch.ghosted, patch.own, patch.first
    own = ((z - first[2]) * own_y + y - first[1]) * own_x + x - first[0]
    place, x0, y0 = z % layout.layers, boxes[tile, KNOWN, 0, 0], boxes[tile, KNOWN, 1, 0]
    node = place * layout.layer + (y - y0) * layout.row + x - x0
    begin = min(max(layout.begin - x, 0), n)
    end = max(min(layout.end - x, n), begin)
    return Row(n, (z * ny + y) * nx + x, own, node, x, y, z, place, begin, end)


@njit(**INNER_LOOP)
def take(like, q, row, unknowns):
    """Take the interlaced unknowns apart."""
    dof = 2 * len(like) + 1
    for c in range(dof):
        to, of = U64(c * step_of(like) + row.tile), U64(row.patch * dof + c)
        for i in range(U64(row.n)):
            unknowns[to + i] = q[of + i * U64(dof)]


@njit(**INNER_LOOP)
def give(like, found, row, rates):
    """Interlace the rates."""
    dof = 2 * len(like) + 1
    for c in range(dof):
        to, of = U64(row.own * dof + c), U64(c) * WIDTH
        for i in range(U64(row.n)):
            rates[to + i * U64(dof)] = found[of + i]


# Rows


@njit(**INNER_LOOP)
def differentiate(like, table, row, kind, f, first, next_k, count, out, to):
    """D_k f, or D°_k f if kind is FREE, for k = 1 … d: to components of out, from ``to`` on.

    Along axis k those of count components of f, an array of a tile, from first + k next_k on.
    Nodes with the same neighbours are taken together: all across the row, and those in the interior.
    """
    (jumps, weights, layout), step = table, step_of(like)
    for k in range(len(like)):
        axis, begin = 2 * k if len(like) == 2 else k, 0
        while begin < row.n:
            end, x = row.n, row.y if axis == 1 else row.z
            if axis == 0:
                end, x = max(row.end, begin + 1) if begin == row.begin else begin + 1, row.x + begin
            w, far = weights[kind, axis, x], jumps[axis, x]
            for m in range(1, 1 + far[0], 4):
                four = w[m], w[m + 1], w[m + 2], w[m + 3]
                a, b = away(layout, row, axis, far[m]), away(layout, row, axis, far[m + 1])
                c, d = away(layout, row, axis, far[m + 2]), away(layout, row, axis, far[m + 3])
                for l in range(count):
                    node = (first + k * next_k + l) * step + row.tile + begin
                    there = U64(node + a), U64(node + b), U64(node + c), U64(node + d)
                    here = U64(to + k * count + l) * WIDTH + U64(begin)
                    if end == begin + 1:  # a loop over one node takes twice as long
                        before = out[here] if m > 1 else 0.0
                        out[here] = before + weighted(four, f, there, U64(0))
                        continue
                    for i in range(U64(end - begin)):
                        before = out[here + i] if m > 1 else 0.0
                        out[here + i] = before + weighted(four, f, there, i)
            begin = end


@njit(**INNER_CALL)
def away(layout, row, axis, jump):
    """Numbers between a node and a neighbour along an axis in the arrays of a tile."""
    if axis < 2:
        return jump if axis == 0 else jump * layout.row
    there = row.place + jump
    ring = 0 if 0 <= there < layout.layers else layout.layers if there < 0 else -layout.layers
    return (jump + ring) * layout.layer


@njit(**INNER_LOOP)
def strain(like, metrics, row, slopes, strains):
    """F = 1 + 1/J0 sum_k D_k D A^k."""
    nine, step = outer(like, like), U64(step_of(like))
    N, node, g = U64(metrics.size // (len(nine) + 1)), U64(row.tile), U64(row.patch)
    for i in range(U64(row.n)):
        A, J0 = at(nine, metrics, g, N, i), metrics[g + U64(len(nine)) * N + i]
        gradient = scale(1.0 / J0, transposed_product(at(nine, slopes, U64(0), WIDTH, i), A))
        put(strains, node, step, i, add_unit(1.0, gradient))


@njit(**INNER_LOOP)
def relieve(solid, like, extra, row, strains, unknowns):
    """Take the energy of a prestress S, S : (F - 1)/m0, from e: only T follows from e."""
    n = row.n if extra.size > 0 and solid.coupled == 0.0 else 0
    nine, step = outer(like, like), U64(step_of(like))
    N, node, g = U64(extra.size // len(nine)), U64(row.tile), U64(row.patch)
    e = node + U64(2 * len(like)) * step
    for i in range(U64(n)):
        S, F = at(nine, extra, g, N, i), at(nine, strains, node, step, i)
        unknowns[e + i] -= dot(S, add_unit(-1.0, F)) / solid.m0


@njit(**INNER_LOOP)
def pull(solid, like, metrics, row, unknowns, strains, tractions):
    """t^k = P A^k."""
    nine, step, d = outer(like, like), U64(step_of(like)), U64(len(like))
    N, node, g = U64(metrics.size // (len(nine) + 1)), U64(row.tile), U64(row.patch)
    for i in range(U64(row.n)):
        A, F = at(nine, metrics, g, N, i), at(nine, strains, node, step, i)
        v, e = at(like, unknowns, node + d * step, step, i), unknowns[node + U64(2) * d * step + i]
        P = solid.stress_at(F, solid.temperature(v, e, F))
        put(tractions, node, step, i, product_transposed(A, P))


@njit(**INNER_LOOP)
def pull_more(like, metrics, extra, row, tractions):
    """t^k += S A^k of a prestress."""
    n, nine, step = row.n if extra.size > 0 else 0, outer(like, like), U64(step_of(like))
    N, node, g = U64(extra.size // len(nine)), U64(row.tile), U64(row.patch)
    for i in range(U64(n)):
        A, S = at(nine, metrics, g, N, i), at(nine, extra, g, N, i)
        more = add(at(nine, tractions, node, step, i), product_transposed(A, S))
        put(tractions, node, step, i, more)


@njit(**INNER_LOOP)
def find_temps(solid, like, row, unknowns, strains, temps):
    """T; with heat 'coupled' F does not matter, and is not known everywhere."""
    nine, step, d = outer(like, like), U64(step_of(like)), U64(len(like))
    node, first = U64(row.tile), U64(row.tile) + d * step
    for i in range(U64(row.n)):
        v, e = at(like, unknowns, first, step, i), unknowns[first + d * step + i]
        temps[node + i] = solid.temperature(v, e, add_unit(1.0, nine))
    if solid.coupled == 0.0:
        for i in range(U64(row.n)):
            v, e = at(like, unknowns, first, step, i), unknowns[first + d * step + i]
            temps[node + i] = solid.temperature(v, e, at(nine, strains, node, step, i))


@njit(**INNER_LOOP)
def conduct(solid, like, metrics, row, slopes, strains, heats):
    """A^k . h with grad T = 1/J0 sum_k A^k D_k T."""
    nine, step = outer(like, like), U64(step_of(like))
    N, node, g = U64(metrics.size // (len(nine) + 1)), U64(row.tile), U64(row.patch)
    for i in range(U64(row.n)):
        A, J0 = at(nine, metrics, g, N, i), metrics[g + U64(len(nine)) * N + i]
        gradient = scale(1.0 / J0, apply_transposed(A, at(like, slopes, U64(0), WIDTH, i)))
        h = solid.heat_flux(at(nine, strains, node, step, i), gradient)
        put(heats, node, step, i, apply(A, h))


@njit(**INNER_LOOP)
def accelerate(solid, like, metrics, row, slopes, unknowns, tractions, found):
    """(v, Div P/m0 + b, Div (P^T v + h)/m0 + b . v); slopes: D°_k t^k, D_k v, D°_k A^k . h."""
    nine, step, d = outer(like, like), U64(step_of(like)), U64(len(like))
    N, node, g = U64(metrics.size // (len(nine) + 1)), U64(row.tile), U64(row.patch)
    for i in range(U64(row.n)):
        per_mass = 1.0 / (metrics[g + d * d * N + i] * solid.m0)
        v, t = at(like, unknowns, node + d * step, step, i), at(nine, tractions, node, step, i)
        force = column_sums(at(nine, slopes, U64(0), WIDTH, i))
        heat = total(at(like, slopes, U64(2) * d * d * WIDTH, WIDTH, i))
        power = dot(v, force) + dot(t, at(nine, slopes, d * d * WIDTH, WIDTH, i)) + heat
        acceleration = along(solid.force, per_mass, force)
        energy = per_mass * power + dot(solid.force, v)
        put(found, U64(0), WIDTH, i, (*v, *acceleration, energy))
