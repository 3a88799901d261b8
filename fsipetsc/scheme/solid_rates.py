"""Rates of the nodes of a solid block, boundary-flux-free, layer by layer.

fsipetsc.equations.solid has the equations, fsipetsc.operators.bands the weights S_il of pairs. With

    D_k f   = sum_l S_il (f_l - f_i) / (2 weight_i)     derivative along axis k
    D°_k f  = sum_l S_il (f_l + f_i) / (2 weight_i)     the same without the flux through the ends

and the tractions t^k = P A^k, the rates of displacement, velocity and energy are

    D_t = v,    J0 m0 v_t = sum_k D°_k t^k,    J0 m0 e_t = v . sum_k D°_k t^k + sum_k t^k . D_k v.

The power is, pair by pair, S_il (t_i . v_l + t_l . v_i)/2: nothing is lost or won.

Tiles (fsipetsc.scheme.solid_work) are swept layer by layer: a layer is loaded, F and t^k are found
one reach behind, rates two reaches behind. Arrays keep as many layers as are needed, in a ring.
What two tiles need is found twice by the same operations: rates do not depend on tiles, nor on how
a block is cut.
"""

from numba import njit

from fsipetsc.equations.tensors import (
    add_unit,
    apply,
    apply_transposed,
    column_sums,
    outer,
    product_transposed,
    transposed_product,
)
from fsipetsc.operators.loops import (
    EXACT_LOOP,
    INNER_CALL,
    MERGED_CALL,
    add,
    along,
    by_length,
    dot,
    scale,
    total,
    total_of,
)
from fsipetsc.scheme.rows import U64, at, put
from fsipetsc.scheme.solid_work import (
    FREE,
    KNOWN,
    NEAR,
    NONE,
    ONE,
    OWN,
    PLAIN,
    STRAINED,
    WIDTH,
    Row,
    step_of,
)

#: sum of weights w times f at some places, i nodes on
weighted = by_length("weighted", "w, f, places, i", total_of("w[@] * f[places[@] + i]"))


# The sweep


@njit(**MERGED_CALL)
def solid_rates(part, q, rates):
    """Fill rates (M, 2d + 1) of the owned nodes of a part; q: (N, 2d + 1) unknowns, with a halo of
    two interior reaches, of three for conduction.
    """
    solid, like, metrics, work = part.laws, part.like, part.metrics, part.work
    patch, layout, lags, boxes, jumps, weights, ends = work[:7]
    unknowns, strains, tractions, temps, heats, slopes = work[7:13]
    q, metrics, rates = q.reshape(q.size), metrics.reshape(metrics.size), rates.reshape(rates.size)
    extra, d, table = part.prestress.reshape(-1), ONE * len(like), (jumps, weights, ends, layout)
    for tile in range(boxes.shape[0]):
        for z in range(boxes[tile, KNOWN, 2, 0], boxes[tile, OWN, 2, 1] + lags[2]):
            begin, end = rows_of(boxes, tile, KNOWN, z)
            for y in range(begin, end):
                take(like, q, row_of(patch, layout, boxes, tile, KNOWN, y, z), unknowns)
            begin, end = rows_of(boxes, tile, STRAINED, z - lags[0])
            for y in range(begin, end):
                row = row_of(patch, layout, boxes, tile, STRAINED, y, z - lags[0])
                differentiate(like, table, row, PLAIN, unknowns, NONE, NONE, d, slopes, NONE)
                strain(solid, like, metrics, row, slopes, unknowns, strains)
                relieve(solid, like, extra, row, strains, unknowns)
                pull(solid, like, metrics, extra, row, unknowns, strains, temps, tractions)
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
                    differentiate(like, table, row, FREE, heats, NONE, ONE, ONE, slopes, 2 * d * d)
                accelerate(solid, like, metrics, row, slopes, unknowns, tractions, strains, rates)


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


@njit(**EXACT_LOOP)
def pull(solid, like, metrics, extra, row, unknowns, strains, temps, tractions):
    """T, and t^k = (P + S) A^k with a prestress S."""
    nine, step, d = outer(like, like), U64(step_of(like)), U64(len(like))
    N, node, g = U64(metrics.size // solid.rows(like)), U64(row.tile), U64(row.patch)
    for i in range(U64(row.n)):
        A, F = at(nine, metrics, g, N, i), at(solid.unstrained(like), strains, node, step, i)
        v, e = at(like, unknowns, node + d * step, step, i), unknowns[node + U64(2) * d * step + i]
        T = solid.temperature(v, e, F)
        P, temps[node + i] = solid.stress_at(F, T), T
        put(tractions, node, step, i, product_transposed(A, P))
    for i in range(U64(row.n if extra.size > 0 else 0)):
        A, S = at(nine, metrics, g, N, i), at(nine, extra, g, N, i)
        more = add(at(nine, tractions, node, step, i), product_transposed(A, S))
        put(tractions, node, step, i, more)


@njit(**EXACT_LOOP)
def conduct(solid, like, metrics, row, slopes, strains, heats):
    """A^k . h with grad T = 1/J0 sum_k A^k D_k T."""
    nine, step = outer(like, like), U64(step_of(like))
    N, node, g = U64(metrics.size // solid.rows(like)), U64(row.tile), U64(row.patch)
    for i in range(U64(row.n)):
        A, J0 = at(nine, metrics, g, N, i), metrics[g + U64(len(nine)) * N + i]
        gradient = scale(1.0 / J0, apply_transposed(A, at(like, slopes, U64(0), WIDTH, i)))
        h = solid.heat_flux(at(solid.unstrained(like), strains, node, step, i), gradient)
        put(heats, node, step, i, apply(A, h))


@njit(**EXACT_LOOP)
def accelerate(solid, like, metrics, row, slopes, unknowns, tractions, strains, rates):
    """(v, Div P/m0 + b, Div (P^T v + h)/m0 + b . v); slopes: D°_k t^k, D_k v, D°_k A^k . h."""
    nine, step, d = outer(like, like), U64(step_of(like)), U64(len(like))
    dof = U64(2 * len(like) + 1)
    N, node, g = U64(metrics.size // solid.rows(like)), U64(row.tile), U64(row.patch)
    for i in range(U64(row.n)):
        per_mass = 1.0 / (metrics[g + d * d * N + i] * solid.m0)
        v, t = at(like, unknowns, node + d * step, step, i), at(nine, tractions, node, step, i)
        force = column_sums(at(nine, slopes, U64(0), WIDTH, i))
        heat = total(at(like, slopes, U64(2) * d * d * WIDTH, WIDTH, i))
        power = dot(v, force) + dot(t, at(nine, slopes, d * d * WIDTH, WIDTH, i)) + heat
        e = unknowns[node + U64(2) * d * step + i]
        F = at(solid.unstrained(like), strains, node, step, i)
        acceleration = along(solid.force, per_mass, force)
        R = metrics[U64(metrics.size) - N + g + i]
        acceleration = solid.with_hoop_force(acceleration, v, e, F, R)
        energy = per_mass * power + dot(solid.force, v)
        put(rates, U64(row.own) * dof, U64(1), i * dof, (*v, *acceleration, energy))
