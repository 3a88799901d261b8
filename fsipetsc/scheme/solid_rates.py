"""Rows of a tile of a solid block and their F, for the monitor; fsipetsc/scheme/solid.c has the
rates.
"""


from fsipetsc.equations.tensors import (
    add_unit,
    outer,
    transposed_product,
)
from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import (
    EXACT_LOOP,
    INNER_CALL,
    by_length,
    dot,
    scale,
    total_of,
)
from fsipetsc.scheme.rows import U64, at, put
from fsipetsc.scheme.solid_work import (
    KNOWN,
    WIDTH,
    Row,
    step_of,
)

#: sum of weights w times f at some places, i nodes on
weighted = by_length("weighted", "w, f, places, i", total_of("w[@] * f[places[@] + i]"))


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
    return Row(n, (z * ny + y) * nx + x, own, node, x, y, z, place)


@njit(**EXACT_LOOP)
def take(like, q, row, unknowns):
    """Take the interlaced unknowns apart."""
    dof = 2 * len(like) + 1
    for c in range(dof):
        to, of = U64(c * step_of(like) + row.tile), U64(row.patch * dof + c)
        for i in range(U64(row.n)):
            unknowns[to + i] = q[of + i * U64(dof)]


# Rows


@njit(**EXACT_LOOP)
def differentiate(like, table, row, kind, f, first, next_k, count, out, to):
    """D_k f, or D°_k f if kind is FREE, for k = 1 … d: to components of out, from ``to`` on.

    Along axis k those of count components of f, an array of a tile, from first + k next_k on.
    Nodes with the same neighbours are taken together: all across the row, those in the interior.
    """
    (jumps, weights, ends, layout), step = table, step_of(like)
    for k in range(len(like)):
        axis, begin = 2 * k if len(like) == 2 else k, 0
        while begin < row.n:
            end, x = row.n, row.y if axis == 1 else row.z
            if axis == 0:
                end, x = min(ends[row.x + begin] - row.x, row.n), row.x + begin
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


@njit(**EXACT_LOOP)
def strain(solid, like, metrics, row, slopes, unknowns, strains):
    """F = 1 + 1/J0 sum_k D_k D A^k, with the stretch of hoops."""
    nine, step = outer(like, like), U64(step_of(like))
    N, node, g = U64(metrics.size // solid.rows(like)), U64(row.tile), U64(row.patch)
    end = U64(metrics.size) - N
    for i in range(U64(row.n)):
        A, J0 = at(nine, metrics, g, N, i), metrics[g + U64(len(nine)) * N + i]
        gradient = scale(1.0 / J0, transposed_product(at(nine, slopes, U64(0), WIDTH, i), A))
        D, R = at(like, unknowns, node, step, i), metrics[end + g + i]
        F = solid.with_hoops(add_unit(1.0, gradient), D, R)
        put(strains, node, step, i, F)


@njit(**EXACT_LOOP)
def relieve(solid, like, extra, row, strains, unknowns):
    """Take the energy of a prestress S, S : (F - 1)/m0, from e: only T follows from e."""
    n = row.n if extra.size > 0 and solid.coupled == 0.0 else 0
    nine, step = outer(like, like), U64(step_of(like))
    N, node, g = U64(extra.size // len(nine)), U64(row.tile), U64(row.patch)
    e = node + U64(2 * len(like)) * step
    for i in range(U64(n)):
        S, F = at(nine, extra, g, N, i), at(nine, strains, node, step, i)
        unknowns[e + i] -= dot(S, add_unit(-1.0, F)) / solid.m0
