"""Rates of a block of gas in d = 1, 2 or 3 dimensions, without fluxes through its faces.

    (J U)_t,i = - sum_k sum_l S_il (F^k(i, l) - {a^k . f_v}) / weight_i

and J_t from the metrics, with F of fsipetsc.equations.gas, S and the weights of
fsipetsc.operators.bands. F is symmetric and S antisymmetric, so mass, momentum and energy stay.
The viscous flux f_v is that of fsipetsc.scheme.viscous_rows. A constant force is summed in the same
sweep, beside the fluxes (fsipetsc.scheme.gas_force).

The nodes are swept in tiles: TILE nodes along the first axis, a few rows along the second one of
three, and layer after layer along the last axis, so that what is worked on stays in the fastest
memory. Each pair's flux is computed once and added to both of its nodes: the sum of the lower one
belongs to the row at work, that of the upper one waits in a row of its own. The fluxes reach a node
in an order that does not depend on how a block is cut, so neither do the bits of its rate.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.equations.means import NEAR
from fsipetsc.equations.tensors import outer
from fsipetsc.operators.loops import (
    EXACT_LOOP,
    INLINED_CALL,
    MERGED_CALL,
    add,
    along,
    choose,
    zeros,
)
from fsipetsc.scheme.gas_memory import (
    DEPTH,
    Axes,
    Axis,
    Tile,
    clear,
    fill,
    number_of,
    piece,
    row_of,
    tiles_of,
)
from fsipetsc.scheme.gas_rows import grid_of, pair_of, place_of
from fsipetsc.scheme.rows import MARGIN, ONE, ROW, U64, at, put
from fsipetsc.scheme.viscous_rows import viscous_layer

# loops over nodes of a row


@njit(**EXACT_LOOP)
def load_row(gas, like, force, q, at_q, metrics, at_m, step, potential, w, row, n):
    """Primitive variables, metrics, and the potential of a force."""
    like_q, like_m = (*like, 0.0, 0.0, 0.0), (*outer(like, like), *gas.of_grid(like))
    count = U64(len(like_q))
    for i in range(n):
        state = gas.primitive(at(like_q, q, at_q, ONE, i * count))
        put(w, row, ROW, i, (*state, *at(like_m, metrics, at_m, step, i)))
        force.load(potential, at_m, w, place_of(gas, like, row, 0), i)


@njit(**EXACT_LOOP)
def pair_row(
    gas, like, form, viscous, w, place, other, gain, loss, weights, low, lower, high, upper, n
):
    """Add fluxes of nodes of a row and those `other` numbers on to the sums of both.

    Returns how many are farther apart than NEAR: these are left out, but for their viscous flux.
    """
    force, far = form.force, 0
    like_f, nothing = force.sums(like), (*zeros(like), 0.0, 0.0)
    for i in range(n):
        j = i + other
        l, r = pair_of(like, w, place, i, j)
        apart, areas = form.distance(gas, l, r) > NEAR, grid_of(gas, like, w, place, i, j)
        F = choose(apart, nothing, form.near(gas, l, r, *areas))
        F = viscous.less(like, F, w, place, i, j)
        rise = force.rise(w, place.potential + i, place.potential + j)
        below, above = force.near(gas, F, l, r, areas[0], areas[1], rise, apart)
        put(low, lower, ROW, i, along(at(like_f, low, lower, ROW, i), -loss[weights + i], below))
        put(high, upper, ROW, i, along(at(like_f, high, upper, ROW, i), gain[weights + i], above))
        far += apart
    return far


@njit(**EXACT_LOOP)
def far_row(gas, like, form, w, place, other, gain, loss, weights, low, lower, high, upper, n):
    """Add the fluxes that were left out."""
    force = form.force
    like_f = force.sums(like)
    for i in range(n):
        j = i + other
        l, r = pair_of(like, w, place, i, j)
        if form.distance(gas, l, r) > NEAR:
            areas = grid_of(gas, like, w, place, i, j)
            rise = force.rise(w, place.potential + i, place.potential + j)
            F = form.any(gas, l, r, *areas)
            below, above = force.any(gas, F, l, r, areas[0], areas[1], rise)
            less, more = -loss[weights + i], gain[weights + i]
            put(low, lower, ROW, i, along(at(like_f, low, lower, ROW, i), less, below))
            put(high, upper, ROW, i, along(at(like_f, high, upper, ROW, i), more, above))


@njit(**EXACT_LOOP)
def store_row(like, force, low, high, upper, metrics, J_t, rates, supplied, own, n):
    """J_t and the rates of a row, interlaced, and the force on its nodes; own: its first one."""
    like_f, count, lower = (*like, 0.0, 0.0), U64(len(like) + 3), U64(MARGIN)
    for i in range(n):
        total = add(at(like_f, low, lower, ROW, i), at(like_f, high, upper, ROW, i))
        put(rates, own * count, ONE, i * count, (metrics[J_t + i], *total))
        force.store(like, low, lower, high, upper, i, supplied, own)


# a tile


@njit(**INLINED_CALL)
def load_layer(gas, like, form, viscous, q, metrics, axes, tile, work, layer):
    """The rows of a layer that are read."""
    inner, last, d = axes.inner, axes.last, len(like)
    ahead, beside, reach = last.S.shape[0] - 1, inner.S.shape[0] - 1, 1 + viscous.reach
    within = last.begin - viscous.reach * ahead <= layer < last.end + viscous.reach * ahead
    more = reach * beside if within else 0
    step = U64(metrics.size // (d * d + len(gas.of_grid(like)) + 1))
    force, sums = form.force, len(form.force.sums(like))
    for j in range(max(tile.y0 - more, 0), min(tile.y1 + more, inner.size)):
        whole = within and tile.y0 - viscous.reach * beside <= j < tile.y1 + viscous.reach * beside
        longer = reach * (axes.first.S.shape[0] - 1) if whole else 0
        x0, x1 = max(tile.x0 - longer, 0), min(tile.x1 + longer, axes.first.size)
        row, n = row_of(work, tile, layer, j) + U64(MARGIN + x0 - tile.x0), U64(x1 - x0)
        node = U64(x0 + j * inner.stride + layer * last.stride)
        at_m = metrics, node, step, work.potential
        load_row(gas, like, force, q, node * U64(d + 3), *at_m, work.w, row, n)
        high = number_of(work, tile, layer, j) * U64(sums) * ROW + U64(MARGIN)
        clear(work.high, high, sums, U64(tile.x1 - tile.x0))


@njit(**INLINED_CALL)
def pairs(gas, like, form, viscous, work, row, k, other, weights, column, upper, n):
    """Add the fluxes of n pairs along axis k, of nodes of a row and those `other` numbers on.

    column: of the first pair, weights: where gain and loss begin, upper: the upper nodes' sums.
    """
    place, whole = place_of(gas, like, row + column, k), U64((n + 3) // 4 * 4)
    w, gain, loss, low, high = work.w, work.gain, work.loss, work.low, work.high
    more = weights, low, column, high, upper
    far = pair_row(gas, like, form, viscous, w, place, other, gain, loss, *more, whole)
    if far > 0:
        far_row(gas, like, form, w, place, other, gain, loss, *more, U64(n))


@njit(**INLINED_CALL)
def pairs_across(gas, like, form, viscous, axes, tile, work, layer, j, along_last):
    """The pairs of row j of a layer with those in layers (or rows) farther on."""
    axis, k_axis = (axes.last, len(like) - 1) if along_last else (axes.inner, 1)
    i, n, row = layer if along_last else j, tile.x1 - tile.x0, row_of(work, tile, layer, j)
    up, right = (1, 0) if along_last else (0, 1)
    sums = U64(len(form.force.sums(like)))
    for k in range(1, axis.S.shape[0]):
        s = axis.S[k, i]
        if s != 0.0 and i + k >= axis.begin:
            fill(work.gain, work.loss, s / axis.weight[i + k], s / axis.weight[i], U64(n + 3))
            there, column = number_of(work, tile, layer + k * up, j + k * right), U64(MARGIN)
            other = there * U64(work.numbers) * ROW - row
            upper = there * sums * ROW + column
            pairs(gas, like, form, viscous, work, row, k_axis, other, U64(0), column, upper, n)


@njit(**INLINED_CALL)
def sweep_layer(gas, like, form, viscous, q, metrics, axes, tile, work, rates, layer):
    """Add the fluxes of the pairs that begin in a layer; its rates if it is owned."""
    first, inner, last, d = axes.first, axes.inner, axes.last, len(like)
    owned, n = layer >= last.begin, U64(tile.x1 - tile.x0)
    sums = len(form.force.sums(like))
    for j in range(max(tile.y0 - inner.S.shape[0] + 1, 0) if owned else tile.y0, tile.y1):
        clear(work.low, U64(MARGIN), sums, n)
        if owned and d == 3:
            pairs_across(gas, like, form, viscous, axes, tile, work, layer, j, False)
        if j < tile.y0:
            continue
        if d > 1:
            pairs_across(gas, like, form, viscous, axes, tile, work, layer, j, True)
        if owned:
            high = number_of(work, tile, layer, j) * U64(sums) * ROW
            row = row_of(work, tile, layer, j)
            for m in range(tile.spans, tile.end):
                k, a, b = work.spans[m, 0], work.spans[m, 1], work.spans[m, 2]
                column, other = U64(MARGIN + a - tile.x0), U64(k)
                weights, upper = tile.weights + other * ROW + column, high + column + other
                pairs(gas, like, form, viscous, work, row, 0, other, weights, column, upper, b - a)
            node = U64(tile.x0 + j * inner.stride + layer * last.stride)
            own = (layer - last.begin) * (inner.end - inner.begin) + j - inner.begin
            to = U64(own * (first.end - first.begin) + tile.x0 - first.begin)
            J_t = U64(metrics.size - first.size * inner.size * last.size) + node
            found = work.low, work.high, high + U64(MARGIN), metrics, J_t, rates, work.supplied
            store_row(like, form.force, *found, to, n)


@njit(**INLINED_CALL)
def sweep(gas, like, form, viscous, q, metrics, axes, tile, work, rates):
    """Sweep a tile along the last axis: load layers, complete them, take pairs that begin there."""
    last = axes.last
    ahead = last.S.shape[0] - 1
    behind = viscous.reach * ahead
    completed = max(last.begin - ahead, 0)
    loaded = max(completed - behind, 0)
    for layer in range(completed, last.end):
        while completed <= layer + ahead and completed < last.size:
            while loaded <= completed + behind and loaded < last.size:
                load_layer(gas, like, form, viscous, q, metrics, axes, tile, work, loaded)
                loaded += 1
            if viscous.reach > 0:
                viscous_layer(gas, like, q, axes, tile, work, completed)
            completed += 1
        sweep_layer(gas, like, form, viscous, q, metrics, axes, tile, work, rates, layer)


@njit(**MERGED_CALL)
def gas_rates(part, q, rates):
    """Rates of the nodes of a part that are owned.

    q: (N, d + 3) over the ghosted array. rates: (M, d + 3) of the owned nodes: J_t, and those of
    J rho, J rho u, J E.
    """
    gas, like, form, viscous, work = part.laws, part.like, part.form, part.viscous, part.work
    metrics, S, weight, patch = part.metrics, part.S, part.weight, part.patch
    own, size, first = patch.own, patch.ghosted, patch.first
    x = Axis(S[0], weight[0], first[0], first[0] + own[0], size[0], 1)
    y = Axis(S[1], weight[1], first[1], first[1] + own[1], size[1], size[0])
    z = Axis(S[2], weight[2], first[2], first[2] + own[2], size[2], size[0] * size[1])
    axes = Axes(x, y, z) if len(like) == 3 else Axes(x, z, y)
    inner, q, metrics, rates = axes.inner, q.reshape(-1), metrics.reshape(-1), rates.reshape(-1)
    wide, deep = tiles_of(own[0]), (inner.end - inner.begin + DEPTH - 1) // DEPTH
    for m in range(deep):
        y0, y1 = piece(inner.begin, inner.end, m, deep), piece(inner.begin, inner.end, m + 1, deep)
        for n in range(wide):
            x0, x1 = piece(x.begin, x.end, n, wide), piece(x.begin, x.end, n + 1, wide)
            weights = U64(n * x.S.shape[0]) * ROW
            tile = Tile(x0, x1, y0, y1, weights, work.begins[n], work.begins[n + 1])
            sweep(gas, like, form, viscous, q, metrics, axes, tile, work, rates)
